//! The orbits of a branch at a value of its parameter: each is followed to it from the point beside it.

use crate::branch::continuation_parameter::ContinuationParameter;
use crate::branch::options::{ContinuationOptions, Heading, Virtual};
use crate::branch::result::Branch;
use crate::continuation::EndReason;
use crate::error::{Error, Result};
use crate::orbit::PeriodicOrbit;
use crate::quantity::finite;
use std::borrow::Cow;

/// The smallest, the first and the longest step of the way from a point to a value beside it, in arclength. [work]
const STEPS_TO_VALUE: [f64; 3] = [1e-12, 0.1, 0.5];
/// Points of such a way: of one that begins at a boundary there may be many. [work]
const MOST_POINTS_TO_VALUE: [usize; 2] = [100, 10_000];

/// A point of a branch, or a fold or a touch between two of them: from one of these to the next the parameter goes one way.
#[derive(Clone, Copy)]
pub(crate) struct BranchNode<'a> {
    pub arclength: f64,
    pub parameter: f64,
    pub orbit: &'a PeriodicOrbit,
    pub is_fold: bool,
    /// Whether orbits on the other side have other numbers or contacts: at a fold and a touch, and where a doubled branch ends.
    pub turns: bool,
}

/// The points, an orbit each, and the folds between them in their order; and whether the ends are those of a doubled branch.
pub(crate) fn nodes<'a>(
    points: impl ExactSizeIterator<Item = (f64, f64, &'a PeriodicOrbit)>,
    folds: impl Iterator<Item = (f64, f64, &'a PeriodicOrbit)>,
    is_doubled: [bool; 2],
) -> Vec<BranchNode<'a>> {
    let last = points.len().saturating_sub(1);
    let node = |(arclength, parameter, orbit), is_fold, turns| BranchNode {
        arclength,
        parameter,
        orbit,
        is_fold,
        turns,
    };
    let at_end = |k: usize| is_doubled[0] && k == 0 || is_doubled[1] && k == last;
    let points = points
        .enumerate()
        .map(|(k, own)| node(own, false, at_end(k)));
    let mut found: Vec<_> = points.collect();
    found.extend(folds.map(|own| node(own, true, true)));
    found.sort_by(|a, b| a.arclength.total_cmp(&b.arclength));
    found
}

impl Branch {
    /// Its points, and the folds between them, in their order.
    pub(super) fn nodes(&self) -> Vec<BranchNode<'_>> {
        let points =
            (0..self.orbits.len()).map(|k| (self.arclength[k], self.parameter[k], &self.orbits[k]));
        let folds = self.special.iter();
        let folds = folds.filter(|own| own.kind.divides());
        let folds = folds.map(|own| (own.arclength, own.parameter, &own.orbit));
        let is_doubled = |end: usize| self.ends[end].reason == EndReason::Doubling;
        nodes(points, folds, [0, 1].map(is_doubled))
    }

    /// Every orbit that the branch has at a value of its parameter, one for each of its points or passages, in their order: each is
    /// followed to the value from the point beside it.
    ///
    /// # Errors
    /// A value that is not finite; what makes scenes says; `Error::NotReached` of a value to which the branch is not followed from the
    /// points beside it.
    ///
    /// # Examples
    /// ```
    /// use vibroimpact::nalgebra::{dmatrix, dvector};
    /// use vibroimpact::{ContinuationOptions, ContinuationParameter, OrbitOptions, Parameter, Pattern};
    /// use vibroimpact::{Harmonic, LinearSystem, Scene, Stop, continuation, periodic_orbits};
    /// let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0])?;
    /// let force = Harmonic::new(dvector![8.5.into()], 2.4, 0.0)?;
    /// let scene = Scene::new(system, force, [Stop::new(0, 1.0, 0.8)?])?;
    /// let orbits = periodic_orbits(&scene, &Pattern::single(0), &OrbitOptions::default())?;
    /// let options = ContinuationOptions::default();
    /// let branch = continuation(&orbits[0], Parameter::ForcingScale, (0.8, 1.2), &options)?;
    /// let there = branch.at(ContinuationParameter::Number(Parameter::ForcingScale), 0.9)?;
    /// assert_eq!(there.len(), 1);
    /// # Ok::<(), vibroimpact::Error>(())
    /// ```
    pub fn at(
        &self,
        parameter: ContinuationParameter<'_>,
        value: f64,
    ) -> Result<Vec<PeriodicOrbit>> {
        let found = orbits_at(&self.nodes(), parameter, value)?;
        Ok(found.into_iter().map(Cow::into_owned).collect())
    }
}

