//! The equations of motion along a path: accelerations, and the forces of stops in contact (theory 9, "Lasting contact").
//!
//! On a flight `v' = a_free(t, q, v)`, with stops in contact `v' = a_free - sum b_i L_i` and `D L = N^T a_free - kappa`. On a segment of
//! chatter a path has the motion with the stop held, and so its acceleration; the mean force of its impacts is that L.

use crate::error::Result;
use crate::flow::RegimeDynamics;
use crate::law::{ElementState, Regime};
use crate::model::{
    Contact, Dynamics, Energetics, Moment, PhysicalState, Scene, SceneMotion, System, contacts,
    directions, reaction_weights,
};
use crate::path::parts::PathPoint;
use crate::path::path::Path;
use crate::tolerance::CLOSED_AT_IMPACT;
use nalgebra::DVector;
use std::sync::Arc;

/// The equations of motion of a scene along a path of it.
pub(crate) struct PathEquations<'a> {
    path: &'a Path,
    scene: &'a Scene,
    dynamics: SceneMotion,
    contacts: Arc<Vec<Contact>>,
    phase: f64,
}

impl<'a> PathEquations<'a> {
    pub fn new(path: &'a Path, scene: &'a Scene) -> Self {
        Self {
            path,
            scene,
            dynamics: SceneMotion::new(scene),
            contacts: Arc::new(contacts(scene)),
            phase: scene.turned_phase(),
        }
    }

    /// The moment a time after the start of an arc, with the angle of the forcing.
    pub fn moment(&self, arc: usize, local: f64) -> Moment {
        let clock = self.path.arc(arc).clock;
        Moment {
            since: clock.time(),
            ..clock.after(local).moment(self.phase)
        }
    }

    /// The contacts of the scene's stops.
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// The system of the scene.
    pub fn system(&self) -> &System {
        self.scene.system()
    }

    /// Whether a stop moves by itself.
    pub fn has_stop_motion(&self) -> bool {
        self.contacts.iter().any(|contact| contact.motion.is_some())
    }

    /// The speed at which a stop recedes by its own motion.
    pub fn stop_speed(&self, stop: usize, at: Moment) -> f64 {
        self.contacts[stop].own_motion(|| at)[1]
    }

    /// The energy that an impulse of a stop takes of a motion, or the power that its force takes; the work of the stop's own motion is not of the
    /// body and counts apart.
    ///
    /// # Errors
    /// What the functions of a nonlinear system or stop report.
    pub fn taken(
        &self,
        energetics: &Energetics,
        (stop, given): (usize, f64),
        at: Moment,
        (q, v): (&DVector<f64>, &DVector<f64>),
    ) -> Result<f64> {
        let Some(reaction) = self.contacts[stop].reaction(self.scene.system(), q.as_slice())?
        else {
            return Ok(0.0);
        };
        let taken = energetics.inertial_work(q, v, &(reaction * given))?;
        Ok(taken - given * self.stop_speed(stop, at))
    }

    /// The stops that are closed at a position, as far as an impact leaves them.
    ///
    /// # Errors
    /// What the functions of a nonlinear stop report.
    pub fn closed_stops(&self, at: Moment, q: &DVector<f64>) -> Result<Vec<usize>> {
        let q = q.as_slice();
        let mut closed = Vec::new();
        for (stop, contact) in self.contacts.iter().enumerate() {
            let value = contact.along(|| at, (q, q, q), 0.0)?;
            if value.gap.abs() <= CLOSED_AT_IMPACT * value.size {
                closed.push(stop);
            }
        }
        Ok(closed)
    }

    /// The acceleration of free motion.
    ///
    /// # Errors
    /// What the functions of a nonlinear system report.
    pub fn free_acceleration(
        &self,
        at: Moment,
        q: &DVector<f64>,
        v: &DVector<f64>,
    ) -> Result<DVector<f64>> {
        let mut a = DVector::zeros(q.len());
        let (x, y) = (q.as_slice(), v.as_slice());
        self.dynamics.acceleration(at, x, y, a.as_mut_slice())?;
        Ok(a)
    }

