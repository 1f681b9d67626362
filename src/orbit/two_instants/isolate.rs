//! Every zero of an analytic function on an interval, by walking over it in cells that are each decided by bounds
//! (theory 5): a cell has no zero, or the function is monotone in it, or the cell is halved, down to a smallest width.

use crate::error::Result;
use crate::observer::Observer;
use crate::orbit::two_instants::taylor_model::TaylorModel;

/// The interval over the smallest cell.
const FINEST: u64 = 1 << 26;
/// Cells after which the search gives up.
const MOST_CELLS: usize = 400_000;

/// A function over a cell, and the size of its rounding there.
pub(crate) struct Sampled {
    pub series: TaylorModel,
    pub floor: f64,
}

/// A part of the interval in which a zero lies, or may lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Enclosure {
    pub low: f64,
    pub high: f64,
    /// Where the polynomial has its zero.
    pub guess: f64,
}

/// What the walk found.
#[derive(Debug, Clone, Default)]
pub(crate) struct Isolated {
    /// Cells in which the function is monotone and has one zero.
    pub simple: Vec<Enclosure>,
    /// Stretches of smallest cells, or of cells of rounding, that nothing was proved of.
    pub undecided: Vec<Enclosure>,
    /// Cells looked at.
    pub cells: usize,
}

impl Isolated {
    /// What walks over two intervals found.
    pub fn joined(mut self, other: Self) -> Self {
        self.simple.extend(other.simple);
        self.undecided.extend(other.undecided);
        self.cells += other.cells;
        self
    }
}

/// A cell as the function sees it: both ends and the origin of its series; `end` says that the interval's end is part of
/// it, and that the series is about that end.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CellPlace {
    pub low: f64,
    pub high: f64,
    pub end: CellEnd,
}

/// Which end of the interval a cell touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum CellEnd {
    Neither,
    Low,
    High,
}

enum CellVerdict {
    Clear,
    Simple(f64),
    Unknown,
    Rounding,
}

fn judge(place: &CellPlace, sampled: &Sampled) -> CellVerdict {
    let Sampled { series, floor } = sampled;
    if series.is_clear_of_zero(*floor) {
        return CellVerdict::Clear;
    }
    if series.bound() <= *floor {
        return CellVerdict::Rounding;
    }
    if !series.is_monotone() {
        return CellVerdict::Unknown;
    }
    let (first, last) = match place.end {
        CellEnd::Neither => (-1.0, 1.0),
        CellEnd::Low => (0.0, 1.0),
        CellEnd::High => (-1.0, 0.0),
    };
    let slack = series.remainder() + floor;
    let (a, b) = (series.value(first), series.value(last));
    if a.min(b) > slack || a.max(b) < -slack {
        return CellVerdict::Clear;
    }
    // A zero within the slack of an end may be the neighbour's, or nobody's.
    if a.abs().min(b.abs()) <= slack {
        return CellVerdict::Unknown;
    }
    CellVerdict::Simple(series.newton(0.5 * (first + last)).clamp(first, last))
}

