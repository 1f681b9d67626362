#![cfg(test)]
//! The worked example of `docs/extending.md`: an explicit method from scratch, the pair of Bogacki and Shampine of orders 3 and 2 (Appl.
//! Math. Lett. 2 (1989) 321) with the cubic through both ends as its dense output.

use crate::flow::steps::control::StepControl;
use crate::flow::steps::explicit_rk::{ButcherTableau, EmbeddedError, ExplicitRk};

/// The tableau of the pair.
#[derive(Debug)]
pub(crate) struct BogackiShampineTableau;

/// The pair, with the step last taken.
pub(crate) type BogackiShampine<S> = ExplicitRk<BogackiShampineTableau, S, 4, 3>;

impl ButcherTableau for BogackiShampineTableau {
    const NODES: &'static [f64] = &[0.5, 0.75, 1.0];
    const ROWS: &'static [&'static [f64]] =
        &[&[0.5], &[0.0, 0.75], &[2.0 / 9.0, 1.0 / 3.0, 4.0 / 9.0]];
    /// The last stage of the solution. [exact]
    const END: usize = 3;
    // The solution of order 3 less that of order 2.
    const ERROR: EmbeddedError =
        EmbeddedError::One(&[-5.0 / 72.0, 1.0 / 12.0, 1.0 / 9.0, -1.0 / 8.0]);
    const DENSE: &'static [&'static [f64]] = &[];
    const HAS_QUINTIC: bool = true;
    const CONTROL: StepControl = StepControl {
        order: 3,
        beta: 0.04,
        least: 0.2,
        most: 10.0,
        kept_below: 1.0,
    };
    /// The last two stages are at two times. [exact]
    const STABLE: f64 = f64::INFINITY;
}
