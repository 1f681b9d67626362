//! A state put onto the stops that it lies behind: where a stop was moved over it.

use crate::error::Result;
use crate::model::{PhysicalState, Scene};
use crate::path::Evaluator;
use crate::simulate::by_method::{RunMaker, RunVisitor, visit_runs};
use crate::simulate::options::SimulateOptions;

/// The state at a time, moved along the reactions of the stops that it lies behind onto them; as it is, where it lies behind none.
///
/// # Errors
/// What the gap functions of nonlinear stops report; stops that cannot be reached together.
pub(crate) fn put_onto(
    scene: &Scene,
    state: PhysicalState,
    t: f64,
    options: &SimulateOptions,
) -> Result<PhysicalState> {
    if scene.gaps_at(&state.0, t)?.iter().all(|gap| *gap >= 0.0) {
        return Ok(state);
    }
    visit_runs(scene, options, OntoStops { state, t })
}

struct OntoStops {
    state: PhysicalState,
    t: f64,
}

impl RunVisitor for OntoStops {
    type Output = PhysicalState;

    const BY_EXACT_FLIGHTS: &'static str = "a state put onto stops with method=\"exact\"";

    fn visit(self, make: &RunMaker<'_, '_>, _: Evaluator) -> Result<PhysicalState> {
        let (q, v) = self.state;
        make().flow.onto_stops((&q, &v, self.t))
    }
}
