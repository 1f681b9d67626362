//! The free motion of an integrated scene, while no stop is held: in steps (`steps.rs`) or along Taylor series (`series.rs`).

use super::scene::Integrated;
use crate::error::Result;
use crate::flow::steps::{State, Stepper};
use crate::hybrid::flow::Arrival;
use crate::hybrid::recorder::Recorder;
use crate::model::Dynamics;
use crate::observer::Observer;

/// A way to move a scene while no stop is held.
pub(crate) trait FreeFlight<S: State, D: Dynamics> {
    /// The method of the steps with stops held.
    type Steps: Stepper<S>;

    /// The choice within that method.
    fn choice(&self) -> <Self::Steps as Stepper<S>>::Choice;

    /// Forgets the run before.
    fn reset(&mut self);

    /// A flight, as [`crate::hybrid::HybridFlow::advance_to_event`].
    fn advance(
        &mut self,
        system: &mut Integrated<'_, S, D, Self::Steps>,
        orders: &[usize],
        ends: (f64, f64),
        recorder: &mut dyn Recorder,
        observer: &mut Observer,
    ) -> Result<Arrival>;

    /// Records an arc of no length at the present state; `last` is the time at which the run ends with it.
    fn record_instant(
        &mut self,
        system: &mut Integrated<'_, S, D, Self::Steps>,
        last: Option<f64>,
        recorder: &mut dyn Recorder,
    ) -> Result<()>;
}
