//! The lowest gap \[m\] on a flight of a known span \[s\], by steps each of which provably holds no lower one unseen (theory 8).

use crate::error::Result;
use crate::event::levels::PropagatorLevels;
use crate::event::lowest::Lowest;
use crate::event::touch::Bottom;
use crate::flow::gap_model::{GapModel, Shape};
use crate::flow::{GapRow, LinearFlow};
use crate::modal::Pair;
use crate::observer::Observer;
use crate::tolerance::GAP_ROUNDING;

/// Shortest steps without a proof after which nothing more is expected to be proved. [work]
const MOST_UNPROVED_STEPS: usize = 64;
/// Steps between two checks whether a stop is out of reach for all times to come: damping takes stops out of reach during a flight. [work]
pub(crate) const STEPS_PER_REACH_CHECK: usize = 16;

/// What the search of a whole flight found.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct FlightCheck {
    /// The lowest point below minus the margin.
    pub violation: Option<Lowest>,
    /// The lowest interior minimum within the margin of zero.
    pub graze: Option<Lowest>,
    /// The time from which on nothing is proved of the gap.
    pub undecided: Option<f64>,
}

impl FlightCheck {
    /// Takes note of a minimum that is not clear of the margin.
    fn note(&mut self, lowest: Lowest, margin: f64) {
        let slot = match Bottom::of(lowest.gap, margin) {
            Bottom::Passed => &mut self.violation,
            _ => &mut self.graze,
        };
        if slot.is_none_or(|known| lowest.gap < known.gap) {
            *slot = Some(lowest);
        }
    }
}

/// How deep, and how accurately, the search follows a violation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StopDepth {
    /// A violation deeper than this ends the search.
    pub enough: f64,
    /// Relative error that its depth may have; the margin decides where that is finer.
    pub depth_error: f64,
}

impl StopDepth {
    /// The error that a minimum of some value may have.
    fn fineness(self, margin: f64, value: f64) -> f64 {
        (0.1 * margin).max(-self.depth_error * value)
    }

    /// To the deepest point, as accurately as it can be known.
    pub const FULL: Self = Self {
        enough: f64::INFINITY,
        depth_error: 0.0,
    };
}

/// The search of one flight: its span, the margin within which a gap counts as zero, how deep a violation is followed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sought {
    pub span: f64,
    pub margin: f64,
    pub stop_depth: StopDepth,
}

/// A gap at a time of a flight.
struct GapSample<'a, F: LinearFlow> {
    flow: &'a F,
    gap: &'a GapRow,
    state: &'a [Pair],
    model: &'a GapModel,
    time: f64,
}

impl<F: LinearFlow> GapSample<'_, F> {
    /// Whether the model proves what the gap does in a step; a minimum within the margin, or below it, is noted.
    fn tells(
        &self,
        step: f64,
        (margin, stop_depth): (f64, StopDepth),
        check: &mut FlightCheck,
    ) -> bool {
        let &Self { model, time, .. } = self;
        match model.shape(step) {
            // A gap that does not move by more than the margin has its value there as its lowest.
            Shape::Unknown if model.spread(step) <= margin => {
                if model.c[0] <= margin {
                    let gap = model.c[0];
                    check.note(Lowest { time, gap }, margin);
                }
                true
            }
            Shape::Unknown => false,
            Shape::Minimum { at, value, error } => {
                // A stop left at zero speed has its minimum at the start, but for rounding: the contact itself.
                let is_contact = time == 0.0
                    && model.c[0] <= margin
                    && model.c[0] - value <= GAP_ROUNDING * model.size;
                let is_clear = is_contact || value - error > margin;
                // Of a motion of no size the margin is none: no value is known better than to rounding.
                let (fine, rounding) = (
                    stop_depth.fineness(margin, value),
                    GAP_ROUNDING * model.size,
                );
                let margin = if error > fine {
                    margin.max(rounding)
                } else {
                    margin
                };
                let is_sharp = is_clear || error <= fine.max(rounding);
                if is_sharp && !is_clear {
                    let found = Lowest {
                        time: at,
                        gap: value,
                    };
                    let Lowest { time: at, gap } = found.sharpened(self.flow, self.gap, self.state);
                    let time = time + at;
                    check.note(Lowest { time, gap }, margin);
                }
                is_sharp
            }
            Shape::Falling | Shape::LowestAtEnd => true,
        }
    }
}

