//! The next impact of an exact flight (theory 8): the first time at which some gap falls below minus its margin, led back
//! to its zero. Every step is proved to hold no other; touches inside the margin are noted as grazes.

use crate::contact::ahead::{Ahead, from_contact, from_open};
use crate::contact::bracket::Bracket;
use crate::contact::walk::{DEEPEST, Ladder, ROUNDING, STEPS_PER_LOOK};
use crate::flow::jet::Jet;
use crate::flow::{Derivatives, GapRow, LinearFlow};
use crate::modal::Pair;
use crate::watch::Watch;

/// Distance from zero within which a gap's minimum is a graze: `absolute + relative * size of the gap's terms`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Margin {
    pub absolute: f64,
    pub relative: f64,
}

impl Margin {
    pub fn of(self, size: f64) -> f64 {
        self.absolute + self.relative * size
    }
}

/// A touch without impact: stop, time since the start of the flight, gap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Grazed {
    pub stop: usize,
    pub time: f64,
    pub gap: f64,
}

/// What ends the search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Next {
    /// No impact before the end of the span.
    End,
    /// A stop is reached, within the span or in the step that leaves it; the time since the start of the flight, to the
    /// accuracy of a cubic.
    Contact { stop: usize, time: f64 },
    /// The steps became too short to go on.
    Stalled { stop: usize, time: f64 },
    /// The watch said to stop.
    Interrupted,
}

/// Evaluations of the motion spent on one impact time.
const MOST_POLISHES: usize = 60;
/// A time step this small, in units of the fastest rate, moves the state by its Taylor series of third order: what that
/// leaves out is below rounding.
const TAYLOR_STEP: f64 = 1e-4;

/// A step of Newton's method up to this part of the time since the start of a flight is near its zero.
const NEAR: f64 = 0.25;

/// The search along one flight after another, with its buffers.
pub(crate) struct Search<'f, F: LinearFlow> {
    flow: &'f F,
    gaps: Vec<GapRow>,
    margins: Vec<Margin>,
    ladder: Ladder<F>,
    level: usize,
    propagator: F::Propagator,
    derivatives: Vec<Derivatives>,
    /// The jet of each gap where the search last looked.
    jets: Vec<Jet>,
    /// Whether each gap was falling where the search looked before.
    was_falling: Vec<bool>,
    /// The order of each gap's root at the start of the flight.
    orders: Vec<usize>,
    /// Where the walk last saw each gap open, and from where on no longer: the zero at which a stop is reached lies between.
    brackets: Vec<Bracket>,
    /// The stops within reach.
    active: Vec<usize>,
    norms: Vec<f64>,
    state: Vec<Pair>,
    /// Evaluations of a gap so far.
    pub n_gap_evaluations: usize,
}

impl<'f, F: LinearFlow> Search<'f, F> {
    pub fn new(flow: &'f F, gaps: Vec<GapRow>, margins: Vec<Margin>) -> Self {
        let ladder = Ladder::new(flow);
        Self {
            flow,
            jets: vec![Jet::default(); gaps.len()],
            was_falling: vec![false; gaps.len()],
            orders: Vec::with_capacity(gaps.len()),
            brackets: Vec::with_capacity(gaps.len()),
            active: Vec::with_capacity(gaps.len()),
            gaps,
            margins,
            ladder,
            level: Ladder::<F>::START,
            propagator: F::Propagator::default(),
            derivatives: Vec::new(),
            norms: Vec::new(),
            state: Vec::new(),
            n_gap_evaluations: 0,
        }
    }

    /// Forgets what earlier flights left, so that the next run has the same bits as a first one.
    pub fn restart(&mut self) {
        self.level = Ladder::<F>::START;
        self.n_gap_evaluations = 0;
    }

    /// Takes the jets of every gap at a state.
    pub fn look(&mut self, state: &[Pair]) -> &[Jet] {
        self.n_gap_evaluations += self.gaps.len();
        self.flow.derivatives(state, &mut self.derivatives);
        for (jet, gap) in self.jets.iter_mut().zip(&self.gaps) {
            *jet = gap.jet(&self.derivatives);
        }
        &self.jets
    }

    /// The gap of a stop on the flow.
    pub fn gap(&self, stop: usize) -> &GapRow {
        &self.gaps[stop]
    }

    /// The jets of every gap where the search last looked.
    pub fn jets(&self) -> &[Jet] {
        &self.jets
    }

