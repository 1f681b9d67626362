//! Energies of a system and the powers of its forces (theory 2): kinetic and potential energy, the power of the forcing, what
//! dampers take.
//!
//! A system that is given by functions, mass M and potential V among them, has no separate damping force, but its power is known:
//! along the free motion `q' = v`, `v' = a`, what is taken is `P = F.v - d/dt (v.M v/2 + V)`, F the harmonic force.

use crate::error::{Error, Result};
use crate::model::dynamics::mass_at;
use crate::model::excitation::Excitation;
use crate::model::linear::Coefficient;
use crate::model::moment::Moment;
use crate::model::nonlinear::NonlinearSystem;
use crate::model::pendulum::Links;
use crate::model::ramp::SteadyRamp;
use crate::model::scene::Scene;
use crate::model::system::System;
use crate::tolerance::ENERGY_DIFFERENCE_STEP;
use nalgebra::{DMatrix, DVector};

/// Energies and powers of a scene's motion.
#[derive(Debug, Clone)]
pub(crate) struct Energetics {
    system: System,
    excitation: Excitation,
    damping: Coefficient,
    /// The factor on the damping, where that drifts.
    drifting: Option<SteadyRamp>,
    potential: Potential,
    /// Base acceleration times these, times `cos q_i` for a pendulum, is the force of base motion.
    base: Option<DVector<f64>>,
}

/// Where potential energy is.
#[derive(Debug, Clone)]
enum Potential {
    /// `q.K q/2 - f0.q`, K symmetric; the circulatory rest of a stiffness matrix has none.
    Quadratic {
        stiffness: Coefficient,
        circulatory: Option<DMatrix<f64>>,
        load: DVector<f64>,
    },
    /// `sum w_i (1 - cos q_i)`
    Hanging { weights: DVector<f64> },
    /// A function of q.
    Given(NonlinearSystem),
}

/// Damping, potential and base of a pendulum.
fn static_moment(links: Links) -> (Coefficient, Potential, Option<DVector<f64>>) {
    let weights = &links.static_moment * links.gravity;
    let potential = Potential::Hanging { weights };
    (links.damping.into(), potential, Some(links.static_moment))
}

impl Energetics {
    /// The energetics of a scene.
    ///
    /// # Errors
    /// A system given by functions without its mass matrix.
    pub fn new(scene: &Scene) -> Result<Self> {
        let (damping, potential, base) = match scene.system() {
            System::Linear(system) => {
                let (stiffness, circulatory) = parts(system.stiffness());
                let potential = Potential::Quadratic {
                    stiffness,
                    circulatory,
                    load: system.load().clone(),
                };
                (system.damping().clone(), potential, None)
            }
            System::DoublePendulum(pendulum) => static_moment(pendulum.links()),
            System::PendulumChain(chain) => static_moment(chain.links()),
            System::Nonlinear(system) if !system.has_mass() => return Err(lacks("mass")),
            System::Nonlinear(system) => {
                let none = DVector::zeros(system.n_dof());
                (none.into(), Potential::Given(system.clone()), None)
            }
        };
        Ok(Self {
            system: scene.system().clone(),
            excitation: scene.excitation(),
            damping,
            drifting: scene.drifting_damping(),
            potential,
            base,
        })
    }

    /// `v.M(q) v/2`
    pub fn kinetic(&self, q: &DVector<f64>, v: &DVector<f64>) -> Result<f64> {
        Ok(0.5 * self.inertial_work(q, v, v)?)
    }

    /// Work of a velocity jump or an acceleration b along the motion: `v.M(q) b`.
    pub fn inertial_work(
        &self,
        q: &DVector<f64>,
        v: &DVector<f64>,
        b: &DVector<f64>,
    ) -> Result<f64> {
        Ok(v.dot(&match &self.system {
            System::Linear(system) => system.mass().times(b),
            system => mass_at(system, q)? * b,
        }))
    }

