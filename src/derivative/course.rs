//! A run as a course of legs (theory 21): flights and what happens at their ends, those impacts of which a sequence accumulates among them, each
//! of which is differentiated by itself.

use crate::error::{Error, Result};
use crate::flow::differences::Watch;
use crate::hybrid::chatter_map::{NO_REST, complete, finish};
use crate::hybrid::{IntegratedMaps, ScaledUnits, SegmentKind, Timed, joined, land, largest_of};
use crate::model::Scene;
use crate::orbit::{
    ContactStage, Event, OF_INTEGRATED, Shooting, Signature, instants_of, with_shooting,
};
use crate::simulate::{ImpactSide, Trajectory};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// An impact of so small a part of the motion's speed is a touch that the rounding of the gap made one.
pub(super) const SLOW: f64 = 1e-7;
/// A stop whose gap is no larger, in parts of the motion, at the impact on another is met with it.
pub(super) const MET: f64 = 1e-9;
const BEGUN: &str = "the run begins in contact: one-sided only";
/// Growth of deviations, in parts of the motion, beyond which a flight of a nonlinear system is cut: a difference of it would go too far.
const MOST_GROWTH: f64 = 10.0;
/// Halvings of a flight beyond which it is cut no further.
const MOST_CUTS: i32 = 30;

/// A part of a run between instants, and what happens at its end.
pub(super) struct Leg {
    pub start: f64,
    pub end: f64,
    pub state: DVector<f64>,
    /// The state before its end.
    pub before: DVector<f64>,
    /// Times that are asked for, by their places, in order.
    pub asked: Vec<(usize, f64)>,
    /// Whether it ends with one of the impacts that accumulate.
    pub is_accumulating: bool,
}

/// A run leg by leg. What happens at the end of leg k is event k + 1 of the signature; nothing where a flight is cut.
pub(super) struct Course {
    pub legs: Vec<Leg>,
    pub signature: Signature,
    pub units: ScaledUnits,
    pub n_stops: usize,
    /// Within impacts that accumulate a run has no derivatives.
    accumulations: Vec<(f64, f64)>,
}

