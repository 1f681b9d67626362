//! Equations of motion `q'' = a(t, q, v)` of a system under its forcing, as integrators ask for them (theory 2).

use crate::error::{Error, Result};
use crate::linalg::small;
use crate::model::linear_motion::{Diagonals, Full, LinearMotion};
use crate::model::{DoublePendulum, Forcing, Links, NonlinearSystem, PendulumChain, Scene, System};
use nalgebra::{Cholesky, Complex, DMatrix, DVector, Dyn};

/// A time, and the forcing angle `frequency t + phase` there, which keeps its digits at any time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moment {
    pub time: f64,
    pub angle: f64,
}

/// The motion of a system under its forcing.
pub(crate) trait Dynamics {
    /// Number of degrees of freedom.
    fn n_dof(&self) -> usize;
    /// The acceleration.
    fn acceleration(&self, at: Moment, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()>;
}

/// Motion of the base `A cos(angle)`: what enters the equations is `A w^2 cos(angle)`, its acceleration towards the
/// pendulum; zero at rest.
#[derive(Debug, Clone, Copy, Default)]
struct Base {
    acceleration: f64,
}

impl Base {
    fn new(forcing: &Forcing) -> Self {
        match forcing {
            Forcing::BaseMotion(base) => Self {
                acceleration: base.amplitude() * base.frequency().powi(2),
            },
            Forcing::Harmonic(_) | Forcing::Unforced => Self::default(),
        }
    }

    #[inline]
    fn at(self, moment: Moment) -> f64 {
        if self.acceleration == 0.0 {
            0.0
        } else {
            self.acceleration * moment.angle.cos()
        }
    }
}

/// A generalised force `Re(f e^{i angle})`, if there is one.
#[derive(Debug, Clone, Default)]
pub(super) struct Force(pub(super) Option<DVector<Complex<f64>>>);

impl Force {
    fn new(forcing: &Forcing) -> Self {
        match forcing {
            Forcing::Harmonic(force) => Self(Some(force.amplitude().clone())),
            Forcing::BaseMotion(_) | Forcing::Unforced => Self(None),
        }
    }

    /// Adds the force to `f`.
    #[inline]
    pub(super) fn add(&self, moment: Moment, f: &mut [f64]) {
        let Some(amplitude) = &self.0 else { return };
        let (sin, cos) = moment.angle.sin_cos();
        for (f, a) in f.iter_mut().zip(amplitude.as_slice()) {
            *f += a.re * cos - a.im * sin;
        }
    }
}

/// Eq. (3), the large motions of the double pendulum, in its symmetric form `M(q) q'' = f`.
#[derive(Debug, Clone)]
pub(crate) struct DoublePendulumMotion {
    /// `xi/mu`
    alpha: f64,
    /// `alpha/mu`, the second entry of the mass matrix's diagonal.
    second: f64,
    /// `1/(1 + m)`
    gravity: f64,
    /// By rows, `None` without damping.
    damping: Option<[f64; 4]>,
    base: Base,
    force: Force,
}

impl DoublePendulumMotion {
    /// The motion of a double pendulum under a forcing.
    pub fn new(system: &DoublePendulum, forcing: &Forcing) -> Self {
        let (m, mu) = (system.mass_ratio(), system.length_ratio());
        let alpha = m / (1.0 + m) / mu;
        let c = system.damping();
        let damping = [c[(0, 0)], c[(0, 1)], c[(1, 0)], c[(1, 1)]];
        Self {
            alpha,
            second: alpha / mu,
            gravity: 1.0 / (1.0 + m),
            damping: (damping != [0.0; 4]).then_some(damping),
            base: Base::new(forcing),
            force: Force::new(forcing),
        }
    }
}

impl Dynamics for DoublePendulumMotion {
    fn n_dof(&self) -> usize {
        2
    }

    #[allow(
        clippy::inline_always,
        reason = "four numbers that stay in registers where the caller's state is an array"
    )]
    #[inline(always)]
    fn acceleration(&self, at: Moment, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
        let (q, v) = ([q[0], q[1]], [v[0], v[1]]);
        let ((s0, c0), (s1, c1)) = (q[0].sin_cos(), q[1].sin_cos());
        // sine and cosine of the difference of the angles
        let (sin, cos) = (s0 * c1 - c0 * s1, c0 * c1 + s0 * s1);
        let base = self.base.at(at);
        let mut f = [
            base * c0 - self.gravity * s0 - self.alpha * sin * v[1] * v[1],
            self.alpha * (base * c1 - self.gravity * s1 + sin * v[0] * v[0]),
        ];
        if let Some(c) = &self.damping {
            f[0] = f[0] - c[0] * v[0] - c[1] * v[1];
            f[1] = f[1] - c[2] * v[0] - c[3] * v[1];
        }
        self.force.add(at, &mut f);
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
    hanging: Vec<f64>,
    damping: Vec<f64>,
    gravity: f64,
    base: Base,
    force: Force,
}

