//! The next impact of an exact flight (theory 8): the first time \[s\] at which some gap \[m\] falls below zero by more than its rounding,
//! traced back to its zero. Every step before is proved to hold none; touches within rounding (`touch.rs`) are noted as grazes.
//! Integrated motions are searched in `polynomial.rs` and `certified.rs`, Taylor series in `series.rs`.

use crate::error::Result;
use crate::event::first_root::{FirstEvent, FirstRoot};
use crate::event::gap_bracket::GapBracket;
use crate::event::gap_verdict::{GapVerdict, from_contact, from_open};
use crate::event::levels::PropagatorLevels;
use crate::event::lowest::{GapEvaluator, Lowest};
use crate::event::touch::Bottom;
use crate::event::tracked_gap::TrackedGap;
use crate::event::walk::STEPS_PER_REACH_CHECK;
use crate::flow::gap_model::GapModel;
use crate::flow::samples::{SampleDerivatives, SampleModels};
use crate::flow::{Derivatives, GapRow, LinearFlow, PropagatorCache};
use crate::modal::Pair;
use crate::observer::Observer;
use crate::quantity::larger;
use crate::tolerance::{CUBIC_ROOT_STEP, GAP_ROUNDING, NEWTON_NEAR_ZERO, TAYLOR_TIME};

/// A touch without impact: stop, time since the start of the flight, gap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Grazed {
    pub stop: usize,
    pub time: f64,
    pub gap: f64,
}

impl Grazed {
    /// The touch to rounding, on a flight of some span from a state; one whose minimum lies outside, by rounding, stays where it was
    /// found.
    pub fn sharpened<F: LinearFlow>(
        self,
        flow: &F,
        gap: &GapRow,
        from: &[Pair],
        span: f64,
    ) -> Self {
        let found = Lowest {
            time: self.time,
            gap: self.gap,
        };
        let Lowest { time, gap } = found.sharpened(flow, gap, from);
        if (0.0..=span).contains(&time) {
            Self { time, gap, ..self }
        } else {
            self
        }
    }
}

/// Evaluations of the motion for the time of one impact. [work]
const MOST_CONTACT_POLISHES: usize = 60;

/// The order of the zero of a gap that its third derivative opens, where all lower ones vanish. [exact]
pub(crate) const LATE: usize = 3;
/// Steps of Newton's method on one cubic: before a shallow contact each halves the error at first. [work]
const MOST_CUBIC_STEPS: usize = 12;

/// The search along one flight after another, with its buffers.
pub(crate) struct ContactSearch<'f, F: LinearFlow> {
    pub(super) flow: &'f F,
    pub(super) gaps: Vec<TrackedGap>,
    pub(super) levels: PropagatorLevels<F>,
    pub(super) level: usize,
    propagator_cache: PropagatorCache<F>,
    pub(super) derivatives: Vec<Derivatives>,
    /// The stops within reach.
    pub(super) active: Vec<usize>,
    norms: Vec<f64>,
    /// The state at the samples ahead, and the gaps of the stops within reach there.
    pub(super) samples: Vec<SampleDerivatives>,
    pub(super) models: Vec<SampleModels>,
    /// The sample next after the state, and the time to it, where there is one.
    pub(super) beyond: Option<(usize, f64)>,
    pub(super) state: Vec<Pair>,
    /// Evaluations of a gap so far.
    pub n_gap_evaluations: usize,
}

/// How far the search has advanced.
pub(super) struct StepAdvance {
    /// Number of steps.
    pub count: usize,
    /// Whether a step after each of them is clear of contacts too.
    pub are_clear: bool,
}

/// The results of a search along a flight beside its end: for each stop its extent and the rounding of its gap at the end, and the number of
/// evaluations of gaps and forces.
pub(crate) struct SearchSummary {
    pub extents: Vec<(usize, [f64; 2])>,
    pub roundings: Vec<(usize, f64)>,
    pub n_gap_evaluations: usize,
}

impl<'f, F: LinearFlow> ContactSearch<'f, F> {
    pub fn new(flow: &'f F, gaps: Vec<GapRow>) -> Self {
        Self::with(flow, gaps, PropagatorLevels::new(flow))
    }