impl Course {
    /// The course of a run; why it has no derivatives, if it has none at all.
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
            return Ok(Err(BEGUN.to_owned()));
        }
        let mut stages = vec![free(Event::Nothing)];
        stages.extend(instants.iter().map(|own| ContactStage {
            event: own.event.clone(),
            held: own.held.clone(),
        }));
        let states: Vec<&DVector<f64>> = instants.iter().map(|own| &own.state).collect();
        let units = units(states.into_iter().chain([&begin]), run);
        let mut all = Self {
            legs: Vec::with_capacity(instants.len() + 1),
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
        let flown = with_shooting(run.scene(), &signature, |shooting, _| {
            if all.is_touching(shooting, (first, &begin))? {
                return Ok(false);
            }
            all.signature.stages.truncate(1);
            let mut from = (first, begin);
            for own in instants {
                let held = all.held(all.legs.len()).to_vec();
                let before = all.fly(shooting, from, own.time)?;
                let stage = |event: Event| ContactStage {
                    event,
                    held: own.held.clone(),
                };
                if let Event::Chatter(stop) = own.event {
                    debug_assert!(held.is_empty());
                    all.accumulate(shooting, (own.time, before), stop, stage(own.event.clone()))?;
                    all.accumulations.push((own.time, own.start));
                } else {
                    all.signature.stages.push(stage(own.event));
                }
                from = (own.start, own.state);
            }
            all.fly(shooting, from, end)?;
            Ok(true)
        });
        match flown {
            Ok(true) => {}
            Ok(false) => return Ok(Err(BEGUN.to_owned())),
            Err(Error::NoConvergence { stage, .. }) if stage == NO_REST => {
                return Ok(Err("impacts that accumulate come to no rest".to_owned()));
            }
            Err(error) => return Err(error),
        }
        let states = all.legs.iter().flat_map(|leg| [&leg.state, &leg.before]);
        all.units = self::units(states, run);
        all.signature.units = all.units;
        Ok(Ok(all))
    }

    /// Adds the legs of a flight from a state on, and returns the state at its end.
    fn fly(
        &mut self,
        shooting: &Shooting<'_>,
        (mut start, mut state): (f64, DVector<f64>),
        end: f64,
    ) -> Result<DVector<f64>> {
        let held = self.held(self.legs.len()).to_vec();
        let whole = end - start;
        let mut length = whole;
        let is_linear = shooting.weak_directions != OF_INTEGRATED;
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
            (shooting.motion).flow(&held, (start, to), &mut there, &mut jacobian)?;
            if self.units.scaled(&jacobian).amax() > MOST_GROWTH
                && length > whole * 0.5f64.powi(MOST_CUTS)
            {
                length *= 0.5;
                continue;
            }
            self.legs.push(Leg {
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
            self.signature.stages.push(ContactStage {
                event: Event::Nothing,
                held: held.clone(),
            });
            (start, state) = (to, there);
            length *= 2.0;
        }
    }

    /// Adds the impacts that accumulate from a state before the first of them, with the flights between; what is left of them is the last event.
    fn accumulate(
        &mut self,
        shooting: &Shooting<'_>,
        (time, state): (f64, DVector<f64>),
        stop: usize,
        rest: ContactStage,
    ) -> Result<()> {
        let none = DMatrix::zeros(state.len(), 0);
        let mut y = Timed {
            time,
            state,
            deviations: none,
            delays: DVector::zeros(0),
        };
        let all = complete(shooting.motion, stop, &self.units, &mut y)?;
        if let Some(last) = self.legs.last_mut() {
            last.is_accumulating = true;
        }
        let ends = all.bounces.iter().skip(1);
        let ends = ends.map(|next| (next.time, next.before.clone()));
        let ends = ends.chain([(all.last_time, all.last)]);
        for (bounce, (end, before)) in all.bounces.iter().zip(ends) {
            self.signature.stages.push(free(Event::Strike(vec![stop])));
            self.legs.push(Leg {
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

    /// Asks for times.
    pub fn ask(&mut self, times: &[f64]) {
        let mut order: Vec<(usize, f64)> = times.iter().copied().enumerate().collect();
        order.sort_by(|a, b| a.1.total_cmp(&b.1));
        for (place, t) in order {
            let is_within = |own: &(f64, f64)| own.0 <= t && t < own.1;
            if self.accumulations.iter().any(is_within) {
                continue;
            }
            let own = self.legs.iter().rposition(|leg| leg.start <= t);
            self.legs[own.unwrap_or(0)].asked.push((place, t));
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
                MET * size * self.units.position,
                SLOW * size * self.units.velocity,
            );
            if at.gap <= near && at.speed(state.rows(n, n)) <= slow {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// The event at the end of a leg, but at that of the last one.
    pub fn event(&self, k: usize) -> Option<usize> {
        Some(k + 1).filter(|next| *next < self.legs.len())
    }

    /// Whether nothing happens there.
    pub fn is_cut(&self, event: usize) -> bool {
        self.signature.stages[event].event == Event::Nothing
    }

    pub fn held(&self, stage: usize) -> &[usize] {
        &self.signature.stages[stage].held
    }

    /// What an event makes of a state before it; what is held loses along its reaction what it is not to have.
    pub fn pass(&self, shooting: &Shooting<'_>, event: usize, y: &mut Timed) -> Result<()> {
        if let Event::Chatter(stop) = self.signature.stages[event].event {
            finish(shooting.motion, stop, &self.units, y)?;
        } else {
            shooting.pass(event, &self.units, y)?;
        }
        land(shooting.motion, self.held(event), y)
    }

    /// What an event lacks in a state before it, in parts of the motion, and what deviations make of that: the gap of the stop that is struck,
    /// the condition of another; `None` where a stop receives its impulse at the time of another's, which there is none of.
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

impl Leg {
    /// The state before its end, with so many deviations that are zero.
    pub fn timed(&self, count: usize) -> Timed {
        Timed {
            time: self.end,
            state: self.before.clone(),
            deviations: DMatrix::zeros(self.before.len(), count),
            delays: DVector::zeros(count),
        }
    }
}

/// An event behind which nothing is held.
fn free(event: Event) -> ContactStage {
    ContactStage {
        event,
        held: Vec::new(),
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

/// Does some work with the equations of a run, whatever moves it, and with what notes where deviations from it are to be doubted.
pub(super) fn with_doubts<T>(
    scene: &Scene,
    signature: &Signature,
    work: impl FnOnce(&Shooting<'_>, &Watch) -> Result<T>,
) -> Result<T> {
    if scene.linear_system("derivatives").is_ok() {
        return with_shooting(scene, signature, |shooting, _| {
            work(shooting, &Watch::default())
        });
    }
    let motion = IntegratedMaps::new(scene, scene.phase()).in_units(signature.units);
    let (motion, watch) = motion.watched();
    let shooting = Shooting {
        motion: &motion,
        stages: &signature.stages,
        clocked: signature.clocked(scene),
        images: None,
        weak_directions: OF_INTEGRATED,
    };
    work(&shooting, &watch)
}
