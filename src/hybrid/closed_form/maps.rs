//! The maps of a linear scene: flights in closed form, in any regime.

use crate::error::Result;
use crate::flow::{ModalScene, RegimeMotion, SceneFlow, propagate, with_flow};
use crate::hybrid::maps::{Breaks, GapAt, HybridMaps, halves, joined};
use crate::impact::impulse_matrix;
use crate::law::{Law, Newton, Regime};
use crate::modal::ModalState;
use crate::model::{Moment, along_reactions};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// A linear scene from a forcing phase.
pub(crate) struct ClosedFormMaps<'a> {
    scene: &'a ModalScene,
    flow: Arc<SceneFlow>,
    phase: f64,
    to_physical: DMatrix<f64>,
    to_modal: DMatrix<f64>,
    regimes: Vec<Arc<RegimeMotion>>,
    breaks: Breaks,
}

/// The motions in some regimes, of each that is not free one.
pub(crate) fn regime_motions<'s>(
    scene: &ModalScene,
    regimes: impl Iterator<Item = &'s Regime>,
) -> Result<Vec<Arc<RegimeMotion>>> {
    let mut all: Vec<Arc<RegimeMotion>> = Vec::new();
    for regime in regimes.filter(|regime| !regime.is_free()) {
        if all.iter().all(|known| known.regime != *regime) {
            all.push(Arc::new(RegimeMotion::new(scene, regime)?));
        }
    }
    Ok(all)
}

impl<'a> ClosedFormMaps<'a> {
    /// A scene from a forcing phase, with its motions in the regimes that are not free.
    pub fn new(scene: &'a ModalScene, phase: f64, regimes: Vec<Arc<RegimeMotion>>) -> Self {
        let (to_physical, to_modal) = scene.form.transformation();
        Self {
            scene,
            flow: scene.flow(),
            phase,
            to_physical,
            to_modal,
            regimes,
            breaks: Breaks(scene.excitation.breaks()),
        }
    }

    /// Takes motions in other regimes.
    pub fn take_regimes(&mut self, regimes: &[Arc<RegimeMotion>]) {
        self.regimes = regimes.to_vec();
    }

    /// A state in modal pairs.
    pub fn modal(&self, state: &DVector<f64>) -> ModalState {
        self.scene.form.pairs_of(state)
    }

    fn moment(&self, t: f64) -> Moment {
        let w = self.scene.frequency;
        Moment::new(t, w * t + self.phase, w)
    }

    fn in_regime(&self, regime: &Regime) -> &RegimeMotion {
        let known = self.regimes.iter().find(|motion| motion.regime == *regime);
        known.expect("made for every regime of the itinerary")
    }
}

impl HybridMaps for ClosedFormMaps<'_> {
    fn flow(
        &self,
        regime: &Regime,
        (start, end): (f64, f64),
        state: &mut DVector<f64>,
        deviations: &mut DMatrix<f64>,
    ) -> Result<()> {
        let span = end - start;
        if !regime.is_free() {
            let own = self.in_regime(regime);
            for (from, to) in self.breaks.parts((start, end)) {
                let (q, v) = halves(state);
                *state = joined(&own.propagate(self.moment(from), to - from, &q, &v));
            }
            own.propagate_deviations(span, deviations);
            return Ok(());
        }
        let mut modal = self.modal(state);
        for (from, to) in self.breaks.parts((start, end)) {
            let at = self.moment(from);
            with_flow!(&*self.flow, f => propagate(f, at, to - from, &mut modal));
        }
        *state = self.scene.form.state_of(&modal);
        if deviations.ncols() > 0 {
            let mut carried = &self.to_modal * &*deviations;
            self.scene.form.propagate(span, &mut carried);
            *deviations = &self.to_physical * carried;
        }
        Ok(())
    }

    fn rate(&self, regime: &Regime, t: f64, state: &DVector<f64>) -> Result<DVector<f64>> {
        let modal = self.modal(state);
        let mut rate = ModalState::from(vec![[0.0; 2]; modal.len()]);
        self.scene.rate(&modal, self.moment(t), &mut rate);
        let mut rate = self.scene.form.state_of(&rate);
        let n = state.len() / 2;
        for (element, force) in self.scene.geometry.forces(regime) {
            let at = self.gap(element, t, state)?;
            let force = force.at(at.gap, at.speed(state.rows(n, n)));
            let mut a = rate.rows_mut(n, n);
            a -= self.scene.geometry.reactions.column(element) * force;
        }
        let held = regime.constrained();
        if !held.is_empty() {
            let (normals, reactions) = self.scene.geometry.directions(held);
            let mut a = rate.rows_mut(n, n);
            let own = |i: usize| self.stop_motion(held[i], t)[2];
            let pressed = DVector::from_fn(held.len(), |i, _| normals[i].dot(&a) - own(i));
            a -= along_reactions(&normals, &reactions, &pressed)?;
        }
        Ok(rate)
    }

    fn impact(
        &self,
        stops: &[usize],
        t: f64,
        state: &mut DVector<f64>,
        deviations: &mut DMatrix<f64>,
    ) -> Result<Vec<f64>> {
        if stops.is_empty() {
            return Ok(Vec::new());
        }
        let (n, g) = (state.len() / 2, &self.scene.geometry);
        let (normals, reactions) = g.columns(stops);
        let impulse_matrix = impulse_matrix(g, stops)?;
        let mut approach = normals.tr_mul(&state.rows(n, n));
        for (approach, &stop) in approach.iter_mut().zip(stops) {
            *approach -= self.stop_motion(stop, t)[1];
        }
        let impulses = &impulse_matrix * approach;
        let mut v = state.rows_mut(n, n);
        v -= &reactions * &impulses;
        if deviations.ncols() > 0 {
            let mut dv = deviations.rows_mut(n, n);
            let change = reactions * (impulse_matrix * normals.tr_mul(&dv));
            dv -= change;
        }
        Ok(impulses.iter().copied().collect())
    }

    fn kick(&self, stops: &[usize], _: &DVector<f64>, s: DVector<f64>) -> Result<DVector<f64>> {
        let g = &self.scene.geometry;
        Ok(g.reactions.select_columns(stops) * (impulse_matrix(g, stops)? * s))
    }

    fn stop_motion(&self, stop: usize, t: f64) -> [f64; 3] {
        self.scene.stop_motion(stop, self.moment(t))
    }

    fn gap(&self, stop: usize, t: f64, state: &DVector<f64>) -> Result<GapAt> {
        let normal = self.scene.geometry.normals.column(stop).into_owned();
        let [moved, slope, _] = self.stop_motion(stop, t);
        let clearance = self.scene.geometry.clearances[stop] + moved;
        Ok(GapAt {
            gap: clearance - normal.dot(&state.rows(0, normal.len())),
            gradient: -normal,
            slope,
        })
    }

    fn gap_acceleration(
        &self,
        stop: usize,
        t: f64,
        state: &DVector<f64>,
        rate: &DVector<f64>,
    ) -> Result<f64> {
        let n = state.len() / 2;
        let normal = self.scene.geometry.normals.column(stop);
        Ok(self.stop_motion(stop, t)[2] - normal.dot(&rate.rows(n, n)))
    }

    fn reaction(&self, stop: usize, _state: &DVector<f64>) -> Result<DVector<f64>> {
        Ok(self.scene.geometry.reactions.column(stop).into_owned())
    }

    fn law(&self, stop: usize) -> Newton {
        self.scene.geometry.law(stop)
    }

    fn contact_law(&self, element: usize) -> &Law {
        &self.scene.geometry.laws[element]
    }
}