    /// That of a flow whose propagators were made by another search.
    pub fn with(flow: &'f F, gaps: Vec<GapRow>, levels: PropagatorLevels<F>) -> Self {
        Self {
            flow,
            active: Vec::with_capacity(gaps.len()),
            gaps: gaps.into_iter().map(TrackedGap::new).collect(),
            levels,
            level: PropagatorLevels::<F>::START,
            propagator_cache: PropagatorCache::default(),
            derivatives: Vec::new(),
            norms: Vec::new(),
            samples: Vec::new(),
            models: Vec::new(),
            beyond: None,
            state: Vec::new(),
            n_gap_evaluations: 0,
        }
    }

    /// The propagators that it has made.
    pub fn into_levels(self) -> PropagatorLevels<F> {
        self.levels
    }

    /// Resets what depends on earlier flights, so that the next run has the same bits as a first one.
    pub fn restart(&mut self) {
        self.level = PropagatorLevels::<F>::START;
        self.n_gap_evaluations = 0;
    }

    /// The level of the steps with which the next flight is searched first.
    #[inline]
    pub fn level(&self) -> usize {
        self.level
    }

    /// The last level that there is.
    pub fn deepest_level(&self) -> usize {
        self.levels.deepest
    }

    /// Resets what depends on earlier flights to what a flight found; without extents, those of one that goes from its own.
    pub fn restart_at(&mut self, level: usize, extents: &[[f64; 2]]) {
        self.level = level;
        for (gap, extent) in self.gaps.iter_mut().zip(extents) {
            gap.extent = *extent;
        }
    }

    /// Evaluates the model of every gap at a state.
    pub fn evaluate(&mut self, state: &[Pair]) {
        self.n_gap_evaluations += self.gaps.len();
        self.flow.derivatives(state, &mut self.derivatives);
        for gap in &mut self.gaps {
            gap.model = gap.row.model(&self.derivatives);
        }
    }

    /// The row of a stop's gap on the flow's state.
    pub fn gap(&self, stop: usize) -> &GapRow {
        &self.gaps[stop].row
    }

    /// The model of a gap at the last evaluation.
    #[inline]
    pub fn model(&self, stop: usize) -> &GapModel {
        &self.gaps[stop].model
    }

    /// The rounding of a gap at the last evaluation.
    pub fn rounding(&self, stop: usize) -> f64 {
        self.gaps[stop].rounding()
    }

    /// Size of the terms of a gap's speed at the last evaluation.
    pub fn speed_size(&self, stop: usize) -> f64 {
        self.gaps[stop].row.speed_size(&self.derivatives)
    }

    /// Size of the terms of a gap's acceleration at the last evaluation.
    pub fn acceleration_size(&self, stop: usize) -> f64 {
        let row = &self.gaps[stop].row;
        row.acceleration_size(&self.derivatives, self.flow.fastest_rate())
    }

    /// The rounding of a gap's acceleration at the last evaluation that modes which cancel each other leave.
    pub fn acceleration_lost(&self, stop: usize) -> f64 {
        self.gaps[stop].row.acceleration_lost(&self.derivatives)
    }

    /// The largest size of the terms of a gap on the last flight, and the largest gap.
    pub fn extent(&self, stop: usize) -> [f64; 2] {
        self.gaps[stop].extent
    }

    /// Takes over the extents and the count of another search along the last flight.
    pub fn saw(&mut self, other: &SearchSummary) {
        self.n_gap_evaluations += other.n_gap_evaluations;
        for &(stop, extent) in &other.extents {
            self.gaps[stop].extent = extent;
        }
    }

