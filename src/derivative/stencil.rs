//! Differences by a number of a scene: central ones, of one side where the scene refuses the other.

use crate::error::{Error, Result};
use crate::model::Scene;
use nalgebra::DVector;

/// The scenes at the nodes of a difference, the offset of each from the number, and its weight in the derivative.
pub(super) struct Stencil {
    pub nodes: Vec<Node>,
}

/// One of them.
pub(super) struct Node {
    pub scene: Scene,
    pub offset: f64,
    pub weight: f64,
}

/// The order of central differences.
#[derive(Debug, Clone, Copy)]
pub(super) enum Order {
    Second,
    Fourth,
}

/// Offsets in steps and weights over them; those of one side are of second order.
const SECOND: &[(f64, f64)] = &[(-1.0, -0.5), (1.0, 0.5)];
const FOURTH: &[(f64, f64)] = &[
    (-2.0, 1.0 / 12.0),
    (-1.0, -2.0 / 3.0),
    (1.0, 2.0 / 3.0),
    (2.0, -1.0 / 12.0),
];
const AHEAD: &[(f64, f64)] = &[(0.0, -1.5), (1.0, 2.0), (2.0, -0.5)];
const BACK: &[(f64, f64)] = &[(0.0, 1.5), (-1.0, -2.0), (-2.0, 0.5)];

impl Stencil {
    /// The scenes about a number, each made of an offset from it; the step becomes a power of two, which moves the number exactly.
    ///
    /// # Errors
    /// Scenes that are refused on both sides; what else making them reports.
    pub fn new(make: &dyn Fn(f64) -> Result<Scene>, step: f64, order: Order) -> Result<Self> {
        let step = step.log2().round().exp2();
        let on = |stencil: &[(f64, f64)]| -> Result<Self> {
            let node = |&(steps, weight): &(f64, f64)| {
                let offset = steps * step;
                let (scene, weight) = (make(offset)?, weight / step);
                Ok(Node {
                    scene,
                    offset,
                    weight,
                })
            };
            let nodes = stencil.iter().map(node).collect::<Result<_>>()?;
            Ok(Self { nodes })
        };
        let mut found = on(match order {
            Order::Second => SECOND,
            Order::Fourth => FOURTH,
        });
        for stencil in [AHEAD, BACK] {
            if matches!(found, Err(Error::BadValue { .. })) {
                found = on(stencil);
            }
        }
        found
    }

    /// The derivative of a list of numbers that each node has; `None` where they have not as many.
    pub fn derivative(&self, at: impl Fn(&Node) -> Result<Vec<f64>>) -> Result<Option<Vec<f64>>> {
        let mut sum: Option<DVector<f64>> = None;
        for node in &self.nodes {
            let values = DVector::from_vec(at(node)?) * node.weight;
            sum = match sum {
                None => Some(values),
                Some(sum) if sum.len() == values.len() => Some(sum + values),
                Some(_) => return Ok(None),
            };
        }
        Ok(sum.map(|sum| sum.as_slice().to_vec()))
    }
}
