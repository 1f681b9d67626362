//! Equations (11) to (18): mode shapes, modal forces and damping, the motion between impacts.

use crate::library::shape_errors;
use crate::system::{Case, KIND_1};
use crate::{STEP, fails, holds};
use nalgebra::{Complex, Matrix2, Matrix4, Vector2, Vector4, matrix};

/// Natural frequency `w_j`, decay rate `eta_j`, damped frequency and modal force of one mode.
#[derive(Clone, Copy)]
pub struct Mode {
    pub natural: f64,
    pub eta: f64,
    pub damped: f64,
    pub force: f64,
}

impl Case {
    /// Equation (10), the higher frequency first.
    pub fn natural_frequencies(&self) -> [f64; 2] {
        let sum = 1.0 + self.mu;
        let root = (sum * sum - 4.0 * self.mu * (1.0 - self.xi())).sqrt();
        [1.0, -1.0].map(|sign| f64::midpoint(sum, sign * root).sqrt())
    }

    pub fn modes(&self) -> [Mode; 2] {
        let force = modal_force(&shapes(self), self.f10);
        [0, 1].map(|j| {
            let natural = self.natural_frequencies()[j];
            let eta = 0.5 * (self.mass_damping + self.stiffness_damping * natural * natural);
            Mode {
                natural,
                eta,
                damped: ((natural - eta) * (natural + eta)).sqrt(),
                force: force[j],
            }
        })
    }

    /// `(A_j, B_j)` with the phase: `y = A sin(w t) + B cos(w t)` is `Re(Y e^{i w t})`.
    pub fn steady_amplitudes(&self) -> [(f64, f64); 2] {
        self.modes().map(|mode| {
            let (a, b) = steady(&mode, self.w);
            let y = Complex::new(b, -a) * Complex::cis(self.phase);
            (-y.im, y.re)
        })
    }
}

/// Columns `(1, lower entry)`, normalised, from the square of each frequency.
fn shapes_from(case: &Case, lower: impl Fn(f64) -> f64) -> Matrix2<f64> {
    Matrix2::from_columns(
        &case
            .natural_frequencies()
            .map(|w| Vector2::new(1.0, lower(w * w)).normalize()),
    )
}

fn shapes_printed(case: &Case) -> Matrix2<f64> {
    shapes_from(case, |w2| 1.0 - w2)
}

pub fn shapes(case: &Case) -> Matrix2<f64> {
    shapes_from(case, |w2| (1.0 - w2) / case.xi())
}

/// Equation (11): the second row is `(1 - w_j^2)/xi`. Judge: the columns as eigenvectors of K, and `Phi^-1 K Phi`.
#[test]
fn equation_11_mode_shapes() {
    let k = KIND_1.stiffness();
    let squares = Vector2::from(KIND_1.natural_frequencies().map(|w| w * w));
    let residual = |phi: Matrix2<f64>| (k * phi - phi * Matrix2::from_diagonal(&squares)).amax();
    let coupling = |phi: Matrix2<f64>| {
        let decoupled = phi.try_inverse().expect("two shapes") * k * phi;
        decoupled.m12.abs().max(decoupled.m21.abs())
    };
    for measure in [&residual as &dyn Fn(Matrix2<f64>) -> f64, &coupling] {
        fails(measure(shapes_printed(&KIND_1)));
        holds(measure(shapes(&KIND_1)));
    }
    holds(shape_errors(&KIND_1));
    let modes = vibroimpact::modes(&KIND_1.linear_system()).expect("real");
    let [upper, lower] = KIND_1.natural_frequencies();
    holds((modes.natural_frequencies[1] - upper).abs());
    holds((modes.natural_frequencies[0] - lower).abs());
}

fn modal_force_printed(phi: &Matrix2<f64>, f10: f64) -> Vector2<f64> {
    phi.transpose() * Vector2::new(f10, 0.0)
}

/// `Phi^-1 (f10, 0)`.
pub fn modal_force(phi: &Matrix2<f64>, f10: f64) -> Vector2<f64> {
    Vector2::new(phi.m22, -phi.m21) * (f10 / phi.determinant())
}

/// Equation (13), forcing: `Phi^-1 P`. Judge: `Phi y'' + ... = P`, so `Phi F` is the force on the angles; and the modal
/// forces `Phi^T F` of the symmetric form with M-orthonormal shapes, brought to the paper's scaling.
#[test]
fn equation_13_modal_force() {
    let (case, phi) = (KIND_1, shapes(&KIND_1));
    let (mass, alpha) = (case.mass(), case.alpha());
    let residual = |force: Vector2<f64>| {
        let on_angles = (phi * force - Vector2::new(case.f10, 0.0)).amax();
        let symmetric = (0..2).map(|j| {
            let shape = phi.column(j).into_owned();
            shape.dot(&Vector2::new(case.f10, case.f10 * alpha)) / shape.dot(&(mass * shape))
                - force[j]
        });
        symmetric.fold(on_angles, |worst, error| worst.max(error.abs()))
    };
    fails(residual(modal_force_printed(&phi, case.f10)));
    holds(residual(modal_force(&phi, case.f10)));
    // The library's shapes are M-orthonormal: theirs is `Phi^T F`, in units of the length of a shape.
    let modes = vibroimpact::modes(&case.linear_system()).expect("real");
    for (j, scale) in case.shape_scales().into_iter().enumerate() {
        let shape = modes.shapes.column(1 - j).map(|z| z.re);
        let force = shape[0] * case.f10 + shape[1] * case.f10 * alpha;
        holds((force * scale - modal_force(&phi, case.f10)[j]).abs());
    }
}

