//! Where a function of a branch or a curve is zero on a step, by the method of the false position in its Illinois form.

use crate::error::Result;

/// Evaluations of a search, and a part of a step below which it is over.
const MOST_TRIES: usize = 40;
const SHARP: f64 = 1e-13;
/// A value is small in this part of those at the ends.
const SMALL: f64 = 1e-6;
/// Places on a step that are not reached.
const MOST_MISSES: usize = 12;
/// The search is over when the parameter moves by no more than this part of its range.
const KNOWN: f64 = 1e-12;

/// A point between the ends of a step.
pub(super) struct Tried<T> {
    pub point: T,
    /// The parameter there.
    pub parameter: f64,
    /// The function there.
    pub value: f64,
}

/// The point nearest to a zero.
pub(super) struct Zero<T> {
    pub point: T,
    pub along: f64,
    /// How far the parameter is known.
    pub error: f64,
}

/// The zero of a function between the beginning of a step, where it has a value, and another so far along it; none where no point between
/// is reached. A parameter of some span tells when it is known.
pub(super) fn zero_between<T>(
    [length, at_start, at_end]: [f64; 3],
    span: f64,
    point: &mut dyn FnMut(f64) -> Result<Option<Tried<T>>>,
) -> Result<Option<Zero<T>>> {
    let (mut low, mut high) = ((0.0, at_start), (length, at_end));
    let mut found: Option<(Zero<T>, f64)> = None;
    let mut side = 0;
    let (mut misses, mut beside) = (0, None);
    for _ in 0..MOST_TRIES {
        let wanted = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        let inside = if wanted > low.0 && wanted < high.0 {
            wanted
        } else {
            0.5 * (low.0 + high.0)
        };
        let along = beside.take().unwrap_or(inside);
        let Some(Tried {
            point,
            parameter,
            value,
        }) = point(along)?
        else {
            // Next to a crossing nothing is reached: it is shut in from both sides, and no more is known.
            misses += 1;
            let from = if misses % 2 == 1 { low.0 } else { high.0 };
            beside = Some(0.5 * (from + along));
            if misses < MOST_MISSES {
                continue;
            }
            break;
        };
        let change = found
            .as_ref()
            .map_or(f64::INFINITY, |(_, before)| (before - parameter).abs());
        let is_small = value.abs() <= SMALL * at_start.abs().max(at_end.abs());
        let is_over = is_small && change <= KNOWN * span && high.0 - low.0 < 0.5 * length
            || high.0 - low.0 <= SHARP * length
            || value == 0.0;
        let error = if value == 0.0 {
            0.0
        } else {
            change.min(length * span)
        };
        let zero = Zero {
            point,
            along,
            error,
        };
        found = Some((zero, parameter));
        if is_over {
            break;
        }
        if (value > 0.0) == (low.1 > 0.0) {
            low = (along, value);
            if side == -1 {
                high.1 *= 0.5;
            }
            side = -1;
        } else {
            high = (along, value);
            if side == 1 {
                low.1 *= 0.5;
            }
            side = 1;
        }
    }
    let width = (high.0 - low.0) * span;
    Ok(found.map(|(zero, _)| Zero {
        error: if misses > 0 { width } else { zero.error },
        ..zero
    }))
}
