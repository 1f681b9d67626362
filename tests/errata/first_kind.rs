//! Equations (30) to (37): the closed form of the first kind, and when it has one solution.

use crate::motion::{Mode, motions_at_zero, shapes};
use crate::system::{Case, KIND_1};
use crate::{HOLDS, fails, holds};
use nalgebra::{Matrix2, Matrix4, Vector4, matrix};
use vibroimpact::{Verdict, first_kind_coefficients, recovery_matrix};

/// The letters of (30): `k_j, m_j, n_j, p_j` and `u_i`.
#[derive(Clone, Copy)]
pub struct Terms {
    pub k: [f64; 2],
    pub m: [f64; 2],
    pub n: [f64; 2],
    pub p: [f64; 2],
    pub u: [f64; 2],
}

/// Equation (30) with the sign before `(1 - gamma) e_j`.
fn terms_with(case: &Case, sign: f64) -> Terms {
    let (phi, [one, two]) = (shapes(case), case.steady_amplitudes());
    let each = |letter: fn(Mode, f64, f64, f64) -> f64| {
        case.modes().map(|mode| {
            let (s, c) = (mode.damped * case.period()).sin_cos();
            let decay = (-mode.eta * case.period()).exp();
            letter(mode, sign * case.e, decay * s, decay * c)
        })
    };
    Terms {
        k: each(|_, _, _, c| 1.0 - c),
        m: each(|_, _, s, _| s),
        n: each(|mode, e, s, c| mode.eta + e * (mode.eta * c + mode.damped * s)),
        p: each(|mode, e, s, c| mode.damped + e * (mode.damped * c - mode.eta * s)),
        u: [0, 1].map(|i| -case.w * (1.0 + case.e) * (phi[(i, 0)] * one.0 + phi[(i, 1)] * two.0)),
    }
}

fn terms_printed(case: &Case) -> Terms {
    terms_with(case, -1.0)
}

pub fn terms(case: &Case) -> Terms {
    terms_with(case, 1.0)
}

/// Matrix of (31) for the unknowns `a1, a2, b1, b2`.
fn matrix_31(phi: &Matrix2<f64>, x: &Terms) -> Matrix4<f64> {
    Matrix4::from_fn(|row, column| {
        let j = column % 2;
        let entry = match (row % 2, column < 2) {
            (0, true) => x.k[j],
            (0, false) => -x.m[j],
            (_, true) => -x.n[j],
            (_, false) => x.p[j],
        };
        phi[(row / 2, j)] * entry
    })
}

/// Equation (30): plus signs in `n_j`, `p_j`. Judge: (29) with the dense flow, `(I - R1 e^{A T}) C(0)` and `(R1 - I) s(0)`.
#[test]
fn equation_30_terms() {
    let phi = shapes(&KIND_1);
    let (matrix, right) = KIND_1.dense(&KIND_1.recovery(1));
    let truth = matrix * motions_at_zero(&KIND_1);
    fails((matrix_31(&phi, &terms_printed(&KIND_1)) - truth).amax());
    holds((matrix_31(&phi, &terms(&KIND_1)) - truth).amax());
    let scene = KIND_1.scene();
    for kind in [1, 2, 3] {
        let ours = recovery_matrix(&scene, Case::stops(kind))
            .expect("valid")
            .diagonal();
        let ours = Vector4::new(ours[0], ours[2], ours[1], ours[3]);
        holds((ours - KIND_1.recovery(kind)).amax());
    }
    let [u1, u2] = terms(&KIND_1).u;
    holds((Vector4::new(0.0, u1, 0.0, u2) - right).amax());
}

/// `k_j p_j - m_j n_j`, the determinant of mode j.
pub fn determinants(x: &Terms) -> [f64; 2] {
    [0, 1].map(|j| x.k[j] * x.p[j] - x.m[j] * x.n[j])
}

