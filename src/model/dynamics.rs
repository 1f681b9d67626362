//! Equations of motion `q'' = a(t, q, v)` of a system under its forcing, as integrators ask for them (theory 2).

use crate::error::{Error, Result};
use crate::linalg::small;
use crate::model::excitation::Excitation;
use crate::model::input::{ByInput, Driven, Input, NoInput, Swing};
use crate::model::moment::Moment;
use crate::model::nonlinear::NonlinearSystem;
use crate::model::pendulum::{DoublePendulum, Links, PendulumChain};
use crate::model::system::System;
use crate::tolerance::CENTRAL_DIFFERENCE_STEP;
use nalgebra::{Complex, DMatrix, DVector};

/// The motion of a system under its forcing.
pub(crate) trait Dynamics {
    /// The drive: the part of the excitation that depends on time alone.
    type Drive: Copy;

    /// Number of degrees of freedom.
    fn n_dof(&self) -> usize;
    /// The drive at a moment.
    fn drive(&self, at: Moment) -> Self::Drive;
    /// The acceleration at a state under a given drive.
    fn driven(&self, drive: Self::Drive, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()>;
    /// The acceleration at a moment.
    fn acceleration(&self, at: Moment, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
        self.driven(self.drive(at), q, v, a)
    }
    /// The derivative of the acceleration by `(q, v)`, shape `(n, 2n)`, where it is known other than by differences.
    fn jacobian(&self, at: Moment, q: &[f64], v: &[f64]) -> Result<Option<DMatrix<f64>>> {
        let _ = (at, q, v);
        Ok(None)
    }
}

/// Eq. (3), the large motions of the double pendulum, in its symmetric form `M(q) q'' = f`.
#[derive(Debug, Clone)]
pub(crate) struct DoublePendulumMotion<I> {
    /// `xi/mu`
    alpha: f64,
    /// `alpha/mu`, the second entry of the mass matrix's diagonal.
    second: f64,
    /// `1/(1 + m)`
    gravity: f64,
    /// By rows, `None` without damping.
    damping: Option<[f64; 4]>,
    input: I,
}

impl<I: Input> DoublePendulumMotion<I> {
    /// The motion of a double pendulum on which something acts.
    pub fn new(system: &DoublePendulum, input: I) -> Self {
        let (m, mu) = (system.mass_ratio(), system.length_ratio());
        let alpha = m / (1.0 + m) / mu;
        let c = system.damping();
        let damping = [c[(0, 0)], c[(0, 1)], c[(1, 0)], c[(1, 1)]];
        Self {
            alpha,
            second: alpha / mu,
            gravity: 1.0 / (1.0 + m),
            damping: (damping != [0.0; 4]).then_some(damping),
            input,
        }
    }
}

impl DoublePendulumMotion<Option<Driven>> {
    /// The motion with its excitation as a type, so that a free one has no code for it.
    pub fn by_input(&self) -> ByInput<DoublePendulumMotion<NoInput>, DoublePendulumMotion<Driven>> {
        match self.input.clone() {
            None => ByInput::Free(self.under(NoInput)),
            Some(input) => ByInput::Driven(self.under(input)),
        }
    }

    fn under<I>(&self, input: I) -> DoublePendulumMotion<I> {
        DoublePendulumMotion {
            alpha: self.alpha,
            second: self.second,
            gravity: self.gravity,
            damping: self.damping,
            input,
        }
    }
}

impl<I: Input> Dynamics for DoublePendulumMotion<I> {
    type Drive = I::Push;

    fn n_dof(&self) -> usize {
        2
    }

    #[inline]
    fn drive(&self, at: Moment) -> I::Push {
        self.input.push(at)
    }

    #[allow(
        clippy::inline_always,
        reason = "four numbers that stay in registers where the caller's state is an array"
    )]
    #[inline(always)]
    fn driven(&self, push: I::Push, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
        let (q, v) = ([q[0], q[1]], [v[0], v[1]]);
        let ((s0, c0), (s1, c1)) = (q[0].sin_cos(), q[1].sin_cos());
        // sine and cosine of the difference of the angles
        let (sin, cos) = (s0 * c1 - c0 * s1, c0 * c1 + s0 * s1);
        let mut f = [
            -self.gravity * s0 - self.alpha * sin * v[1] * v[1],
            self.alpha * (sin * v[0] * v[0] - self.gravity * s1),
        ];
        if let Some(c) = &self.damping {
            f[0] = f[0] - c[0] * v[0] - c[1] * v[1];
            f[1] = f[1] - c[2] * v[0] - c[3] * v[1];
        }
        let levers = [c0, self.alpha * c1];
        self.input.add(push, |i| levers[i], &mut f);
        let coupling = self.alpha * cos;
        let det = self.second - coupling * coupling;
        a[0] = (self.second * f[0] - coupling * f[1]) / det;
        a[1] = (f[1] - coupling * f[0]) / det;
        Ok(())
    }
}

