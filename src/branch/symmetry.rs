//! Motions that are their own mirror images half a period later, `q(t + T/2) = -q(t)`: the loop of half a period, which closes with its
//! image, and the whole one (theory 19, "Symmetry").

use crate::branch::parametric_loop::ParametricLoop;
use crate::branch::problem::BranchProblem;
use crate::branch::shooting_nodes::period;
use crate::error::{Error, Result};
use crate::model::Scene;
use crate::orbit::{Signature, images, with_maps};
use crate::tolerance::SAME_ROUND;

impl BranchProblem<'_> {
    /// The mirror image of each stop in a scene, where that is odd.
    pub fn images_in(&self, scene: &Scene, place: &ParametricLoop) -> Result<Option<Vec<usize>>> {
        let units = &self.units_in(scene);
        with_maps(scene, &self.signature, |motion| {
            images(motion, scene, units, &place.state)
        })
    }

    /// The loop of half a period, if the motion is its own mirror image and the scenes near its value are odd; and its problem.
    pub fn half(&self, place: &ParametricLoop) -> Result<Option<(Self, ParametricLoop)>> {
        if !self.formulation.has_images() {
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
                // The scene refuses a value next to that of the loop.
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
        let (mut problem, half) = self.with_instants(place.value, instants, length)?;
        problem.signature.images = Some(images);
        let closes = problem.mismatch(&half)? <= SAME_ROUND;
        Ok(closes.then_some((problem, half)))
    }

    /// A touch (stop, time) of the whole loop as one of the loop of half a period.
    pub fn in_half(&self, place: &ParametricLoop, (stop, time): (usize, f64)) -> (usize, f64) {
        let (first, half) = (place.state.times[0], period(&place.state));
        let late = (time - first).rem_euclid(2.0 * half);
        match &self.signature.images {
            Some(images) if late >= half => (images[stop], first + late - half),
            _ => (stop, first + late),
        }
    }

    /// The loop of the whole period, and its problem.
    pub fn whole(&self, place: &ParametricLoop) -> Result<(Self, ParametricLoop)> {
        self.repeated(place, &place.state, &[0.0, 0.0])
    }
}
