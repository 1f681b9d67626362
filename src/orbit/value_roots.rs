//! Roots on an interval of a function of which only values are known. Cells are halved until the values in them leave no room for
//! a root that they do not show: by their second differences, once these agree with each other. That is no proof, as bounds are
//! (`isolate.rs`), but it follows the function where it is steep or bends, and says where it could not decide.

use crate::error::Result;
use crate::root::FalsePosition;
use crate::tolerance::{SAME_PLACE, SECOND_DIFFERENCE_SAFETY, VALUE_ROUNDING};
use std::cell::Cell;

/// Subintervals to begin with. [work]
const FIRST_SUBINTERVALS: usize = 64;
/// Halvings of a subinterval. [work]
const MOST_SUBINTERVAL_HALVINGS: u32 = 30;
/// Halvings of a subinterval in which the function has no value at some places. [work]
const MOST_VALUELESS_HALVINGS: u32 = 10;
/// Values for one root in its bracket. [work]
const MOST_ROOT_POLISHES: usize = 200;
/// Values after which what is left is undecided. [work]
const MOST_ROOT_VALUES: usize = 20_000;
/// Values in a subinterval: both ends, the middle and the quarters, of which a half keeps three. [exact]
const SUBINTERVAL_NODES: usize = 5;

/// The outcome of a search.
#[derive(Debug, Clone, Default)]
pub(crate) struct Roots {
    /// The roots that were found, shape (roots,), [unit of the argument].
    pub places: Vec<f64>,
    /// Stretches in which the values decide nothing, in order.
    pub undecided: Vec<(f64, f64)>,
    /// Number of values.
    pub values: usize,
}

struct Subinterval {
    low: f64,
    high: f64,
    depth: u32,
    /// At five places of equal distance, both ends among them; none where the function has no value.
    y: [Option<f64>; SUBINTERVAL_NODES],
}

enum SubintervalVerdict {
    Clear,
    /// The quarters with a simple root inside, and the places that are one.
    Crossed {
        quarters: Vec<usize>,
        places: Vec<usize>,
    },
    Unknown,
    /// All values are rounding.
    Rounding,
}

/// The verdict on a subinterval by its values.
fn judge(y: [f64; SUBINTERVAL_NODES]) -> SubintervalVerdict {
    let second: [f64; SUBINTERVAL_NODES - 2] =
        std::array::from_fn(|i| y[i] - 2.0 * y[i + 1] + y[i + 2]);
    let largest = second.iter().fold(0.0f64, |m, d| m.max(d.abs()));
    let spread = second.iter().copied().fold(f64::NEG_INFINITY, f64::max)
        - second.iter().copied().fold(f64::INFINITY, f64::min);
    let size = y.iter().fold(0.0f64, |m, y| m.max(y.abs()));
    if size <= 10.0 * VALUE_ROUNDING {
        return SubintervalVerdict::Rounding;
    }
    // Where the function bends alike all over the cell, or hardly, the second differences tell how far it may leave a chord.
    if spread > 0.5 * largest && largest > 0.05 * size {
        return SubintervalVerdict::Unknown;
    }
    let room = SECOND_DIFFERENCE_SAFETY * largest;
    let (mut quarters, mut places) = (Vec::new(), Vec::new());
    for (quarter, ends) in y.windows(2).enumerate() {
        let (a, b) = (ends[0], ends[1]);
        let is_at_place = a.abs().min(b.abs()) <= VALUE_ROUNDING;
        if is_at_place || a * b < 0.0 {
            // The function is monotone on the quarter: its root, at an end too, is simple and the only one.
            if (b - a).abs() <= room {
                return SubintervalVerdict::Unknown;
            }
            if is_at_place {
                places.push(quarter + usize::from(b.abs() < a.abs()));
            } else {
                quarters.push(quarter);
            }
        } else if a.abs().min(b.abs()) <= 0.125 * room {
            return SubintervalVerdict::Unknown;
        }
    }
    if quarters.is_empty() && places.is_empty() {
        SubintervalVerdict::Clear
    } else {
        SubintervalVerdict::Crossed { quarters, places }
    }
}

impl Subinterval {
    fn place(&self, i: usize) -> f64 {
        self.low + (self.high - self.low) * (i as f64 / (SUBINTERVAL_NODES - 1) as f64)
    }

    /// The halves, their values in between made.
    fn halves(&self, mut f: impl FnMut(f64) -> Result<Option<f64>>) -> Result<[Self; 2]> {
        let middle = self.place(2);
        let mut half = |low: f64, high: f64, [a, b, c]: [Option<f64>; 3]| -> Result<Self> {
            let between = |part: f64| low + (high - low) * part;
            Ok(Self {
                low,
                high,
                depth: self.depth + 1,
                y: [a, f(between(0.25))?, b, f(between(0.75))?, c],
            })
        };
        let [a, b, c, d, e] = self.y;
        Ok([
            half(self.low, middle, [a, b, c])?,
            half(middle, self.high, [c, d, e])?,
        ])
    }
}

