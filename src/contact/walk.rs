//! Walking along a flight in steps each of which provably holds nothing unseen (theory 8): the steps are halves of one
//! longest step, so that their propagators are made once and kept.

use crate::error::Result;
use crate::flow::jet::Shape;
use crate::flow::{GapRow, LinearFlow};
use crate::modal::Pair;
use crate::watch::Watch;

/// Halvings of the longest step before the search gives up proving and takes the node for what it is.
pub(crate) const DEEPEST: usize = 52;
/// Rungs that a ladder has room for from the start.
const USUAL_DEPTH: usize = 12;
/// Shortest steps without a proof after which a gap counts as touching its stop for good: it is within rounding of it.
const MOST_UNPROVED: usize = 64;
/// Steps after which a stop out of reach is looked for: damping takes stops out of reach during a flight.
pub(crate) const STEPS_PER_LOOK: usize = 16;
/// Rounding of a gap, relative to the size of its terms.
pub(crate) const ROUNDING: f64 = 1e-14;

/// Propagators for `longest_step / 2^level`, made when first asked for.
pub(crate) struct Ladder<F: LinearFlow> {
    longest: f64,
    rungs: Vec<F::Propagator>,
    /// Bit k: rung k is made.
    made: u64,
}

impl<F: LinearFlow> Ladder<F> {
    /// An empty ladder for a flow.
    pub fn new(flow: &F) -> Self {
        Self {
            longest: flow.longest_step(),
            rungs: Vec::with_capacity(USUAL_DEPTH),
            made: 0,
        }
    }

    /// The step of a level.
    #[inline]
    pub fn step(&self, level: usize) -> f64 {
        // 2^-level, by its exponent.
        self.longest * f64::from_bits((1023 - level as u64) << 52)
    }

    /// The first level whose step does not exceed a span.
    pub fn level_below(&self, span: f64) -> usize {
        let level = (self.longest / span).log2().ceil().max(0.0);
        if level < DEEPEST as f64 {
            level as usize
        } else {
            DEEPEST
        }
    }

    /// Moves a state forward by the step of a level. The work that it was, in operations on a block, at the most.
    #[inline]
    pub fn advance(&mut self, flow: &F, level: usize, state: &mut [Pair]) -> usize {
        let mut work = state.len();
        if self.made >> level & 1 == 0 {
            if self.rungs.len() <= level {
                self.rungs.resize_with(level + 1, F::Propagator::default);
            }
            flow.prepare(self.step(level), &mut self.rungs[level]);
            self.made |= 1 << level;
            work = work.pow(3);
        }
        flow.advance(&self.rungs[level], state);
        work
    }
}

/// A place where a gap is lowest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lowest {
    pub time: f64,
    pub gap: f64,
}

/// What the search of a whole flight found.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct FlightCheck {
    /// The lowest point below minus the margin.
    pub violation: Option<Lowest>,
    /// The lowest interior minimum within the margin of zero.
    pub graze: Option<Lowest>,
}

impl FlightCheck {
    /// Takes note of a minimum that is not clear of the margin.
    fn note(&mut self, lowest: Lowest, margin: f64) {
        let slot = if lowest.gap < -margin {
            &mut self.violation
        } else {
            &mut self.graze
        };
        if slot.is_none_or(|known| lowest.gap < known.gap) {
            *slot = Some(lowest);
        }
    }
}

/// How far a violation is followed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Effort {
    /// A violation deeper than this ends the search.
    pub enough: f64,
    /// Relative error that its depth may have; the margin decides where that is finer.
    pub depth_error: f64,
}

impl Effort {
    /// The deepest point, as well as it can be known.
    pub const FULL: Self = Self {
        enough: f64::INFINITY,
        depth_error: 0.0,
    };
}

/// Searches a flight of a known span for the lowest value of one gap; every value above the margin is passed over by
/// proof. An end at which the stop is hit has gap zero and is judged by the sign of the slope, not by its rounding.
///
/// # Errors
/// `Error::Interrupted` from the watch.
pub(crate) fn check_flight<F: LinearFlow>(
    flow: &F,
    ladder: &mut Ladder<F>,
    gap: &GapRow,
    state: &mut [Pair],
    span: f64,
    (margin, effort): (f64, Effort),
    watch: &mut Watch<'_>,
) -> Result<FlightCheck> {
    let mut derivatives = Vec::with_capacity(state.len());
    let mut norms = Vec::with_capacity(state.len());
    let mut steps = 0usize;
    let mut check = FlightCheck::default();
    let mut level = ladder.level_below(0.25 * span);
    let mut time = 0.0;
    let mut unproved = 0;
    loop {
        if steps.is_multiple_of(STEPS_PER_LOOK) {
            flow.norms(state, &mut norms);
            if gap.least(&norms).0 > margin {
                return Ok(check);
            }
        }
        steps += 1;
        flow.derivatives(state, &mut derivatives);
        let jet = gap.jet(&derivatives);
        if jet.c[0] < -margin {
            check.note(
                Lowest {
                    time,
                    gap: jet.c[0],
                },
                margin,
            );
        }
        let floor = match check.violation {
            Some(lowest) if lowest.gap < -effort.enough => return Ok(check),
            Some(lowest) => lowest.gap,
            None => ROUNDING * jet.size,
        };
        let mut step;
        let mut refined = false;
        loop {
            step = ladder.step(level).min(span - time);
            let proved = match jet.shape(floor, step) {
                // A gap that does not move by more than the margin has its value there as its lowest.
                Shape::Unknown if jet.spread(step) <= margin => {
                    if jet.c[0] <= margin {
                        check.note(
                            Lowest {
                                time,
                                gap: jet.c[0],
                            },
                            margin,
                        );
                    }
                    true
                }
                Shape::Unknown => false,
                Shape::Minimum { at, value, error } => {
                    // A stop left at zero speed has its minimum at the start, but for rounding: the contact itself.
                    let is_contact = time == 0.0
                        && jet.c[0] <= margin
                        && jet.c[0] - value <= ROUNDING * jet.size;
                    let is_clear = is_contact || value - error > margin;
                    let is_sharp =
                        is_clear || error <= (0.1 * margin).max(-effort.depth_error * value);
                    if is_sharp && !is_clear {
                        check.note(
                            Lowest {
                                time: time + at,
                                gap: value,
                            },
                            margin,
                        );
                    }
                    is_sharp
                }
                Shape::Above | Shape::Falling | Shape::LowestAtEnd => true,
            };
            if proved {
                break;
            }
            if level == DEEPEST {
                unproved += 1;
                if unproved > MOST_UNPROVED {
                    check.note(
                        Lowest {
                            time,
                            gap: jet.c[0],
                        },
                        margin,
                    );
                    return Ok(check);
                }
                break;
            }
            refined = true;
            level += 1;
        }
        if time + step >= span {
            return Ok(check);
        }
        watch.work(ladder.advance(flow, level, state))?;
        time += step;
        if !refined {
            level = level.saturating_sub(1);
        }
    }
}
