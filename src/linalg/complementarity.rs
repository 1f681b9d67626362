//! Small linear complementarity problems: `0 <= x perp w = M x + q >= 0`, each `x_i w_i = 0`, scaled, solved on an active set;
//! of several solutions the one of least norm.

use crate::linalg::active_set::{Complementarity, ComplementarySolution};
use crate::linalg::rank;
use crate::tolerance::{COMPLEMENTARITY_ROUNDINGS, DEPENDENT_ACTIVE};
use nalgebra::{DMatrix, DVector};

/// Solves `0 <= x perp w = M x + q >= 0` where `q_i` is known up to `slack_i`: `w_i` that near zero is zero, and where the
/// problem has no solution, that of `q + slack` is taken: it has one if any within the slack has.
///
/// `None` where no solution was found: with up to 12 unknowns none exists (where w misses zero by less than 1e-7 of its terms),
/// with more Lemke's method ended on a ray, which proves the same for a positive semidefinite M. Nor is there one where numbers
/// are not finite, or overflow. A positive semidefinite M has one w whatever x; of many x (dependent columns) the one of least
/// norm is taken. Another M may have several w: the first found is taken, sets of low indices before others.
///
/// # References
/// Cottle, Pang, Stone, The Linear Complementarity Problem (1992): theorem 3.1.7 for uniqueness, 4.4 for Lemke's method.
pub(crate) fn solve(m: &DMatrix<f64>, q: &[f64], slack: &[f64]) -> Option<ComplementarySolution> {
    if let (&[m], &[q], &[slack]) = (m.as_slice(), q, slack)
        && m > 0.0
    {
        return solve_one(m, q, slack);
    }
    let scales: Vec<f64> = m.diagonal().iter().map(|&d| scale(d)).collect();
    let scaled = |values: &[f64]| values.iter().zip(&scales).map(|(v, s)| v * s).collect();
    let problem = Complementarity {
        m: DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| {
            m[(i, j)] * scales[i] * scales[j]
        }),
        q: scaled(q),
        slack: scaled(slack),
    };
    let mut entries = problem.m.iter().chain(&problem.q).chain(&problem.slack);
    if !entries.all(|value| value.is_finite()) {
        return None;
    }
    let found = problem.solve().or_else(|| problem.relaxed().solve())?;
    let solution = least_norm(&problem, &scales, &found).unwrap_or(found);
    Some(ComplementarySolution {
        x: DVector::from_fn(q.len(), |i, _| solution.x[i] * scales[i]),
        w: DVector::from_fn(q.len(), |i, _| solution.w[i] / scales[i]),
    })
}

/// The same of one unknown, with a positive m.
fn solve_one(m: f64, q: f64, slack: f64) -> Option<ComplementarySolution> {
    let nothing = slack + COMPLEMENTARITY_ROUNDINGS[0] * q.abs();
    let (x, w) = if q < -nothing {
        (-q / m, 0.0)
    } else {
        (0.0, if q > nothing { q } else { 0.0 })
    };
    let known = [m, q, slack, x].iter().all(|value| value.is_finite());
    let alone = |value: f64| DVector::from_element(1, value);
    known.then(|| ComplementarySolution {
        x: alone(x),
        w: alone(w),
    })
}

/// The power of two nearest `1/sqrt(diagonal)`: rows and columns times it have diagonals of order one, to the same bits.
fn scale(diagonal: f64) -> f64 {
    if diagonal > 0.0 {
        2.0_f64.powi((-0.5 * diagonal.log2()).round() as i32)
    } else {
        1.0
    }
}