/// The transformation P before (33), with what differs: the two `n` of its last row and that row's divisor.
fn transformation_with(
    phi: &Matrix2<f64>,
    x: &Terms,
    last_n: [f64; 2],
    last_divisor: f64,
) -> Matrix4<f64> {
    let [d1, d2] = determinants(x).map(|d| d * phi.determinant());
    let rows = [(phi.m22, -phi.m12), (-phi.m21, phi.m11)];
    let row = |j: usize, [left, right]: [f64; 2], middle: f64, divisor: f64| {
        let (upper, lower) = rows[j];
        Vector4::new(upper * left, upper * middle, lower * right, lower * middle).transpose()
            / divisor
    };
    Matrix4::from_rows(&[
        row(0, [x.p[0]; 2], x.m[0], d1),
        row(1, [x.p[1]; 2], x.m[1], d2),
        row(0, [x.n[0]; 2], x.k[0], d1),
        row(1, last_n, x.k[1], last_divisor),
    ])
}

fn transformation_printed(phi: &Matrix2<f64>, x: &Terms) -> Matrix4<f64> {
    transformation_with(phi, x, x.n, determinants(x)[0] * phi.determinant())
}

fn transformation(phi: &Matrix2<f64>, x: &Terms) -> Matrix4<f64> {
    transformation_with(phi, x, [x.n[1]; 2], determinants(x)[1] * phi.determinant())
}

/// `(a1, a2, b1, b2)` of (33), (34), (35), with the entry that multiplies `u1` for the second mode and the `k` of `b2`.
fn coefficients_with(phi: &Matrix2<f64>, x: &Terms, entry: f64, k: f64) -> Vector4<f64> {
    let [d1, d2] = determinants(x).map(|d| d * phi.determinant());
    let first = (phi.m22 * x.u[0] - phi.m12 * x.u[1]) / d1;
    let second = (phi.m11 * x.u[1] - entry * x.u[0]) / d2;
    Vector4::new(x.m[0] * first, x.m[1] * second, x.k[0] * first, k * second)
}

fn coefficients_printed(phi: &Matrix2<f64>, x: &Terms) -> Vector4<f64> {
    coefficients_with(phi, x, phi.m12, x.k[0])
}

fn coefficients(phi: &Matrix2<f64>, x: &Terms) -> Vector4<f64> {
    coefficients_with(phi, x, phi.m21, x.k[1])
}

/// The same with each mode by itself: `a_j = -(1+e) w A_j m_j/D_j`, `b_j = -(1+e) w A_j k_j/D_j`.
fn coefficients_by_mode(case: &Case) -> Vector4<f64> {
    let (x, steady) = (terms(case), case.steady_amplitudes());
    let jump = [0, 1].map(|j| -(1.0 + case.e) * case.w * steady[j].0 / determinants(&x)[j]);
    Vector4::new(
        x.m[0] * jump[0],
        x.m[1] * jump[1],
        x.k[0] * jump[0],
        x.k[1] * jump[1],
    )
}

/// P before (33): the last row has `n2` in its first entry and is divided by `P2`. Judge: it must invert (31).
#[test]
fn equation_33_transformation() {
    let (phi, x) = (shapes(&KIND_1), terms(&KIND_1));
    let residual = |p: Matrix4<f64>| (p * matrix_31(&phi, &x) - Matrix4::identity()).amax();
    fails(residual(transformation_printed(&phi, &x)));
    holds(residual(transformation(&phi, &x)));
}

/// Equations (33) to (35): `a2`, `b2` have `phi21 u1`, `b2` has `k2`. With any phase. Judge: the dense solution.
#[test]
fn equations_33_34_35_coefficients() {
    for phase in [0.0, 1.0, 4.0] {
        let case = Case { phase, ..KIND_1 };
        let (phi, x, start) = (shapes(&case), terms(&case), motions_at_zero(&case));
        let z = case.orbit(&case.recovery(1)).0;
        fails((start * coefficients_printed(&phi, &x) - z).amax());
        holds((start * coefficients(&phi, &x) - z).amax());
        holds((start * coefficients_by_mode(&case) - z).amax());
        let (ours, _) = case.paper_coefficients(&case.orbits(1)[0]);
        holds((ours - coefficients(&phi, &x)).amax());
        for (j, mode) in case.modes().into_iter().enumerate() {
            let sine = case.steady_amplitudes()[j].0;
            let n = case.n as usize;
            let (a, b) = first_kind_coefficients(mode.eta, mode.damped, sine, case.w, case.e, n);
            let wanted = coefficients(&phi, &x);
            holds((a - wanted[j]).abs().max((b - wanted[2 + j]).abs()));
        }
    }
}

