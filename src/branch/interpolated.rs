//! Where a smooth number of a branch is zero at a point to which Newton's method does not come, as another branch crosses there: by
//! interpolation between points on both sides (theory 19).

use crate::branch::corrector::Settled;
use crate::branch::family::Family;
use crate::branch::place::{Direction, Place};
use crate::branch::step::{Point, Target, step_to};
use crate::branch::zero::Zero;
use crate::error::Result;
use crate::orbit::ShootingState;
use nalgebra::DVector;
use std::f64::consts::PI;

/// How many points, none of them in the middle.
const NODES: usize = 8;
/// How far the farthest are at the most, in arclength, and how often half as far where they do not lie on both sides, or say less than what is
/// known well.
const REACH: f64 = 0.015;
const MOST_HALVINGS: usize = 3;
const KNOWN: f64 = 1e-11;
/// Bisections of the polynomial: to the last digit.
const BISECTIONS: usize = 60;

/// A point, its number, and how far along a step it is.
struct Node {
    along: f64,
    number: f64,
    settled: Settled,
}

/// The zero of a number of a branch near a place on a step from a point, known by what two points less make of it; none where the points beside
/// do not have it between them.
pub(super) fn zero_through(
    family: &Family<'_>,
    from: &Point,
    near: f64,
    number: &dyn Fn(&Settled) -> Result<f64>,
) -> Result<Option<Zero<Settled>>> {
    let mut reach = REACH;
    let mut best: Option<Zero<Settled>> = None;
    for _ in 0..MOST_HALVINGS {
        if let Some(nodes) = nodes(family, from, (near, reach), number)? {
            let found = interpolated(family, &nodes)?;
            let is_known = found.error <= KNOWN * family.span();
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

/// Points at the zeros of Chebyshev's polynomial about a place; none where one of them is missed, or the numbers do not change their sign once.
fn nodes(
    family: &Family<'_>,
    from: &Point,
    (near, reach): (f64, f64),
    number: &dyn Fn(&Settled) -> Result<f64>,
) -> Result<Option<Vec<Node>>> {
    let mut nodes = Vec::with_capacity(NODES);
    for k in 0..NODES {
        let along = near - reach * (PI * (k as f64 + 0.5) / NODES as f64).cos();
        let Ok(settled) = step_to(family, from.foot(), Target::Length(along))? else {
            return Ok(None);
        };
        let number = number(&settled)?;
        nodes.push(Node {
            along,
            number,
            settled,
        });
    }
    let changes = nodes
        .windows(2)
        .filter(|pair| pair[0].number * pair[1].number <= 0.0);
    let is_between = nodes[0].number * nodes[NODES - 1].number < 0.0;
    Ok((is_between && changes.count() == 1).then_some(nodes))
}

/// The weights with which the values at some places make that at another.
fn weights(places: &[f64], at: f64) -> Vec<f64> {
    let weight = |k: usize| {
        let others = places.iter().enumerate().filter(|(j, _)| *j != k);
        others.map(|(_, x)| (at - x) / (places[k] - x)).product()
    };
    (0..places.len()).map(weight).collect()
}

/// Where the polynomial through the numbers of some nodes is zero, and their weights there.
fn zero_of(nodes: &[Node]) -> (f64, Vec<f64>) {
    let places: Vec<f64> = nodes.iter().map(|node| node.along).collect();
    let number = |at: f64| -> f64 {
        let each = nodes.iter().zip(weights(&places, at));
        each.map(|(node, weight)| node.number * weight).sum()
    };
    let (mut low, mut high) = (places[0], places[places.len() - 1]);
    let is_rising = nodes[0].number < 0.0;
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if (number(middle) < 0.0) == is_rising {
            low = middle;
        } else {
            high = middle;
        }
    }
    let zero = 0.5 * (low + high);
    (zero, weights(&places, zero))
}

fn interpolated(family: &Family<'_>, nodes: &[Node]) -> Result<Zero<Settled>> {
    let (along, weights) = zero_of(nodes);
    let value = value_of(nodes, &weights);
    let fewer = &nodes[1..NODES - 1];
    let error = (value_of(fewer, &zero_of(fewer).1) - value).abs();
    let of = |part: &dyn Fn(&Settled) -> DVector<f64>| -> DVector<f64> {
        let each = nodes.iter().zip(&weights);
        let mut parts = each.map(|(node, weight)| part(&node.settled) * *weight);
        let first = parts.next().unwrap_or_default();
        parts.fold(first, |sum, part| sum + part)
    };
    let times = |part: fn(&ShootingState) -> &Vec<f64>| {
        let all = of(&|own| DVector::from_column_slice(part(&own.place.state)));
        all.as_slice().to_vec()
    };
    let count = nodes[0].settled.place.state.states.len();
    let state = ShootingState {
        times: times(|state| &state.times),
        starts: times(|state| &state.starts),
        states: (0..count)
            .map(|k| of(&|own| own.place.state.states[k].clone()))
            .collect(),
    };
    let place: Place = family.place(&*family.scene(value)?, value, state)?;
    let tangent = Direction::of(&of(&|own| own.tangent.numbers()));
    Ok(Zero {
        point: Settled {
            equations: family.equations(&place)?,
            tangent: tangent.scaled(1.0 / tangent.length()),
            contraction: 0.0,
            place,
        },
        along,
        error,
    })
}

/// The parameter that some weights make.
fn value_of(nodes: &[Node], weights: &[f64]) -> f64 {
    let each = nodes.iter().zip(weights);
    each.map(|(node, weight)| node.settled.place.value * weight)
        .sum()
}