/// Every orbit that a branch has at a value; that of a node as it is.
pub(crate) fn orbits_at<'a>(
    nodes: &[BranchNode<'a>],
    parameter: ContinuationParameter<'_>,
    value: f64,
) -> Result<Vec<Cow<'a, PeriodicOrbit>>> {
    finite("value", value)?;
    let first = nodes.first().filter(|node| node.parameter == value);
    let mut found: Vec<_> = first
        .map(|node| Cow::Borrowed(node.orbit))
        .into_iter()
        .collect();
    for pair in nodes.windows(2) {
        let (here, there) = (pair[0].parameter, pair[1].parameter);
        if there == value || here.min(there) < value && value < here.max(there) {
            found.push(orbit_between([&pair[0], &pair[1]], parameter, value)?);
        }
    }
    Ok(found)
}

/// The orbit at a value of one of two nodes or between them: followed from one of them, that is no fold if there is one.
pub(super) fn orbit_between<'a>(
    ends: [&BranchNode<'a>; 2],
    parameter: ContinuationParameter<'_>,
    value: f64,
) -> Result<Cow<'a, PeriodicOrbit>> {
    let mut nodes = ends.to_vec();
    if let Some(known) = ends.iter().rev().find(|node| node.parameter == value) {
        return Ok(Cow::Borrowed(known.orbit));
    }
    if ends.iter().any(|node| !node.turns) {
        nodes.retain(|node| !node.turns);
    }
    // From the nearer one in few steps; where that is a boundary many may be needed, and the other may be better. Of factors none
    // counts from zero.
    let is_zero = |node: &BranchNode<'_>| parameter.is_factor() && node.parameter == 0.0;
    let distance = |node: &BranchNode<'_>| (node.parameter - value).abs();
    nodes.sort_by(|a, b| {
        is_zero(a)
            .cmp(&is_zero(b))
            .then(distance(a).total_cmp(&distance(b)))
    });
    let mut nearest: Option<(f64, String)> = None;
    for max_points in MOST_POINTS_TO_VALUE {
        for node in &nodes {
            let start = node.parameter;
            let is_up = value > start;
            let options = ContinuationOptions {
                heading: if is_up { Heading::Up } else { Heading::Down },
                max_points,
                steps: STEPS_TO_VALUE,
                beyond: Virtual::Keep,
                symmetric: None,
            };
            let between = (start.min(value), start.max(value));
            let from = (node.orbit, Some(start));
            let mut part = parameter.continuation(from, between, &options)?;
            let last = if is_up { part.orbits.len() - 1 } else { 0 };
            let reached = part.parameter[last];
            if reached == value {
                return Ok(Cow::Owned(part.orbits.swap_remove(last)));
            }
            let end = &part.ends[usize::from(is_up)];
            if end.reason == EndReason::Interrupted {
                return Err(Error::Interrupted);
            }
            let is_nearer =
                |(own, _): &(f64, String)| (reached - value).abs() < (own - value).abs();
            if nearest.as_ref().is_none_or(is_nearer) {
                nearest = Some((reached, end.detail.clone()));
            }
        }
    }
    let (reached, reason) = nearest.unwrap_or((f64::NAN, String::new()));
    Err(Error::NotReached {
        value,
        beside: ends.map(|node| node.parameter),
        reached,
        reason,
    })
}