pub fn has_one_solution_printed(x: &Terms) -> bool {
    x.k.iter()
        .chain(&determinants(x))
        .all(|value| value.abs() > HOLDS)
}

fn has_one_solution(x: &Terms) -> bool {
    determinants(x).iter().all(|value| value.abs() > HOLDS)
}

/// Condition (32) restricts nothing when both modes are damped: `k_j > 0` and `k_j p_j - m_j n_j > 0`, whatever the
/// period and the restitution. Judge: the smallest values over many cases.
#[test]
fn equation_32_holds_with_damping() {
    for (step, e) in (1..400).flat_map(|step| [0.0, 0.5, 1.0].map(|e| (step, e))) {
        for zeta in [1e-6, 0.01, 0.1, 0.4] {
            let (w, stiffness_damping) = (0.02 * f64::from(step), 2.0 * zeta);
            let x = terms(&Case {
                w,
                e,
                stiffness_damping,
                n: 1,
                ..KIND_1
            });
            assert!(
                x.k.iter()
                    .chain(&determinants(&x))
                    .all(|&value| value > 0.0)
            );
        }
    }
}

/// Condition (32) without damping fails only at `wd_j T = 2 pi N`. There `a_j` is free, at every phase: the remark after
/// (36) allows for no solution too. Judge: the dense system.
#[test]
fn equation_32_without_damping() {
    let w = 3.0 * KIND_1.natural_frequencies()[1]; // wd_2 T = 2 pi
    let case = Case {
        w,
        stiffness_damping: 0.0,
        ..KIND_1
    };
    let (x, phi, (matrix, right)) = (terms(&case), shapes(&case), case.dense(&case.recovery(1)));
    holds(x.k[1].abs().max(x.m[1].abs()));
    assert!(!has_one_solution_printed(&x) && !has_one_solution(&x));
    let mut solution = coefficients(&phi, &x);
    solution[3] = (phi.m11 * x.u[1] - phi.m21 * x.u[0]) / (phi.determinant() * x.p[1]);
    for free in [-1.0, 0.0, 2.0] {
        solution[1] = free;
        holds((matrix * motions_at_zero(&case) * solution - right).amax());
    }
}

/// Condition (32): `k_j /= 0` is not needed. Light negative damping makes `k_1` zero. Judge: the dense solution.
#[test]
fn equation_32_k_may_vanish() {
    let at = |stiffness_damping| Case {
        stiffness_damping,
        ..KIND_1
    };
    let (mut low, mut high) = (-6e-4, 0.0); // k_1 changes its sign in between
    for _ in 0..80 {
        let middle = f64::midpoint(low, high);
        let end = if terms(&at(middle)).k[0] < 0.0 {
            &mut low
        } else {
            &mut high
        };
        *end = middle;
    }
    let case = at(high);
    let (x, phi) = (terms(&case), shapes(&case));
    holds(x.k[0].abs());
    assert!(!has_one_solution_printed(&x) && has_one_solution(&x));
    let (matrix, right) = case.dense(&case.recovery(1));
    fails(matrix.singular_values().min());
    holds((matrix * motions_at_zero(&case) * coefficients(&phi, &x) - right).amax());
    assert_eq!(case.orbits(1).verdict(), Verdict::Found);
}

