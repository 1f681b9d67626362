//! The mirror image of an orbit.

use crate::error::{Error, Result};
use crate::orbit::periodic_orbit::PeriodicOrbit;
use crate::orbit::shooting::find::begun;
use crate::orbit::shooting::guess::Guess;
use crate::orbit::shooting::mirror::images;
use crate::orbit::shooting::own_time::with_phase;
use crate::orbit::shooting::signature::{Signature, with_shooting};
use nalgebra::DVector;
use std::f64::consts::PI;

impl PeriodicOrbit {
    /// Its mirror image: of the motion `q(t)` the motion `-q(t + T/2)`, T the period of the forcing, counted from its own first impact. It
    /// is the orbit itself, half a period later, if that is its own image.
    ///
    /// # Errors
    /// A scene that is not odd: opposite states half a period later have to have opposite accelerations, and every stop an opposite one
    /// with the same clearance and restitution.
    pub fn mirrored(&self) -> Result<Self> {
        let (scene, signature, mut state) = begun(self.scene(), Guess::Orbit(self), None)?;
        let refused = || {
            let rule = "its mirror image -q(t + T/2) has to be a motion too: forces of odd harmonics alone, opposite stops that are alike";
            Error::bad_value("scene", "one that is not odd", rule)
        };
        let (found, units) = with_shooting(&scene, &signature, |shooting, _| {
            let units = shooting.units(&state)?;
            Ok((images(shooting.motion, &scene, &units, &state)?, units))
        })?;
        let images = found.ok_or_else(refused)?;
        let stages = signature.stages.iter();
        let signature = Signature {
            stages: stages.map(|stage| stage.mirrored(&images)).collect(),
            ..signature
        };
        state.states.iter_mut().for_each(DVector::neg_mut);
        let late = if scene.frequency().is_some() { PI } else { 0.0 };
        let scene = with_phase(&scene, scene.phase() + late, signature.depends_on_time)?;
        let image = with_shooting(&scene, &signature, |shooting, orbit| {
            orbit(&state, &shooting.flight_ends(&state, &units)?)
        })?;
        // Along the whole motion, not in a few states alone.
        match image.closure_defect([units.position, units.velocity])? {
            None => Ok(image),
            Some(_) => Err(refused()),
        }
    }
}
