//! Differences by a number of a scene: central ones, of one side where the scene refuses the other.

use crate::error::{Error, Result};
use crate::model::Scene;
use std::ops::Range;

/// The scenes at the nodes of a difference, the offset of each from the number, and its weight in the derivative.
pub(super) struct Stencil {
    pub nodes: Vec<StencilNode>,
    /// The distance of the nodes.
    pub step: f64,
}

/// One of them.
pub(super) struct StencilNode {
    pub scene: Scene,
    pub offset: f64,
    pub weight: f64,
    /// Its weight in the difference between this derivative and that of lower order.
    beyond: f64,
}

/// A derivative of a list of numbers by differences.
pub(super) struct DifferenceQuotient {
    /// The derivatives, shape (numbers,), [units of the numbers] per unit of the parameter.
    pub derivative: Vec<f64>,
    /// What a difference of lower order on the same nodes lacks to them, shape (numbers,), [same units]; zero at second order.
    pub beyond: Vec<f64>,
}

/// The order of central differences.
#[derive(Debug, Clone, Copy)]
pub(super) enum DifferenceOrder {
    Second,
    Fourth,
}

/// Offsets in steps of central differences of second order, and their weights over the step. [exact]
const SECOND: &[(f64, f64)] = &[(-1.0, -0.5), (1.0, 0.5)];
/// The same of one side, of second order too. [exact]
const AHEAD: &[(f64, f64)] = &[(0.0, -1.5), (1.0, 2.0), (2.0, -0.5)];
/// Central differences of fourth order. [exact]
const FOURTH: &[(f64, f64)] = &[
    (-2.0, 1.0 / 12.0),
    (-1.0, -2.0 / 3.0),
    (1.0, 2.0 / 3.0),
    (2.0, -1.0 / 12.0),
];
/// Those of one side of fourth order. [exact]
const FOURTH_AHEAD: &[(f64, f64)] = &[
    (0.0, -25.0 / 12.0),
    (1.0, 4.0),
    (2.0, -3.0),
    (3.0, 4.0 / 3.0),
    (4.0, -0.25),
];
/// Weights of the difference between a central derivative of fourth order and that of second on the same nodes. [exact]
const FOURTH_BEYOND: &[f64] = &[1.0 / 12.0, -1.0 / 6.0, 1.0 / 6.0, -1.0 / 12.0];
/// The same of one side. [exact]
const AHEAD_BEYOND: &[f64] = &[-7.0 / 12.0, 2.0, -2.5, 4.0 / 3.0, -0.25];

impl Stencil {
    /// The scenes about a number, each made of an offset from it; the step becomes a power of two, which moves the number exactly.
    ///
    /// # Errors
    /// Scenes that are refused on both sides; what else making them reports.
    pub fn new(
        make: &dyn Fn(f64) -> Result<Scene>,
        step: f64,
        order: DifferenceOrder,
    ) -> Result<Self> {
        let step = step.log2().round().exp2();
        let on = |stencil: &[(f64, f64)], beyond: &[f64], step: f64| -> Result<Self> {
            let mut beyond = beyond.iter().copied();
            let node = |&(steps, weight): &(f64, f64)| {
                let offset = steps * step;
                Ok(StencilNode {
                    scene: make(offset)?,
                    offset,
                    weight: weight / step,
                    beyond: beyond.next().unwrap_or(0.0) / step,
                })
            };
            let nodes = stencil.iter().map(node).collect::<Result<_>>()?;
            Ok(Self {
                nodes,
                step: step.abs(),
            })
        };
        let ((central, beyond), (ahead, ahead_beyond)) = match order {
            DifferenceOrder::Second => ((SECOND, &[][..]), (AHEAD, &[][..])),
            DifferenceOrder::Fourth => ((FOURTH, FOURTH_BEYOND), (FOURTH_AHEAD, AHEAD_BEYOND)),
        };
        let mut found = on(central, beyond, step);
        for step in [step, -step] {
            if matches!(found, Err(Error::BadValue { .. })) {
                found = on(ahead, ahead_beyond, step);
            }
        }
        found
    }

    /// The derivative of a list of numbers that each node has; `None` where they have not as many.
    pub fn derivative(
        &self,
        at: impl Fn(&StencilNode) -> Result<Vec<f64>>,
    ) -> Result<Option<Vec<f64>>> {
        Ok(self.differences(at)?.map(|found| found.derivative))
    }

    /// The same beside how far it is from a difference of lower order.
    pub fn differences(
        &self,
        at: impl Fn(&StencilNode) -> Result<Vec<f64>>,
    ) -> Result<Option<DifferenceQuotient>> {
        let mut found: Option<DifferenceQuotient> = None;
        let mut first = Vec::new();
        for node in &self.nodes {
            let values = at(node)?;
            let own = found.get_or_insert_with(|| {
                first.clone_from(&values);
                DifferenceQuotient::none(values.len())
            });
            if own.derivative.len() != values.len() {
                return Ok(None);
            }
            // Weights have the sum zero: what is the same at all nodes has no rounding.
            for (i, (value, first)) in values.iter().zip(&first).enumerate() {
                own.derivative[i] += node.weight * (value - first);
                own.beyond[i] += node.beyond * (value - first);
            }
        }
        Ok(found)
    }
}

impl DifferenceQuotient {
    fn none(len: usize) -> Self {
        Self {
            derivative: vec![0.0; len],
            beyond: vec![0.0; len],
        }
    }

    /// The largest of some of them, and by how much they differ from those of lower order.
    pub fn largest(&self, own: Range<usize>) -> (f64, f64) {
        let amax = |x: &[f64]| x.iter().fold(0.0f64, |size, x| size.max(x.abs()));
        (amax(&self.derivative[own.clone()]), amax(&self.beyond[own]))
    }
}
