//! The period of a motion from its states once in each period of the forcing, and the advance of a motion that repeats itself but for a
//! constant shift of its positions.

use crate::error::digits;
use crate::recurrence::measure::Measure;
use crate::tolerance::{RECURRENCE_ROUNDING, SAME_STATE};
use nalgebra::{DMatrix, DVector};

/// After how many strobes a motion repeats itself, by its states, one a row: the smallest number m up to a longest one for which the last
/// `2m + 4` states, or as many as there are behind the first m, are each the state m strobes before. Zero where there is none.
///
/// A slow convergence may look like a period before it is one.
pub(crate) fn repeats_after(states: &DMatrix<f64>, measure: &Measure, longest: usize) -> usize {
    let count = states.nrows();
    let within = SAME_STATE * measure.size(states);
    let repeats = |&period: &usize| {
        let compared = compared(period, count);
        (count - compared..count)
            .all(|k| measure.distance((states, k), (states, k - period)) <= within)
    };
    (1..=longest.min(count / 2)).find(repeats).unwrap_or(0)
}

/// How many of the last states are held against those a period before.
fn compared(period: usize, count: usize) -> usize {
    (2 * period + 4).min(count - period)
}

/// The least number of its states after which a cycle, the last of which is followed by the first, repeats itself.
pub(crate) fn least_period(cycle: &DMatrix<f64>, measure: &Measure) -> usize {
    let m = cycle.nrows();
    let within = SAME_STATE * measure.size(cycle);
    let is_round = |late: &usize| {
        m.is_multiple_of(*late)
            && (0..m).all(|k| measure.distance((cycle, k), (cycle, (k + late) % m)) <= within)
    };
    (1..m).find(is_round).unwrap_or(m)
}

/// Whether two cycles are one, whichever of its states each begins with, and however often it goes round.
pub(crate) fn are_one_cycle(a: &DMatrix<f64>, b: &DMatrix<f64>, measure: &Measure) -> bool {
    let m = least_period(a, measure);
    if least_period(b, measure) != m {
        return false;
    }
    let within = SAME_STATE * measure.size(a).max(measure.size(b));
    let is_near = |k: usize, late: usize| measure.distance((a, k), (b, (k + late) % m)) <= within;
    (0..m).any(|late| (0..m).all(|k| is_near(k, late)))
}

/// The drift of a motion that repeats itself but for a constant change of its positions.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Advance {
    /// Periods of the forcing after which it repeats itself, the advance taken off.
    pub n_periods: usize,
    /// The change of its positions in that time, shape `(n_dof,)`, [m].
    pub by: DVector<f64>,
}

impl Advance {
    /// The drift in words.
    pub fn told(&self) -> String {
        let each: Vec<String> = self.by.iter().map(|x| digits(*x)).collect();
        let by = each.join(", ");
        match self.n_periods {
            1 => {
                format!("it drifts: in each period of the forcing its position advances by ({by})")
            }
            m => format!(
                "it drifts: in each {m} periods of the forcing its position advances by ({by})"
            ),
        }
    }
}

/// The advance of a motion: the smallest number of strobes, up to a longest one, after which all states, as many as
/// [`repeats_after`] asks for, are on by the same positions, which are not none, nor angles alone: these come back.
pub(crate) fn advance(states: &DMatrix<f64>, measure: &Measure, longest: usize) -> Option<Advance> {
    let count = states.nrows();
    let n = states.ncols() / 2;
    let of = |k: usize, period: usize| {
        DVector::from_fn(2 * n, |j, _| {
            measure.part(j, states[(k, j)] - states[(k - period, j)])
        })
    };
    // Positions far away are known to their rounding alone.
    let rounding = RECURRENCE_ROUNDING * states.columns(0, n).amax();
    let speed = measure.size(&velocities_alone(states));
    let found = |period: usize| {
        let by = of(count - 1, period).rows(0, n).into_owned();
        let size = by.amax().max(speed);
        let far = (0..n)
            .filter(|&k| !measure.is_angle(k))
            .map(|k| by[k].abs());
        let far = far.fold(0.0, f64::max);
        if !(far > SAME_STATE * size && far > rounding / SAME_STATE) {
            return None;
        }
        let within = SAME_STATE * by.amax() + rounding;
        let is_same = |k: usize| {
            let off = of(k, period);
            (off.rows(0, n) - &by).amax() <= within && off.rows(n, n).amax() <= SAME_STATE * size
        };
        let all = (count - compared(period, count)..count).all(is_same);
        all.then_some(Advance {
            n_periods: period,
            by,
        })
    };
    (1..=longest.min(count / 2)).find_map(found)
}

