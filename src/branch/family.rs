//! The scenes of a branch, one for each value of its parameter.

use crate::branch::place::{Direction, Place};
use crate::error::{Error, Result};
use crate::hybrid::{ScaledUnits, joined};
use crate::model::{Energetics, Scene};
use crate::orbit::{
    Event, Guess, PeriodicOrbit, ShootingState, Signature, begun, check_landings, with_phase,
};
use nalgebra::DVector;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::rc::Rc;
use std::sync::Arc;

/// A range of so small a part of its numbers is measured by these: steps in parts of it would be lost in their rounding.
const SHORT: f64 = 1e-3;

/// The scenes of a branch, what happens along its orbits, and the units of its unknowns.
#[derive(Clone)]
pub(super) struct Family<'a> {
    pub make: &'a dyn Fn(f64) -> Result<Scene>,
    /// The range that is asked for.
    pub range: (f64, f64),
    pub signature: Signature,
    /// The phase of the forcing at time zero, for all of them; whether there is none, and the first instant is at time zero.
    pub phase: f64,
    pub is_free: bool,
    /// Units of positions and velocities, and of time where nothing gives one.
    pub units: ScaledUnits,
    /// Where the number is the energy of the motion.
    pub energetics: Option<&'a Energetics>,
    /// Whether loops are followed by their impulses.
    pub has_pulses: bool,
    pub recent: Recent,
}

/// The scenes made last, with their values and phases: of one several questions are asked. Copies share them.
#[derive(Clone, Default)]
pub(super) struct Recent(Rc<RefCell<VecDeque<(f64, f64, Arc<Scene>)>>>);

/// So many are kept.
const MOST_RECENT: usize = 4;

impl Recent {
    fn of(&self, value: f64, phase: f64) -> Option<Arc<Scene>> {
        let known = self.0.borrow();
        let mut known = known.iter().filter(|own| (own.0, own.1) == (value, phase));
        known.next().map(|(_, _, scene)| Arc::clone(scene))
    }

    fn keep(&self, value: f64, phase: f64, scene: Scene) -> Arc<Scene> {
        let (mut known, scene) = (self.0.borrow_mut(), Arc::new(scene));
        known.truncate(MOST_RECENT - 1);
        known.push_front((value, phase, Arc::clone(&scene)));
        scene
    }
}

impl<'a> Family<'a> {
    /// The scenes about an orbit, which is that of a value, and the orbit's loop in the scene of that value.
    pub fn around(
        orbit: &PeriodicOrbit,
        make: &'a dyn Fn(f64) -> Result<Scene>,
        value: f64,
        range: (f64, f64),
    ) -> Result<(Self, Place)> {
        let (scene, signature, state) = begun(&make(value)?, Guess::Orbit(orbit), None)?;
        let units = units_of(orbit, &state);
        let family = Self {
            make,
            range,
            signature,
            phase: scene.phase(),
            is_free: scene.frequency().is_none(),
            units,
            energetics: None,
            has_pulses: false,
            recent: Recent::default(),
        };
        let place = family.place(&scene, value, state)?;
        Ok((family, place))
    }

    /// A loop in the scene of a value.
    pub fn place(&self, scene: &Scene, value: f64, state: ShootingState) -> Result<Place> {
        let clock = self.units_in(scene).time;
        Ok(Place {
            value,
            impulses: self.impulses_of(scene, &state)?,
            state,
            clock,
        })
    }

    /// Whether nothing happens along the orbits: they are one flight, however long.
    pub fn is_empty(&self) -> bool {
        self.signature.stages[0].event == Event::Nothing
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

    /// The unit of the parameter.
    pub fn span(&self) -> f64 {
        span_of(self.range)
    }

    /// A value, the end of the range where it is that but for rounding: beyond it there may be no scene.
    pub fn snapped(&self, value: f64) -> f64 {
        let (low, high) = self.range;
        let rounding = 4.0 * f64::EPSILON * self.span();
        let ends = [low, high].into_iter();
        let end = ends.min_by(|a, b| (a - value).abs().total_cmp(&(b - value).abs()));
        end.filter(|end| (end - value).abs() <= rounding)
            .unwrap_or(value)
    }

    /// The step of a difference by the parameter.
    pub fn difference(&self, value: f64) -> f64 {
        let size = value.abs().max(1e-3 * self.span());
        6e-6 * self.span().min(size)
    }

    /// The units in a scene, where times count in angles of its forcing.
    pub fn units_in(&self, scene: &Scene) -> ScaledUnits {
        let time = scene.frequency().map_or(self.units.time, f64::recip);
        ScaledUnits { time, ..self.units }
    }

    /// By how many turns of the forcing a loop comes later than another.
    pub fn turns(&self, from: &Place, to: &Place) -> f64 {
        let later = to.state.times[0] / to.clock - from.state.times[0] / from.clock;
        if self.is_free {
            0.0
        } else {
            (later / TAU).round()
        }
    }

    /// How large the states of a loop are in the units.
    pub fn size(&self, state: &ShootingState) -> f64 {
        let n = state.states[0].len() / 2;
        let each = state.states.iter().map(|x| {
            let (q, v) = (x.rows(0, n).amax(), x.rows(n, n).amax());
            (q / self.units.position).max(v / self.units.velocity)
        });
        each.fold(0.0, f64::max)
    }

    /// How many unknowns a loop has: its first state, its times, and what it is open by where the number is the energy.
    pub fn n_unknowns(&self, place: &Place) -> usize {
        let times = if self.is_empty() {
            0
        } else {
            self.signature.stages.len()
        };
        place.n_before_times() + times + usize::from(self.energetics.is_some())
    }

    /// The way from a loop to another, in the scaled unknowns.
    pub fn between(&self, from: &Place, to: &Place) -> Direction {
        if self.has_pulses {
            return self.between_pulses(from, to);
        }
        let unknowns = self.n_unknowns(from);
        let two_n = from.state.states[0].len();
        let first = usize::from(self.is_free);
        let part = |i: usize| {
            if i < two_n {
                let unit = if i < two_n / 2 {
                    self.units.position
                } else {
                    self.units.velocity
                };
                (to.state.states[0][i] - from.state.states[0][i]) / unit
            } else if self.energetics.is_some() && i + 1 == unknowns {
                // Both are closed.
                0.0
            } else {
                let k = i - two_n + first;
                to.state.times[k] / to.clock - from.state.times[k] / from.clock
            }
        };
        Direction {
            loop_part: DVector::from_fn(unknowns, |i, _| part(i)),
            value_part: (to.value - from.value) / self.span(),
        }
    }
}

/// The units of a loop that is that of an orbit: of its states, and of those before its impacts, as behind impacts that take all speed the
/// states may be zero but for rounding.
fn units_of(orbit: &PeriodicOrbit, state: &ShootingState) -> ScaledUnits {
    let first = state.times[0];
    let ends = state
        .times
        .iter()
        .skip(1)
        .map(|t| joined(&orbit.state(t - first, true)));
    let ends: Vec<DVector<f64>> = ends.collect();
    let period = state.times[state.times.len() - 1] - first;
    ScaledUnits::of(state.states.iter().chain(&ends), period)
}

/// The unit of a number of some range: the width, unless that is next to nothing of it.
pub(super) fn span_of((low, high): (f64, f64)) -> f64 {
    (high - low).max(SHORT * low.abs().max(high.abs()))
}

/// A loop of one scene in another, instants at the phases that they have.
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

/// Refuses scenes in which a loop of another has no meaning.
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
