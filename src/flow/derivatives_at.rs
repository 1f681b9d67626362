//! A quantity of a linear motion where it is, with its derivatives and what rounding leaves unknown of each.

use crate::flow::gap_row::Quantity;
use crate::flow::linear::LinearFlow;
use crate::modal::ModalState;
use crate::model::Moment;
use crate::tolerance::GAP_ROUNDING;

/// A quantity and its first three time derivatives, each with what rounding leaves unknown of it.
pub(crate) type GuardDerivatives = [[f64; 2]; 4];

/// A quantity of a motion at a moment.
#[derive(Debug, Clone, Copy)]
pub(crate) struct QuantityDerivatives {
    pub derivatives: GuardDerivatives,
    /// The size of the terms of the second derivative, and what the forcing's part leaves unknown of it.
    pub bend_size: f64,
    pub bend_lost: f64,
}

/// A quantity of a motion in a state at a moment.
pub(crate) fn derivatives_at<F: LinearFlow>(
    flow: &F,
    quantity: &Quantity,
    (state, at): (&ModalState, Moment),
) -> QuantityDerivatives {
    let (mut entered, mut derivatives) = (Vec::new(), Vec::new());
    flow.state_from_modal(state, at, &mut entered);
    flow.derivatives(&entered, &mut derivatives);
    let row = flow.gap_row(quantity);
    let model = row.model(&derivatives);
    let [c0, c1, c2, c3] = model.c;
    let bend_size = row.acceleration_size(&derivatives, flow.fastest_rate());
    let bend_lost = row.acceleration_lost(&derivatives);
    let derivatives = [
        [c0, row.rounding(&model)],
        [c1, GAP_ROUNDING * row.speed_size(&derivatives)],
        [2.0 * c2, GAP_ROUNDING * bend_size],
        [6.0 * c3, GAP_ROUNDING * row.jerk_size(&derivatives)],
    ];
    QuantityDerivatives {
        derivatives,
        bend_size,
        bend_lost,
    }
}