/// Searches an interval for the simple roots of a function, which may be without a value at some places.
pub(crate) fn roots(
    (low, high): (f64, f64),
    mut f: impl FnMut(f64) -> Result<Option<f64>>,
) -> Result<Roots> {
    let mut found = Roots::default();
    let values = Cell::new(0);
    let mut f = |x: f64| {
        values.set(values.get() + 1);
        f(x)
    };
    let at = |i: usize| low + (high - low) * i as f64 / FIRST_SUBINTERVALS as f64;
    let mut last = f(low)?;
    for i in 0..FIRST_SUBINTERVALS {
        let mut y = [last; SUBINTERVAL_NODES];
        let (start, end) = (at(i), at(i + 1));
        for (k, y) in y.iter_mut().enumerate().skip(1) {
            *y = f(start + (end - start) * (k as f64 / (SUBINTERVAL_NODES - 1) as f64))?;
        }
        last = y[SUBINTERVAL_NODES - 1];
        // The cells that are open, the first one last.
        let mut open = vec![Subinterval {
            low: start,
            high: end,
            depth: 0,
            y,
        }];
        while let Some(cell) = open.pop() {
            let known: Option<Vec<f64>> = cell.y.iter().copied().collect();
            let deepest = if known.is_some() {
                MOST_SUBINTERVAL_HALVINGS
            } else {
                MOST_VALUELESS_HALVINGS
            };
            let verdict = known.and_then(|y| Some(judge(y.try_into().ok()?)));
            match verdict {
                Some(SubintervalVerdict::Clear) => {}
                Some(SubintervalVerdict::Crossed { quarters, places }) => {
                    found.places.extend(places.iter().map(|&i| cell.place(i)));
                    for k in quarters {
                        let ends = [k, k + 1];
                        let values = ends.map(|i| cell.y[i].unwrap_or(f64::NAN));
                        let search = FalsePosition::new(ends.map(|i| cell.place(i)), values);
                        found
                            .places
                            .extend(search.zero(MOST_ROOT_POLISHES, &mut f)?);
                    }
                }
                Some(SubintervalVerdict::Rounding) => {
                    extend(&mut found.undecided, (cell.low, cell.high));
                }
                _ if cell.depth >= deepest || values.get() >= MOST_ROOT_VALUES => {
                    extend(&mut found.undecided, (cell.low, cell.high));
                }
                _ => {
                    let [first, second] = cell.halves(&mut f)?;
                    open.push(second);
                    open.push(first);
                }
            }
        }
    }
    found.values = values.get();
    // A root at a place is seen from both sides of it.
    let same = SAME_PLACE * (low.abs() + high.abs());
    found.places.sort_by(f64::total_cmp);
    found.places.dedup_by(|b, a| (*b - *a).abs() <= same);
    Ok(found)
}

/// Adds a stretch, joined to the last one where they touch.
fn extend(stretches: &mut Vec<(f64, f64)>, (low, high): (f64, f64)) {
    match stretches.last_mut() {
        Some(last) if last.1 >= low => last.1 = high,
        _ => stretches.push((low, high)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(range: (f64, f64), f: impl Fn(f64) -> f64) -> Roots {
        roots(range, |x| Ok(Some(f(x)))).expect("no failure")
    }

    #[test]
    fn pairs_between_the_first_places_are_found() {
        for gap in [1e-2, 1e-3, 1e-5] {
            for middle in [0.3, 1.234_567, 4.0] {
                let pair = found((0.0, 4.3), |x| {
                    ((x - middle).powi(2) - gap * gap) / (1.0 + x * x)
                });
                assert_eq!(pair.places.len(), 2, "{gap} {middle}: {pair:?}");
                for (root, exact) in pair.places.iter().zip([middle - gap, middle + gap]) {
                    assert!((root - exact).abs() < 1e-14 / gap, "{root} {exact}");
                }
                assert!(pair.undecided.is_empty(), "{pair:?}");
                assert!(
                    found((0.0, 4.3), |x| (x - middle).powi(2) + gap * gap)
                        .places
                        .is_empty()
                );
            }
        }
    }

    #[test]
    fn a_root_where_a_value_is_taken_is_found_once() {
        // Ends and halves of cells and of quarters, and both ends of the interval; curved, too.
        for place in [0.0, 0.25, 0.5, 0.515_625, 0.503_906_25, 0.75, 1.0] {
            for bend in [0.0, 0.3, -0.3] {
                let single = found((0.0, 1.0), |x| (x - place) * (1.0 + bend * x));
                assert_eq!(single.places, [place], "{bend}");
                assert!(single.undecided.is_empty(), "{place} {bend}: {single:?}");
            }
        }
        let ends = found((0.1, 0.7), |x| (x - 0.1) * (x - 0.4) * (x - 0.7));
        assert_eq!(ends.places.len(), 3, "{ends:?}");
        assert!(ends.undecided.is_empty(), "{ends:?}");
    }

    #[test]
    fn every_root_of_a_fast_function_is_found_and_a_double_one_is_undecided() {
        let fast = found((0.0, 10.0), |x| (20.0 * x).sin() + 0.999);
        assert!(fast.undecided.is_empty());
        // Two about each minimum, 3 pi/2 + 2 pi k below 200: k up to 31.
        assert_eq!(fast.places.len(), 64);
        let double = found((0.0, 1.0), |x| (x - 0.3).powi(2));
        assert_eq!((double.places.len(), double.undecided.len()), (0, 1));
        let (low, high) = double.undecided[0];
        assert!(
            low <= 0.3 && 0.3 <= high && high - low < 1e-5,
            "{low} {high}"
        );
        let half = roots((0.0, 1.0), |x| Ok((x > 0.4).then_some(x - 0.7))).expect("no failure");
        assert_eq!((half.places.len(), half.undecided.len()), (1, 1));
        assert!((half.places[0] - 0.7).abs() < 1e-15);
    }
}
