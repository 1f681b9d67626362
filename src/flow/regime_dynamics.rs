//! The motion of any scene in a regime (theory 9): the contact forces keep their gaps from accelerating.

use crate::error::{Error, Result};
use crate::law::{Action, ElementState, Guard, GuardKind, Regime};
use crate::model::{Contact, Dynamics, Moment, System, reaction_weights, slow_time};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// The motion in a regime: `a - sum b L`, with the contact forces L that keep their gaps from accelerating.
pub(crate) struct RegimeDynamics<'a, D> {
    pub dynamics: &'a D,
    pub system: &'a System,
    pub contacts: Arc<Vec<Contact>>,
    pub regime: Regime,
}

impl<D: Dynamics> RegimeDynamics<'_, D> {
    /// The contact forces at a moment; `a` becomes the acceleration under them.
    pub fn forces(&self, at: Moment, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<Vec<f64>> {
        self.forces_under(self.drive(at), q, v, a)
    }

    /// The forces of all elements in contact, with what the laws of others than those held have.
    pub fn element_forces(
        &self,
        at: Moment,
        q: &[f64],
        v: &[f64],
        a: &mut [f64],
    ) -> Result<Vec<(usize, f64)>> {
        let elements = self.regime.constrained().iter().copied();
        let mut forces: Vec<_> = elements.zip(self.forces(at, q, v, a)?).collect();
        for &(element, state) in self.regime.others() {
            let own = self.own_force(element, state, at, (q, v))?;
            forces.extend(own.map(|force| (element, force)));
        }
        Ok(forces)
    }

    /// The forces that guard the regime, or what has their sign, each above zero while its element stays in its state.
    pub fn guards(
        &self,
        guards: &[Guard],
        at: Moment,
        (q, v): (&[f64], &[f64]),
    ) -> Result<Vec<f64>> {
        let held = if self.regime.constrained().is_empty() {
            Vec::new()
        } else {
            self.forces(at, q, v, &mut vec![0.0; q.len()])?
        };
        let constrained = self.regime.constrained();
        let of = |guard: &Guard| {
            let element = guard.element;
            let place = constrained.iter().position(|own| *own == element);
            let held = place.map_or(0.0, |k| held[k]);
            let seat = || self.contacts[element].law.by_state().seat();
            let grip = || {
                let contact = &self.contacts[element];
                let gap = contact.along(|| at, (q, v, v), 0.0)?;
                Ok::<_, Error>(contact.law.by_state().grip(-gap.gap, -gap.speed).value)
            };
            Ok(match guard.kind {
                GuardKind::Excess => seat().unwrap_or(0.0) - held,
                GuardKind::Push => grip()?,
                GuardKind::Pull => -grip()?,
                _ => held,
            })
        };
        guards.iter().map(of).collect()
    }

    /// The force of an element that its law gives in a state.
    fn own_force(
        &self,
        element: usize,
        state: ElementState,
        at: Moment,
        (q, v): (&[f64], &[f64]),
    ) -> Result<Option<f64>> {
        let contact = &self.contacts[element];
        let law = contact.law.by_state();
        if matches!(law.action(state), Action::Nothing | Action::Constraint) {
            return Ok(None);
        }
        let gap = contact.along(|| at, (q, v, v), 0.0)?;
        Ok(law.force_in(state, gap.gap, gap.speed))
    }

    /// Adds what the force of an element gives to an acceleration.
    fn push(
        &self,
        element: usize,
        state: ElementState,
        at: Moment,
        (q, v): (&[f64], &[f64]),
        a: &mut [f64],
    ) -> Result<()> {
        if let Some(force) = self.own_force(element, state, at, (q, v))? {
            let reaction = self.contacts[element].reaction(self.system, q)?;
            for (a, b) in a.iter_mut().zip(reaction.iter().flat_map(|b| b.iter())) {
                *a -= b * force;
            }
        }
        Ok(())
    }

    /// The same under what drives the motion.
    fn forces_under(
        &self,
        (drive, at): (D::Drive, Moment),
        q: &[f64],
        v: &[f64],
        a: &mut [f64],
    ) -> Result<Vec<f64>> {
        self.dynamics.driven(drive, q, v, a)?;
        if self.regime.is_free() {
            return Ok(Vec::new());
        }
        for &(element, state) in self.regime.others() {
            self.push(element, state, at, (q, v), a)?;
        }
        let stops = self.regime.constrained();
        if stops.is_empty() {
            return Ok(Vec::new());
        }
        let (k, slow) = (stops.len(), slow_time(q, v, a));
        let mut opening = DVector::zeros(k);
        let (mut normals, mut reactions) = (Vec::with_capacity(k), Vec::with_capacity(k));
        for (i, &stop) in stops.iter().enumerate() {
            let contact = &self.contacts[stop];
            opening[i] = contact.along(|| at, (q, v, a), slow)?.acceleration;
            let reaction = contact.reaction(self.system, q)?;
            reactions.push(reaction.unwrap_or_else(|| DVector::zeros(q.len())));
            normals.push(contact.surface.normal(q)?);
        }
        let forces = reaction_weights(&normals, &reactions, &-opening)?;
        for (reaction, force) in reactions.iter().zip(forces.iter()) {
            for (a, b) in a.iter_mut().zip(reaction.iter()) {
                *a -= b * force;
            }
        }
        Ok(forces.iter().copied().collect())
    }
}

impl<D: Dynamics> Dynamics for RegimeDynamics<'_, D> {
    /// What drives the free motion, and when: stops may move.
    type Drive = (D::Drive, Moment);

    fn n_dof(&self) -> usize {
        self.dynamics.n_dof()
    }

    fn drive(&self, at: Moment) -> (D::Drive, Moment) {
        (self.dynamics.drive(at), at)
    }

    fn driven(&self, drive: (D::Drive, Moment), q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
        self.forces_under(drive, q, v, a).map(|_| ())
    }

    /// Differences do where a regime adds forces.
    fn jacobian(&self, at: Moment, q: &[f64], v: &[f64]) -> Result<Option<DMatrix<f64>>> {
        if self.regime.is_free() {
            self.dynamics.jacobian(at, q, v)
        } else {
            Ok(None)
        }
    }
}
