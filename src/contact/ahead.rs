//! What a gap does over one step, from its cubic with a certified remainder (theory 8).

use crate::contact::walk::ROUNDING;
use crate::flow::jet::{Jet, Shape};

/// What one gap does over one step.
pub(crate) enum Ahead {
    /// No contact.
    Clear,
    /// A touch within the margin.
    Touch { at: f64, gap: f64 },
    /// The stop is reached, to the accuracy of the cubic.
    Reached { at: f64 },
    /// Nothing could be proved.
    Unknown,
}

/// Over a step that starts with an open gap.
pub(crate) fn from_open(jet: &Jet, step: f64, margin: f64) -> Ahead {
    let backwards = |jet: &Jet, end: f64| {
        if jet.c[0] > 0.0 {
            jet.falling_root(end)
        } else {
            -jet.c[0] / jet.c[1]
        }
    };
    match jet.shape(margin.max(ROUNDING * jet.size), step) {
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
pub(crate) fn from_contact(jet: &Jet, order: usize, step: f64) -> Ahead {
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