    /// The derivatives of the state where the search last looked.
    pub fn derivatives(&self) -> &[Derivatives] {
        &self.derivatives
    }

    /// The next contact within `span` of the state, at which the search must have looked. `starts[i]` is the order of the
    /// root of gap i at the start, zero for an open gap.
    pub fn next(
        &mut self,
        start: &[Pair],
        starts: &[usize],
        span: f64,
        grazes: &mut Vec<Grazed>,
        watch: &mut Watch<'_>,
    ) -> Next {
        self.orders.clear();
        self.orders.extend_from_slice(starts);
        self.active.clear();
        self.active.extend(0..self.gaps.len());
        let opens = |(order, jet): (&usize, &Jet)| Bracket::start(*order > 0 || jet.c[0] > 0.0);
        self.brackets.clear();
        self.brackets
            .extend(starts.iter().zip(&self.jets).map(opens));
        self.state.clear();
        self.state.extend_from_slice(start);
        self.leave_out(Some(starts));
        let mut time = 0.0;
        let mut steps = 0usize;
        while !self.active.is_empty() {
            let first_level = self.level;
            let reached = loop {
                let step = self.ladder.step(self.level);
                let noted = grazes.len();
                let starts = if steps == 0 { Some(starts) } else { None };
                match self.step_ahead(starts, step, time, grazes) {
                    Ok(reached) => break reached,
                    Err(stop) => {
                        grazes.truncate(noted);
                        if self.level == DEEPEST || time + step == time {
                            return Next::Stalled { stop, time };
                        }
                        self.level += 1;
                    }
                }
            };
            if let Some((stop, at)) = reached {
                // A gap that has passed zero by less than its margin may point back beyond the start of the flight.
                let at = if time + at > 0.0 { time + at } else { time };
                grazes.retain(|g| g.time < at);
                return Next::Contact { stop, time: at };
            }
            time += self.ladder.step(self.level);
            let made = self.ladder.advance(self.flow, self.level, &mut self.state);
            if made.is_some_and(|work| watch.work(work).is_err()) {
                return Next::Interrupted;
            }
            if self.level == first_level {
                self.level = self.ladder.above(self.level);
            }
            steps += 1;
            if steps.is_multiple_of(STEPS_PER_LOOK) {
                if watch.work(STEPS_PER_LOOK * self.state.len()).is_err() {
                    return Next::Interrupted;
                }
                self.leave_out(None);
            }
            self.n_gap_evaluations += self.active.len();
            self.flow.derivatives(&self.state, &mut self.derivatives);
            for &stop in &self.active {
                self.was_falling[stop] = self.jets[stop].c[1] < 0.0;
                self.jets[stop] = self.gaps[stop].jet(&self.derivatives);
                self.brackets[stop].note(time, self.jets[stop].c[0]);
            }
            self.note_turns(time, steps, grazes);
            // At the end or past it, a stop that is passed by less than its margin may have been reached before it.
            let is_reached = |&stop: &usize| {
                let [gap, speed, ..] = self.jets[stop].c;
                gap <= 0.0 && speed < 0.0
            };
            if time >= span && !self.active.iter().any(is_reached) {
                return Next::End;
            }
        }
        Next::End
    }

    /// Notes the touches of gaps that turned within the margin, in a step that could not tell on which side of its end: the
    /// minimum is here, to the accuracy of a step.
    fn note_turns(&self, time: f64, steps: usize, grazes: &mut Vec<Grazed>) {
        let before = time - self.ladder.step(self.ladder.above(self.level));
        for &stop in &self.active {
            let jet = &self.jets[stop];
            let has_turned = self.was_falling[stop] && jet.c[1] >= 0.0 && steps > 0;
            let is_noted = || grazes.iter().any(|g| g.stop == stop && g.time >= before);
            if has_turned && jet.c[0] <= self.margins[stop].of(jet.size) && !is_noted() {
                let (time, gap) = (time, jet.c[0]);
                grazes.push(Grazed { stop, time, gap });
            }
        }
    }

    /// Leaves out the stops that are beyond reach for all times to come, but for those in contact.
    fn leave_out(&mut self, starts: Option<&[usize]>) {
        let Self {
            flow,
            norms,
            state,
            gaps,
            margins,
            active,
            ..
        } = self;
        flow.norms(state, norms);
        active.retain(|&stop| {
            let (least, size) = gaps[stop].least(norms);
            let margin = margins[stop].absolute + (margins[stop].relative + ROUNDING) * size;
            let is_beyond_reach = least > margin && starts.is_none_or(|orders| orders[stop] == 0);
            !is_beyond_reach
        });
    }