    /// The next contact within `span` of the state, or in the step that leaves it, to the accuracy of a cubic; undecided where the steps
    /// became too short to go on. The gaps must have been evaluated at the state; `root_orders[i]` is the order of the root of gap i there, zero
    /// for an open gap.
    ///
    /// # Errors
    /// `Error::Interrupted` from the observer.
    pub fn next(
        &mut self,
        start: &[Pair],
        root_orders: &[usize],
        span: f64,
        grazes: &mut Vec<Grazed>,
        observer: &mut Observer,
    ) -> Result<FirstEvent> {
        for (gap, &order) in self.gaps.iter_mut().zip(root_orders) {
            gap.depart(order);
        }
        self.active.clear();
        self.active.extend(0..self.gaps.len());
        self.state.clear();
        self.state.extend_from_slice(start);
        self.beyond = None;
        self.leave_out();
        let mut time = 0.0;
        let mut steps = 0usize;
        while !self.active.is_empty() {
            let first_level = self.level;
            let (reached, step) = loop {
                let step = self.levels.step(self.level);
                let noted = grazes.len();
                match self.step_ahead(start, step, time, grazes) {
                    Ok(reached) => break (reached, step),
                    Err(stop) => {
                        grazes.truncate(noted);
                        if self.level == self.levels.deepest || time + step == time {
                            let root = FirstRoot::Undecided { at: time };
                            return Ok(FirstEvent { stop, root });
                        }
                        self.level += 1;
                    }
                }
            };
            if let Some((stop, at)) = reached {
                let at = self.between_samples(stop, at, step);
                grazes.retain(|g| g.time < time + at);
                let root = FirstRoot::Crossing {
                    at: time + at,
                    passed: self.gaps[stop].bracket.passed,
                };
                return Ok(FirstEvent { stop, root });
            }
            let made = (self.levels).prepare(self.flow, self.level, self.state.len());
            if let Some(work) = made {
                observer.work(work)?;
            }
            let StepAdvance { count, are_clear } = self.go_on(time, span, grazes);
            time += count as f64 * step;
            if self.level == first_level && are_clear {
                self.level = self.levels.above(self.level);
            }
            let checks = steps / STEPS_PER_REACH_CHECK;
            steps += count;
            if steps / STEPS_PER_REACH_CHECK > checks {
                observer.work(STEPS_PER_REACH_CHECK * self.state.len())?;
                self.leave_out();
            }
            // A gap at or below zero that falls at the end of the span, or past it, may have been zero before: the search goes on until it
            // shows. A gap that only rests at zero never does, and at twice the span the search is over.
            let is_reached = |&stop: &usize| {
                let [gap, speed, ..] = self.gaps[stop].model.c;
                gap <= 0.0 && speed < 0.0
            };
            if time >= span && (time >= 2.0 * span || !self.active.iter().any(is_reached)) {
                return Ok(FirstEvent::NONE);
            }
        }
        Ok(FirstEvent::NONE)
    }

    /// Notes the touch of a gap that turned within rounding of zero, in a step that could not tell on which side of its end: the
    /// minimum is here, to the accuracy of a step.
    pub(super) fn note_turn(
        &self,
        stop: usize,
        time: f64,
        model: &GapModel,
        grazes: &mut Vec<Grazed>,
    ) {
        let gap = model.c[0];
        if gap <= self.gaps[stop].row.rounding(model) {
            let before = time - self.levels.step(self.levels.above(self.level));
            if !grazes.iter().any(|g| g.stop == stop && g.time >= before) {
                grazes.push(Grazed { stop, time, gap });
            }
        }
    }

    /// Leaves out the stops that are beyond reach for all times to come, but for those in contact.
    fn leave_out(&mut self) {
        let Self {
            flow,
            norms,
            state,
            gaps,
            active,
            beyond,
            ..
        } = self;
        if active.iter().all(|&stop| gaps[stop].order_here > 0) {
            return;
        }
        flow.norms(state, norms);
        let count = active.len();
        active.retain(|&stop| {
            let gap = &gaps[stop];
            gap.order_here > 0 || !gap.row.is_beyond_reach(norms)
        });
        if active.len() < count {
            // The samples ahead are of all of them.
            *beyond = None;
        }
    }