/// The left side of (37), with the letter in the third column of its second row.
fn matrix_37_with(phi: &Matrix2<f64>, x: &Terms, letter: f64) -> Matrix4<f64> {
    let [r1, r2] = [0, 1].map(|j| x.m[j] / x.k[j]);
    let last = x.p[1] - r2 * x.n[1];
    matrix![
        phi.m11 * x.k[0], phi.m12 * x.k[1], -phi.m11 * x.m[0], -phi.m12 * x.m[1];
        0.0, 0.0, phi.m11 * (x.p[0] - r1 * letter), phi.m12 * last;
        0.0, 1.0, 0.0, -r2;
        0.0, 0.0, 0.0, last
    ]
}

fn matrix_37_printed(phi: &Matrix2<f64>, x: &Terms) -> Matrix4<f64> {
    matrix_37_with(phi, x, x.n[1])
}

fn matrix_37(phi: &Matrix2<f64>, x: &Terms) -> Matrix4<f64> {
    matrix_37_with(phi, x, x.n[0])
}

/// Equation (37): `n1` in row 2, third column. Judge: the solution of the dense system must satisfy it.
#[test]
fn equation_37_reduced_rows() {
    let (n, stiffness_damping) = (1, 0.02); // in longer flights the first mode all but dies out
    let case = Case {
        n,
        stiffness_damping,
        ..KIND_1
    };
    let (phi, x) = (shapes(&case), terms(&case));
    let z = case.orbit(&case.recovery(1)).0;
    let solution = motions_at_zero(&case)
        .lu()
        .solve(&z)
        .expect("four independent motions");
    let mixed = (phi.m11 * x.u[1] - phi.m21 * x.u[0]) / phi.determinant();
    let right = Vector4::new(0.0, x.u[0], 0.0, mixed);
    fails((matrix_37_printed(&phi, &x) * solution - right).amax());
    holds((matrix_37(&phi, &x) * solution - right).amax());
}

fn has_a_solution_printed(phi: &Matrix2<f64>, x: &Terms) -> bool {
    (phi.m11 * x.u[1] - phi.m21 * x.u[0]).abs() < HOLDS && x.u[0].abs() < HOLDS
}

fn has_a_solution(phi: &Matrix2<f64>, x: &Terms) -> bool {
    (phi.m11 * x.u[1] - phi.m21 * x.u[0]).abs() < HOLDS
}

/// After (37): only `phi11 u2 - phi21 u1 /= 0` excludes a solution; with it zero `b_2` is free, for any `u1`. The case
/// is e = 1 with the second mode undamped, at phase 0 and at another phase. Judge: the dense system.
#[test]
fn equation_37_family() {
    let slow = KIND_1.natural_frequencies()[1];
    let mass_damping = -KIND_1.stiffness_damping * slow * slow;
    for (phase, solvable) in [(0.0, true), (1.0, false)] {
        let case = Case {
            e: 1.0,
            mass_damping,
            phase,
            ..KIND_1
        };
        let (phi, x, (matrix, right)) =
            (shapes(&case), terms(&case), case.dense(&case.recovery(1)));
        holds(determinants(&x)[1].abs());
        fails(determinants(&x)[0].abs().min(x.k[1]).min(x.u[0].abs()));
        assert!(has_a_solution(&phi, &x) == solvable && !has_a_solution_printed(&phi, &x));
        let nearest = matrix
            .svd(true, true)
            .solve(&right, 1e-10)
            .expect("both factors were asked for");
        let left_over = (matrix * nearest - right).amax();
        let verdict = if solvable {
            Verdict::Family
        } else {
            Verdict::None
        };
        assert_eq!(case.orbits(1).verdict(), verdict);
        if !solvable {
            fails(left_over);
            continue;
        }
        holds(left_over);
        let b1 = x.u[0] / (phi.m11 * (x.p[0] - x.m[0] / x.k[0] * x.n[0]));
        for b2 in [-1.0, 0.0, 2.0] {
            let member = Vector4::new(x.m[0] / x.k[0] * b1, x.m[1] / x.k[1] * b2, b1, b2);
            holds((matrix * motions_at_zero(&case) * member - right).amax());
        }
    }
}