/// Searches a flight of a known span for the lowest value of one gap; every value above the margin is passed over by
/// proof, and where there is none the search ends and says from when on. An end at which the stop is hit has gap zero and is
/// judged by the sign of the slope, not by its rounding.
///
/// # Errors
/// `Error::Interrupted` from the observer.
pub(crate) fn check_flight<F: LinearFlow>(
    flow: &F,
    levels: &mut PropagatorLevels<F>,
    gap: &GapRow,
    state: &mut [Pair],
    Sought {
        span,
        margin,
        stop_depth,
    }: Sought,
    observer: &mut Observer,
) -> Result<FlightCheck> {
    let mut derivatives = Vec::with_capacity(state.len());
    let mut norms = Vec::with_capacity(state.len());
    let mut steps = 0usize;
    let mut check = FlightCheck::default();
    let mut level = levels.level_below(0.25 * span);
    let mut time = 0.0;
    let mut unproved = 0;
    loop {
        if steps.is_multiple_of(STEPS_PER_REACH_CHECK) {
            flow.norms(state, &mut norms);
            if gap.least(&norms).0 > margin {
                return Ok(check);
            }
        }
        steps += 1;
        flow.derivatives(state, &mut derivatives);
        let model = gap.model(&derivatives);
        if model.c[0] < -margin.max(GAP_ROUNDING * model.size) {
            check.note(
                Lowest {
                    time,
                    gap: model.c[0],
                },
                margin,
            );
        }
        let floor = match check.violation {
            Some(lowest) if lowest.gap < -stop_depth.enough => return Ok(check),
            Some(lowest) => lowest.gap,
            None => GAP_ROUNDING * model.size,
        };
        let (mut step, mut is_last);
        let mut refined = false;
        loop {
            // The state goes on by whole steps of a level: one that is cut short is the last, whatever its sum with the time rounds to.
            is_last = levels.step(level) >= span - time;
            step = levels.step(level).min(span - time);
            let here = GapSample {
                flow,
                gap,
                state,
                model: &model,
                time,
            };
            let proved =
                model.is_above(floor, step) || here.tells(step, (margin, stop_depth), &mut check);
            if proved {
                break;
            }
            if level == levels.deepest {
                // A step of rounding's length hides nothing; a longer one may hide a whole passage.
                unproved += 1;
                if unproved > MOST_UNPROVED_STEPS || step > f64::EPSILON * span {
                    check.undecided = Some(time);
                    return Ok(check);
                }
                break;
            }
            refined = true;
            level += 1;
        }
        if is_last {
            return Ok(check);
        }
        let made = levels.prepare(flow, level, state.len());
        levels.advance(flow, level, state);
        observer.work(made.unwrap_or(state.len()))?;
        time += step;
        if !refined {
            level = levels.above(level);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::FlowRows;
    use crate::flow::Quantity;
    use crate::flow::block::BlockFlow;
    use crate::flow::drive::Undriven;
    use crate::modal::Block;
    use crate::model::Moment;

    /// `q = cos t` before a stop at 0.916, which it passes by 0.084 about t = 2 pi; `longest` stands for a rate from which no
    /// halving comes down to the flight.
    fn passed_by_a_twelfth(longest: Option<f64>) -> FlightCheck {
        let flow = BlockFlow::new(&[Block::Oscillator { w2: 1.0, eta: 0.0 }], Undriven);
        let gap = flow.gap_row(&Quantity::gap(0.916, &[[1.0, 0.0]]));
        let mut levels = PropagatorLevels::new(&flow);
        levels.longest = longest.unwrap_or(levels.longest);
        let mut state = Vec::new();
        let at = Moment::of_angle(0.0);
        flow.state_from_modal(&vec![[0.0, -1.0]].into(), at, &mut state);
        let sought = Sought {
            span: 6.0,
            margin: 1e-12,
            stop_depth: StopDepth::FULL,
        };
        check_flight(
            &flow,
            &mut levels,
            &gap,
            &mut state,
            sought,
            &mut Observer::default(),
        )
        .expect("not interrupted")
    }

    #[test]
    fn no_search_goes_on_without_a_proof() {
        let depth = passed_by_a_twelfth(None).violation.expect("passed").gap;
        assert!((depth + 0.084).abs() < 1e-12, "{depth}");
        for longest in [1e17, 1e19, 1e21] {
            let check = passed_by_a_twelfth(Some(longest));
            assert!(
                check.undecided.is_some() || check.violation.is_some(),
                "{longest:e}: {check:?}"
            );
        }
    }
}
