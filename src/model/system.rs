//! The systems a scene may hold.

use crate::model::linear::LinearSystem;
use crate::model::nonlinear::NonlinearSystem;
use crate::model::pendulum::{DoublePendulum, PendulumChain};
use std::sync::Arc;

/// A mechanical system.
#[derive(Debug, Clone, PartialEq)]
pub enum System {
    /// `M q'' + C q' + K q = f`.
    Linear(Arc<LinearSystem>),
    /// The double pendulum of eq. (3), dimensionless.
    DoublePendulum(DoublePendulum),
    /// A chain of N links in physical units.
    PendulumChain(PendulumChain),
    /// Any equations of motion.
    Nonlinear(NonlinearSystem),
}

impl From<LinearSystem> for System {
    fn from(system: LinearSystem) -> Self {
        Self::Linear(Arc::new(system))
    }
}

impl From<DoublePendulum> for System {
    fn from(system: DoublePendulum) -> Self {
        Self::DoublePendulum(system)
    }
}

impl From<PendulumChain> for System {
    fn from(system: PendulumChain) -> Self {
        Self::PendulumChain(system)
    }
}

impl From<NonlinearSystem> for System {
    fn from(system: NonlinearSystem) -> Self {
        Self::Nonlinear(system)
    }
}

impl System {
    /// Number of degrees of freedom.
    pub fn n_dof(&self) -> usize {
        match self {
            Self::Linear(s) => s.n_dof(),
            Self::DoublePendulum(_) => 2,
            Self::PendulumChain(s) => s.n_dof(),
            Self::Nonlinear(s) => s.n_dof(),
        }
    }

    /// Lengths of a pendulum's links in the units of its scene, `None` for a system that is no pendulum.
    pub(crate) fn link_lengths(&self) -> Option<nalgebra::DVector<f64>> {
        match self {
            Self::Linear(_) | Self::Nonlinear(_) => None,
            Self::DoublePendulum(s) => Some(s.link_lengths()),
            Self::PendulumChain(s) => Some(s.lengths().clone()),
        }
    }
}
