//! Transport of deviations along a known motion, in coordinates of its own (modal or physical).

use crate::error::Result;
use crate::hybrid::HybridMaps;
use crate::law::Regime;
use crate::path::{Evaluator, Path};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// A motion, where it is, with what deviations from it become.
pub(crate) trait Tangents {
    /// The maps of its instants, in (q, v).
    type Maps: HybridMaps;
    /// The type of its state.
    type State: Clone;

    fn maps(&self) -> &Self::Maps;
    /// Why deviations since a time are not to be trusted, if they are not.
    fn doubt_since(&self, _time: f64) -> Option<String> {
        None
    }
    /// The state where it is.
    fn state(&mut self) -> &mut Self::State;

    /// Is where the motion begins, before any impact there.
    fn begin(&mut self, start: (&DVector<f64>, &DVector<f64>));
    /// Takes over the motions in regimes of an evaluator.
    fn take_regimes(&mut self, evaluator: &Evaluator);
    /// The arcs of a segment, in spans over which the motion goes on by itself from where it begins.
    fn spans(arcs: Range<usize>) -> impl Iterator<Item = Range<usize>>;
    /// Goes to the beginning of an arc of a path.
    fn read(&mut self, path: &Path, arc: usize);
    /// Is at the end of an arc of a path, to which it has flown.
    fn arrive(&mut self, path: &Path, arc: usize);
    /// Goes on over a span of time in a regime.
    fn fly(
        &mut self,
        regime: &Regime,
        span: (f64, f64),
        deviations: &mut DMatrix<f64>,
    ) -> Result<()>;
    /// The impact on one stop while none is held.
    fn strike(&mut self, stop: usize, time: f64, deviations: &mut DMatrix<f64>) -> Result<()>;
    /// Does something to the state and to deviations from it as position and velocity.
    fn physically<R>(
        &mut self,
        deviations: &mut DMatrix<f64>,
        work: impl FnOnce(&Self::Maps, &mut DVector<f64>, &mut DMatrix<f64>) -> Result<R>,
    ) -> Result<R>;
}
