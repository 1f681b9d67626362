//! Impacts on a state in modal pairs, and on first deviations from it (theory 7), for exponents and multipliers. Runs strike by
//! `NormalImpacts::strike` in `hybrid/system.rs`.

use crate::error::Result;
use crate::flow::{ModalScene, along};
use crate::impact::{GapRate, saltation};
use crate::modal::Pair;
use crate::model::Moment;
use nalgebra::{DMatrix, DVectorView};

/// The impacts of one instant, one after the other, with their buffers.
pub(crate) struct ModalImpacts<'a> {
    scene: &'a ModalScene,
    at: Moment,
    /// The rates before and after an impact.
    before: Vec<Pair>,
    after: Vec<Pair>,
}

/// The numbers of modal pairs, one after the other.
fn flat(pairs: &[Pair]) -> DVectorView<'_, f64> {
    DVectorView::from_slice(pairs.as_flattened(), 2 * pairs.len())
}

impl<'a> ModalImpacts<'a> {
    /// Those of a scene.
    pub fn new(scene: &'a ModalScene) -> Self {
        let none = vec![[0.0; 2]; scene.form.n_dof()];
        Self {
            scene,
            at: Moment::of_angle(0.0),
            before: none.clone(),
            after: none,
        }
    }

    /// An instant, with the state before its first impact.
    pub fn begin(&mut self, state: &[Pair], at: Moment) {
        self.at = at;
        self.scene.rate(state, at, &mut self.before);
    }

    /// The next impact, on the state and on deviations, columns.
    pub fn strike(
        &mut self,
        stop: usize,
        state: &mut [Pair],
        deviations: &mut DMatrix<f64>,
    ) -> Result<()> {
        let (scene, g) = (self.scene, &self.scene.geometry);
        let (velocity, jump) = (&scene.velocity_rows[stop], &scene.jumps[stop]);
        let factor = g.law(stop).rebound(g.give(stop, stop));
        let [_, receding, bend] = scene.stop_motion(stop, self.at);
        let impulse = factor * (along(velocity, state) - receding);
        for (z, jump) in state.iter_mut().zip(jump) {
            *z = [z[0] - jump[0] * impulse, z[1] - jump[1] * impulse];
        }
        let Self { before, after, .. } = self;
        scene.rate(state, self.at, after);
        let reset = |deviations: &mut DMatrix<f64>| {
            let impulses = deviations.tr_mul(&flat(velocity));
            deviations.ger(-factor, &flat(jump), &impulses, 1.0);
            let kick = factor * (along(velocity, before) - bend);
            Ok(flat(after) - flat(before) + flat(jump) * kick)
        };
        // Both of minus the gap.
        let by_state = flat(&scene.position_rows[stop]);
        let total = by_state.dot(&flat(before)) - receding;
        saltation(GapRate { by_state, total }, reset, deviations)?;
        std::mem::swap(before, after);
        Ok(())
    }
}