/// The chain of N links with large angles.
#[derive(Debug, Clone)]
pub(crate) struct ChainMotion {
    /// `l_i l_j S_max(i,j)`, by rows.
    inertia: Vec<f64>,
    /// `l_i S_i`
    static_moment: Vec<f64>,
    damping: Vec<f64>,
    gravity: f64,
    input: Option<Driven>,
}

impl ChainMotion {
    /// The motion of a chain on which something acts.
    pub fn new(system: &PendulumChain, excitation: &Excitation) -> Self {
        let links = system.links();
        let by_rows = |m: &DMatrix<f64>| m.transpose().as_slice().to_vec();
        Self {
            inertia: by_rows(&links.inertia),
            static_moment: links.static_moment.as_slice().to_vec(),
            damping: by_rows(&links.damping),
            gravity: links.gravity,
            input: Driven::new(excitation),
        }
    }
}

impl Dynamics for ChainMotion {
    type Drive = Option<Swing>;

    fn n_dof(&self) -> usize {
        self.static_moment.len()
    }

    fn drive(&self, at: Moment) -> Option<Swing> {
        self.input.push(at)
    }

    fn driven(&self, push: Option<Swing>, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
        let n = self.static_moment.len();
        let turns: Vec<(f64, f64)> = q.iter().map(|q| q.sin_cos()).collect();
        let mut mass = vec![0.0; n * n];
        for i in 0..n {
            let (si, ci) = turns[i];
            let mut f = -self.static_moment[i] * self.gravity * si;
            for j in 0..n {
                let (sj, cj) = turns[j];
                let inertia = self.inertia[i * n + j];
                mass[i * n + j] = inertia * (ci * cj + si * sj);
                f -= inertia * (si * cj - ci * sj) * v[j] * v[j] + self.damping[i * n + j] * v[j];
            }
            a[i] = f;
        }
        self.input
            .add(push, |i| self.static_moment[i] * turns[i].1, a);
        if small::solve_positive(&mut mass, a) {
            Ok(())
        } else {
            Err(singular_mass())
        }
    }
}

/// A mass matrix that cannot be factored.
pub(crate) fn singular_mass() -> Error {
    Error::NoConvergence {
        stage: "the solve with the mass matrix, which is not positive definite in double precision,",
        iterations: 0,
        residual: f64::NAN,
    }
}

/// Any equations of motion, with `M^-1` times the force added.
#[derive(Debug, Clone)]
pub(crate) struct NonlinearMotion {
    system: NonlinearSystem,
    force: Option<Driven>,
    /// Whether the force has been divided by the mass matrix, which is the same everywhere.
    is_over_mass: bool,
}

impl NonlinearMotion {
    /// The motion of a system on which something acts.
    pub fn new(system: &NonlinearSystem, excitation: &Excitation) -> Self {
        let mass = (excitation.acts())
            .then(|| system.constant_mass())
            .flatten();
        let over_mass = mass.and_then(|mass| over(&mass, excitation));
        Self {
            system: system.clone(),
            is_over_mass: over_mass.is_some(),
            force: Driven::new(over_mass.as_ref().unwrap_or(excitation)),
        }
    }
}

impl Dynamics for NonlinearMotion {
    /// The time, and what acts then.
    type Drive = (f64, Option<Swing>);

    fn n_dof(&self) -> usize {
        self.system.n_dof()
    }

    fn drive(&self, at: Moment) -> (f64, Option<Swing>) {
        (at.time, self.force.push(at))
    }

