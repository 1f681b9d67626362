//! The verdict on a gap over one step of a flight, from its cubic model with a certified remainder (theory 8). A minimum that the cubic does
//! not tell from zero is left to the motion itself, and to `touch.rs`. Times are counted from the start of the step \[s\].

use crate::flow::gap_model::{GapModel, Shape};

/// What one gap provably does over one step.
pub(crate) enum GapVerdict {
    /// No contact.
    Clear,
    /// It falls to its one minimum and rises again; the minimum lies too near to zero for the cubic to tell on which side.
    Dips { near: f64 },
    /// It stays within rounding of zero.
    Rests,
    /// The stop is reached at a time, to the accuracy of the cubic, and provably passed at a later one.
    Reached { at: f64, passed: f64 },
    /// Nothing could be proved.
    Unknown,
}

/// The verdict over a step that begins with an open gap. `rounding` gives the rounding of the gap; it is called where the gap does not stay
/// above `clear`, which is no smaller.
#[inline]
pub(crate) fn from_open(
    model: &GapModel,
    step: f64,
    clear: f64,
    rounding: impl FnOnce() -> f64,
) -> GapVerdict {
    if model.is_above(clear, step) {
        return GapVerdict::Clear;
    }
    near_stop(model, step, rounding())
}

/// The same for a gap that may reach the stop.
fn near_stop(model: &GapModel, step: f64, rounding: f64) -> GapVerdict {
    let reached = |model: &GapModel, passed: f64| {
        let at = if model.c[0] > 0.0 {
            model.falling_root(passed)
        } else {
            0.0
        };
        GapVerdict::Reached { at, passed }
    };
    // Passed already: nothing is open that could close later.
    if model.c[0] < -rounding {
        return GapVerdict::Reached {
            at: 0.0,
            passed: 0.0,
        };
    }
    match model.shape(step) {
        Shape::Falling => {
            let (end, error) = (model.value(step), model.remainder(step));
            if end + error < -rounding {
                reached(model, step)
            } else if end - error > -rounding {
                GapVerdict::Clear
            } else {
                GapVerdict::Unknown
            }
        }
        Shape::LowestAtEnd if model.value(step) - model.remainder(step) > -rounding => {
            GapVerdict::Clear
        }
        Shape::Minimum { at, value, error } => {
            if value - error > rounding {
                GapVerdict::Clear
            } else if value + model.remainder(at) < -rounding {
                reached(model, at)
            } else {
                GapVerdict::Dips { near: at }
            }
        }
        Shape::LowestAtEnd | Shape::Unknown if model.spread(step) <= rounding => {
            if model.c[0] <= rounding {
                GapVerdict::Rests
            } else {
                GapVerdict::Clear
            }
        }
        Shape::LowestAtEnd | Shape::Unknown => GapVerdict::Unknown,
    }
}

/// The verdict over a step that begins on the stop, with a root of the given order, or a higher one, at its start; `rounding` is that of the
/// gap.
pub(crate) fn from_contact(model: &GapModel, order: usize, step: f64, rounding: f64) -> GapVerdict {
    let deflated = model.deflated(order);
    if deflated.is_positive(step) {
        GapVerdict::Clear
    } else if deflated.crosses(step) {
        GapVerdict::Reached {
            at: deflated.root(step),
            passed: step,
        }
    } else if deflated.spread(step) <= rounding {
        GapVerdict::Clear
    } else {
        GapVerdict::Unknown
    }
}
