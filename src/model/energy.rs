//! Energies of a system and the powers of its forces (theory 2): kinetic and potential energy, the power of the forcing, what
//! dampers take.

use crate::error::{Error, Result};
use crate::model::dynamics::{Moment, mass_at};
use crate::model::{Forcing, Scene, System};
use nalgebra::{DMatrix, DVector};

/// Energies and powers of a scene's motion.
#[derive(Debug, Clone)]
pub(crate) struct Energetics {
    system: System,
    forcing: Forcing,
    damping: DMatrix<f64>,
    potential: Potential,
    /// Base acceleration times these, times `cos q_i` for a pendulum, is the force of base motion.
    base: Option<DVector<f64>>,
}

/// Where potential energy is.
#[derive(Debug, Clone)]
enum Potential {
    /// `q.K q/2 - f0.q`, K symmetric; the circulatory rest of a stiffness matrix has none.
    Quadratic {
        stiffness: DMatrix<f64>,
        circulatory: Option<DMatrix<f64>>,
        load: DVector<f64>,
    },
    /// `sum w_i (1 - cos q_i)`
    Hanging { weights: DVector<f64> },
}

impl Energetics {
    /// The energetics of a scene.
    ///
    /// # Errors
    /// A system given by functions, whose forces cannot be told apart.
    pub fn new(scene: &Scene) -> Result<Self> {
        let (damping, potential, base) = match scene.system() {
            System::Linear(system) => {
                let k = system.stiffness().to_dense();
                let (even, odd) = ((&k + k.transpose()) * 0.5, (&k - k.transpose()) * 0.5);
                let potential = Potential::Quadratic {
                    stiffness: even,
                    circulatory: (odd.amax() > 0.0).then_some(odd),
                    load: system.load().clone(),
                };
                (system.damping().to_dense(), potential, None)
            }
            System::DoublePendulum(pendulum) => {
                let weights = pendulum.stiffness().diagonal();
                let base = pendulum.mass().column(0).into_owned();
                let potential = Potential::Hanging { weights };
                (pendulum.damping().clone(), potential, Some(base))
            }
            System::PendulumChain(chain) => {
                let base = chain.lengths().component_mul(&chain.hanging_mass());
                let weights = &base * chain.gravity();
                let potential = Potential::Hanging { weights };
                (chain.damping().clone(), potential, Some(base))
            }
            System::Nonlinear(_) => {
                let rule = "the energy ledger tells springs, dampers and forcing apart, which functions do not";
                return Err(Error::bad_value("system", "a NonlinearSystem", rule));
            }
        };
        Ok(Self {
            system: scene.system().clone(),
            forcing: scene.forcing().clone(),
            damping,
            potential,
            base,
        })
    }

    /// `v.M(q) v/2`
    pub fn kinetic(&self, q: &DVector<f64>, v: &DVector<f64>) -> Result<f64> {
        Ok(0.5 * v.dot(&(mass_at(&self.system, q)? * v)))
    }

    /// Work of a velocity jump or an acceleration b along the motion: `v.M(q) b`.
    pub fn inertial_work(
        &self,
        q: &DVector<f64>,
        v: &DVector<f64>,
        b: &DVector<f64>,
    ) -> Result<f64> {
        Ok(v.dot(&(mass_at(&self.system, q)? * b)))
    }

    /// The potential energy.
    pub fn potential(&self, q: &DVector<f64>) -> f64 {
        match &self.potential {
            Potential::Quadratic {
                stiffness, load, ..
            } => 0.5 * q.dot(&(stiffness * q)) - load.dot(q),
            Potential::Hanging { weights } => weights
                .iter()
                .zip(q.iter())
                .map(|(w, q)| 2.0 * w * (0.5 * q).sin().powi(2))
                .sum(),
        }
    }

    /// The power of the forcing.
    pub fn forcing_power(&self, at: Moment, q: &DVector<f64>, v: &DVector<f64>) -> f64 {
        let (sin, cos) = at.angle.sin_cos();
        match (&self.forcing, &self.system, &self.base) {
            (Forcing::Unforced, ..) => 0.0,
            (Forcing::BaseMotion(base), _, Some(lever)) => {
                let acceleration = base.amplitude() * base.frequency().powi(2) * cos;
                let along = |i: usize| lever[i] * q[i].cos() * v[i];
                acceleration * (0..q.len()).map(along).sum::<f64>()
            }
            (forcing, System::Linear(system), _) => {
                let force = forcing.force_on(system);
                let power = |(f, v): (&nalgebra::Complex<f64>, &f64)| (f.re * cos - f.im * sin) * v;
                force.iter().zip(v.iter()).map(power).sum()
            }
            (Forcing::Harmonic(harmonic), ..) => harmonic
                .amplitude()
                .iter()
                .zip(v.iter())
                .map(|(f, v)| (f.re * cos - f.im * sin) * v)
                .sum(),
            (Forcing::BaseMotion(_), _, None) => 0.0,
        }
    }

    /// What dampers take, and the circulatory part of a stiffness matrix.
    pub fn damping_power(&self, q: &DVector<f64>, v: &DVector<f64>) -> f64 {
        let dampers = v.dot(&(&self.damping * v));
        match &self.potential {
            Potential::Quadratic {
                circulatory: Some(odd),
                ..
            } => dampers + v.dot(&(odd * q)),
            _ => dampers,
        }
    }
}
