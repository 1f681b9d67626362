//! A motion in another unit of time \[s\]: in the one in which its speeds are as large as its positions, one tolerance serves both.

use crate::error::Result;
use crate::model::{Dynamics, Moment};
use nalgebra::DMatrix;

/// A motion from a moment on, in units of time.
pub(crate) struct OwnTime<'a, D> {
    pub dynamics: &'a D,
    pub start: Moment,
    /// A power of two: nothing is rounded.
    pub unit: f64,
}

impl<D> OwnTime<'_, D> {
    /// The start: time counts from there.
    pub fn zero() -> Moment {
        Moment::new(0.0, 0.0, 0.0)
    }

    /// The moment that a time in units is.
    fn moment(&self, at: Moment) -> Moment {
        self.start.after(at.time * self.unit)
    }

    /// Velocities in the motion's own unit.
    fn velocities(&self, v: &[f64]) -> Vec<f64> {
        v.iter().map(|v| v / self.unit).collect()
    }
}

impl<D: Dynamics> Dynamics for OwnTime<'_, D> {
    type Drive = D::Drive;

    fn n_dof(&self) -> usize {
        self.dynamics.n_dof()
    }

    fn drive(&self, at: Moment) -> D::Drive {
        self.dynamics.drive(self.moment(at))
    }

    fn driven(&self, drive: D::Drive, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
        self.dynamics.driven(drive, q, &self.velocities(v), a)?;
        for a in a {
            *a *= self.unit * self.unit;
        }
        Ok(())
    }

    fn jacobian(&self, at: Moment, q: &[f64], v: &[f64]) -> Result<Option<DMatrix<f64>>> {
        let n = q.len();
        let known = self
            .dynamics
            .jacobian(self.moment(at), q, &self.velocities(v))?;
        Ok(known.map(|mut jacobian| {
            jacobian.columns_mut(0, n).scale_mut(self.unit * self.unit);
            jacobian.columns_mut(n, n).scale_mut(self.unit);
            jacobian
        }))
    }
}
