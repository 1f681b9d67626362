//! System (7) and its dense solution by the matrix exponential, without modes: the judge of the other files.

use nalgebra::{Complex, Matrix2, Matrix4, Vector2, Vector4, matrix};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// System (7) with forcing `f10 cos(w t + phase)`, damping `C = mass_damping I + stiffness_damping K` (the paper's is
/// `2 zeta K`), restitution `e = 1 - gamma`, and one instant of impact in `n` forcing periods.
#[derive(Clone, Copy)]
pub struct Case {
    pub m: f64,
    pub mu: f64,
    pub f10: f64,
    pub w: f64,
    pub e: f64,
    pub n: u32,
    pub mass_damping: f64,
    pub stiffness_damping: f64,
    pub phase: f64,
}

/// The paper's three cases; damping and phase are not printed there.
pub const KIND_1: Case = Case {
    m: 3.0,
    mu: 3.24,
    f10: 0.162,
    w: 1.5,
    e: 0.9,
    n: 3,
    mass_damping: 0.0,
    stiffness_damping: 0.1,
    phase: 1.0,
};
pub const KIND_2: Case = Case {
    m: 1.0,
    f10: 0.22,
    n: 2,
    stiffness_damping: 0.02,
    phase: 0.3,
    ..KIND_1
};
pub const KIND_3: Case = Case {
    m: 1.0,
    mu: 3.2,
    f10: 0.1,
    n: 2,
    phase: 2.5,
    ..KIND_1
};

impl Case {
    pub fn xi(&self) -> f64 {
        self.m / (1.0 + self.m)
    }

    pub fn alpha(&self) -> f64 {
        self.xi() / self.mu
    }

    /// Mass matrix of the symmetric form: (5) with its lower row times `alpha / mu`.
    pub fn mass(&self) -> Matrix2<f64> {
        Matrix2::new(1.0, self.alpha(), self.alpha(), self.alpha() / self.mu)
    }

    pub fn period(&self) -> f64 {
        TAU * f64::from(self.n) / self.w
    }

    pub fn stiffness(&self) -> Matrix2<f64> {
        Matrix2::new(1.0, -self.xi(), -self.mu, self.mu)
    }

    pub fn damping(&self) -> Matrix2<f64> {
        Matrix2::identity() * self.mass_damping + self.stiffness() * self.stiffness_damping
    }

    /// State matrix of (7).
    pub fn state_matrix(&self) -> Matrix4<f64> {
        let (k, c) = (self.stiffness(), self.damping());
        matrix![
            0.0, 1.0, 0.0, 0.0;
            -k.m11, -c.m11, -k.m12, -c.m12;
            0.0, 0.0, 0.0, 1.0;
            -k.m21, -c.m21, -k.m22, -c.m22
        ]
    }

    /// Complex amplitude of the steady angles, from the dynamic stiffness, without modes.
    pub fn response(&self) -> Vector2<Complex<f64>> {
        let real = self.stiffness() - Matrix2::identity() * (self.w * self.w);
        let dynamic = real.zip_map(&(self.damping() * self.w), Complex::new);
        let force = Vector2::new(Complex::cis(self.phase) * self.f10, Complex::ZERO);
        dynamic.lu().solve(&force).expect("no resonance")
    }

    pub fn steady_state(&self, t: f64) -> Vector4<f64> {
        let turned = self.response() * Complex::cis(self.w * t);
        let (x, y) = (turned.x, turned.y);
        Vector4::new(x.re, -self.w * x.im, y.re, -self.w * y.im)
    }

    /// The dense system of an orbit, `(I - R e^{A T}) z = (R - I) s(0)`, with the diagonal of R.
    pub fn dense(&self, recovery: &Vector4<f64>) -> (Matrix4<f64>, Vector4<f64>) {
        let (r, one) = (Matrix4::from_diagonal(recovery), Matrix4::identity());
        (
            one - r * (self.state_matrix() * self.period()).exp(),
            (r - one) * self.steady_state(0.0),
        )
    }

    /// `z` and the state just after the impact.
    pub fn orbit(&self, recovery: &Vector4<f64>) -> (Vector4<f64>, Vector4<f64>) {
        let (matrix, right) = self.dense(recovery);
        let z = matrix.lu().solve(&right).expect("a regular case");
        (z, z + self.steady_state(0.0))
    }

    /// Diagonal of R1, R2 or R3, equation (23) and Note 2.
    pub fn recovery(&self, kind: u8) -> Vector4<f64> {
        let upper = if kind == 3 { 1.0 } else { -self.e };
        let lower = if kind == 2 { 1.0 } else { -self.e };
        Vector4::new(1.0, upper, 1.0, lower)
    }

    /// The mirror image: forcing half a turn on.
    pub fn turned(&self) -> Self {
        let phase = self.phase + PI;
        Self { phase, ..*self }
    }

    /// This case with the phase at which kind 1 has equal contact positions and the upper pendulum goes back.
    pub fn with_equal_contacts(&self) -> Self {
        let mismatch = |phase| {
            let case = Self { phase, ..*self };
            let x = case.orbit(&case.recovery(1)).1;
            x[0] - x[2]
        };
        let phase = (-mismatch(0.0)).atan2(mismatch(FRAC_PI_2)); // linear in cos(phase), sin(phase)
        let case = Self { phase, ..*self };
        if case.orbit(&case.recovery(1)).1[1] < 0.0 {
            case
        } else {
            case.turned()
        }
    }

    /// Smallest gap to the wall of kind 1 on a grid of the inside of the period: the wall is where the contact is.
    pub fn lowest_gap(&self) -> f64 {
        const SAMPLES: u32 = 2000;
        let step = self.period() / f64::from(SAMPLES);
        let flow = (self.state_matrix() * step).exp();
        let (mut z, start) = self.orbit(&self.recovery(1));
        (1..SAMPLES).fold(f64::INFINITY, |lowest, k| {
            z = flow * z;
            let x = z + self.steady_state(f64::from(k) * step);
            lowest.min(start[0] - x[0]).min(start[2] - x[2])
        })
    }
}
