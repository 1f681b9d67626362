//! Deviations from a motion that is integrated: by the variational equations, to the tolerance of the run.

use crate::error::Result;
use crate::exponents::tangents::Tangents;
use crate::flow::characteristic_length::{StepLengths, Tolerances, part_of};
use crate::flow::differences::WarningLog;
use crate::flow::steps::Tolerance;
use crate::hybrid::{IntegratedMaps, across_free_impact, joined};
use crate::law::Regime;
use crate::model::Scene;
use crate::path::{Evaluator, Path};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;
use std::sync::Arc;

/// The state where the motion is.
pub(crate) struct IntegratedTangents {
    maps: IntegratedMaps,
    doubts: Arc<WarningLog>,
    tolerance: Tolerance,
    state: DVector<f64>,
}

impl IntegratedTangents {
    /// Those of a scene from a start, to the tolerances of the run.
    pub fn new(
        scene: &Scene,
        tolerances: Tolerances,
        (q0, v0): (&DVector<f64>, &DVector<f64>),
    ) -> Self {
        let usual = || {
            let lengths = StepLengths::new(scene);
            let shortest = lengths.shortest((q0.as_slice(), v0.as_slice()), Vec::new);
            part_of(shortest.unwrap_or(0.0))
        };
        let tolerance = Tolerance {
            relative: tolerances.relative,
            absolute: tolerances.absolute.unwrap_or_else(usual),
        };
        let (maps, doubts) = IntegratedMaps::new(scene, scene.phase()).watched();
        Self {
            maps,
            doubts,
            tolerance,
            state: DVector::zeros(2 * scene.n_dof()),
        }
    }
}

impl Tangents for IntegratedTangents {
    type Maps = IntegratedMaps;
    type State = DVector<f64>;

    fn maps(&self) -> &IntegratedMaps {
        &self.maps
    }

    fn doubt_since(&self, time: f64) -> Option<String> {
        let [_, last] = self.doubts.noted()?;
        (last.time() >= time).then(|| last.reason())
    }

    fn state(&mut self) -> &mut DVector<f64> {
        &mut self.state
    }

    fn begin(&mut self, (q, v): (&DVector<f64>, &DVector<f64>)) {
        self.state = joined(&(q.clone(), v.clone()));
    }

    fn take_regimes(&mut self, _evaluator: &Evaluator) {}

    /// All: the equations are integrated by steps of their own.
    fn spans(arcs: Range<usize>) -> impl Iterator<Item = Range<usize>> {
        std::iter::once(arcs)
    }

    fn read(&mut self, path: &Path, arc: usize) {
        self.state = joined(&path.state_in(arc, 0.0));
    }

    /// The run knows its impacts to its tolerance.
    fn arrive(&mut self, path: &Path, arc: usize) {
        self.state = joined(&path.state_in(arc, path.arc(arc).span));
    }

    fn fly(
        &mut self,
        regime: &Regime,
        span: (f64, f64),
        deviations: &mut DMatrix<f64>,
    ) -> Result<()> {
        self.maps
            .flow_to(self.tolerance, regime, span, &mut self.state, deviations)
    }

    fn strike(&mut self, stop: usize, time: f64, deviations: &mut DMatrix<f64>) -> Result<()> {
        across_free_impact(&self.maps, (stop, time), &mut self.state, deviations)
    }

    fn physically<R>(
        &mut self,
        deviations: &mut DMatrix<f64>,
        work: impl FnOnce(&IntegratedMaps, &mut DVector<f64>, &mut DMatrix<f64>) -> Result<R>,
    ) -> Result<R> {
        work(&self.maps, &mut self.state, deviations)
    }
}