/// Of the x that share the w of a solution, the one of least norm; `None` where it is the only one.
///
/// The unknowns with `w_i = 0` may change along the null space of their part of M: `min |x_0 + Z c|`, `x_0 + Z c >= 0`,
/// with orthonormal columns Z and `x_0` across them. Its multipliers solve the complementarity problem of the projector
/// `Z Z^T` and `x_0`, whose w is the x sought.
fn least_norm(
    problem: &Complementarity,
    scales: &[f64],
    found: &ComplementarySolution,
) -> Option<ComplementarySolution> {
    let tight: Vec<usize> = (0..found.w.len()).filter(|&i| found.w[i] == 0.0).collect();
    let active = found.x.iter().filter(|&&x| x > 0.0).count();
    if active == 0 || active == tight.len() {
        return None;
    }
    let part = problem.m.select_rows(&tight).select_columns(&tight);
    let tolerance = DEPENDENT_ACTIVE * part.amax();
    let mut null = rank::solve(&part, &DVector::zeros(tight.len()), tolerance)
        .ok()?
        .null_space;
    if null.ncols() == 0 {
        return None;
    }
    let mut x = DVector::zeros(tight.len());
    for (place, &i) in tight.iter().enumerate() {
        // The norm is that of the unknowns as they were given, before scaling.
        null.row_mut(place).scale_mut(scales[i]);
        x[place] = found.x[i] * scales[i];
    }
    let null = null.qr().q();
    let across = &x - &null * null.tr_mul(&x);
    let least = Complementarity {
        m: &null * null.transpose(),
        q: across.as_slice().to_vec(),
        slack: vec![COMPLEMENTARITY_ROUNDINGS[0] * x.amax(); x.len()],
    }
    .solve()?
    .w;
    let mut x = DVector::zeros(found.x.len());
    for (place, &i) in tight.iter().enumerate() {
        x[i] = least[place] / scales[i];
    }
    // Any other M may have its w changed by it.
    let w = &problem.m * &x + DVector::from_column_slice(&problem.q);
    let size = problem.m.abs() * &x;
    let is_same = (0..x.len()).all(|i| {
        let terms = size[i] + problem.q[i].abs();
        (w[i] - found.w[i]).abs() <= problem.slack[i] + COMPLEMENTARITY_ROUNDINGS[1] * terms
    });
    is_same.then(|| ComplementarySolution {
        x,
        w: found.w.clone(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::active_set::Work;
    use crate::linalg::lemke;
    use crate::linalg::seeded::config;
    use crate::tolerance::LEMKE_PIVOTS;
    use nalgebra::{dmatrix, dvector};
    use proptest::prelude::*;

    fn no_slack(k: usize) -> Vec<f64> {
        vec![0.0; k]
    }

    /// An exact fraction in lowest terms, its denominator positive.
    #[derive(Debug, Clone, Copy, PartialEq)]
    struct Fraction(i128, i128);

    impl Fraction {
        fn new(top: i128, bottom: i128) -> Self {
            let (mut a, mut b) = (top.abs(), bottom.abs());
            while b != 0 {
                (a, b) = (b, a % b);
            }
            let unit = a.max(1) * bottom.signum();
            Self(top / unit, bottom / unit)
        }

        fn minus(self, factor: Self, other: Self) -> Self {
            let bottom = factor.1 * other.1;
            Self::new(
                self.0 * bottom - factor.0 * other.0 * self.1,
                self.1 * bottom,
            )
        }

        fn over(self, other: Self) -> Self {
            Self::new(self.0 * other.1, self.1 * other.0)
        }

        fn value(self) -> f64 {
            self.0 as f64 / self.1 as f64
        }
    }

    /// The exact solution of a regular system, by Gauss and Jordan.
    fn exact_solve(mut rows: Vec<Vec<Fraction>>) -> Option<Vec<Fraction>> {
        let n = rows.len();
        for k in 0..n {
            let pivot = (k..n).find(|&i| rows[i][k].0 != 0)?;
            rows.swap(k, pivot);
            let unit = rows[k][k];
            rows[k].iter_mut().for_each(|x| *x = x.over(unit));
            let pivot_row = rows[k].clone();
            for (i, row) in rows.iter_mut().enumerate() {
                let factor = row[k];
                if i != k {
                    row.iter_mut()
                        .zip(&pivot_row)
                        .for_each(|(x, &p)| *x = x.minus(factor, p));
                }
            }
        }
        Some(rows.iter().map(|row| row[n]).collect())
    }

    /// Every solution with a regular active set, exactly: the vertices of the set of all solutions.
    fn exact_vertices(m: &[Vec<i128>], q: &[i128]) -> Vec<(Vec<f64>, Vec<f64>)> {
        let k = q.len();
        let whole = |value: i128| Fraction(value, 1);
        let vertex = |mask: usize| {
            let set: Vec<usize> = (0..k).filter(|i| mask >> i & 1 == 1).collect();
            let row = |i: usize| -> Vec<Fraction> {
                let entries = set.iter().map(|&j| whole(m[i][j]));
                entries.chain([whole(-q[i])]).collect()
            };
            let found = exact_solve(set.iter().map(|&i| row(i)).collect())?;
            let mut x = vec![Fraction(0, 1); k];
            set.iter().zip(found).for_each(|(&i, value)| x[i] = value);
            let w: Vec<Fraction> = (0..k)
                .map(|i| (0..k).fold(whole(q[i]), |w, j| w.minus(whole(-m[i][j]), x[j])))
                .collect();
            let is_solution = x.iter().chain(&w).all(|value| value.0 >= 0);
            let values = |v: &[Fraction]| v.iter().map(|f| f.value()).collect();
            is_solution.then(|| (values(&x), values(&w)))
        };
        (0..1 << k).filter_map(vertex).collect()
    }

    /// `N^T N` of k small whole normals in n coordinates (many of them dependent), or a matrix that is not symmetric,
    /// `N^T (I + J) N` with J skew, and any whole q: with many ties.
    fn whole_problem(
        sizes: std::ops::Range<usize>,
        skew: bool,
    ) -> impl Strategy<Value = (Vec<Vec<i128>>, Vec<i128>)> {
        (sizes, 1..4_usize).prop_flat_map(move |(k, n)| {
            let normals = proptest::collection::vec(-2..3_i128, n * k);
            let q = proptest::collection::vec(-4..4_i128, k);
            (normals, q).prop_map(move |(normals, q)| {
                let row = |i: usize| -> Vec<i128> {
                    (0..k)
                        .map(|j| {
                            let (a, b) = (&normals[n * i..][..n], &normals[n * j..][..n]);
                            let dot: i128 = a.iter().zip(b).map(|(a, b)| a * b).sum();
                            let turn = a[0] * b[n - 1] - a[n - 1] * b[0];
                            dot + if skew { turn } else { 0 }
                        })
                        .collect()
                };
                ((0..k).map(row).collect(), q)
            })
        })
    }

    fn floats(m: &[Vec<i128>], q: &[i128]) -> (DMatrix<f64>, Vec<f64>) {
        let k = q.len();
        let matrix = DMatrix::from_fn(k, k, |i, j| m[i][j] as f64);
        (matrix, q.iter().map(|&q| q as f64).collect())
    }

    proptest! {
        #![proptest_config(config())]

        #[test]
        fn whole_problems_have_the_exact_answer(
            (m, q) in prop_oneof![whole_problem(1..6, false), whole_problem(1..6, true)]
        ) {
            let vertices = exact_vertices(&m, &q);
            let (matrix, right) = floats(&m, &q);
            let found = solve(&matrix, &right, &no_slack(q.len()));
            prop_assert_eq!(found.is_some(), !vertices.is_empty());
            if let Some(ComplementarySolution { x, w }) = found {
                prop_assert!(x.min() >= 0.0 && w.min() >= 0.0);
                for (vertex, exact_w) in vertices {
                    // Monotone: w is the same of all solutions.
                    prop_assert!((&w - DVector::from_vec(exact_w)).amax() < 1e-12);
                    // x is nearest to 0 among the convex combinations of the vertices.
                    let step = DVector::from_vec(vertex) - &x;
                    prop_assert!(x.dot(&step) > -1e-11 * (1.0 + x.norm_squared()), "{x} {step}");
                }
                let residual = &matrix * &x + DVector::from_vec(right) - &w;
                prop_assert!(residual.amax() < 1e-12 * (1.0 + x.amax()));
            }
        }

        #[test]
        fn lemke_finds_what_trying_every_set_finds((m, q) in whole_problem(4..9, false)) {
            let (m, q) = floats(&m, &q);
            let slack = no_slack(q.len());
            let problem = Complementarity { m, q, slack };
            let set = lemke::active_set(&problem.m, &problem.q, LEMKE_PIVOTS[0]);
            let by_path = problem.on(&set, COMPLEMENTARITY_ROUNDINGS[0], &mut Work::default());
            let by_trial = problem.try_every(&mut Work::default());
            prop_assert_eq!(by_path.is_some(), by_trial.is_some());
            if let (Some(path), Some(trial)) = (by_path, by_trial) {
                prop_assert!((path.w - trial.w).amax() < 1e-12);
            }
        }

        #[test]
        fn twenty_contacts_on_a_few_coordinates(
            normals in proptest::collection::vec(-1.0..1.0_f64, 20 * 12),
            n in 2..13_usize,
            push in proptest::collection::vec(-1.0..1.0_f64, 12),
        ) {
            let normals = DMatrix::from_column_slice(n, 20, &normals[..20 * n]);
            let m = normals.tr_mul(&normals);
            let q = -normals.tr_mul(&DVector::from_column_slice(&push[..n]));
            let slack = vec![1e-14; 20];
            let ComplementarySolution { x, w } = solve(&m, q.as_slice(), &slack).expect("q is in the range of M");
            prop_assert!(x.min() >= 0.0 && w.min() >= 0.0);
            prop_assert!((0..20).all(|i| x[i] == 0.0 || w[i] == 0.0));
            prop_assert!((&m * &x + q - w).amax() < 1e-11 * (1.0 + x.amax()));
        }

        #[test]
        fn nothing_panics(
            k in 0..6_usize,
            entries in proptest::collection::vec(prop_oneof![5 => -2.0..2.0, 2 => any::<f64>(), 1 => Just(0.0)], 46),
        ) {
            let m = DMatrix::from_column_slice(k, k, &entries[..k * k]);
            let slack: Vec<f64> = entries[40..40 + k].iter().map(|s: &f64| s.abs() * 1e-14).collect();
            if let Some(ComplementarySolution { x, w }) = solve(&m, &entries[30..30 + k], &slack) {
                prop_assert!((0..k).all(|i| x[i] >= 0.0 && w[i] >= 0.0 && (x[i] == 0.0 || w[i] == 0.0)));
            }
        }
    }

    #[test]
    fn equal_columns_share_and_unequal_demands_do_not() {
        let m = DMatrix::from_element(2, 2, 4.0);
        let found = solve(&m, &[-2.0, -2.0], &no_slack(2)).expect("solvable");
        assert!((found.x - dvector![0.25, 0.25]).amax() < 1e-15);
        let found = solve(&m, &[-2.0, -3.0], &no_slack(2)).expect("solvable");
        assert_eq!(
            (found.x, found.w),
            (dvector![0.0, 0.75], dvector![1.0, 0.0])
        );
    }

    #[test]
    fn the_share_is_of_least_norm_in_the_units_given() {
        // The second column is the first in units 3 times as large: min x1^2 + x2^2 with x1 + 3 x2 = 1.
        let m = dmatrix![1.0, 3.0; 3.0, 9.0];
        let found = solve(&m, &[-1.0, -3.0], &no_slack(2)).expect("solvable");
        assert!((found.x - dvector![0.1, 0.3]).amax() < 1e-15);
    }

    #[test]
    fn a_jam_has_no_solution_unless_it_is_one_by_rounding() {
        let jam = dmatrix![1.0, -1.0; -1.0, 1.0];
        assert_eq!(solve(&jam, &[-1.0, -1.0], &no_slack(2)), None);
        let tight = solve(&jam, &[-1.0, 1.0 - f64::EPSILON], &no_slack(2)).expect("rounding");
        assert!((tight.x - dvector![1.0, 0.0]).amax() < 1e-14);
        for k in [6, 20] {
            let m = DMatrix::from_fn(k, k, |i, j| {
                if i / 2 == j / 2 {
                    jam[(i % 2, j % 2)]
                } else {
                    0.0
                }
            });
            assert_eq!(solve(&m, &vec![-1.0; k], &no_slack(k)), None);
            let q: Vec<f64> = (0..k).map(|i| [-1.0, 1.0 - f64::EPSILON][i % 2]).collect();
            let found = solve(&m, &q, &no_slack(k)).expect("rounding");
            assert!((0..k).all(|i| (found.x[i] - [1.0, 0.0][i % 2]).abs() < 1e-14));
        }
    }

    #[test]
    fn nearly_dependent_columns_leave_no_gap() {
        // Whatever the angle between two normals, around the threshold too, w is zero or positive as of one or of two.
        for exponent in 1..17 {
            let c = 1.0 - 10.0_f64.powi(-exponent);
            for lead in [0.0, 1e-13, 1e-6] {
                let m = dmatrix![1.0, c; c, 1.0];
                let found = solve(&m, &[-1.0, -1.0 - lead], &no_slack(2)).expect("positive");
                assert!(found.x.min() >= 0.0 && found.w.min() >= 0.0);
                let residual = &m * &found.x + dvector![-1.0, -1.0 - lead] - &found.w;
                assert!(residual.amax() < 5e-12, "{exponent} {residual}");
            }
        }
    }

    #[test]
    fn a_wedge_may_be_as_narrow_as_it_likes() {
        // Walls with normals (1, 0) and (-cos a, sin a) meet v = (1, 1). M knows the angle a up to the rounding of a^2.
        for exponent in 0..16 {
            for lead in [1.0, 3.0] {
                let (sin, cos) = (lead * 10.0_f64.powi(-exponent)).sin_cos();
                let normals = dmatrix![1.0, -cos; 0.0, sin.abs()];
                let m = normals.tr_mul(&normals);
                let q = -normals.tr_mul(&dvector![1.0, 1.0]);
                for copies in [1, 3] {
                    let k = 2 * copies;
                    let m = DMatrix::from_fn(k, k, |i, j| m[(i % 2, j % 2)]);
                    let q: Vec<f64> = (0..k).map(|i| q[i % 2]).collect();
                    let ComplementarySolution { x, w } =
                        solve(&m, &q, &no_slack(k)).expect("definite");
                    assert!(x.min() >= 0.0 && w.min() >= 0.0);
                    let miss = (&m * &x + DVector::from_vec(q) - w).amax();
                    let allowed = if sin.abs() > 1e-6 { 1e-9 } else { 2e-7 };
                    assert!(miss <= allowed, "{exponent} {lead} {miss}");
                }
            }
        }
    }

    #[test]
    fn units_do_not_matter() {
        let m = dmatrix![2.0, -1.0, 0.5; -1.0, 3.0, 1.0; 0.5, 1.0, 1.0];
        let q = [-1.0, -2.0, 0.25];
        let plain = solve(&m, &q, &no_slack(3)).expect("positive definite");
        let units = dvector![2.0_f64.powi(400), 1.0, 2.0_f64.powi(-300)];
        let scaled = DMatrix::from_fn(3, 3, |i, j| m[(i, j)] * units[i] * units[j]);
        let right: Vec<f64> = (0..3).map(|i| q[i] * units[i]).collect();
        let found = solve(&scaled, &right, &no_slack(3)).expect("positive definite");
        assert_eq!(found.x.component_mul(&units), plain.x);
        assert_eq!(found.w.component_div(&units), plain.w);
    }

    #[test]
    fn slack_makes_ties() {
        let found = solve(&DMatrix::identity(2, 2), &[-1e-10, 1e-10], &[1e-9, 1e-9]);
        assert_eq!(
            found.map(|s| (s.x, s.w)),
            Some((DVector::zeros(2), DVector::zeros(2)))
        );
    }
}
