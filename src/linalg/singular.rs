//! Singular values by Hestenes' one-sided rotations: `A V = W` with orthogonal columns, whose lengths they are. Of matrices of
//! less than full rank, which contacts in one plane make every day, iterations on a bidiagonal form can lose whole digits.

use crate::error::{Error, Result};
use crate::observer::unless_broken_off;
use crate::tolerance::ORTHOGONAL_COLUMNS;
use nalgebra::{DMatrix, DVector};

/// Rounds of rotations allowed; some ten are enough. [work]
const MOST_ROTATION_ROUNDS: usize = 60;
/// Number of columns from which a round of rotations takes so long that it is asked in it whether to go on. [work]
const LARGE_DECOMPOSITION: usize = 64;
/// Least binary exponent of a scale whose inverse is a number. [exact]
const LEAST_EXPONENT: f64 = -1000.0;

/// The failure of equations that doubles do not hold; its residual is infinite.
pub(crate) const fn overflow() -> Error {
    Error::NoConvergence {
        stage: "a linear system whose entries overflow",
        iterations: 0,
        residual: f64::INFINITY,
    }
}

/// `A = sum values_k left_k right_k^T`, in no order.
#[derive(Debug, Clone)]
pub(crate) struct Singular {
    /// `A V`, over the scale: left vectors times their values.
    images: DMatrix<f64>,
    right: DMatrix<f64>,
    /// Lengths of the images.
    lengths: DVector<f64>,
    scale: f64,
}

impl Singular {
    /// Of any matrix of finite numbers; V is square.
    pub fn new(a: &DMatrix<f64>) -> Result<Self> {
        let n = a.ncols();
        let largest = a.amax();
        if !a.iter().all(|x| x.is_finite()) {
            return Err(overflow());
        }
        let scale = if largest > 0.0 {
            largest.log2().floor().max(LEAST_EXPONENT).exp2()
        } else {
            1.0
        };
        let (mut images, mut right) = (a / scale, DMatrix::identity(n, n));
        let least = f64::EPSILON * images.norm();
        for _ in 0..MOST_ROTATION_ROUNDS {
            let mut is_done = true;
            for i in 0..n {
                if n >= LARGE_DECOMPOSITION {
                    unless_broken_off()?;
                }
                for j in i + 1..n {
                    if let Some(turn) = turn(&images, [i, j], least) {
                        rotate(&mut images, [i, j], turn);
                        rotate(&mut right, [i, j], turn);
                        is_done = false;
                    }
                }
            }
            if is_done {
                let lengths = DVector::from_iterator(n, images.column_iter().map(|w| w.norm()));
                return Ok(Self {
                    images,
                    right,
                    lengths,
                    scale,
                });
            }
        }
        Err(Error::NoConvergence {
            stage: "the singular value decomposition",
            iterations: MOST_ROTATION_ROUNDS,
            residual: f64::NAN,
        })
    }

    /// A singular value.
    pub fn value(&self, k: usize) -> f64 {
        self.scale * self.lengths[k]
    }

    /// The right vector of a value.
    pub fn right(&self, k: usize) -> DVector<f64> {
        self.right.column(k).into_owned()
    }

    /// The left vector of a value, over the value.
    pub fn left_over_value(&self, k: usize) -> DVector<f64> {
        let length = self.lengths[k];
        self.images.column(k) / length / length / self.scale
    }

    /// The part of a solution for a right-hand side along the right vector of a value.
    pub fn part(&self, k: usize, b: &DVector<f64>) -> f64 {
        self.left_over_value(k).dot(b)
    }
}

/// Cosine and sine that make two columns orthogonal; `None` where they are, or the shorter one is nothing but rounding.
fn turn(images: &DMatrix<f64>, [i, j]: [usize; 2], least: f64) -> Option<[f64; 2]> {
    let (a, b) = (images.column(i), images.column(j));
    let (p, q, r) = (a.norm_squared(), b.norm_squared(), a.dot(&b));
    let is_nothing = p.min(q) <= least * least;
    let rounding = ORTHOGONAL_COLUMNS * a.len() as f64 * f64::EPSILON;
    if is_nothing || r.abs() <= rounding * p.sqrt() * q.sqrt() {
        return None;
    }
    let zeta = (q - p) / (2.0 * r);
    let tangent = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
    let cosine = 1.0 / tangent.hypot(1.0);
    Some([cosine, cosine * tangent])
}

