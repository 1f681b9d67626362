//! After how many periods of the forcing a motion repeats itself, from its states once in each.

use nalgebra::DMatrix;

/// States nearer to each other than this part of the motion are one.
const SAME: f64 = 1e-6;

/// A difference of angles the shorter way round.
pub(crate) fn shorter(off: f64, turn: f64) -> f64 {
    off - turn * (off / turn).round()
}

/// After how many strobes the states, one a row, repeat themselves: the smallest number up to a longest one for which all those after it
/// are those that many before, at least as many as it, at most twice as many and four, the last ones. Zero where there is none.
/// `frequency` makes velocities and positions alike; positions with a turn, not zero, are angles.
///
/// A slow convergence may look like a period before it is one.
pub(crate) fn repeats_after(
    q: &DMatrix<f64>,
    v: &DMatrix<f64>,
    turns: &[f64],
    frequency: f64,
    longest: usize,
) -> usize {
    let count = q.nrows();
    let within = |turn: f64, x: f64| if turn > 0.0 { shorter(x, turn) } else { x };
    let sizes = (0..q.ncols()).flat_map(|i| {
        q.column(i)
            .into_iter()
            .map(move |x| within(turns[i], *x).abs())
    });
    let size = sizes.fold(v.amax() / frequency, f64::max);
    let is_same = |i: usize, j: usize| {
        let off =
            (0..q.ncols()).all(|k| within(turns[k], q[(i, k)] - q[(j, k)]).abs() <= SAME * size);
        off && (v.row(i) - v.row(j)).amax() <= SAME * size * frequency
    };
    let repeats = |&period: &usize| {
        let compared = (2 * period + 4).min(count - period);
        (count - compared..count).all(|k| is_same(k, k - period))
    };
    (1..=longest.min(count / 2)).find(repeats).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(count: usize, of: impl Fn(usize) -> f64) -> [DMatrix<f64>; 2] {
        [1.0, -3.0].map(|scale| DMatrix::from_fn(count, 1, |k, _| scale * of(k)))
    }

    fn period(count: usize, of: impl Fn(usize) -> f64) -> usize {
        let [q, v] = rows(count, of);
        repeats_after(&q, &v, &[0.0], 3.0, 32)
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
}
