//! Every zero of an analytic function on an interval, part by part, each decided by bounds (theory 5): a part has no zero, or the function is
//! monotone in it, or the part is halved, down to a smallest width.

use crate::error::Result;
use crate::observer::Observer;
use crate::orbit::two_instants::green::TimeInterval;
use crate::orbit::two_instants::taylor_model::TaylorModel;

/// The interval over its smallest part. [work]
const FINEST_DIVISION: u64 = 1 << 26;
/// Parts of the interval after which the search gives up. [work]
const MOST_INTERVALS: usize = 400_000;

/// The Taylor model of a function over a part of the interval, and the size of its rounding there.
pub(crate) struct IntervalModel {
    pub series: TaylorModel,
    pub floor: f64,
}

impl IntervalModel {
    /// That of a part over which nothing is known of the function.
    pub fn unknown() -> Self {
        Self {
            series: TaylorModel::constant(f64::NAN),
            floor: 0.0,
        }
    }
}

/// A part of the interval in which a zero lies, or may lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Enclosure {
    pub low: f64,
    pub high: f64,
    /// Where the polynomial has its zero.
    pub guess: f64,
}

/// The outcome of the search.
#[derive(Debug, Clone, Default)]
pub(crate) struct Isolated {
    /// Parts in which the function is monotone and has one zero.
    pub simple: Vec<Enclosure>,
    /// Stretches of smallest parts, or of parts where all is rounding, of which nothing was proved.
    pub undecided: Vec<Enclosure>,
    /// Number of parts.
    pub cells: usize,
}

impl Isolated {
    /// The outcome of searches of two intervals.
    pub fn joined(mut self, other: Self) -> Self {
        self.simple.extend(other.simple);
        self.undecided.extend(other.undecided);
        self.cells += other.cells;
        self
    }
}

/// A part of the interval: both ends, and which of them, if one, is an end of the interval about which the Taylor model is expanded.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SearchInterval {
    pub low: f64,
    pub high: f64,
    pub end: IntervalEnd,
}

impl SearchInterval {
    /// The part with the place about which the model is expanded.
    pub fn time_interval(&self) -> TimeInterval {
        let (low, high) = (self.low, self.high);
        let (origin, scale) = match self.end {
            IntervalEnd::Neither => (0.5 * (low + high), 0.5 * (high - low)),
            IntervalEnd::Low => (low, high - low),
            IntervalEnd::High => (high, high - low),
        };
        TimeInterval {
            origin,
            scale,
            low,
            high,
        }
    }
}

/// The end of the interval that a part touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum IntervalEnd {
    Neither,
    Low,
    High,
}

enum IntervalVerdict {
    Clear,
    Simple(f64),
    Unknown,
    Rounding,
}

fn judge(place: &SearchInterval, sampled: &IntervalModel) -> IntervalVerdict {
    let IntervalModel { series, floor } = sampled;
    if series.is_clear_of_zero(*floor) {
        return IntervalVerdict::Clear;
    }
    if series.bound() <= *floor {
        return IntervalVerdict::Rounding;
    }
    if !series.is_monotone() {
        return IntervalVerdict::Unknown;
    }
    let (first, last) = match place.end {
        IntervalEnd::Neither => (-1.0, 1.0),
        IntervalEnd::Low => (0.0, 1.0),
        IntervalEnd::High => (-1.0, 0.0),
    };
    let slack = series.remainder() + floor;
    let (a, b) = (series.value(first), series.value(last));
    if a.min(b) > slack || a.max(b) < -slack {
        return IntervalVerdict::Clear;
    }
    // A zero within the slack of an end may be the neighbour's, or nobody's.
    if a.abs().min(b.abs()) <= slack {
        return IntervalVerdict::Unknown;
    }
    IntervalVerdict::Simple(series.newton(0.5 * (first + last)).clamp(first, last))
}

/// Searches `low..high`; Taylor models are expanded about the ends that `deflated` names, where known zeros are divided out.
///
/// # Errors
/// `Error::Interrupted` from the observer.
pub(crate) fn isolate(
    (low, high): (f64, f64),
    deflated: (bool, bool),
    observer: &mut Observer,
    mut function: impl FnMut(&SearchInterval) -> IntervalModel,
) -> Result<Isolated> {
    let mut found = Isolated::default();
    let at = |i: u64| {
        if i == FINEST_DIVISION {
            high
        } else {
            low + (high - low) * (i as f64 / FINEST_DIVISION as f64)
        }
    };
    let (mut position, mut step) = (0, FINEST_DIVISION / 16);
    while position < FINEST_DIVISION {
        let mut width = step.min(FINEST_DIVISION - position);
        let mut is_first_try = true;
        loop {
            let end = match (position, position + width) {
                (0, _) if deflated.0 => IntervalEnd::Low,
                (_, FINEST_DIVISION) if deflated.1 => IntervalEnd::High,
                _ => IntervalEnd::Neither,
            };
            let place = SearchInterval {
                low: at(position),
                high: at(position + width),
                end,
            };
            observer.ask()?;
            found.cells += 1;
            let verdict = judge(&place, &function(&place));
            let is_last = width == 1 || found.cells >= MOST_INTERVALS;
            match verdict {
                IntervalVerdict::Unknown if !is_last => {
                    width /= 2;
                    is_first_try = false;
                    continue;
                }
                IntervalVerdict::Clear => {}
                IntervalVerdict::Simple(x) => {
                    let guess = match end {
                        IntervalEnd::Neither => {
                            0.5 * ((place.low + place.high) + x * (place.high - place.low))
                        }
                        IntervalEnd::Low => place.low + x * (place.high - place.low),
                        IntervalEnd::High => place.high + x * (place.high - place.low),
                    };
                    found.simple.push(Enclosure {
                        low: place.low,
                        high: place.high,
                        guess,
                    });
                }
                IntervalVerdict::Unknown | IntervalVerdict::Rounding => {
                    extend(&mut found.undecided, &place);
                }
            }
            break;
        }
        if found.cells >= MOST_INTERVALS {
            extend(
                &mut found.undecided,
                &SearchInterval {
                    low: at(position),
                    high,
                    end: IntervalEnd::Neither,
                },
            );
            return Ok(found);
        }
        position += width;
        step = if is_first_try { 2 * width } else { width };
    }
    Ok(found)
}

/// Adds a part to the undecided stretches, joined to the last one where they touch.
fn extend(stretches: &mut Vec<Enclosure>, place: &SearchInterval) {
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
    use crate::orbit::two_instants::green::turned;

    /// `cos(w t - shift) + offset` on (0, 10).
    fn search(w: f64, shift: f64, offset: f64) -> Isolated {
        let mut observer = Observer::default();
        isolate((0.0, 10.0), (false, false), &mut observer, |place| {
            let (origin, scale) = (
                0.5 * (place.low + place.high),
                0.5 * (place.high - place.low),
            );
            let cell = TimeInterval {
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
            IntervalModel {
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