    /// The earliest contact in one step, none if every gap is clear; the stop that could not be decided otherwise. The flight
    /// began at a state.
    fn step_ahead(
        &mut self,
        start: &[Pair],
        step: f64,
        time: f64,
        grazes: &mut Vec<Grazed>,
    ) -> std::result::Result<Option<(usize, f64)>, usize> {
        let mut earliest: Option<(usize, f64)> = None;
        for &stop in &self.active {
            let tracked = &mut self.gaps[stop];
            // A flight that began a rounding inside its stop is searched with the gap raised by that.
            let lifted;
            let model = if tracked.bracket.floor == 0.0 {
                &tracked.model
            } else {
                lifted = tracked.model.above(tracked.bracket.floor);
                &lifted
            };
            let (gap, order) = (&tracked.row, tracked.order_here);
            let mut ahead = match order {
                0 => {
                    let (late, clear) = (tracked.late, tracked.clear * model.size);
                    from_open(model, step, larger(clear, late), || {
                        larger(gap.rounding(model), late)
                    })
                }
                order => from_contact(model, order, step, gap.rounding(model)),
            };
            // A stop may be left so slowly that the bound on the rest of the cubic hides its opening. Then the part of third order is judged
            // alone, and it is enough that it stays within the rounding of the gap.
            if order == LATE && !matches!(ahead, GapVerdict::Clear) {
                let soon = 1.0 / self.flow.fastest_rate();
                let rounding = gap.rounding_after(&self.derivatives, step);
                // From rest at zero all terms grow from zero.
                tracked.late = GAP_ROUNDING * model.remainder(soon);
                let rounding = rounding.max(tracked.late);
                let rounding = rounding.max(gap.rounding(model));
                let clear = rounding.max(GAP_ROUNDING * model.size);
                ahead = from_open(&model.only(LATE), step, clear, || rounding);
            }
            if let GapVerdict::Dips { near } = ahead {
                let (lowest, met) =
                    at_bottom(self.flow, gap, start, [time, time + step], time + near);
                self.n_gap_evaluations += 1;
                ahead = met;
                if let Some(Lowest { time, gap }) = lowest {
                    grazes.push(Grazed { stop, time, gap });
                }
            }
            match ahead {
                GapVerdict::Reached { at, passed } => {
                    let bracket = &mut tracked.bracket;
                    bracket.passed = time + passed;
                    bracket.closed = bracket.closed.min(bracket.passed);
                    if earliest.is_none_or(|(_, first)| at < first) {
                        earliest = Some((stop, at));
                    }
                }
                // What leaves its stop slowly does not touch it anew.
                GapVerdict::Rests if order > 0 || tracked.late > 0.0 => {}
                GapVerdict::Rests => {
                    let gap = tracked.model.c[0];
                    let is_noted = |g: &Grazed| g.stop == stop && g.time >= time - step;
                    if !grazes.iter().any(is_noted) {
                        grazes.push(Grazed { stop, time, gap });
                    }
                }
                GapVerdict::Clear | GapVerdict::Dips { .. } => {}
                GapVerdict::Unknown => return Err(stop),
            }
        }
        if let Some((stop, at)) = earliest {
            // A flight of few steps is farthest from its stop half-way.
            let tracked = &mut self.gaps[stop];
            let far = tracked.model.value(0.5 * at).abs();
            tracked.widen([far, far]);
        }
        Ok(earliest)
    }

    /// Carries a state over a span of time.
    pub fn forward(&mut self, state: &mut [Pair], span: f64) {
        self.propagator_cache.forward(self.flow, state, span);
    }

    /// The contact that comes first and its time to rounding; on return `arrived` is the state there, and the search has
    /// looked there. The contacts of one step were ordered to the accuracy of a cubic: a stop that is passed when the one
    /// found is reached was reached before.
    pub fn arrive(
        &mut self,
        mut stop: usize,
        guess: f64,
        start: &[Pair],
        arrived: &mut Vec<Pair>,
    ) -> (usize, f64) {
        let mut time = self.polish(stop, guess, start, arrived);
        for _ in 1..self.gaps.len() {
            let passed = |(i, other): (usize, &TrackedGap)| {
                let GapBracket { floor, passed, .. } = other.bracket;
                let model = &other.model;
                let gap = model.c[0] - floor;
                let is_passed = gap < -other.rounding() && model.c[1] < 0.0;
                // A dip that was seen may be over.
                let guess = if passed < time {
                    passed
                } else {
                    time - gap / model.c[1]
                };
                (i != stop && (is_passed || passed < time)).then_some((i, guess))
            };
            let earlier = (self.gaps.iter().enumerate())
                .filter_map(passed)
                .min_by(|a, b| a.1.total_cmp(&b.1));
            let Some((other, guess)) = earlier else { break };
            let closed = &mut self.gaps[other].bracket.closed;
            *closed = closed.min(time);
            let reached = self.polish(other, guess, start, arrived);
            if reached >= time {
                time = self.polish(stop, time, start, arrived);
                break;
            }
            (stop, time) = (other, reached);
        }
        (stop, time)
    }

