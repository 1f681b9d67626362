//! Deviations from exact flights, in modal pairs: they fly in closed form.

use crate::error::Result;
use crate::exponents::tangents::Tangents;
use crate::flow::{TimedScene, propagate, with_flow};
use crate::hybrid::{ClosedFormMaps, HybridMaps, ModalImpacts};
use crate::law::Regime;
use crate::modal::{ModalState, pairs};
use crate::model::Moment;
use crate::path::{Evaluator, Path};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// The modal state where the motion is.
pub(crate) struct ModalTangents<'a> {
    scene: &'a TimedScene,
    maps: ClosedFormMaps<'a>,
    impacts: ModalImpacts<'a>,
    state: ModalState,
    to_physical: DMatrix<f64>,
    to_modal: DMatrix<f64>,
}

impl<'a> ModalTangents<'a> {
    /// Those of a scene.
    pub fn new(scene: &'a TimedScene) -> Self {
        let modal = &scene.modal;
        let (to_physical, to_modal) = modal.form.transformation();
        Self {
            scene,
            maps: ClosedFormMaps::new(modal, 0.0, Vec::new()),
            impacts: ModalImpacts::new(modal),
            state: ModalState::default(),
            to_physical,
            to_modal,
        }
    }

    fn moment(&self, t: f64) -> Moment {
        let w = self.scene.modal.frequency;
        Moment::new(t, w * t, w)
    }
}

impl<'a> Tangents for ModalTangents<'a> {
    type Maps = ClosedFormMaps<'a>;
    type State = ModalState;

    fn maps(&self) -> &ClosedFormMaps<'a> {
        &self.maps
    }

    fn state(&mut self) -> &mut ModalState {
        &mut self.state
    }

    fn begin(&mut self, (q, v): (&DVector<f64>, &DVector<f64>)) {
        self.state = self.scene.modal.form.to_modal(q.as_slice(), v.as_slice());
    }

    fn take_regimes(&mut self, evaluator: &Evaluator) {
        if let Evaluator::Exact { regimes, .. } = evaluator {
            self.maps.take_regimes(regimes);
        }
    }

    /// Each: a signal passes from one polynomial to the next between them.
    fn spans(arcs: Range<usize>) -> impl Iterator<Item = Range<usize>> {
        arcs.map(|arc| arc..arc + 1)
    }

    fn read(&mut self, path: &Path, arc: usize) {
        let parts = &path.parts;
        let numbers = parts.numbers_of(parts.segment_of(arc), arc, 2 * path.n_dof);
        self.state.clear();
        self.state.extend(numbers.chunks(2).map(|z| [z[0], z[1]]));
    }

    fn arrive(&mut self, _path: &Path, _arc: usize) {}

    fn fly(
        &mut self,
        regime: &Regime,
        span: (f64, f64),
        deviations: &mut DMatrix<f64>,
    ) -> Result<()> {
        if regime.is_free() {
            let (at, length) = (self.moment(span.0), span.1 - span.0);
            with_flow!(&*self.scene.flow, flow => propagate(flow, at, length, &mut self.state));
            self.scene.modal.form.propagate(length, deviations);
            return Ok(());
        }
        self.physically(deviations, |maps, state, own| {
            maps.flow(regime, span, state, own)
        })
    }

    fn strike(&mut self, stop: usize, time: f64, deviations: &mut DMatrix<f64>) -> Result<()> {
        let at = self.moment(time);
        self.impacts.begin(&self.state, at);
        self.impacts.strike(stop, &mut self.state, deviations)
    }

    fn physically<R>(
        &mut self,
        deviations: &mut DMatrix<f64>,
        work: impl FnOnce(&ClosedFormMaps<'a>, &mut DVector<f64>, &mut DMatrix<f64>) -> Result<R>,
    ) -> Result<R> {
        let mut state = self.scene.modal.form.state_of(&self.state);
        let mut own = &self.to_physical * &*deviations;
        let done = work(&self.maps, &mut state, &mut own)?;
        *deviations = &self.to_modal * own;
        self.state = pairs(&(&self.to_modal * state)).into();
        Ok(done)
    }
}
