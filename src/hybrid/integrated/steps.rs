//! Flights in steps of any method (`flow/steps`): free, or with stops held; each step is judged by its error, searched for
//! contacts and for the release of what is held, and taken again to either.

use super::free::FreeFlight;
use super::scene::Integrated;
use crate::error::Result;
use crate::event::certified::SearchFailure;
use crate::event::first_root::{FirstEvent, FirstRoot};
use crate::flow::steps::control::{first_step, trial_step};
use crate::flow::steps::{DenseOutput, State, StepStart, Stepper, Tolerance};
use crate::hybrid::clock::Clock;
use crate::hybrid::flow::Arrival;
use crate::hybrid::recorder::{ArcSpan, Recorder};
use crate::hybrid::segment::SegmentKind;
use crate::hybrid::system::Gaps;
use crate::model::{Dynamics, GapValue};
use crate::observer::Observer;
use crate::tolerance::MOST_STEP_HALVINGS;
use std::f64::consts::PI;
use std::marker::PhantomData;

/// Free flights in steps, by what is chosen of their method.
pub(crate) struct InSteps<C, P> {
    choice: C,
    method: PhantomData<P>,
}

impl<C, P> InSteps<C, P> {
    /// Flights in steps of the method P.
    pub fn new(choice: C) -> Self {
        let method = PhantomData;
        Self { choice, method }
    }
}

/// What became of a step that was tried.
enum Trial {
    /// A step of length h, `next` what the next one may be; the last one where it reaches the end.
    Accepted { h: f64, next: f64, is_last: bool },
    /// Its error was too large: a shorter one is to be tried.
    Rejected,
    /// There is nothing left to go.
    AtEnd,
    /// It would be too short for the time.
    TooShort,
}

impl<S: State, D: Dynamics, P: Stepper<S>> FreeFlight<S, D> for InSteps<P::Choice, P> {
    type Steps = P;

    fn choice(&self) -> P::Choice {
        self.choice
    }

    fn reset(&mut self) {}

    fn advance(
        &mut self,
        system: &mut Integrated<'_, S, D, P>,
        orders: &[usize],
        ends: (f64, f64),
        recorder: &mut dyn Recorder,
        observer: &mut Observer,
    ) -> Result<Arrival> {
        let dynamics = system.dynamics;
        if system.contacts.is_empty() && recorder.wanted().is_nothing() {
            return system.step_through(dynamics, ends.0, observer);
        }
        let ends = (ends.0, Some(ends.1));
        system.advance_along::<D, false>(dynamics, orders, ends, recorder, observer)
    }

    fn record_instant(
        &mut self,
        system: &mut Integrated<'_, S, D, P>,
        last: Option<f64>,
        recorder: &mut dyn Recorder,
    ) -> Result<()> {
        system.begin(system.dynamics)?;
        system.record_no_step(last, recorder);
        Ok(())
    }
}

