//! A run as an itinerary (theory 21): arcs, which are free flights or flights with stops held, and the events at their ends; accumulating
//! impacts are arcs of their own down to their last. Each arc and each event is differentiated by itself. States are (q, v) [m, m/s], times
//! [s].

use crate::error::{Error, Result};
use crate::flow::differences::WarningLog;
use crate::hybrid::chatter_map::{NO_REST, complete, finish};
use crate::hybrid::{IntegratedMaps, ScaledUnits, SegmentKind, Timed, joined, land, largest_of};
use crate::law::{Regime, Stage, Transition};
use crate::model::Scene;
use crate::orbit::{Shooting, Signature, WEAK_INTEGRATED, instants_of, with_shooting};
use crate::simulate::{ImpactSide, Trajectory};
use crate::tolerance::{FLIGHT_CUT_GROWTH, HIT_TOGETHER_GAP, TOUCHING_IMPACT_SPEED};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Why a run that begins on a stop has no derivatives.
const BEGINS_IN_CONTACT: &str = "the run begins in contact: one-sided only";
/// Halvings of a flight beyond which it is cut no further. [work]
const MOST_FLIGHT_CUTS: i32 = 30;

/// A part of a run between instants, and what happens at its end.
pub(super) struct RunArc {
    pub start: f64,
    pub end: f64,
    /// The state (q, v) at its start, shape (2n,), [m, m/s].
    pub state: DVector<f64>,
    /// The state (q, v) at its end, before what happens there, shape (2n,), [m, m/s].
    pub before: DVector<f64>,
    /// Places in the list of times that are asked for, and the times, in order of time.
    pub asked: Vec<(usize, f64)>,
    /// Whether it ends with one of the impacts that accumulate.
    pub is_accumulating: bool,
}

/// A run arc by arc. The event at the end of arc k is number k + 1 of the signature; it is `Transition::Nothing` where a flight is cut.
pub(super) struct Itinerary {
    pub arcs: Vec<RunArc>,
    pub signature: Signature,
    pub units: ScaledUnits,
    pub n_stops: usize,
    /// Time spans of accumulating impacts, within which a run has no derivatives.
    accumulations: Vec<(f64, f64)>,
}

