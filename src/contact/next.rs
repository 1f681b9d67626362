//! The next impact of an exact flight (theory 8): the first time at which some gap falls below minus its margin, led back
//! to its zero. Every step is proved to hold no other; touches inside the margin are noted as grazes.

use crate::contact::walk::{DEEPEST, Ladder, ROUNDING};
use crate::flow::jet::{Jet, Shape};
use crate::flow::{GapRow, LinearFlow};
use crate::modal::Pair;

/// Distance from zero within which a gap's minimum is a graze: `absolute + relative * size of the gap's terms`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Margin {
    pub absolute: f64,
    pub relative: f64,
}

impl Margin {
    pub fn of(self, jet: &Jet) -> f64 {
        self.absolute + self.relative * jet.size
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
    /// The caller's check asked to stop.
    Interrupted,
}

/// What one gap does over one step.
enum Ahead {
    Clear,
    Touch { at: f64, gap: f64 },
    Reached { at: f64 },
    Unknown,
}

/// Over a step that starts with an open gap.
fn from_open(jet: &Jet, step: f64, margin: f64) -> Ahead {
    let backwards = |jet: &Jet, end: f64| {
        if jet.c[0] > 0.0 {
            jet.falling_root(end)
        } else {
            -jet.c[0] / jet.c[1]
        }
    };
    match jet.shape(ROUNDING * jet.size, step) {
        Shape::Above => Ahead::Clear,
        Shape::Falling => {
            let (end, error) = (jet.value(step), jet.remainder(step));
            if end + error < -margin {
                Ahead::Reached {
                    at: backwards(jet, step),
                }
            } else if end - error > -margin {
                Ahead::Clear
            } else {
                Ahead::Unknown
            }
        }
        Shape::LowestAtEnd if jet.value(step) - jet.remainder(step) > -margin => Ahead::Clear,
        Shape::Minimum { at, value, error } => {
            if value - error > margin {
                Ahead::Clear
            } else if value + jet.remainder(at) < -margin {
                Ahead::Reached {
                    at: backwards(jet, at),
                }
            } else if error <= 0.1 * margin {
                Ahead::Touch { at, gap: value }
            } else {
                Ahead::Unknown
            }
        }
        Shape::LowestAtEnd | Shape::Unknown => Ahead::Unknown,
    }
}

/// Over a step that starts on the stop, with a root of the given order at its start.
fn from_contact(jet: &Jet, order: usize, step: f64) -> Ahead {
    let deflated = jet.deflated(order);
    if deflated.is_positive(step) {
        Ahead::Clear
    } else if deflated.crosses(step) {
        Ahead::Reached {
            at: deflated.root(step),
        }
    } else {
        Ahead::Unknown
    }
}

/// Steps between two calls of the caller's check.
const STEPS_PER_CHECK: usize = 4096;

/// The search along one flight after another, with its buffers.
pub(crate) struct Search<'f, F: LinearFlow> {
    flow: &'f F,
    rows: Vec<GapRow>,
    margins: Vec<Margin>,
    ladder: Ladder<F>,
    level: usize,
    jets: Vec<Jet>,
    state: Vec<Pair>,
    steps_to_check: usize,
    /// Evaluations of a gap so far.
    pub n_gap_evaluations: usize,
}

impl<'f, F: LinearFlow> Search<'f, F> {
    pub fn new(flow: &'f F, rows: Vec<GapRow>, margins: Vec<Margin>) -> Self {
        let ladder = Ladder::new(flow);
        Self {
            flow,
            jets: vec![Jet::default(); rows.len()],
            rows,
            margins,
            ladder,
            level: 0,
            state: Vec::new(),
            steps_to_check: STEPS_PER_CHECK,
            n_gap_evaluations: 0,
        }
    }

    /// Forgets what earlier flights left, so that the next run has the same bits as a first one.
    pub fn restart(&mut self) {
        self.level = 0;
        self.n_gap_evaluations = 0;
        self.steps_to_check = STEPS_PER_CHECK;
    }

    /// The jets of every gap at a state.
    pub fn jets(&mut self, state: &[Pair], u: F::Phasor) -> &mut [Jet] {
        self.n_gap_evaluations += self.rows.len();
        self.flow.jets(state, u, &self.rows, &mut self.jets);
        &mut self.jets
    }

    /// The margins.
    pub fn margin(&self, stop: usize, jet: &Jet) -> f64 {
        self.margins[stop].of(jet)
    }

    /// The next contact within `span` of the state. `starts[i]` is the order of the root of gap i at the start, zero
    /// for an open gap; `check` is asked from time to time whether to go on.
    pub fn next(
        &mut self,
        start: &[Pair],
        mut u: F::Phasor,
        starts: &[usize],
        span: f64,
        grazes: &mut Vec<Grazed>,
        check: &mut dyn FnMut() -> bool,
    ) -> Next {
        if self.rows.is_empty() {
            return Next::End;
        }
        self.state.clear();
        self.state.extend_from_slice(start);
        let mut time = 0.0;
        let mut is_first = true;
        loop {
            self.steps_to_check -= 1;
            if self.steps_to_check == 0 {
                self.steps_to_check = STEPS_PER_CHECK;
                if !check() {
                    return Next::Interrupted;
                }
            }
            self.n_gap_evaluations += self.rows.len();
            self.flow.jets(&self.state, u, &self.rows, &mut self.jets);
            // Past the end, a stop that is passed by less than its margin may have been reached before it.
            if time >= span && !self.jets.iter().any(|j| j.c[0] < 0.0 && j.c[1] < 0.0) {
                return Next::End;
            }
            let first_level = self.level;
            let reached = loop {
                let step = self.ladder.step(self.level);
                let noted = grazes.len();
                match self.step_ahead(
                    if is_first { Some(starts) } else { None },
                    step,
                    time,
                    grazes,
                ) {
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
                grazes.retain(|g| g.time < time + at);
                return Next::Contact {
                    stop,
                    time: time + at,
                };
            }
            time += self.ladder.step(self.level);
            self.ladder
                .advance(self.flow, self.level, &mut self.state, &mut u);
            if self.level == first_level {
                self.level = self.level.saturating_sub(1);
            }
            is_first = false;
        }
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
        for (stop, jet) in self.jets.iter().enumerate() {
            let ahead = match starts.map_or(0, |orders| orders[stop]) {
                0 => from_open(jet, step, self.margins[stop].of(jet)),
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
}
