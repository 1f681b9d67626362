//! What a gap does over one step, from its cubic with a certified remainder (theory 8).

use crate::flow::gap_model::{GapModel, Shape};

/// What one gap does over one step.
pub(crate) enum Ahead {
    /// No contact.
    Clear,
    /// It falls to its one minimum and rises again; that lies too near zero for the cubic to tell on which side.
    Dips { near: f64 },
    /// It stays within rounding of zero.
    Rests,
    /// The stop is reached at a time, to the accuracy of the cubic, and provably passed at a later one.
    Reached { at: f64, passed: f64 },
    /// Nothing could be proved.
    Unknown,
}

/// Over a step that begins with an open gap; `rounding` is that of the gap, asked for where it does not stay above `clear`, which is
/// no less.
#[inline]
pub(crate) fn from_open(
    model: &GapModel,
    step: f64,
    clear: f64,
    rounding: impl FnOnce() -> f64,
) -> Ahead {
    if model.is_above(clear, step) {
        return Ahead::Clear;
    }
    near_stop(model, step, rounding())
}

/// The same of a gap that may reach the stop.
fn near_stop(model: &GapModel, step: f64, rounding: f64) -> Ahead {
    let reached = |model: &GapModel, passed: f64| {
        let at = if model.c[0] > 0.0 {
            model.falling_root(passed)
        } else {
            0.0
        };
        Ahead::Reached { at, passed }
    };
    // Passed already: nothing is open that could close later.
    if model.c[0] < -rounding {
        return Ahead::Reached {
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
                Ahead::Clear
            } else {
                Ahead::Unknown
            }
        }
        Shape::LowestAtEnd if model.value(step) - model.remainder(step) > -rounding => Ahead::Clear,
        Shape::Minimum { at, value, error } => {
            if value - error > rounding {
                Ahead::Clear
            } else if value + model.remainder(at) < -rounding {
                reached(model, at)
            } else {
                Ahead::Dips { near: at }
            }
        }
        Shape::LowestAtEnd | Shape::Unknown if model.spread(step) <= rounding => {
            if model.c[0] <= rounding {
                Ahead::Rests
            } else {
                Ahead::Clear
            }
        }
        Shape::LowestAtEnd | Shape::Unknown => Ahead::Unknown,
    }
}

/// Over a step that begins on the stop, with a root of the given order, or a higher one, at its start; `rounding` is that of the
/// gap.
pub(crate) fn from_contact(model: &GapModel, order: usize, step: f64, rounding: f64) -> Ahead {
    let deflated = model.deflated(order);
    if deflated.is_positive(step) {
        Ahead::Clear
    } else if deflated.crosses(step) {
        Ahead::Reached {
            at: deflated.root(step),
            passed: step,
        }
    } else if deflated.spread(step) <= rounding {
        Ahead::Clear
    } else {
        Ahead::Unknown
    }
}