    /// The earliest contact in one step, none if every gap is clear; the stop that could not be decided otherwise.
    fn step_ahead(
        &self,
        starts: Option<&[usize]>,
        step: f64,
        time: f64,
        grazes: &mut Vec<Grazed>,
    ) -> Result<Option<(usize, f64)>, usize> {
        let mut earliest: Option<(usize, f64)> = None;
        for &stop in &self.active {
            let jet = &self.jets[stop];
            let ahead = match starts.map_or(0, |orders| orders[stop]) {
                0 => from_open(jet, step, self.margins[stop].of(jet.size)),
                order => from_contact(jet, order, step),
            };
            match ahead {
                Ahead::Touch { at, gap } => grazes.push(Grazed {
                    stop,
                    time: time + at,
                    gap,
                }),
                Ahead::Reached { at } if earliest.is_none_or(|(_, t)| at < t) => {
                    earliest = Some((stop, at));
                }
                Ahead::Clear | Ahead::Reached { .. } => {}
                Ahead::Unknown => return Err(stop),
            }
        }
        Ok(earliest)
    }

    /// Carries a state over a span of time.
    pub fn forward(&mut self, state: &mut [Pair], span: f64) {
        self.flow.prepare(span, &mut self.propagator);
        self.flow.advance(&self.propagator, state);
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
            let earlier = self
                .jets
                .iter()
                .enumerate()
                .filter(|(i, jet)| *i != stop && jet.is_passed(10.0 * ROUNDING))
                .map(|(i, jet)| (i, time - jet.c[0] / jet.c[1]))
                .min_by(|a, b| a.1.total_cmp(&b.1));
            let Some((other, guess)) = earlier else { break };
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
    /// `arrived` is the state there, and the search has looked there.
    fn polish(&mut self, stop: usize, guess: f64, start: &[Pair], arrived: &mut Vec<Pair>) -> f64 {
        let short = TAYLOR_STEP / self.flow.fastest_rate();
        let mut bracket = self.brackets[stop];
        // A stop passed within its margin may have turned since.
        let mut time = guess.max(0.0).min(bracket.closed);
        let mut looked = time;
        for _ in 0..MOST_POLISHES {
            arrived.clear();
            arrived.extend_from_slice(start);
            self.forward(arrived, time);
            let jet = self.look(arrived)[stop];
            looked = time;
            if jet.c[0].abs() <= f64::EPSILON * jet.size && jet.c[1] < 0.0 {
                break;
            }
            bracket.narrow(time, jet.c[0]);
            let wanted = newton_step(&jet, self.orders[stop], time).map(|step| time + step);
            let next = bracket.next(wanted, time);
            let step = next - time;
            time = next;
            // Half the way is no sign that the zero is near.
            let is_newton = wanted == Some(next) || step == 0.0;
            if is_newton && step.abs() <= short.max(2.0 * f64::EPSILON * time) {
                for (z, d) in arrived.iter_mut().zip(&self.derivatives) {
                    *z = d.after(step);
                }
                for jet in &mut self.jets {
                    *jet = jet.after(step);
                }
                return time;
            }
        }
        looked
    }
}

/// The step to the zero of a falling gap, by Newton's method on its cubic; none where it does not fall. Behind a contact, whose
/// root of some order lies so far back, a step of a length with that time is one of Newton's method on `gap/time^order`: a low
/// flight, all of it within the margin, is found from beyond its end without falling back to its start.
fn newton_step(jet: &Jet, order: usize, time: f64) -> Option<f64> {
    let [a, b, c, d] = jet.c;
    let is_far = b >= 0.0 || (a / b).abs() > NEAR * time;
    if order > 0 && is_far && time > 0.0 {
        let ahead = -a / (b - order as f64 * a / time);
        return ahead.is_finite().then(|| ahead.clamp(-0.5 * time, time));
    }
    if b >= 0.0 {
        return None;
    }
    let mut r = -a / b;
    for _ in 0..3 {
        let slope = b + r * (2.0 * c + 3.0 * r * d);
        if slope < 0.0 {
            r -= jet.value(r) / slope;
        }
    }
    Some(r)
}