impl<S: State, D: Dynamics, P: Stepper<S>> Integrated<'_, S, D, P> {
    /// Takes the rate of the present state, and with it the gaps.
    pub(super) fn begin<E: Dynamics>(&mut self, dynamics: &E) -> Result<()> {
        if self.is_begun {
            return Ok(());
        }
        let (at, x) = (self.moment(), &self.x);
        self.stepper.begin(dynamics, StepStart { at, x })?;
        self.is_begun = true;
        self.take_gaps()
    }

    /// A first step, from the sizes of the state, its rate and a second derivative, in units of the tolerance.
    fn first_step<E: Dynamics>(&mut self, dynamics: &E, span: f64) -> Result<f64> {
        let size = |state: &Self, y: &[f64]| {
            let scaled = y.iter().zip(state.x.slice()).map(|(y, x)| {
                (y / (state.tolerance.absolute + state.tolerance.relative * x.abs())).powi(2)
            });
            (scaled.sum::<f64>() / y.len() as f64).sqrt()
        };
        let rate = self.stepper.start_rate().clone();
        let (d0, d1) = (size(self, self.x.slice()), size(self, rate.slice()));
        let trial = trial_step(d0, d1).min(span);
        if !self.step_within_doubles(dynamics, trial)? {
            return Ok(trial);
        }
        let change: Vec<f64> = self
            .stepper
            .end_rate()
            .slice()
            .iter()
            .zip(rate.slice())
            .map(|(a, b)| (a - b) / trial)
            .collect();
        Ok(first_step(
            self.stepper.control().order,
            trial,
            d1,
            size(self, &change),
        ))
    }

    /// The gaps at the end of the step last taken, of a length that is no more than h.
    #[inline]
    pub(super) fn evaluate_gaps_ahead(&mut self, length: f64, h: f64) -> Result<()> {
        let n = self.n();
        let (q, v) = self.stepper.end().slice().split_at(n);
        let a = &self.stepper.end_rate().slice()[n..];
        for (value, contact) in self.ahead.iter_mut().zip(self.contacts.iter()) {
            *value = contact.surface.along(q, v, a, h)?;
            if let Some(motion) = &contact.motion {
                value.widen(motion, self.clock.moment(self.phase).after(length));
            }
        }
        for &(element, state) in self.regime.others() {
            self.watched(element, state)
                .turn(&mut self.ahead[element], length);
        }
        self.n_gap_evaluations += self.contacts.len();
        Ok(())
    }

    /// At a contact the end rate of the step to it serves for the gaps, unless stops were held; the next flight evaluates its own.
    pub(super) fn evaluate_gaps_on_arrival(&mut self) -> Result<()> {
        if !self.regime.is_free() {
            return self.evaluate_gaps();
        }
        self.stepper.go_on();
        self.is_begun = false;
        self.take_gaps()
    }

    /// Makes the end of the step last taken the present state.
    pub(super) fn arrive(&mut self, s: f64) {
        self.x.clone_from(self.stepper.end());
        self.clock = self.clock.after(s);
        self.places_back.relax(s);
    }

    /// Records what is wanted of the step last taken, of length s; `last` is the time at which the run ends with it.
    #[inline(never)]
    pub(super) fn record<E: Dynamics>(
        &mut self,
        dynamics: &E,
        s: f64,
        last: Option<f64>,
        recorder: &mut dyn Recorder,
    ) -> Result<()> {
        let arc = ArcSpan {
            start: self.clock,
            span: s,
            last,
        };
        if recorder.wants_arc(&arc) {
            // Borrowed where it was made: it is large.
            match self.dense(dynamics, s) {
                Ok(ref dense) => self.record_dense(dense, &arc, recorder),
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Records an arc of no length at the present state; `last` as in `record`.
    pub(super) fn record_no_step(&mut self, last: Option<f64>, recorder: &mut dyn Recorder) {
        let still = <P as Stepper<S>>::Dense::line(&self.x, &self.x, 1.0);
        let arc = ArcSpan {
            start: self.clock,
            span: 0.0,
            last,
        };
        self.record_dense(&still, &arc, recorder);
    }

    /// Tries the next step towards an instant: its length is what the step before left, and its error is judged.
    #[allow(
        clippy::inline_always,
        reason = "a part of the innermost loop of two callers"
    )]
    #[inline(always)]
    fn try_step<E: Dynamics>(&mut self, dynamics: &E, end: Clock) -> Result<Trial> {
        let left = self.clock.until(end);
        if left <= 0.0 {
            return Ok(Trial::AtEnd);
        }
        let wanted = match self.h {
            Some(h) => h,
            None => self.first_step(dynamics, left)?,
        };
        // A step that would leave less than a thousandth of the way goes all of it.
        let is_last = wanted >= 0.999 * left;
        let h = if is_last { left } else { wanted };
        if self.is_too_short(h) {
            // What is left may be less than a rounding of the time.
            if is_last {
                return Ok(Trial::AtEnd);
            }
            let now = self.clock.time();
            let beyond = self.beyond.take_if(|(start, _)| *start == now);
            return beyond.map_or(Ok(Trial::TooShort), |(_, error)| Err(error));
        }
        let error = if self.step_within_doubles(dynamics, h)? {
            let (at, x, attainable) = (self.moment(), &self.x, self.attainable());
            self.stepper
                .error(dynamics, StepStart { at, x }, h, attainable)?
        } else {
            f64::INFINITY
        };
        let verdict = self.controller.judge(self.stepper.control(), h, error);
        if !verdict.is_accepted {
            self.h = Some(verdict.next);
            return Ok(Trial::Rejected);
        }
        // A step cut short by the end says nothing about the next one.
        let next = if is_last {
            verdict.next.max(wanted)
        } else {
            verdict.next
        };
        Ok(Trial::Accepted { h, next, is_last })
    }

    /// The tolerances, the absolute one no less than the rounding of the largest coordinate, which drives the small ones.
    #[inline]
    fn attainable(&self) -> Tolerance {
        let (q, _) = self.x.slice().split_at(self.n());
        let size = q.iter().fold(0.0f64, |size, q| size.max(q.abs()));
        Tolerance {
            absolute: self.tolerance.absolute.max(4.0 * f64::EPSILON * size),
            ..self.tolerance
        }
    }

    /// Keeps the next step from being longer than half a period of the fastest harmonic of the forcing where stops are held and
    /// nothing moves: no error would tell of the forces in it; and than the motion of stops allows, of which no error tells either.
    #[cold]
    fn limit_step<E: Dynamics, const IS_HELD: bool>(
        &mut self,
        dynamics: &E,
        end: Clock,
    ) -> Result<()> {
        let left = self.clock.until(end);
        let half_period = PI / self.fastest_forcing;
        let most = if IS_HELD {
            self.longest_step.min(half_period)
        } else {
            self.longest_step
        };
        if most < f64::INFINITY && left > 0.0 {
            let wanted = match self.h {
                Some(h) => h,
                None => self.first_step(dynamics, left)?,
            };
            self.h = Some(wanted.min(most));
        }
        Ok(())
    }

    /// Takes note of a step of length h that was accepted.
    #[allow(clippy::inline_always, reason = "a part of the innermost loop")]
    #[inline(always)]
    fn accept(&mut self, h: f64, next: f64) {
        self.h = Some(next);
        self.stepper.accept(h, &mut self.controller);
        if self.controller.is_stiff && self.stiff_from.is_none() {
            self.stiff_from = Some(self.clock.after(h).time());
        }
        self.n_steps += 1;
    }

    /// Goes on from the end of the step last taken, which is the present state.
    #[inline]
    fn go_on<E: Dynamics>(&mut self, dynamics: &E) -> Result<()> {
        if !self.stepper.go_on() {
            self.is_begun = false;
            self.begin(dynamics)?;
        }
        Ok(())
    }

    /// A segment along some equations of motion where there is no stop, and nothing to keep of it but its end.
    fn step_through<E: Dynamics>(
        &mut self,
        dynamics: &E,
        span: f64,
        observer: &mut Observer,
    ) -> Result<Arrival> {
        let end = self.clock.after(span);
        let mut steps = observer.steps(self.work_of_step());
        self.begin(dynamics)?;
        loop {
            steps.begin()?;
            match self.try_step(dynamics, end)? {
                Trial::Accepted { h, next, is_last } => {
                    self.accept(h, next);
                    self.arrive(h);
                    self.go_on(dynamics)?;
                    if is_last {
                        return Ok(Arrival::End);
                    }
                }
                Trial::Rejected => {}
                Trial::AtEnd => return Ok(Arrival::End),
                Trial::TooShort => return Ok(Arrival::Underflow),
            }
        }
    }

    /// A motion that nothing ends over a short span, in steps that are kept.
    pub(super) fn advance_without_events<E: Dynamics>(
        &mut self,
        dynamics: &E,
        span: f64,
        recorder: &mut dyn Recorder,
    ) -> Result<()> {
        let end = self.clock.after(span);
        self.begin(dynamics)?;
        loop {
            match self.try_step(dynamics, end)? {
                Trial::Accepted { h, next, is_last } => {
                    self.accept(h, next);
                    self.record(dynamics, h, None, recorder)?;
                    self.arrive(h);
                    self.go_on(dynamics)?;
                    if is_last {
                        return Ok(());
                    }
                }
                Trial::Rejected => {}
                Trial::AtEnd | Trial::TooShort => {
                    self.record_no_step(None, recorder);
                    self.clock = end;
                    return Ok(());
                }
            }
        }
    }

    /// Operations that a step is: its right-hand side may be full matrices.
    fn work_of_step(&self) -> usize {
        self.n().pow(2)
    }

    /// A segment along some equations of motion: free, or with stops held.
    pub(super) fn advance_along<E: Dynamics, const IS_HELD: bool>(
        &mut self,
        dynamics: &E,
        orders: &[usize],
        (span, last): (f64, Option<f64>),
        recorder: &mut dyn Recorder,
        observer: &mut Observer,
    ) -> Result<Arrival> {
        self.grazes.clear();
        self.doubt = None;
        self.forget_extents();
        recorder.begin_segment(SegmentKind::of(&self.regime), &self.regime);
        let end = self.clock.after(span);
        let mut steps = observer.steps(self.work_of_step());
        let mut orders = Some(orders);
        let mut halvings = 0;
        self.begin(dynamics)?;
        let is_recorded = recorder.wanted().motion_in(&self.regime);
        let arrival = loop {
            if IS_HELD || self.longest_step < f64::INFINITY {
                self.limit_step::<E, IS_HELD>(dynamics, end)?;
            }
            steps.begin()?;
            let (h, next, is_last) = match self.try_step(dynamics, end)? {
                Trial::Accepted { h, next, is_last } => (h, next, is_last),
                Trial::Rejected => continue,
                Trial::AtEnd => {
                    if is_recorded {
                        self.record_no_step(last, recorder);
                    }
                    break Arrival::End;
                }
                Trial::TooShort => break self.given_up(),
            };
            if !self.evaluate_gaps_within_doubles(h)? {
                self.h = Some(0.25 * h);
                continue;
            }
            if IS_HELD && let Some(shorter) = self.shorter_beside_places(h) {
                self.h = Some(shorter);
                continue;
            }
            let may_shorten = halvings < MOST_STEP_HALVINGS;
            let FirstEvent { stop, root } =
                self.contact_along::<E, IS_HELD>(dynamics, orders, (h, may_shorten))?;
            let found = match root {
                // A minimum near zero is reached by a step of its own: it is the motion's, not the interpolation's.
                FirstRoot::Undecided { at } if may_shorten => {
                    halvings += 1;
                    let Some(shorter) = self.shorter(dynamics, (stop, at), (h, end.time()))? else {
                        break self.given_up();
                    };
                    self.h = Some(shorter);
                    continue;
                }
                FirstRoot::Undecided { .. } if self.doubt.is_some() => break self.given_up(),
                // A minimum that no step tells from zero is passed over, with what lies behind it in the step; a stop that is passed at the
                // end of the step is met by the next one.
                FirstRoot::Undecided { .. } | FirstRoot::None => None,
                FirstRoot::Crossing { at, passed } => Some((stop, at, passed)),
            };
            // By its place among the forces that are watched.
            let FirstEvent { stop: guard, root } = if IS_HELD && !self.force_guards.is_empty() {
                self.release_along(h)?
            } else {
                FirstEvent::NONE
            };
            let released = match root {
                FirstRoot::Undecided { .. } if may_shorten => {
                    halvings += 1;
                    self.h = Some(0.5 * h);
                    continue;
                }
                FirstRoot::Undecided { .. } | FirstRoot::None => None,
                FirstRoot::Crossing { at, .. } => Some((guard, at)),
            };
            self.accept(h, next);
            // Where stops are held, the drift of their gaps and speeds is projected away before an event.
            if let Some((guard, x)) = released.filter(|(_, x)| found.is_none_or(|(_, c, _)| *x < c))
            {
                break self.arrive_at_release(dynamics, guard, (x, h), recorder)?;
            }
            if let Some((stop, x, passed)) = found {
                let parts = (x, passed, h);
                let reached = self.arrive_at_contact(dynamics, (stop, orders), parts, recorder)?;
                match reached {
                    Some(arrival) => break arrival,
                    None if may_shorten => {
                        halvings += 1;
                        self.h = Some(0.5 * h);
                        continue;
                    }
                    None => break self.given_up(),
                }
            }
            halvings = 0;
            if is_recorded {
                self.record(dynamics, h, is_last.then_some(last).flatten(), recorder)?;
            }
            self.arrive(h);
            self.advance_gaps();
            self.go_on(dynamics)?;
            orders = None;
            if is_last || is_recorded && recorder.is_satisfied() {
                break Arrival::End;
            }
            if IS_HELD && self.has_strayed() {
                self.settle()?;
                self.begin(dynamics)?;
            }
        };
        self.record_grazes(&arrival, recorder);
        Ok(arrival)
    }

    /// How a flight ends whose steps cannot be made shorter.
    #[cold]
    fn given_up(&self) -> Arrival {
        match self.doubt {
            Some((stop, doubt)) => Arrival::Uncertain { stop, doubt },
            None => Arrival::Underflow,
        }
    }

    /// A shorter step than one that cannot tell a contact near a part of it from none: to the minimum there, if that is all, or to where
    /// a gap contradicts its bound; none where it does at once. A search that took too long got so far in as many places, none where it
    /// would go on like that for too long until the end of the run.
    #[cold]
    fn shorter<E: Dynamics>(
        &mut self,
        dynamics: &E,
        (stop, at): (usize, f64),
        (h, end): (f64, f64),
    ) -> Result<Option<f64>> {
        Ok(match self.doubt {
            Some((_, SearchFailure::Bends)) => (at > 0.0).then_some(at * h),
            Some((_, SearchFailure::Long)) => {
                (!self.is_hopeless(stop, at * h, end)).then_some(at.min(0.5) * h)
            }
            Some(_) => Some(0.5 * h),
            None => {
                let lowest = self.descend(dynamics, stop, at * h, h)?;
                Some(lowest.unwrap_or(0.5 * h))
            }
        })
    }

    /// The gaps at the end of the step last taken; false where one is no number so far away.
    fn evaluate_gaps_within_doubles(&mut self, h: f64) -> Result<bool> {
        match self.evaluate_gaps_ahead(h, h) {
            Ok(()) => Ok(true),
            Err(error) => self.refuse(error),
        }
    }

    /// Makes the gaps at the end of the step those at the present state.
    fn advance_gaps(&mut self) {
        std::mem::swap(&mut self.gaps, &mut self.ahead);
        for (extent, gap) in self.extents.iter_mut().zip(&self.gaps) {
            *extent = extent.max(gap.size);
        }
    }

    /// Whether steps have led off a stop that is held, by more than they may: their errors add up where nothing draws them back.
    fn has_strayed(&self) -> bool {
        let is_off = |&stop: &usize| {
            let GapValue { gap, size, .. } = self.gaps[stop];
            gap.abs() > self.tolerance(stop, size)
        };
        self.regime.constrained().iter().any(is_off)
    }

    /// Records the touches of a segment; a step may have seen some behind what ended it.
    fn record_grazes(&mut self, arrival: &Arrival, recorder: &mut dyn Recorder) {
        if recorder.wanted().events {
            let now = self.clock.time();
            let is_end = matches!(arrival, Arrival::End);
            self.grazes.retain(|graze| is_end || graze.time < now);
            for graze in self.grazes.drain(..) {
                recorder.graze(graze);
            }
        }
    }
}