    /// The acceleration in a regime, and the stops in contact with their forces.
    ///
    /// # Errors
    /// What the functions of a nonlinear system or stop report.
    pub fn regime_acceleration(
        &self,
        regime: &Regime,
        at: Moment,
        q: &DVector<f64>,
        v: &DVector<f64>,
    ) -> Result<(DVector<f64>, Vec<(usize, f64)>)> {
        let motion = RegimeDynamics {
            dynamics: &self.dynamics,
            system: self.scene.system(),
            contacts: Arc::clone(&self.contacts),
            regime: regime.clone(),
        };
        let mut a = DVector::zeros(q.len());
        let forces = motion.element_forces(at, q.as_slice(), v.as_slice(), a.as_mut_slice())?;
        Ok((a, forces))
    }

    /// The energy that elements store at a point of the path and the position there \[J\].
    ///
    /// # Errors
    /// What the functions of a nonlinear stop report.
    pub fn stored(&self, point: PathPoint, q: &DVector<f64>) -> Result<f64> {
        let q = q.as_slice();
        let mut all = 0.0;
        for &(element, state) in self.path.regime_of(point.arc).others() {
            let contact = &self.contacts[element];
            let at = || self.moment(point.arc, point.local);
            let gap = contact.along(at, (q, q, q), 0.0)?.gap;
            all += self.stored_in(element, state, gap);
        }
        Ok(all)
    }

    /// The energy that an element stores in a state, at a gap \[J\]: none where its reaction is not that of inertia.
    pub fn stored_in(&self, element: usize, state: ElementState, gap: f64) -> f64 {
        if self.is_of_inertia(element) {
            self.contacts[element].law.by_state().stored(state, gap)
        } else {
            0.0
        }
    }

    /// Whether a stop pushes along its normal: it takes its force times the approach speed.
    pub fn is_of_inertia(&self, stop: usize) -> bool {
        self.scene.stops()[stop].reacts_by_inertia()
    }

    /// The acceleration of the motion as the path has it, at one of its points and the state there.
    ///
    /// # Errors
    /// As [`regime_acceleration`](Self::regime_acceleration).
    pub fn acceleration(&self, point: PathPoint, (q, v): &PhysicalState) -> Result<DVector<f64>> {
        let at = self.moment(point.arc, point.local);
        let regime = self.path.regime_of(point.arc);
        Ok(self.regime_acceleration(regime, at, q, v)?.0)
    }

    /// The force of a stop in lasting contact, or of its own law; zero elsewhere, impacts that accumulate included.
    ///
    /// # Errors
    /// As [`regime_acceleration`](Self::regime_acceleration).
    pub fn contact_force(
        &self,
        stop: usize,
        point: PathPoint,
        (q, v): &PhysicalState,
    ) -> Result<f64> {
        let regime = self.path.regime_of(point.arc);
        if self.path.is_rest(point.arc) || regime.leaves_free(stop) {
            return Ok(0.0);
        }
        let at = self.moment(point.arc, point.local);
        let (_, forces) = self.regime_acceleration(regime, at, q, v)?;
        let own = forces.iter().find(|own| own.0 == stop);
        let force = own.map_or(0.0, |own| own.1);
        Ok(self.contacts[stop].law.by_state().allowed(force))
    }

    /// The impulses of some stops at a position that take a velocity away along their reactions: `N^T B p = N^T dv`, of many the
    /// least.
    ///
    /// # Errors
    /// As [`regime_acceleration`](Self::regime_acceleration).
    pub fn impulses(
        &self,
        stops: &[usize],
        q: &DVector<f64>,
        taken: &DVector<f64>,
    ) -> Result<DVector<f64>> {
        let contacts = stops.iter().map(|&stop| &self.contacts[stop]);
        let [normals, reactions] = directions(contacts, self.scene.system(), q)?;
        let parts = DVector::from_fn(stops.len(), |i, _| normals[i].dot(taken));
        reaction_weights(&normals, &reactions, &parts)
    }
}
