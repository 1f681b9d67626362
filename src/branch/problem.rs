//! The continuation problem of a branch: a scene for each value of the parameter, what happens along its orbits, the formulation of its
//! loops, and the units of the unknowns.

use crate::branch::parametric_loop::{BranchDirection, ParametricLoop};
use crate::error::{Error, Result};
use crate::hybrid::{ScaledUnits, joined};
use crate::itinerary::check_landings;
use crate::model::{Energetics, Scene};
use crate::orbit::{Guess, PeriodicOrbit, ShootingState, Signature, begun, with_phase};
use crate::path::ImpactSide;
use crate::tolerance::{NARROW_RANGE, PARAMETER_SIZE_FLOOR, PARAMETER_STEP};
use nalgebra::DVector;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::rc::Rc;
use std::sync::Arc;

/// Scenes in a cache. `[work]`
const MOST_RECENT_SCENES: usize = 4;

/// What the unknowns of a loop are, and which equations it closes by (theory 19).
#[derive(Clone, Copy)]
pub(super) enum Formulation<'a> {
    /// Shooting: the first state and the times of the instants; the last flight ends where the first begins.
    Shooting,
    /// The impulses and their times, each with the gap of its stop and the law of restitution ("Many modes").
    Impulses,
    /// Shooting on a level of energy, which is the parameter ("Families"): the energy is one equation more, by how much the loop is open
    /// one unknown more.
    EnergyLevel(&'a Energetics),
}

/// The continuation problem of a branch (theory 19): `G(Z, p) = 0` for loops Z of one signature in the scenes of p.
#[derive(Clone)]
pub(super) struct BranchProblem<'a> {
    /// The scene of a value of the parameter.
    pub make: &'a dyn Fn(f64) -> Result<Scene>,
    /// The range of the parameter, in its unit.
    pub range: (f64, f64),
    pub signature: Signature,
    /// The phase of the forcing at time zero, in all scenes \[rad\].
    pub phase: f64,
    /// Whether there is no forcing; the first instant is at time zero then.
    pub is_free: bool,
    /// Units of positions and velocities, and of time where nothing gives one.
    pub units: ScaledUnits,
    pub formulation: Formulation<'a>,
    pub recent: RecentScenes,
}

/// A cache of the scenes made last, with their values and phases, as each is asked for several times in a row. Copies share it.
#[derive(Clone, Default)]
pub(super) struct RecentScenes(Rc<RefCell<VecDeque<(f64, f64, Arc<Scene>)>>>);

impl RecentScenes {
    fn of(&self, value: f64, phase: f64) -> Option<Arc<Scene>> {
        let known = self.0.borrow();
        let mut known = known.iter().filter(|own| (own.0, own.1) == (value, phase));
        known.next().map(|(_, _, scene)| Arc::clone(scene))
    }

    fn keep(&self, value: f64, phase: f64, scene: Scene) -> Arc<Scene> {
        let (mut known, scene) = (self.0.borrow_mut(), Arc::new(scene));
        known.truncate(MOST_RECENT_SCENES - 1);
        known.push_front((value, phase, Arc::clone(&scene)));
        scene
    }
}

impl<'a> BranchProblem<'a> {
    /// The problem about an orbit, which belongs to a value of the parameter, and its loop there.
    pub fn around(
        orbit: &PeriodicOrbit,
        make: &'a dyn Fn(f64) -> Result<Scene>,
        value: f64,
        range: (f64, f64),
    ) -> Result<(Self, ParametricLoop)> {
        let (scene, signature, state) = begun(&make(value)?, Guess::Orbit(orbit), None)?;
        let units = units_of(orbit, &state);
        let problem = Self {
            make,
            range,
            signature,
            phase: scene.phase(),
            is_free: scene.frequency().is_none(),
            units,
            formulation: Formulation::Shooting,
            recent: RecentScenes::default(),
        };
        let place = problem.place(&scene, value, state)?;
        Ok((problem, place))
    }

    /// A loop in the scene of a value.
    pub fn place(&self, scene: &Scene, value: f64, state: ShootingState) -> Result<ParametricLoop> {
        let impulses = match self.formulation {
            Formulation::Impulses => self.impulses_of(scene, &state)?,
            _ => None,
        };
        Ok(ParametricLoop {
            value,
            impulses,
            state,
            clock: self.units_in(scene).time,
        })
    }

    /// Whether nothing happens along the orbits: a period is one flight.
    pub fn is_empty(&self) -> bool {
        self.signature.stages.is_uneventful()
    }

    /// The scene of a value.
    pub fn scene(&self, value: f64) -> Result<Arc<Scene>> {
        let scene = if let Some(scene) = self.recent.of(value, self.phase) {
            scene
        } else {
            let scene = (self.make)(value)?;
            let turned = with_phase(&scene, self.phase, self.signature.depends_on_time)?;
            self.recent.keep(value, self.phase, turned)
        };
        check_landings(&scene, &self.signature.stages)?;
        Ok(scene)
    }

    /// The unit of the parameter in scaled unknowns: the width of its range.
    pub fn span(&self) -> f64 {
        span_of(self.range)
    }