/// Joint dampers in (7): the matrix of `k1` to `k4`, and the symmetric matrix that it is `M^-1` times.
fn joint_damping(case: &Case, p1: f64, p2: f64) -> (Matrix2<f64>, Matrix2<f64>) {
    let (m, mu, alpha) = (case.m, case.mu, case.alpha());
    let p3 = p2 * mu * mu / case.xi();
    let rows = Matrix2::new(
        p1 + p2 + alpha * p3,
        -p2 - alpha * p3,
        -mu * (p1 + p2) - p3,
        mu * p2 + p3,
    );
    (rows * (1.0 + m), Matrix2::new(p1 + p2, -p2, -p2, p2))
}

/// Equation (13), damping: joint dampers give real modes only at `p2 = m p1`, and never the printed `2 zeta w_j^2`.
/// Judge: `Phi^-1 C Phi`, and what `2 zeta K` would ask of the two dampers.
#[test]
fn equation_13_joint_dampers() {
    let (case, phi, zeta) = (KIND_1, shapes(&KIND_1), 0.05);
    let mass = case.mass();
    let modal =
        |p1, p2| phi.try_inverse().expect("two shapes") * joint_damping(&case, p1, p2).0 * phi;
    let (matrix, symmetric) = joint_damping(&case, 0.03, 0.02);
    holds((mass * matrix - symmetric).amax()); // k1 to k4 of (6) are right
    let coupled = modal(0.03, 0.02);
    fails(coupled.m12.abs().min(coupled.m21.abs()));
    let real = modal(0.03, 0.03 * case.m);
    holds(real.m12.abs().max(real.m21.abs()));
    for (p2, is_real) in [(0.02, false), (0.03 * case.m, true)] {
        let pendulum = vibroimpact::DoublePendulum::new(case.m, case.mu, (0.03, p2));
        let linear = pendulum.and_then(|p| p.linearise()).expect("valid");
        let (_, symmetric) = joint_damping(&case, 0.03, p2);
        for (i, entry) in linear.damping().to_dense().iter().enumerate() {
            holds((entry - symmetric[i]).abs());
        }
        let modes = vibroimpact::modes(&linear).expect("converges");
        assert_eq!(modes.is_proportional, is_real);
    }
    let [w1, w2] = case.natural_frequencies();
    fails((real.m11 / real.m22 - (w1 / w2).powi(2)).abs());
    // `2 zeta K` in the symmetric form: its coupling asks for p2 = 0, its last entry for p2 > 0.
    let wanted = mass * case.stiffness() * (2.0 * zeta);
    holds(wanted.m12.abs());
    fails(wanted.m22);
}

/// Free part of (14) for one mode, at a complex time.
fn displacement(mode: &Mode, [a, b]: [f64; 2], t: Complex<f64>) -> Complex<f64> {
    let turn = t * mode.damped;
    (-t * mode.eta).exp() * (turn.cos() * a + turn.sin() * b)
}

/// (15) with the bracket read so that the forced part keeps its factor: the decay stands on the cosine alone.
fn velocity_printed(mode: &Mode, [a, b]: [f64; 2], t: f64) -> f64 {
    let (sin, cos) = (mode.damped * t).sin_cos();
    (-mode.eta * t).exp() * (b * mode.damped - mode.eta * a) * cos
        - (a * mode.damped + mode.eta * b) * sin
}

fn velocity(mode: &Mode, [a, b]: [f64; 2], t: f64) -> f64 {
    let (sin, cos) = (mode.damped * t).sin_cos();
    (-mode.eta * t).exp()
        * ((b * mode.damped - mode.eta * a) * cos - (a * mode.damped + mode.eta * b) * sin)
}

/// Equation (15): the decay multiplies the cosine and the sine. Judge: the derivative of (14).
#[test]
fn equation_15_velocity() {
    let (mode, amplitudes, t) = (KIND_1.modes()[0], [0.4, -0.3], 1.7);
    let truth = displacement(&mode, amplitudes, Complex::new(t, STEP)).im / STEP;
    fails((velocity_printed(&mode, amplitudes, t) - truth).abs());
    holds((velocity(&mode, amplitudes, t) - truth).abs());
}

