//! The locator of zeros next to a branch point, where the corrector fails: by the polynomial through points of the branch on both sides, at
//! Chebyshev's nodes (theory 19). For folds and doublings it is a fallback. Lengths are arclengths.

use crate::branch::parametric_loop::{BranchDirection, ParametricLoop};
use crate::branch::predictor::{AcceptedPoint, StepTarget, step_to};
use crate::branch::problem::BranchProblem;
use crate::branch::zero_problem::CorrectedPoint;
use crate::continuation::{LocatedZero, ScaledDirection};
use crate::error::Result;
use crate::orbit::ShootingState;
use crate::root::{Bracket, bisected};
use crate::tolerance::{INTERPOLATED_ZERO_ERROR, INTERPOLATION_REACH};
use nalgebra::DVector;
use std::convert::Infallible;
use std::f64::consts::PI;

/// Points that a zero is interpolated between, an even number, so that none is in the middle, where Newton's method does not converge.
/// `[work]`
const CROSSING_NODES: usize = 8;
/// Times that points are taken, each time from half as far. `[work]`
const MOST_REACH_HALVINGS: usize = 3;

/// A point of the branch, its arclength along a step, and the value of the test function.
struct InterpolationNode {
    along: f64,
    number: f64,
    settled: CorrectedPoint,
}

/// The zero of a test function near an arclength on a step, with the difference to the zero by two nodes less as its error; none where the
/// nodes do not have it between them.
pub(super) fn locate_by_interpolation(
    problem: &BranchProblem<'_>,
    from: &AcceptedPoint,
    near: f64,
    number: &dyn Fn(&CorrectedPoint) -> Result<f64>,
) -> Result<Option<LocatedZero<CorrectedPoint>>> {
    let mut reach = INTERPOLATION_REACH;
    let mut best: Option<LocatedZero<CorrectedPoint>> = None;
    for _ in 0..MOST_REACH_HALVINGS {
        if let Some(nodes) = nodes(problem, from, (near, reach), number)? {
            let found = interpolated(problem, &nodes)?;
            let is_known = found.error <= INTERPOLATED_ZERO_ERROR * problem.span();
            if best.as_ref().is_none_or(|best| found.error < best.error) {
                best = Some(found);
            }
            if is_known {
                break;
            }
        }
        reach *= 0.5;
    }
    Ok(best)
}

/// Points at Chebyshev's nodes about an arclength; none where the corrector fails at one, or the test function does not change its sign
/// exactly once.
fn nodes(
    problem: &BranchProblem<'_>,
    from: &AcceptedPoint,
    (near, reach): (f64, f64),
    number: &dyn Fn(&CorrectedPoint) -> Result<f64>,
) -> Result<Option<Vec<InterpolationNode>>> {
    let mut nodes = Vec::with_capacity(CROSSING_NODES);
    for k in 0..CROSSING_NODES {
        let along = near - reach * (PI * (k as f64 + 0.5) / CROSSING_NODES as f64).cos();
        let Ok(settled) = step_to(problem, from.base(), StepTarget::Length(along))? else {
            return Ok(None);
        };
        let number = number(&settled)?;
        nodes.push(InterpolationNode {
            along,
            number,
            settled,
        });
    }
    let changes = nodes
        .windows(2)
        .filter(|pair| pair[0].number * pair[1].number <= 0.0);
    let is_between = nodes[0].number * nodes[CROSSING_NODES - 1].number < 0.0;
    Ok((is_between && changes.count() == 1).then_some(nodes))
}

/// Lagrange's weights: those of the values at some abscissae in the polynomial through them, at another.
fn weights(places: &[f64], at: f64) -> Vec<f64> {
    let weight = |k: usize| {
        let others = places.iter().enumerate().filter(|(j, _)| *j != k);
        others.map(|(_, x)| (at - x) / (places[k] - x)).product()
    };
    (0..places.len()).map(weight).collect()
}

/// The zero of the polynomial through the values of some nodes, and their weights there.
fn zero_of(nodes: &[InterpolationNode]) -> (f64, Vec<f64>) {
    let places: Vec<f64> = nodes.iter().map(|node| node.along).collect();
    let number = |at: f64| -> f64 {
        let each = nodes.iter().zip(weights(&places, at));
        each.map(|(node, weight)| node.number * weight).sum()
    };
    let between = Bracket::new([places[0], places[places.len() - 1]]);
    let is_rising = nodes[0].number < 0.0;
    let Ok(found) = bisected(between, 0.0, |at| {
        Ok::<_, Infallible>((number(at) < 0.0) == is_rising)
    });
    let zero = found.middle();
    (zero, weights(&places, zero))
}

fn interpolated(
    problem: &BranchProblem<'_>,
    nodes: &[InterpolationNode],
) -> Result<LocatedZero<CorrectedPoint>> {
    let (along, weights) = zero_of(nodes);
    let value = value_of(nodes, &weights);
    let fewer = &nodes[1..CROSSING_NODES - 1];
    let error = (value_of(fewer, &zero_of(fewer).1) - value).abs();
    let of = |part: &dyn Fn(&CorrectedPoint) -> DVector<f64>| -> DVector<f64> {
        let each = nodes.iter().zip(&weights);
        let mut parts = each.map(|(node, weight)| part(&node.settled) * *weight);
        let first = parts.next().unwrap_or_default();
        parts.fold(first, |sum, part| sum + part)
    };
    let times = |part: fn(&ShootingState) -> &Vec<f64>| {
        let all = of(&|own| DVector::from_column_slice(part(&own.iterate.state)));
        all.as_slice().to_vec()
    };
    let count = nodes[0].settled.iterate.state.states.len();
    let state = ShootingState {
        times: times(|state| &state.times),
        starts: times(|state| &state.starts),
        states: (0..count)
            .map(|k| of(&|own| own.iterate.state.states[k].clone()))
            .collect(),
    };
    let place: ParametricLoop = problem.place(&*problem.scene(value)?, value, state)?;
    let tangent = BranchDirection::of(&of(&|own| own.tangent.numbers()));
    Ok(LocatedZero {
        point: CorrectedPoint {
            equations: problem.equations(&place)?,
            tangent: tangent.unit(),
            contraction: 0.0,
            iterate: place,
        },
        along,
        error,
    })
}

/// The parameter of the nodes, interpolated by some weights.
fn value_of(nodes: &[InterpolationNode], weights: &[f64]) -> f64 {
    let each = nodes.iter().zip(weights);
    each.map(|(node, weight)| node.settled.iterate.value * weight)
        .sum()
}
