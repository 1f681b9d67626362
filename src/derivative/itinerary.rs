//! A run as an itinerary (theory 21): arcs, which are free flights or flights with stops held, and the events at their ends; accumulating
//! impacts are arcs of their own down to their last. Each arc and each event is differentiated by itself. States are (q, v) [m, m/s], times
//! [s].

use crate::error::{Error, Result};
use crate::flow::differences::WarningLog;
use crate::hybrid::chatter_map::{NO_REST, complete};
use crate::hybrid::{HybridMaps, IntegratedMaps, ScaledUnits, Timed, joined, largest_of};
use crate::itinerary::{Instant, MotionArc, bounces, instants_of};
use crate::law::Stage;
use crate::model::Scene;
use crate::orbit::{Signature, with_maps};
use crate::path::{ImpactSide, KeptMotion, Motion};
use crate::simulate::Trajectory;
use crate::tolerance::{FLIGHT_CUT_GROWTH, HIT_TOGETHER_GAP, TOUCHING_IMPACT_SPEED};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use std::ops::RangeInclusive;

/// Why a run that begins on a stop has no derivatives.
const BEGINS_IN_CONTACT: &str = "the run begins in contact: one-sided only";
/// Halvings of a flight beyond which it is cut no further. [work]
const MOST_FLIGHT_CUTS: i32 = 30;

/// A run arc by arc; an arc after a cut begins with nothing.
pub(super) struct RunItinerary {
    /// The arcs, shape (arcs,), times [s] and states (q, v), [m, m/s].
    pub arcs: Vec<MotionArc<DVector<f64>>>,
    /// For each arc the places in the list of times that are asked for, and the times, in order of time.
    pub asked: Vec<Vec<(usize, f64)>>,
    /// What happens along it, for the equations of motion.
    pub signature: Signature,
    pub units: ScaledUnits,
    pub n_stops: usize,
    accumulations: Vec<Accumulation>,
}

/// Impacts that accumulate, within whose time a run has no derivatives.
struct Accumulation {
    /// From the first of them to where the motion comes to rest.
    span: (f64, f64),
    /// The arcs that end with one of them.
    arcs: RangeInclusive<usize>,
}

impl RunItinerary {
    /// The itinerary of a run, or the reason why the run has no derivatives at all.
    pub fn of(run: &Trajectory) -> Result<std::result::Result<Self, String>> {
        let (first, end) = run.span();
        let begin = joined(&run.state(first, ImpactSide::Before)?);
        let stretches = run.stretches()?;
        let begun = stretches.first().map(|own| own.regime.clone());
        let begun = begun.unwrap_or_default();
        let is_in_contact = !begun.constrained().is_empty();
        let instants = match instants_of(run) {
            Ok(instants) => instants.into_iter().map(|own| own.instant),
            Err(Error::BadValue { value, .. }) => {
                return Ok(Err(format!("of {value} there are none")));
            }
            Err(error) => return Err(error),
        };
        let instants: Vec<Instant> = instants.collect();
        let is_struck = instants.first().is_some_and(|own| own.time <= first);
        if is_in_contact || is_struck {
            return Ok(Err(BEGINS_IN_CONTACT.to_owned()));
        }
        let mut before = &begun;
        for own in &instants {
            if own.stage.transition.is_chatter() && !before.is_free() {
                let reason = "impacts accumulate beside another stop in contact";
                return Ok(Err(reason.to_owned()));
            }
            if let Some(stop) = own.stage.transition.met_again() {
                let reason = format!("stop {stop} is met before it is back at its place");
                return Ok(Err(reason));
            }
            before = &own.stage.regime;
        }
        let none = Stage::uneventful(begun.clone());
        let stages = instants.iter().map(|own| own.stage.clone());
        let units = units(instants.iter().map(|own| &own.state).chain([&begin]), run);
        let mut all = Self {
            arcs: Vec::with_capacity(instants.len() + 1),
            asked: Vec::new(),
            signature: Signature {
                stages: std::iter::once(none.clone()).chain(stages).collect(),
                n_periods: 1,
                depends_on_time: false,
                units,
                images: None,
            },
            units,
            n_stops: run.scene().stops().len(),
            accumulations: Vec::new(),
        };
        let is_linear = run.scene().linear_system("derivatives").is_ok();
        let signature = all.signature.clone();
        let read = with_maps(run.scene(), &signature, |motion| {
            if all.is_touching(motion, (first, &begin), run.scene())? {
                return Ok(false);
            }
            let mut from = (first, begin);
            let mut stage = none;
            for own in instants {
                debug_assert!(
                    own.stage.transition.accumulation().is_none() || stage.regime.is_free()
                );
                let before = all.fly((motion, is_linear), stage, from, own.time)?;
                if let Some(stop) = own.stage.transition.accumulation() {
                    all.accumulate(motion, stop, (own.time, own.start), before)?;
                }
                (stage, from) = (own.stage, (own.start, own.state));
            }
            all.fly((motion, is_linear), stage, from, end)?;
            Ok(true)
        });
        match read {
            Ok(true) => {}
            Ok(false) => return Ok(Err(BEGINS_IN_CONTACT.to_owned())),
            Err(Error::NoConvergence { stage, .. }) if stage == NO_REST => {
                return Ok(Err("impacts that accumulate come to no rest".to_owned()));
            }
            Err(error) => return Err(error),
        }
        let states = all
            .arcs
            .iter()
            .flat_map(|arc| [&arc.after, &arc.before_next]);
        all.units = self::units(states, run);
        all.signature.units = all.units;
        all.signature.stages = all.arcs.iter().map(|arc| arc.stage.clone()).collect();
        all.asked = vec![Vec::new(); all.arcs.len()];
        Ok(Ok(all))
    }

