//! The motion of any scene while stops are held (theory 9): the contact forces keep their gaps from accelerating.

use crate::error::Result;
use crate::linalg::rank;
use crate::model::{Contact, Dynamics, Moment, System};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// Singular values below this, relative to the largest, are zero: the normals are dependent.
const DEPENDENT_TOL: f64 = 1e-12;
/// Time over which a held motion changes little, for the difference that bends a nonlinear gap.
const HELD_TIME: f64 = 1.0;

/// The motion while some stops are held: `a - sum b L`, with the contact forces L that keep their gaps from accelerating.
pub(crate) struct HeldMotion<'a, D> {
    pub dynamics: &'a D,
    pub system: &'a System,
    pub contacts: Arc<Vec<Contact>>,
    pub stops: Vec<usize>,
}

impl<D: Dynamics> HeldMotion<'_, D> {
    /// The contact forces; `a` becomes the acceleration under them.
    pub fn forces(&self, at: Moment, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<Vec<f64>> {
        self.dynamics.acceleration(at, q, v, a)?;
        let k = self.stops.len();
        let mut delassus = DMatrix::zeros(k, k);
        let mut opening = DVector::zeros(k);
        let mut reactions = Vec::with_capacity(k);
        for (i, &stop) in self.stops.iter().enumerate() {
            let contact = &self.contacts[stop];
            opening[i] = contact.surface.along(q, v, a, HELD_TIME)?.acceleration;
            let reaction = contact.reaction(self.system, q)?;
            reactions.push(reaction.unwrap_or_else(|| DVector::zeros(q.len())));
        }
        for (i, &stop) in self.stops.iter().enumerate() {
            let normal = self.contacts[stop].surface.normal(q)?;
            for (j, reaction) in reactions.iter().enumerate() {
                delassus[(i, j)] = normal.dot(reaction);
            }
        }
        let tolerance = DEPENDENT_TOL * delassus.amax();
        let forces = rank::solve(&delassus, &-opening, tolerance)?.particular;
        for (reaction, force) in reactions.iter().zip(forces.iter()) {
            for (a, b) in a.iter_mut().zip(reaction.iter()) {
                *a -= b * force;
            }
        }
        Ok(forces.iter().copied().collect())
    }
}

impl<D: Dynamics> Dynamics for HeldMotion<'_, D> {
    fn n_dof(&self) -> usize {
        self.dynamics.n_dof()
    }

    fn acceleration(&self, at: Moment, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
        self.forces(at, q, v, a).map(|_| ())
    }
}