/// Walks over `low..high`; the ends that are named in `deflated` are expanded about.
///
/// # Errors
/// `Error::Interrupted` from the observer.
pub(crate) fn isolate(
    (low, high): (f64, f64),
    deflated: (bool, bool),
    observer: &mut Observer<'_>,
    mut function: impl FnMut(&CellPlace) -> Sampled,
) -> Result<Isolated> {
    let mut found = Isolated::default();
    let at = |i: u64| {
        if i == FINEST {
            high
        } else {
            low + (high - low) * (i as f64 / FINEST as f64)
        }
    };
    let (mut position, mut step) = (0, FINEST / 16);
    while position < FINEST {
        let mut width = step.min(FINEST - position);
        let mut is_first_try = true;
        loop {
            let end = match (position, position + width) {
                (0, _) if deflated.0 => CellEnd::Low,
                (_, FINEST) if deflated.1 => CellEnd::High,
                _ => CellEnd::Neither,
            };
            let place = CellPlace {
                low: at(position),
                high: at(position + width),
                end,
            };
            observer.ask()?;
            found.cells += 1;
            let verdict = judge(&place, &function(&place));
            let is_last = width == 1 || found.cells >= MOST_CELLS;
            match verdict {
                CellVerdict::Unknown if !is_last => {
                    width /= 2;
                    is_first_try = false;
                    continue;
                }
                CellVerdict::Clear => {}
                CellVerdict::Simple(x) => {
                    let guess = match end {
                        CellEnd::Neither => {
                            0.5 * ((place.low + place.high) + x * (place.high - place.low))
                        }
                        CellEnd::Low => place.low + x * (place.high - place.low),
                        CellEnd::High => place.high + x * (place.high - place.low),
                    };
                    found.simple.push(Enclosure {
                        low: place.low,
                        high: place.high,
                        guess,
                    });
                }
                CellVerdict::Unknown | CellVerdict::Rounding => {
                    extend(&mut found.undecided, &place);
                }
            }
            break;
        }
        if found.cells >= MOST_CELLS {
            extend(
                &mut found.undecided,
                &CellPlace {
                    low: at(position),
                    high,
                    end: CellEnd::Neither,
                },
            );
            return Ok(found);
        }
        position += width;
        step = if is_first_try { 2 * width } else { width };
    }
    Ok(found)
}

/// Adds a cell to the undecided stretches, joined to the last one where they touch.
fn extend(stretches: &mut Vec<Enclosure>, place: &CellPlace) {
    let start = match stretches.last() {
        Some(last) if last.high >= place.low => stretches.pop().map_or(place.low, |s| s.low),
        _ => place.low,
    };
    stretches.push(Enclosure {
        low: start,
        high: place.high,
        guess: 0.5 * (start + place.high),
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::orbit::two_instants::green::{TimeCell, turned};

    /// `cos(w t - shift) + offset` on (0, 10).
    fn search(w: f64, shift: f64, offset: f64) -> Isolated {
        let mut go_on = || std::ops::ControlFlow::Continue(());
        let mut observer = Observer::new(&mut go_on);
        isolate((0.0, 10.0), (false, false), &mut observer, |place| {
            let (origin, scale) = (
                0.5 * (place.low + place.high),
                0.5 * (place.high - place.low),
            );
            let cell = TimeCell {
                origin,
                scale,
                low: place.low,
                high: place.high,
            };
            let [cosine, _] = turned(&cell, w, [shift.cos(), shift.sin()]);
            let (one, f) = (TaylorModel::constant(1.0), cosine.series(1.0));
            let offset = TaylorModel::constant(offset);
            let series =
                TaylorModel::sum_of_products([(1.0, &one, &f), (1.0, &one, &offset)].into_iter());
            Sampled {
                series,
                floor: 1e-15,
            }
        })
        .expect("not interrupted")
    }

    #[test]
    fn every_zero_is_isolated_once() {
        for w in [0.3, 2.0, 17.0] {
            let found = search(w, 0.3, 0.1);
            let zeros: Vec<f64> = (-2..40)
                .flat_map(|k| {
                    [1.0, -1.0].map(|s| {
                        (s * (-0.1f64).acos() + 0.3 + std::f64::consts::TAU * f64::from(k)) / w
                    })
                })
                .filter(|t| (0.0..10.0).contains(t))
                .collect();
            assert_eq!(found.simple.len(), zeros.len(), "{w}");
            assert!(found.undecided.is_empty());
            for zero in zeros {
                assert!(found.simple.iter().any(|b| (b.guess - zero).abs() < 1e-4));
            }
        }
    }

    #[test]
    fn double_zeros_are_left_undecided_and_near_ones_are_told_apart() {
        let found = search(2.0, 0.3, 1.0);
        assert!(
            found.simple.is_empty() && found.undecided.len() == 3,
            "{found:?}"
        );
        assert!(found.undecided.iter().all(|b| b.high - b.low < 1e-5));
        assert_eq!(search(2.0, 0.3, 1.0 - 1e-10).simple.len(), 6);
        assert!(search(2.0, 0.3, 1.0 + 1e-10).simple.is_empty());
        assert!(search(2.0, 0.3, 1.0 + 1e-10).undecided.is_empty());
    }
}