    fn driven(
        &self,
        (time, push): (f64, Option<Swing>),
        q: &[f64],
        v: &[f64],
        a: &mut [f64],
    ) -> Result<()> {
        self.system.acceleration(time, q, v, a)?;
        if self.is_over_mass {
            // There is no base to move: scenes of such systems are refused one.
            self.force.add(push, |_| 0.0, a);
            return Ok(());
        }
        for (a, f) in a.iter_mut().zip(self.forced(push, q)?) {
            *a += f;
        }
        Ok(())
    }

    /// As the system's equations give it, with that of `M(q)^-1` times the force.
    fn jacobian(&self, at: Moment, q: &[f64], v: &[f64]) -> Result<Option<DMatrix<f64>>> {
        let Some(mut jacobian) = self.system.given_jacobian(at.time, q, v)? else {
            return Ok(None);
        };
        if self.force.is_some() && !self.is_over_mass {
            let size = q.iter().fold(1.0f64, |m, x| m.max(x.abs()));
            let step = CENTRAL_DIFFERENCE_STEP * size;
            let push = self.force.push(at);
            let moved = |j: usize, step: f64| {
                let mut q = q.to_vec();
                q[j] += step;
                self.forced(push, &q)
            };
            for j in 0..q.len() {
                let (ahead, behind) = (moved(j, step)?, moved(j, -step)?);
                for (i, (a, b)) in ahead.into_iter().zip(behind).enumerate() {
                    jacobian[(i, j)] += (a - b) / (2.0 * step);
                }
            }
        }
        Ok(Some(jacobian))
    }
}

impl NonlinearMotion {
    /// `M(q)^-1` times the force, nothing without one.
    fn forced(&self, push: Option<Swing>, q: &[f64]) -> Result<Vec<f64>> {
        if self.force.is_none() {
            return Ok(Vec::new());
        }
        let mut f = vec![0.0; q.len()];
        self.force.add(push, |_| 0.0, &mut f);
        // The matrix is symmetric: its rows are its columns.
        if !small::solve_positive(self.system.mass(q)?.as_mut_slice(), &mut f) {
            return Err(singular_mass());
        }
        Ok(f)
    }
}

/// A constant mass matrix's inverse times all that acts; `None` where it is not positive definite in double precision.
fn over(mass: &DMatrix<f64>, excitation: &Excitation) -> Option<Excitation> {
    let solved = |x: DVector<f64>| {
        let mut x = x;
        small::solve_positive(mass.clone().as_mut_slice(), x.as_mut_slice()).then_some(x)
    };
    // A mass matrix that is positive takes every force.
    solved(DVector::zeros(mass.nrows()))?;
    let part = |x: DVector<f64>| solved(x).expect("a positive mass matrix");
    let harmonic = |force: &DVector<Complex<f64>>| {
        let (re, im) = (part(force.map(|z| z.re)), part(force.map(|z| z.im)));
        re.zip_map(&im, Complex::new)
    };
    Some(excitation.map(|load| part(load.clone()), harmonic))
}

/// The mass matrix of a system at a position.
///
/// # Errors
/// What a nonlinear system reports.
pub(crate) fn mass_at(system: &System, q: &DVector<f64>) -> Result<DMatrix<f64>> {
    let turned = |links: Links| {
        let mass = |i: usize, j: usize| links.inertia[(i, j)] * (q[i] - q[j]).cos();
        DMatrix::from_fn(q.len(), q.len(), mass)
    };
    Ok(match system {
        System::Linear(system) => system.mass().to_dense(),
        System::DoublePendulum(pendulum) => turned(pendulum.links()),
        System::PendulumChain(chain) => turned(chain.links()),
        System::Nonlinear(system) => system.mass(q.as_slice())?,
    })
}

/// Solves `M(q) x = b` in the place of b; false where the mass matrix is not positive definite in double precision.
///
/// # Errors
/// What a nonlinear system reports.
pub(crate) fn solve_mass_at(system: &System, q: &[f64], b: &mut [f64]) -> Result<bool> {
    Ok(match system {
        System::Linear(system) => {
            system.solve_mass_mut(b);
            true
        }
        System::DoublePendulum(pendulum) => {
            let [outer, coupling, inner] = pendulum.inertia();
            let turned = coupling * (q[0] - q[1]).cos();
            small::solve_positive(&mut [outer, turned, turned, inner], b)
        }
        // Symmetric: its rows are its columns.
        _ => {
            let mut mass = mass_at(system, &DVector::from_column_slice(q))?;
            small::solve_positive(mass.as_mut_slice(), b)
        }
    })
}