    /// Adds the arcs of a flight that begins with a stage, from a state on, and returns the state at its end.
    fn fly(
        &mut self,
        (motion, is_linear): (&dyn HybridMaps, bool),
        mut stage: Stage,
        (mut start, mut state): (f64, DVector<f64>),
        end: f64,
    ) -> Result<DVector<f64>> {
        let regime = stage.regime.clone();
        let whole = end - start;
        let mut length = whole;
        loop {
            let to = if start + length >= end {
                end
            } else {
                start + length
            };
            let mut jacobian = if is_linear {
                DMatrix::zeros(state.len(), 0)
            } else {
                DMatrix::identity(state.len(), state.len())
            };
            let mut there = state.clone();
            motion.flow(&regime, (start, to), &mut there, &mut jacobian)?;
            if self.units.scaled(&jacobian).amax() > FLIGHT_CUT_GROWTH
                && length > whole * 0.5f64.powi(MOST_FLIGHT_CUTS)
            {
                length *= 0.5;
                continue;
            }
            let states = [state, there.clone()];
            self.arcs
                .push(MotionArc::between(stage, (start, to), states));
            if to >= end {
                return Ok(there);
            }
            stage = Stage::uneventful(regime.clone());
            (start, state) = (to, there);
            length *= 2.0;
        }
    }

    /// Adds the flights between accumulating impacts on a stop, from the state before the first of them.
    fn accumulate(
        &mut self,
        motion: &dyn HybridMaps,
        stop: usize,
        span: (f64, f64),
        state: DVector<f64>,
    ) -> Result<()> {
        let mut y = Timed {
            time: span.0,
            deviations: DMatrix::zeros(state.len(), 0),
            delays: DVector::zeros(0),
            state,
        };
        let all = complete(motion, stop, &self.units, &mut y)?;
        let first = self.arcs.len().saturating_sub(1);
        self.arcs.extend(bounces(stop, &all));
        let arcs = first..=self.arcs.len().saturating_sub(1);
        self.accumulations.push(Accumulation { span, arcs });
        Ok(())
    }

    /// Whether an arc ends with one of the impacts that accumulate.
    pub fn is_accumulating(&self, k: usize) -> bool {
        self.accumulations.iter().any(|own| own.arcs.contains(&k))
    }

    /// Whether impacts accumulate somewhere.
    pub fn accumulates(&self) -> bool {
        !self.accumulations.is_empty()
    }

    /// Assigns each of the times that are asked for to the arc that it lies on; those within accumulating impacts are left out.
    pub fn ask(&mut self, times: &[f64]) {
        let mut order: Vec<(usize, f64)> = times.iter().copied().enumerate().collect();
        order.sort_by(|a, b| a.1.total_cmp(&b.1));
        for (place, t) in order {
            let is_within = |own: &Accumulation| own.span.0 <= t && t < own.span.1;
            if self.accumulations.iter().any(is_within) {
                continue;
            }
            let own = self.arcs.iter().rposition(|arc| arc.start <= t);
            self.asked[own.unwrap_or(0)].push((place, t));
        }
    }

    /// Whether the run begins on a stop that it does not leave, or at the place of one that gives way.
    fn is_touching(
        &self,
        motion: &dyn HybridMaps,
        (start, state): (f64, &DVector<f64>),
        scene: &Scene,
    ) -> Result<bool> {
        let n = state.len() / 2;
        for stop in 0..self.n_stops {
            let at = motion.gap(stop, start, state)?;
            let size = at.gradient.amax();
            let (near, slow) = (
                HIT_TOGETHER_GAP * size * self.units.position,
                TOUCHING_IMPACT_SPEED * size * self.units.velocity,
            );
            let touches = if scene.stops()[stop].contact().is_rigid() {
                at.gap <= near && at.speed(state.rows(n, n)) <= slow
            } else {
                at.gap.abs() <= near
            };
            if touches {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// The arc after an arc, if the event between them is more than a cut; none after the last.
    pub fn next(&self, k: usize) -> Option<&MotionArc<DVector<f64>>> {
        let next = self.arcs.get(k + 1);
        next.filter(|next| !next.stage.transition.is_nothing())
    }
}

/// The state before the end of an arc, with `count` deviations that are zero.
pub(super) fn timed(arc: &MotionArc<DVector<f64>>, count: usize) -> Timed {
    Timed {
        time: arc.end,
        state: arc.before_next.clone(),
        deviations: DMatrix::zeros(arc.before_next.len(), count),
        delays: DVector::zeros(count),
    }
}

/// The units of a run that goes through some states.
fn units<'a>(
    states: impl Iterator<Item = &'a DVector<f64>> + Clone,
    run: &Trajectory,
) -> ScaledUnits {
    if let Some(period) = run.scene().period() {
        return ScaledUnits::of(states, period);
    }
    // Without a period the time in which it goes as far as it goes: it may last much longer.
    let (first, end) = run.span();
    let [position, velocity] = largest_of(states.clone());
    let time = position / velocity;
    let whole = end - first;
    let is_time = time > 0.0 && TAU * time < whole;
    ScaledUnits::of(states, if is_time { TAU * time } else { whole })
}

/// Calls `work` with the maps of the scene of a run, and with the record of times at which deviations are not to be trusted.
pub(super) fn with_doubts<T>(
    scene: &Scene,
    signature: &Signature,
    work: impl FnOnce(&dyn HybridMaps, &WarningLog) -> Result<T>,
) -> Result<T> {
    if scene.linear_system("derivatives").is_ok() {
        let none = WarningLog::default();
        return with_maps(scene, signature, |motion| work(motion, &none));
    }
    let motion = IntegratedMaps::new(scene, scene.phase()).in_units(signature.units);
    let (motion, watch) = motion.watched();
    work(&motion, &watch)
}