impl ChainMotion {
    /// The motion of a chain under a forcing.
    pub fn new(system: &PendulumChain, forcing: &Forcing) -> Self {
        let links = system.links();
        let by_rows = |m: &DMatrix<f64>| m.transpose().as_slice().to_vec();
        Self {
            inertia: by_rows(&links.inertia),
            hanging: links.hanging.as_slice().to_vec(),
            damping: by_rows(&links.damping),
            gravity: links.gravity,
            base: Base::new(forcing),
            force: Force::new(forcing),
        }
    }
}

impl Dynamics for ChainMotion {
    fn n_dof(&self) -> usize {
        self.hanging.len()
    }

    fn acceleration(&self, at: Moment, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
        let n = self.hanging.len();
        let turns: Vec<(f64, f64)> = q.iter().map(|q| q.sin_cos()).collect();
        let base = self.base.at(at);
        let mut mass = vec![0.0; n * n];
        for i in 0..n {
            let (si, ci) = turns[i];
            let mut f = self.hanging[i] * (base * ci - self.gravity * si);
            for j in 0..n {
                let (sj, cj) = turns[j];
                let inertia = self.inertia[i * n + j];
                mass[i * n + j] = inertia * (ci * cj + si * sj);
                f -= inertia * (si * cj - ci * sj) * v[j] * v[j] + self.damping[i * n + j] * v[j];
            }
            a[i] = f;
        }
        self.force.add(at, a);
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
    force: Force,
}

impl NonlinearMotion {
    fn new(system: &NonlinearSystem, forcing: &Forcing) -> Self {
        Self {
            system: system.clone(),
            force: Force::new(forcing),
        }
    }
}

impl Dynamics for NonlinearMotion {
    fn n_dof(&self) -> usize {
        self.system.n_dof()
    }

    fn acceleration(&self, at: Moment, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
        self.system.acceleration(at.time, q, v, a)?;
        if self.force.0.is_none() {
            return Ok(());
        }
        let mut f = vec![0.0; a.len()];
        self.force.add(at, &mut f);
        // The matrix is symmetric: its rows are its columns.
        if !small::solve_positive(self.system.mass(q)?.as_mut_slice(), &mut f) {
            return Err(singular_mass());
        }
        for (a, f) in a.iter_mut().zip(f) {
            *a += f;
        }
        Ok(())
    }
}

/// The motion of a scene's system.
#[derive(Debug, Clone)]
pub(crate) enum SceneMotion {
    Linear(LinearMotion<Full>),
    Diagonal(LinearMotion<Diagonals>),
    DoublePendulum(DoublePendulumMotion),
    Chain(ChainMotion),
    Nonlinear(NonlinearMotion),
}

impl SceneMotion {
    /// The motion of a scene.
    pub fn new(scene: &Scene) -> Self {
        let forcing = scene.forcing();
        match scene.system() {
            System::Linear(system) => match Diagonals::of(system) {
                Some(diagonals) => Self::Diagonal(LinearMotion::new(diagonals, system, forcing)),
                None => Self::Linear(LinearMotion::new(Full::new(system), system, forcing)),
            },
            System::DoublePendulum(system) => {
                Self::DoublePendulum(DoublePendulumMotion::new(system, forcing))
            }
            System::PendulumChain(system) => Self::Chain(ChainMotion::new(system, forcing)),
            System::Nonlinear(system) => Self::Nonlinear(NonlinearMotion::new(system, forcing)),
        }
    }
}

/// Runs a block of code with the motion of a scene, whatever its type.
macro_rules! with_motion {
    ($scene_motion:expr, $motion:ident => $body:expr) => {
        match $scene_motion {
            $crate::model::SceneMotion::Linear($motion) => $body,
            $crate::model::SceneMotion::Diagonal($motion) => $body,
            $crate::model::SceneMotion::DoublePendulum($motion) => $body,
            $crate::model::SceneMotion::Chain($motion) => $body,
            $crate::model::SceneMotion::Nonlinear($motion) => $body,
        }
    };
}
pub(crate) use with_motion;

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

/// The factored mass matrix of a system at a position; `None` where it is singular in double precision.
///
/// # Errors
/// What a nonlinear system reports.
pub(crate) fn factored_mass(
    system: &System,
    q: &DVector<f64>,
) -> Result<Option<Cholesky<f64, Dyn>>> {
    Ok(Cholesky::new(mass_at(system, q)?))
}