    /// A value, set to an end of the range where it differs from that by rounding: beyond the end there may be no scene.
    pub fn snapped(&self, value: f64) -> f64 {
        let (low, high) = self.range;
        let rounding = 4.0 * f64::EPSILON * self.span();
        let ends = [low, high].into_iter();
        let end = ends.min_by(|a, b| (a - value).abs().total_cmp(&(b - value).abs()));
        end.filter(|end| (end - value).abs() <= rounding)
            .unwrap_or(value)
    }

    /// The step of differences by the parameter, in its unit.
    pub fn difference(&self, value: f64) -> f64 {
        let size = value.abs().max(PARAMETER_SIZE_FLOOR * self.span());
        PARAMETER_STEP * self.span().min(size)
    }

    /// The units in a scene; times are phases of its forcing, where there is one.
    pub fn units_in(&self, scene: &Scene) -> ScaledUnits {
        let time = scene.frequency().map_or(self.units.time, f64::recip);
        ScaledUnits { time, ..self.units }
    }

    /// By how many turns of the forcing a loop comes later than another \[-\].
    pub fn turns(&self, from: &ParametricLoop, to: &ParametricLoop) -> f64 {
        let later = to.state.times[0] / to.clock - from.state.times[0] / from.clock;
        if self.is_free {
            0.0
        } else {
            (later / TAU).round()
        }
    }

    /// The largest position or velocity of a loop, in the units \[-\].
    pub fn size(&self, state: &ShootingState) -> f64 {
        let n = state.states[0].len() / 2;
        let each = state.states.iter().map(|x| {
            let (q, v) = (x.rows(0, n).amax(), x.rows(n, n).amax());
            (q / self.units.position).max(v / self.units.velocity)
        });
        each.fold(0.0, f64::max)
    }

    /// How many times are unknown.
    fn n_times(&self) -> usize {
        if self.is_empty() {
            0
        } else {
            self.signature.stages.len()
        }
    }

    /// How many unknowns a loop has: those before its times, these, and those after them.
    pub fn n_unknowns(&self, place: &ParametricLoop) -> usize {
        place.before_times().len() + self.n_times() + self.formulation.n_after_times()
    }

    /// The unit of an unknown before the times.
    pub fn unit_before_times(&self, place: &ParametricLoop, unknown: usize) -> f64 {
        if unknown < place.n_positions() {
            self.units.position
        } else {
            self.units.velocity
        }
    }

    /// The chord from a closed loop to another, in scaled unknowns; those after the times are zero of both.
    pub fn between(&self, from: &ParametricLoop, to: &ParametricLoop) -> BranchDirection {
        let [one, other] = [from, to].map(ParametricLoop::before_times);
        let before = one.iter().zip(other).enumerate();
        let before = before.map(|(i, (a, b))| (b - a) / self.unit_before_times(from, i));
        let first = usize::from(self.is_free);
        let times = (first..first + self.n_times())
            .map(|k| to.state.times[k] / to.clock - from.state.times[k] / from.clock);
        let after = std::iter::repeat_n(0.0, self.formulation.n_after_times());
        let all: Vec<f64> = before.chain(times).chain(after).collect();
        BranchDirection {
            loop_part: DVector::from_vec(all),
            value_part: (to.value - from.value) / self.span(),
        }
    }
}

/// The units of the loop of an orbit: by its states and by those before its impacts, as after impacts with e = 0 the states may be zero but
/// for rounding.
fn units_of(orbit: &PeriodicOrbit, state: &ShootingState) -> ScaledUnits {
    let first = state.times[0];
    let ends = state
        .times
        .iter()
        .skip(1)
        .map(|t| joined(&orbit.state_at(t - first, ImpactSide::Before)));
    let ends: Vec<DVector<f64>> = ends.collect();
    let period = state.times[state.times.len() - 1] - first;
    ScaledUnits::of(state.states.iter().chain(&ends), period)
}

/// The width of a range, or a small part of its numbers where it is narrower still.
pub(super) fn span_of((low, high): (f64, f64)) -> f64 {
    (high - low).max(NARROW_RANGE * low.abs().max(high.abs()))
}

/// A loop of one scene moved to another, its instants at the same phases of the forcing.
pub(crate) fn stretched(state: &ShootingState, from: &Scene, to: &Scene) -> ShootingState {
    let factor = match (from.frequency(), to.frequency()) {
        (Some(from), Some(to)) => from / to,
        _ => 1.0,
    };
    let stretch = |times: &[f64]| times.iter().map(|t| t * factor).collect();
    ShootingState {
        times: stretch(&state.times),
        starts: stretch(&state.starts),
        states: state.states.clone(),
    }
}

/// Refuses a scene in which a loop of another one has no meaning.
pub(crate) fn check_same(one: &Scene, other: &Scene, value: f64) -> Result<()> {
    let shape = |scene: &Scene| {
        (
            scene.n_dof(),
            scene.stops().len(),
            scene.frequency().is_some(),
        )
    };
    if shape(one) == shape(other) {
        return Ok(());
    }
    let (n, stops, forced) = shape(other);
    let forcing = if forced { "a" } else { "no" };
    let found = format!("of {n} coordinates, {stops} stops and {forcing} forcing at {value}");
    let rule = "it must have as many coordinates and stops as the scene of the orbit, and a forcing where that has one";
    Err(Error::bad_value(
        "parameter",
        format!("a scene {found}"),
        rule,
    ))
}