    /// The time of a contact to rounding: the motion is taken again from the start of the flight until Newton's step is
    /// no more than a short Taylor step, or the gap zero to rounding, which at a low speed moves the time by more. On return
    /// `arrived` is the state there, and the gaps have been evaluated there.
    fn polish(&mut self, stop: usize, guess: f64, start: &[Pair], arrived: &mut Vec<Pair>) -> f64 {
        let short = TAYLOR_TIME / self.flow.fastest_rate();
        let TrackedGap {
            mut bracket, order, ..
        } = self.gaps[stop];
        let mut time = guess.max(0.0).min(bracket.closed);
        let mut evaluated_at = time;
        for _ in 0..MOST_CONTACT_POLISHES {
            arrived.clear();
            arrived.extend_from_slice(start);
            self.forward(arrived, time);
            self.evaluate(arrived);
            let mut model = self.gaps[stop].model;
            let gap = model.c[0];
            model.c[0] -= bracket.floor;
            evaluated_at = time;
            if model.c[0].abs() <= f64::EPSILON * model.size && model.c[1] < 0.0 {
                break;
            }
            bracket.narrow(time, gap);
            let wanted = newton_step(&model, order, time).map(|step| time + step);
            let next = bracket.next(wanted, time);
            let step = next - time;
            time = next;
            // The time is found if a step of Newton's, not one of bisection, leads to a gap that is zero to rounding. If all terms of the gap
            // vanish at the contact, so does its rounding, and no double is that near: a gap that is zero within the last place of the time
            // counts, too.
            let last_place = 2.0 * f64::EPSILON * time;
            let there = model.after(step);
            let rounding = self.gaps[stop].row.rounding(&model);
            let leads_there = there.c[0].abs() <= rounding.max(-there.c[1] * last_place);
            let is_newton = wanted == Some(next) && leads_there || step == 0.0;
            if is_newton && step.abs() <= short.max(last_place) {
                for (z, d) in arrived.iter_mut().zip(&self.derivatives) {
                    *z = d.after(step);
                }
                for gap in &mut self.gaps {
                    gap.model = gap.model.after(step);
                }
                return time;
            }
        }
        evaluated_at
    }
}

/// What a gap does in a step in which it provably has one minimum: decided by its value there, which is that of the motion from
/// the start of the flight.
#[cold]
fn at_bottom<F: LinearFlow>(
    flow: &F,
    gap: &GapRow,
    start: &[Pair],
    between: [f64; 2],
    near: f64,
) -> (Option<Lowest>, GapVerdict) {
    let (lowest, model) = GapEvaluator::new(flow, start).bottom(gap, between, near);
    match Bottom::of(lowest.gap, gap.rounding(&model)) {
        Bottom::Passed => {
            let back = (-lowest.gap / model.c[2]).sqrt();
            let passed = lowest.time - between[0];
            let at = (passed - back).max(0.0);
            (None, GapVerdict::Reached { at, passed })
        }
        Bottom::Touch => (Some(lowest), GapVerdict::Clear),
        Bottom::Open | Bottom::Undecided => (None, GapVerdict::Clear),
    }
}

/// The step to the zero of a falling gap, by Newton's method on its cubic; none where it does not fall. On a flight that began on
/// the stop, with a root of some order there, a step of a length comparable with the time since is taken by Newton's method on
/// `gap/time^order`: so the end of a low flight, all of it within the margin, is found from beyond without falling back to its start.
fn newton_step(model: &GapModel, order: usize, time: f64) -> Option<f64> {
    let [a, b, ..] = model.c;
    let is_far = b >= 0.0 || (a / b).abs() > NEWTON_NEAR_ZERO * time;
    if order > 0 && is_far && time > 0.0 {
        let ahead = -a / (b - order as f64 * a / time);
        return ahead.is_finite().then(|| ahead.clamp(-0.5 * time, time));
    }
    if b >= 0.0 {
        return None;
    }
    let mut r = -a / b;
    for _ in 0..MOST_CUBIC_STEPS {
        let slope = model.slope(r);
        if slope >= 0.0 {
            break;
        }
        let change = model.value(r) / slope;
        r -= change;
        if change.abs() <= CUBIC_ROOT_STEP * r.abs() {
            break;
        }
    }
    Some(r)
}
