//! Motions that are their own mirror images half a period later: half of one, that closes with its image, and the whole of a half
//! (theory 19, "Symmetry").

use crate::branch::family::Family;
use crate::branch::instants::period;
use crate::branch::place::Place;
use crate::error::{Error, Result};
use crate::model::Scene;
use crate::orbit::{Signature, images, with_shooting};
use crate::tolerance::SAME_ROUND;

impl Family<'_> {
    /// Of each stop its mirror image in a scene, where that is odd.
    pub fn images_in(&self, scene: &Scene, place: &Place) -> Result<Option<Vec<usize>>> {
        let units = &self.units_in(scene);
        with_shooting(scene, &self.signature, |shooting, _| {
            images(shooting.motion, scene, units, &place.state)
        })
    }

    /// Half of a loop that is its own mirror image half a period later, in scenes that stay odd near its value.
    pub fn half(&self, place: &Place) -> Result<Option<(Self, Place)>> {
        if self.has_pulses {
            return Ok(None);
        }
        let Signature {
            stages, n_periods, ..
        } = &self.signature;
        let count = stages.len();
        let is_odd_period = self.is_free || !n_periods.is_multiple_of(2);
        let own = if self.is_empty() { 1 } else { count / 2 };
        if !is_odd_period || !(self.is_empty() || count.is_multiple_of(2)) {
            return Ok(None);
        }
        let step = self.difference(place.value);
        let mut images = None;
        for value in [place.value, place.value + step, place.value - step] {
            let scene = match self.scene(value) {
                // The number may not take a value beside its own.
                Err(Error::BadValue { .. }) => continue,
                scene => scene?,
            };
            let Some(found) = self.images_in(&scene, place)? else {
                return Ok(None);
            };
            images = Some(found);
        }
        let Some(images) = images else {
            return Ok(None);
        };
        let is_image = |k: usize| stages[k + own] == stages[k].mirrored(&images);
        if !self.is_empty() && !(0..own).all(is_image) {
            return Ok(None);
        }
        let instants = self.instants(&place.state)[..own].to_vec();
        let length = (0.5 * period(&place.state), *n_periods);
        let (mut family, half) = self.with_instants(place.value, instants, length)?;
        family.signature.images = Some(images);
        let closes = family.mismatch(&half)? <= SAME_ROUND;
        Ok(closes.then_some((family, half)))
    }

    /// A touch of a whole loop as one of its half.
    pub fn in_half(&self, place: &Place, (stop, time): (usize, f64)) -> (usize, f64) {
        let (first, half) = (place.state.times[0], period(&place.state));
        let late = (time - first).rem_euclid(2.0 * half);
        match &self.signature.images {
            Some(images) if late >= half => (images[stop], first + late - half),
            _ => (stop, first + late),
        }
    }

    /// The whole loop of a half.
    pub fn whole(&self, place: &Place) -> Result<(Self, Place)> {
        self.repeated(place, &place.state, &[0.0, 0.0])
    }
}
