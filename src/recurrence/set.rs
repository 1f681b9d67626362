//! Whether two motions that do not repeat themselves run on one set, judged by the sets alone: among the neighbours of a state, those
//! that the other motion has left there are held against those that its own has left at other times. On one set both are as many; on
//! two, the other's are none, once states lie closer than the sets do.
//!
//! Source: N. Henze, Ann. Stat. 16 (1988) 772 (coincidences of nearest neighbours of two samples).

use crate::recurrence::measure::Measure;
use crate::tolerance::{NEAREST_NEIGHBOURS, QUERIED_STATES, SHARED_FEW, SHARED_MANY};
use nalgebra::DMatrix;

/// Whether two sets are one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sets {
    /// They are one.
    One,
    /// They are two.
    Apart,
    /// More states may tell.
    Unclear,
}

/// Whether two motions, their states one a row and in the order of time, run on one set.
pub(crate) fn compared(a: &DMatrix<f64>, b: &DMatrix<f64>, measure: &Measure) -> Sets {
    let shares = [shared(a, b, measure), shared(b, a, measure)];
    let (least, most) = (shares[0].min(shares[1]), shares[0].max(shares[1]));
    if least >= SHARED_MANY {
        Sets::One
    } else if most < SHARED_FEW {
        Sets::Apart
    } else {
        Sets::Unclear
    }
}

/// Whether a motion is in the last quarter of its states where it was in the first: what decays slowly is not, nor what has gone through a
/// part of its set alone.
pub(crate) fn comes_back(states: &DMatrix<f64>, measure: &Measure) -> bool {
    let quarter = states.nrows() / 4;
    let [early, late] =
        [0, states.nrows() - quarter].map(|first| states.rows(first, quarter).into_owned());
    compared(&early, &late, measure) == Sets::One
}

/// The part of the nearest neighbours of states of `a` that are of `b`, the others being of the half of `a` that the state is not in.
pub(crate) fn shared(a: &DMatrix<f64>, b: &DMatrix<f64>, measure: &Measure) -> f64 {
    let half = a.nrows().min(b.nrows()) / 2;
    let asked = QUERIED_STATES.min(2 * half);
    let mut of_other = 0;
    for k in 0..asked {
        let i = k * 2 * half / asked;
        // States of the same times of both, one by one, so that of equally near ones neither come first.
        let first = if i < half { half } else { 0 };
        let mut nearest = [(f64::INFINITY, false); NEAREST_NEIGHBOURS];
        for j in first..first + half {
            for (states, is_other) in [(a, false), (b, true)] {
                let away = measure.distance((a, i), (states, j));
                if away < nearest[NEAREST_NEIGHBOURS - 1].0 {
                    let place = nearest.partition_point(|one| one.0 <= away);
                    nearest[place..].rotate_right(1);
                    nearest[place] = (away, is_other);
                }
            }
        }
        of_other += nearest.iter().filter(|one| one.1).count();
    }
    of_other as f64 / (asked * NEAREST_NEIGHBOURS).max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn measure() -> Measure {
        Measure::new(&[0.0], 1.0)
    }

    /// A circle of some radius, gone round by a turn a step.
    fn circle(turn: f64, radius: f64, from: f64, count: usize) -> DMatrix<f64> {
        DMatrix::from_fn(count, 2, |k, j| {
            let angle = TAU * (from + turn * k as f64);
            radius * if j == 0 { angle.cos() } else { angle.sin() }
        })
    }

    /// The map of Henon, chaotic at 1.4.
    fn henon(a: f64, mut x: f64, mut y: f64, count: usize) -> DMatrix<f64> {
        let mut step = || {
            (x, y) = (1.0 - a * x * x + y, 0.3 * x);
            (x, y)
        };
        for _ in 0..1000 {
            step();
        }
        let states: Vec<(f64, f64)> = (0..count).map(|_| step()).collect();
        DMatrix::from_fn(
            count,
            2,
            |k, j| if j == 0 { states[k].0 } else { states[k].1 },
        )
    }

    #[test]
    fn motions_on_one_set_have_each_other_for_neighbours() {
        let own = measure();
        let golden = 0.618_033_988_749_895;
        for from in [0.237, 0.5] {
            let (a, b) = (
                circle(golden, 1.0, 0.0, 400),
                circle(golden, 1.0, from, 400),
            );
            assert_eq!(compared(&a, &b, &own), Sets::One);
            // A circle beside it is another as soon as it is farther than the states of one are from each other.
            assert_eq!(
                compared(&a, &circle(golden, 1.5, from, 400), &own),
                Sets::Apart
            );
        }
        let (a, b) = (henon(1.4, 0.1, 0.1, 1000), henon(1.4, -0.2, 0.05, 1000));
        assert_eq!(compared(&a, &b, &own), Sets::One);
        let part = shared(&a, &b, &own);
        assert!((part - 0.5).abs() < 0.05, "{part}");
        // The same states twice: of equally near ones as many are either's.
        assert!((shared(&a, &a, &own) - 0.5).abs() < 0.2);
    }

    #[test]
    fn slow_decay_does_not_come_back() {
        let own = measure();
        assert!(comes_back(&circle(0.381_966, 1.0, 0.0, 1000), &own));
        assert!(comes_back(&henon(1.4, 0.1, 0.1, 1000), &own));
        for rate in [1e-7, 1e-5, 1e-3] {
            let creep = DMatrix::from_fn(1000, 2, |k, j| {
                (-rate * k as f64).exp() * if j == 0 { 1.0 } else { -rate }
            });
            assert!(!comes_back(&creep, &own));
            let by_turns = DMatrix::from_fn(1000, 2, |k, j| creep[(k, j)] * [1.0, -1.0][k % 2]);
            assert!(!comes_back(&by_turns, &own));
        }
    }
}