/// The states without their positions.
fn velocities_alone(states: &DMatrix<f64>) -> DMatrix<f64> {
    let mut own = states.clone();
    own.columns_mut(0, states.ncols() / 2).fill(0.0);
    own
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(count: usize, of: impl Fn(usize) -> f64) -> DMatrix<f64> {
        DMatrix::from_fn(count, 2, |k, j| [1.0, -3.0][j] * of(k))
    }

    fn measure() -> Measure {
        Measure::new(&[0.0], 3.0)
    }

    fn period(count: usize, of: impl Fn(usize) -> f64) -> usize {
        repeats_after(&rows(count, of), &measure(), 32)
    }

    #[test]
    fn the_smallest_period_is_found() {
        for m in 1..=25 {
            assert_eq!(period(50, |k| ((k % m) as f64).cos()), m);
        }
        // Two that differ by little are two.
        assert_eq!(period(50, |k| 1.0 + 1e-5 * (k % 2) as f64), 2);
        assert_eq!(period(50, |k| 1.0 + 1e-8 * (k % 2) as f64), 1);
        // After a transient that ends in time.
        assert_eq!(
            period(50, |k| if k < 20 { k as f64 } else { (k % 3) as f64 }),
            3
        );
    }

    #[test]
    fn what_does_not_repeat_has_none() {
        assert_eq!(period(50, |k| (k as f64).sin()), 0);
        assert_eq!(period(50, |k| ((k % 26) as f64).cos()), 0);
        assert_eq!(period(1, |_| 1.0), 0);
        assert_eq!(period(0, |_| 1.0), 0);
        assert_eq!(period(50, |_| 0.0), 1);
        assert_eq!(period(50, |_| f64::NAN), 0);
    }

    #[test]
    fn a_cycle_is_the_same_from_each_of_its_states_and_however_often_it_goes_round() {
        let of = |m: usize, count: usize, late: usize, off: f64| {
            rows(count, |k| (((k + late) % m) as f64).cos() + off)
        };
        for m in 1..=8 {
            for rounds in 1..=4 {
                let long = of(m, m * rounds, rounds, 0.0);
                assert_eq!(least_period(&long, &measure()), m);
                assert!(are_one_cycle(&of(m, m, 0, 0.0), &long, &measure()));
                assert!(are_one_cycle(&long, &of(m, m, 0, 1e-8), &measure()));
                assert!(!are_one_cycle(&long, &of(m, m, 0, 1e-4), &measure()));
                assert!(!are_one_cycle(&long, &of(m + 1, m + 1, 0, 0.0), &measure()));
            }
        }
    }

    #[test]
    fn a_constant_advance_is_a_drift_and_nothing_else_is() {
        let drift = |of: &dyn Fn(f64) -> (f64, f64)| {
            let states = DMatrix::from_fn(60, 2, |k, j| {
                let (q, v) = of(k as f64);
                if j == 0 { q } else { v }
            });
            advance(&states, &measure(), 8)
        };
        let third = |k: f64| (k.rem_euclid(3.0) - 1.0).powi(2);
        let found = drift(&|k| (5.0 - 0.25 * k, 1.0)).expect("a drift");
        assert_eq!((found.n_periods, found.by[0]), (1, -0.25));
        let found = drift(&|k| (0.5 * k + third(k), third(k))).expect("a drift");
        assert!(found.n_periods == 3 && (found.by[0] - 1.5).abs() < 1e-14);
        assert_eq!(drift(&|k| (third(k), third(k))), None);
        // What decays slowly, is thrown, or swings, does not drift.
        assert_eq!(
            drift(&|k| ((-1e-4 * k).exp(), 1e-4 * (-1e-4 * k).exp())),
            None
        );
        assert_eq!(drift(&|k| (k * k, 2.0 * k)), None);
        assert_eq!(
            drift(&|k| ((0.01 * k).sin(), 0.01 * (0.01 * k).cos())),
            None
        );
        assert_eq!(drift(&|k| (f64::NAN, k)), None);
        // Nor does an angle, however far it turns.
        let turning = DMatrix::from_fn(60, 2, |k, j| if j == 0 { 0.3 * k as f64 } else { 1.0 });
        assert_eq!(advance(&turning, &Measure::new(&[7.0], 3.0), 8), None);
    }
}