fn rotate(m: &mut DMatrix<f64>, [i, j]: [usize; 2], [cosine, sine]: [f64; 2]) {
    let (mut a, mut b) = m.columns_range_pair_mut(i, j);
    for (a, b) in a.iter_mut().zip(b.iter_mut()) {
        (*a, *b) = (cosine * *a - sine * *b, sine * *a + cosine * *b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::seeded::config;
    use proptest::prelude::*;

    fn recomposed(found: &Singular) -> DMatrix<f64> {
        &found.images * found.scale * found.right.transpose()
    }

    #[test]
    fn matrices_that_rounding_keeps_from_orthogonal_columns_converge() {
        let (a, b, c) = (
            1.216_438_317_939_055_2,
            0.379_677_638_926_343_93,
            1.234_389_248_160_796_8,
        );
        let found =
            Singular::new(&DMatrix::from_row_slice(2, 2, &[a, b, b, c])).expect("converges");
        let (mean, way) = (0.5 * (a + c), (0.5 * (a - c)).hypot(b));
        let mut values = [found.value(0), found.value(1)];
        values.sort_by(f64::total_cmp);
        assert!((values[0] - mean + way).abs() < 1e-15 && (values[1] - mean - way).abs() < 1e-15);
        // Others like it, and larger ones.
        let mut seed = 1u64;
        let mut next = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 11) as f64 / (1u64 << 53) as f64
        };
        for k in 0..20_000 {
            let n = 2 + k % 4;
            let half = DMatrix::from_fn(n, n, |_, _| next());
            let matrix = &half + half.transpose();
            assert!(Singular::new(&matrix).is_ok(), "{matrix}");
        }
    }

    proptest! {
        #![proptest_config(config())]

        /// Products of a tall and a wide matrix, of round numbers or not.
        #[test]
        fn a_matrix_of_any_rank_is_what_it_is_composed_of(
            rows in 1..8_usize, columns in 1..8_usize, rank in 1..4_usize, is_round in any::<bool>(),
            numbers in proptest::collection::vec(-1.0..1.0_f64, 48), exponent in -250..250_i32,
        ) {
            let number = |k: usize| if is_round { (3.0 * numbers[k]).round() } else { numbers[k] };
            let tall = DMatrix::from_fn(rows, rank, |i, j| number(3 * i + j));
            let wide = DMatrix::from_fn(rank, columns, |i, j| number(24 + 8 * i + j));
            let a = tall * wide * 10f64.powi(exponent);
            let found = Singular::new(&a).expect("converges");
            prop_assert!((recomposed(&found) - &a).amax() <= 1e-14 * a.amax());
            let turned = found.right.tr_mul(&found.right);
            prop_assert!((turned - DMatrix::identity(columns, columns)).amax() < 1e-14);
            let least = 1e-13 * a.amax();
            let seen = (0..columns).filter(|&k| found.value(k) > least).count();
            prop_assert!(seen <= rank);
        }
    }

    #[test]
    fn values_of_a_triangle_are_known() {
        // A^T A = [25 20; 20 25].
        let found = Singular::new(&DMatrix::from_row_slice(2, 2, &[3.0, 0.0, 4.0, 5.0]));
        let found = found.expect("converges");
        let mut values = [found.value(0), found.value(1)];
        values.sort_by(f64::total_cmp);
        assert!((values[0] - 5f64.sqrt()).abs() < 1e-15);
        assert!((values[1] - 45f64.sqrt()).abs() < 2e-15);
    }

    #[test]
    fn what_overflows_is_an_error() {
        assert!(Singular::new(&DMatrix::from_element(2, 2, f64::NAN)).is_err());
        assert!(Singular::new(&DMatrix::zeros(2, 2)).is_ok());
    }
}