impl Itinerary {
    /// The itinerary of a run, or the reason why the run has no derivatives at all.
    pub fn of(run: &Trajectory) -> Result<std::result::Result<Self, String>> {
        let (first, end) = run.span();
        let begin = joined(&run.state(first, ImpactSide::Before)?);
        let is_held = (run.stretches()?.first()).is_some_and(|own| own.kind != SegmentKind::Flight);
        let instants = match instants_of(run) {
            Ok(instants) => instants,
            Err(Error::BadValue { value, .. }) => {
                return Ok(Err(format!("of {value} there are none")));
            }
            Err(error) => return Err(error),
        };
        let is_struck = instants.first().is_some_and(|own| own.time <= first);
        if is_held || is_struck {
            return Ok(Err(BEGINS_IN_CONTACT.to_owned()));
        }
        let mut stages = vec![Stage::free(Transition::Nothing)];
        stages.extend(instants.iter().map(|own| own.stage.clone()));
        let states: Vec<&DVector<f64>> = instants.iter().map(|own| &own.state).collect();
        let units = units(states.into_iter().chain([&begin]), run);
        let mut all = Self {
            arcs: Vec::with_capacity(instants.len() + 1),
            signature: Signature {
                stages,
                n_periods: 1,
                depends_on_time: false,
                units,
                images: None,
            },
            units,
            n_stops: run.scene().stops().len(),
            accumulations: Vec::new(),
        };
        let signature = all.signature.clone();
        let read = with_shooting(run.scene(), &signature, |shooting, _| {
            if all.is_touching(shooting, (first, &begin))? {
                return Ok(false);
            }
            all.signature.stages.truncate(1);
            let mut from = (first, begin);
            for own in instants {
                debug_assert!(
                    own.stage.transition.is_chatter() <= all.regime(all.arcs.len()).is_free()
                );
                let before = all.fly(shooting, from, own.time)?;
                if own.stage.transition.is_chatter() {
                    all.accumulate(shooting, (own.time, before), own.stage)?;
                    all.accumulations.push((own.time, own.start));
                } else {
                    all.signature.stages.push(own.stage);
                }
                from = (own.start, own.state);
            }
            all.fly(shooting, from, end)?;
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
        let states = all.arcs.iter().flat_map(|arc| [&arc.state, &arc.before]);
        all.units = self::units(states, run);
        all.signature.units = all.units;
        Ok(Ok(all))
    }

    /// Adds the arcs of a flight from a state on, and returns the state at its end.
    fn fly(
        &mut self,
        shooting: &Shooting<'_>,
        (mut start, mut state): (f64, DVector<f64>),
        end: f64,
    ) -> Result<DVector<f64>> {
        let regime = self.regime(self.arcs.len()).clone();
        let whole = end - start;
        let mut length = whole;
        let is_linear = shooting.weak_directions != WEAK_INTEGRATED;
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
            (shooting.motion).flow(&regime, (start, to), &mut there, &mut jacobian)?;
            if self.units.scaled(&jacobian).amax() > FLIGHT_CUT_GROWTH
                && length > whole * 0.5f64.powi(MOST_FLIGHT_CUTS)
            {
                length *= 0.5;
                continue;
            }
            self.arcs.push(RunArc {
                start,
                end: to,
                state,
                before: there.clone(),
                asked: Vec::new(),
                is_accumulating: false,
            });
            if to >= end {
                return Ok(there);
            }
            self.signature.stages.push(Stage {
                transition: Transition::Nothing,
                regime: regime.clone(),
            });
            (start, state) = (to, there);
            length *= 2.0;
        }
    }

    /// Adds accumulating impacts, from the state before the first of them, and the flights between them; `rest` is the event that completes
    /// them.
    fn accumulate(
        &mut self,
        shooting: &Shooting<'_>,
        (time, state): (f64, DVector<f64>),
        rest: Stage,
    ) -> Result<()> {
        let stop = rest.transition.element().expect("impacts on a stop");
        let none = DMatrix::zeros(state.len(), 0);
        let mut y = Timed {
            time,
            state,
            deviations: none,
            delays: DVector::zeros(0),
        };
        let all = complete(shooting.motion, stop, &self.units, &mut y)?;
        if let Some(last) = self.arcs.last_mut() {
            last.is_accumulating = true;
        }
        let ends = all.bounces.iter().skip(1);
        let ends = ends.map(|next| (next.time, next.before.clone()));
        let ends = ends.chain([(all.last_time, all.last)]);
        for (bounce, (end, before)) in all.bounces.iter().zip(ends) {
            let struck = Stage::free(Transition::Strike(vec![stop]));
            self.signature.stages.push(struck);
            self.arcs.push(RunArc {
                start: bounce.time,
                end,
                state: bounce.after.clone(),
                before,
                asked: Vec::new(),
                is_accumulating: true,
            });
        }
        self.signature.stages.push(rest);
        Ok(())
    }

    /// Assigns each of the times that are asked for to the arc that it lies on; those within accumulating impacts are left out.
    pub fn ask(&mut self, times: &[f64]) {
        let mut order: Vec<(usize, f64)> = times.iter().copied().enumerate().collect();
        order.sort_by(|a, b| a.1.total_cmp(&b.1));
        for (place, t) in order {
            let is_within = |own: &(f64, f64)| own.0 <= t && t < own.1;
            if self.accumulations.iter().any(is_within) {
                continue;
            }
            let own = self.arcs.iter().rposition(|arc| arc.start <= t);
            self.arcs[own.unwrap_or(0)].asked.push((place, t));
        }
    }

    /// Whether the run begins on a stop that it does not leave.
    fn is_touching(
        &self,
        shooting: &Shooting<'_>,
        (start, state): (f64, &DVector<f64>),
    ) -> Result<bool> {
        let n = state.len() / 2;
        for stop in 0..self.n_stops {
            let at = shooting.motion.gap(stop, start, state)?;
            let size = at.gradient.amax();
            let (near, slow) = (
                HIT_TOGETHER_GAP * size * self.units.position,
                TOUCHING_IMPACT_SPEED * size * self.units.velocity,
            );
            if at.gap <= near && at.speed(state.rows(n, n)) <= slow {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// The number of the event at the end of an arc; `None` for the last arc.
    pub fn event(&self, k: usize) -> Option<usize> {
        Some(k + 1).filter(|next| *next < self.arcs.len())
    }

    /// Whether an event only cuts a flight.
    pub fn is_cut(&self, event: usize) -> bool {
        self.signature.stages[event].transition.is_nothing()
    }

    /// The regime behind an event.
    pub fn regime(&self, stage: usize) -> &Regime {
        &self.signature.stages[stage].regime
    }

    /// Maps a state before an event to the one after it, with its deviations; stops held from then on take away, along their
    /// reactions, the deviations that would leave them.
    pub fn pass(&self, shooting: &Shooting<'_>, event: usize, y: &mut Timed) -> Result<()> {
        if let Transition::Chatter(stop) = self.signature.stages[event].transition {
            finish(shooting.motion, stop, &self.units, y)?;
        } else {
            shooting.pass(event, &self.units, y)?;
        }
        land(shooting.motion, self.regime(event), y)
    }

    /// The scaled residual of the condition of an event in a state before it, and its derivatives by the deviations: the gap of the stop that
    /// is struck, or the condition of another event. `None` where a stop that is held receives its impulse with another stop: it has no
    /// condition of its own.
    pub fn lacks(
        &self,
        shooting: &Shooting<'_>,
        event: usize,
        y: &Timed,
    ) -> Result<Option<(f64, DVector<f64>)>> {
        if let Some(condition) = shooting.condition(event, &self.units, y)? {
            return Ok(Some(condition));
        }
        let Some(stop) = shooting.newly_struck(event).next() else {
            return Ok(None);
        };
        let at = shooting.motion.gap(stop, y.time, &y.state)?;
        let scale = 1.0 / (at.gradient.amax() * self.units.position);
        let row = at.timed_deviations(&y.deviations, &y.delays);
        Ok(Some((at.gap * scale, row * scale)))
    }
}

impl RunArc {
    /// The state before its end, with `count` deviations that are zero.
    pub fn timed(&self, count: usize) -> Timed {
        Timed {
            time: self.end,
            state: self.before.clone(),
            deviations: DMatrix::zeros(self.before.len(), count),
            delays: DVector::zeros(count),
        }
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

/// Calls `work` with the equations of motion of a run, in a scene of any kind, and with the record of times at which deviations are not to be
/// trusted.
pub(super) fn with_doubts<T>(
    scene: &Scene,
    signature: &Signature,
    work: impl FnOnce(&Shooting<'_>, &WarningLog) -> Result<T>,
) -> Result<T> {
    if scene.linear_system("derivatives").is_ok() {
        return with_shooting(scene, signature, |shooting, _| {
            work(shooting, &WarningLog::default())
        });
    }
    let motion = IntegratedMaps::new(scene, scene.phase()).in_units(signature.units);
    let (motion, watch) = motion.watched();
    let shooting = Shooting {
        motion: &motion,
        stages: &signature.stages,
        clocked: signature.clocked(scene),
        images: None,
        weak_directions: WEAK_INTEGRATED,
    };
    work(&shooting, &watch)
}