    /// The potential energy.
    ///
    /// # Errors
    /// A system given by functions without its potential, and what that function reports.
    pub fn potential(&self, q: &DVector<f64>) -> Result<f64> {
        Ok(match &self.potential {
            Potential::Quadratic {
                stiffness, load, ..
            } => 0.5 * q.dot(&stiffness.times(q)) - load.dot(q),
            Potential::Hanging { weights } => weights
                .iter()
                .zip(q.iter())
                .map(|(w, q)| 2.0 * w * (0.5 * q).sin().powi(2))
                .sum(),
            Potential::Given(system) => {
                let known = system.potential(q.as_slice())?;
                known.ok_or_else(|| lacks("potential"))?
            }
        })
    }

    /// The kinetic and the potential energy together.
    ///
    /// # Errors
    /// A system given by functions without its potential, and what its functions report.
    pub fn total(&self, q: &DVector<f64>, v: &DVector<f64>) -> Result<f64> {
        Ok(self.kinetic(q, v)? + self.potential(q)?)
    }

    /// The power of the forcing.
    pub fn forcing_power(&self, at: Moment, q: &DVector<f64>, v: &DVector<f64>) -> f64 {
        let lever = |i: usize| self.base.as_ref().map_or(0.0, |base| base[i] * q[i].cos());
        self.excitation.power(at, lever, v)
    }

    /// The power lost in dampers and by the circulatory part of a stiffness matrix; for a system given by functions, the power that its
    /// forces take beyond the potential, from the acceleration `free` of its free motion. `step` is a time over which the motion changes
    /// little.
    ///
    /// # Errors
    /// What the functions of a nonlinear system report.
    pub fn damping_power(
        &self,
        at: Moment,
        (q, v): (&DVector<f64>, &DVector<f64>),
        step: f64,
        free: impl FnOnce() -> Result<DVector<f64>>,
    ) -> Result<f64> {
        let factor = self.drifting.map_or(1.0, |factor| factor.value(at.time));
        let dampers = || factor * v.dot(&self.damping.times(v));
        Ok(match &self.potential {
            Potential::Quadratic {
                circulatory: Some(odd),
                ..
            } => dampers() + v.dot(&(odd * q)),
            Potential::Given(_) => {
                self.forcing_power(at, q, v) - self.gain((q, v), &free()?, step)?
            }
            Potential::Quadratic { .. } | Potential::Hanging { .. } => dampers(),
        })
    }

    /// The rate of kinetic and potential energy along `q' = v`, `v' = a`, by central differences of fourth order.
    fn gain(
        &self,
        (q, v): (&DVector<f64>, &DVector<f64>),
        a: &DVector<f64>,
        step: f64,
    ) -> Result<f64> {
        let s = ENERGY_DIFFERENCE_STEP * step;
        let energy = |s: f64| -> Result<f64> {
            let there = q + v * s;
            self.total(&there, &(v + a * s))
        };
        let apart = |s: f64| Ok::<_, Error>(energy(s)? - energy(-s)?);
        Ok((8.0 * apart(s)? - apart(2.0 * s)?) / (12.0 * s))
    }
}

/// The symmetric part of a matrix, and the rest where there is any.
fn parts(matrix: &Coefficient) -> (Coefficient, Option<DMatrix<f64>>) {
    match matrix {
        Coefficient::Diagonal(_) => (matrix.clone(), None),
        Coefficient::Dense(k) => {
            let (even, odd) = ((k + k.transpose()) * 0.5, (k - k.transpose()) * 0.5);
            (even.into(), (odd.amax() > 0.0).then_some(odd))
        }
    }
}

fn lacks(what: &str) -> Error {
    let value = format!("a NonlinearSystem without `{what}`");
    let rule = "the energy ledger needs its mass matrix and its potential energy: give it `mass` and `potential`";
    Error::bad_value("system", value, rule)
}