/// `(A_j, B_j)` of (17), (18).
fn steady_printed(mode: &Mode, w: f64) -> (f64, f64) {
    let (detuning, damping) = (mode.natural * mode.natural - w * w, 2.0 * mode.eta * w);
    let scale = mode.force / (detuning * detuning + damping * damping);
    (detuning * scale, -damping * scale)
}

pub fn steady(mode: &Mode, w: f64) -> (f64, f64) {
    let (detuning, damping) = (mode.natural * mode.natural - w * w, 2.0 * mode.eta * w);
    let scale = mode.force / (detuning * detuning + damping * damping);
    (damping * scale, detuning * scale)
}

/// Equations (17), (18): the printed amplitudes belong to `f sin(w t)`. Judge: the equation of motion of a mode.
#[test]
fn equations_17_18_steady_amplitudes() {
    let w = KIND_1.w;
    for mode in KIND_1.modes() {
        let residual = |(a, b): (f64, f64), t: f64, force: f64| {
            let (sin, cos) = (w * t).sin_cos();
            let (y, v) = (a * sin + b * cos, w * (a * cos - b * sin));
            (-w * w * y + 2.0 * mode.eta * v + mode.natural * mode.natural * y - mode.force * force)
                .abs()
        };
        for t in [0.0, 0.4, 1.0] {
            fails(residual(steady_printed(&mode, w), t, (w * t).cos()));
            holds(residual(steady(&mode, w), t, (w * t).cos()));
            holds(residual(steady_printed(&mode, w), t, (w * t).sin()));
        }
    }
    for phase in [0.0, 1.0] {
        let case = Case { phase, ..KIND_1 };
        let (_, ours) = case.paper_coefficients(&case.orbits(1)[0]);
        for ((sine, cosine), (a, b)) in ours.into_iter().zip(case.steady_amplitudes()) {
            holds((sine - a).abs().max((cosine - b).abs()));
        }
    }
}

/// Section 5, `A_2 = B_2 = 0`: the second mode is forced, by the printed (13) too. Judge: the dense response.
#[test]
fn section_5_second_mode_is_forced() {
    let phi = shapes(&KIND_1);
    let forces = [
        modal_force_printed(&phi, KIND_1.f10),
        modal_force(&phi, KIND_1.f10),
    ];
    for force in forces {
        fails(force[1].abs());
    }
    let seen = phi.map(Complex::from).try_inverse().expect("two shapes") * KIND_1.response();
    let (a, b) = KIND_1.steady_amplitudes()[1];
    holds((seen.y - Complex::new(b, -a)).norm());
    fails(a.abs().min(b.abs()));
}

/// C(t) of (16): states of the four free motions with `a1, a2, b1, b2` equal to one. `at` is the time that stands in
/// `g_dj`, `h_dj`: the paper writes them with `s_j`, `c_j`, which (25) gives the value at the end of the period.
fn free_motions(case: &Case, t: f64, at: f64) -> Matrix4<f64> {
    let (phi, modes) = (shapes(case), case.modes());
    Matrix4::from_columns(&[0, 1, 2, 3].map(|column| {
        let (mode, j) = (modes[column % 2], column % 2);
        let ((sin, cos), (s, c)) = ((mode.damped * t).sin_cos(), (mode.damped * at).sin_cos());
        let (y, v) = if column < 2 {
            (cos, -(mode.eta * c + mode.damped * s))
        } else {
            (sin, mode.damped * c - mode.eta * s)
        };
        let shape = phi.column(j) * (-mode.eta * t).exp();
        Vector4::new(shape[0] * y, shape[0] * v, shape[1] * y, shape[1] * v)
    }))
}

fn motions_at_zero_printed(case: &Case) -> Matrix4<f64> {
    let mut matrix = motions_at_zero(case);
    matrix[(3, 2)] = shapes(case).m21 * case.modes()[1].damped;
    matrix
}

pub fn motions_at_zero(case: &Case) -> Matrix4<f64> {
    let (p, [one, two]) = (shapes(case), case.modes());
    matrix![
        p.m11, p.m12, 0.0, 0.0;
        -one.eta * p.m11, -two.eta * p.m12, p.m11 * one.damped, p.m12 * two.damped;
        p.m21, p.m22, 0.0, 0.0;
        -one.eta * p.m21, -two.eta * p.m22, p.m21 * one.damped, p.m22 * two.damped
    ]
}

/// C(0) has `phi21 wd1` in its fourth row, and `s_j`, `c_j` in `g_dj`, `h_dj` of (16) stand for `s_dj`, `c_dj`.
/// Judge: the state matrix, `C(t) = e^{A t} C(0)`.
#[test]
fn equation_16_free_motions() {
    let (case, t) = (KIND_1, 0.7);
    let flow = (case.state_matrix() * t).exp();
    let residual = |start: Matrix4<f64>, at| (flow * start - free_motions(&case, t, at)).amax();
    fails(residual(motions_at_zero_printed(&case), t));
    fails(residual(motions_at_zero(&case), case.period()));
    holds(residual(motions_at_zero(&case), t));
}
