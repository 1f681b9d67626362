//! Branches that meet each other, followed from one to the next, each once.

use crate::branch::at_value::{BranchNode, orbits_at};
use crate::branch::candidate::Candidate;
use crate::branch::continuation_parameter::ContinuationParameter;
use crate::branch::options::ContinuationOptions;
use crate::branch::result::Branch;
use crate::branch::same_orbit::are_one_orbit;
use crate::branch::switching;
use crate::continuation::{BranchEnd, EndReason};
use crate::error::{Error, Result};
use crate::orbit::PeriodicOrbit;
use std::ops::Range;

/// Orbits of a branch, evenly spread, by which it is told from others: next to a fold a branch may be found twice, by candidates that no
/// point of it is beside. [work]
const COMPARED_ORBITS: usize = 3;

/// Options of [`branch_tree`].
#[derive(Debug, Clone, PartialEq)]
pub struct TreeOptions {
    /// From branch to branch so often, default 2; at 0 the branch of the orbit alone.
    pub depth: usize,
    /// Whether across boundaries of motion too, default true.
    pub through: bool,
    /// Branches at the most, default 50.
    pub max_branches: usize,
    /// How each is followed.
    pub continuation: ContinuationOptions,
}

impl Default for TreeOptions {
    fn default() -> Self {
        Self {
            depth: 2,
            through: true,
            max_branches: 50,
            continuation: ContinuationOptions::default(),
        }
    }
}

/// Branches that meet each other: a sequence of them, each once.
#[derive(Debug, Clone)]
pub struct BranchTree {
    /// The branches; the first is that of the orbit that was given.
    pub branches: Vec<Branch>,
    /// Of each the branch that it goes off from, and the place of the special point among its `special`; `None` of the first. Shape `(m,)`.
    pub parents: Vec<Option<(usize, usize)>>,
}

/// Follows an orbit, and the branches that meet its branch, and those that meet them. The orbit is that of a value (`None`: of its own
/// scene). Each branch is followed once: two are one if they share an orbit at a value, or one has the mirror image of an orbit of the
/// other. Only orbits that keep the rules of contact are followed.
///
/// # Errors
/// As [`continuation`](fn@crate::continuation) and [`branches`](fn@crate::branches); `Error::Interrupted` when the observer of the
/// thread breaks off.
///
/// # Examples
/// ```
/// use vibroimpact::nalgebra::{dmatrix, dvector};
/// use vibroimpact::{ContinuationParameter, OrbitOptions, Parameter, Pattern, TreeOptions, branch_tree};
/// use vibroimpact::{Harmonic, LinearSystem, Scene, Stop, periodic_orbits};
/// let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0])?;
/// let force = Harmonic::new(dvector![8.5.into()], 2.4, 0.0)?;
/// let scene = Scene::new(system, force, [Stop::new(0, 1.0, 0.8)?])?;
/// let orbits = periodic_orbits(&scene, &Pattern::single(0), &OrbitOptions::default())?;
/// let number = ContinuationParameter::Number(Parameter::ForcingScale);
/// let options = TreeOptions { depth: 1, ..TreeOptions::default() };
/// let tree = branch_tree((&orbits[0], None), number, (0.3, 1.2), &options)?;
/// // The orbit, that without an impact, and at a doubling that of two periods.
/// assert!(tree.branches.len() >= 3);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn branch_tree(
    begin: (&PeriodicOrbit, Option<f64>),
    parameter: ContinuationParameter<'_>,
    between: (f64, f64),
    options: &TreeOptions,
) -> Result<BranchTree> {
    if options.max_branches == 0 {
        return Err(Error::bad_value("max_branches", 0, "it must be at least 1"));
    }
    let follow = |begin: (&PeriodicOrbit, Option<f64>)| {
        let branch = parameter.continuation(begin, between, &options.continuation)?;
        let is_broken_off = |end: &BranchEnd| end.reason == EndReason::Interrupted;
        if branch.ends.iter().any(is_broken_off) {
            return Err(Error::Interrupted);
        }
        Ok(branch)
    };
    let mut tree = BranchTree {
        branches: vec![follow(begin)?],
        parents: vec![None],
    };
    let mut level = 0..1;
    for _ in 0..options.depth {
        let offers = offered(
            &tree.branches,
            level.clone(),
            parameter,
            between,
            options.through,
        )?;
        for (
            (k, j),
            Candidate {
                orbit,
                parameter: value,
                ..
            },
        ) in offers
        {
            if tree.branches.len() == options.max_branches || tree.has(&orbit, value, parameter)? {
                continue;
            }
            let branch = follow((&orbit, Some(value)))?;
            if !tree.has_branch(&branch, parameter)? {
                tree.branches.push(branch);
                tree.parents.push(Some((k, j)));
            }
        }
        level = level.end..tree.branches.len();
    }
    Ok(tree)
}

/// What goes off from some branches: of each candidate the branch and the place of its special point.
fn offered(
    branches: &[Branch],
    level: Range<usize>,
    parameter: ContinuationParameter<'_>,
    between: (f64, f64),
    through: bool,
) -> Result<Vec<((usize, usize), Candidate)>> {
    let mut found = Vec::new();
    for k in level {
        for (j, special) in branches[k].special.iter().enumerate() {
            if !through && special.kind.is_boundary() {
                continue;
            }
            let each = switching::branches(special, parameter, between)?.into_iter();
            let is_offered = |own: &Candidate| {
                (between.0..=between.1).contains(&own.parameter)
                    && own.orbit.is_admissible() == Some(true)
            };
            found.extend(each.filter(is_offered).map(|own| ((k, j), own)));
        }
    }
    Ok(found)
}

impl BranchTree {
    /// Whether one of the branches has an orbit at its value, or its mirror image.
    fn has(
        &self,
        orbit: &PeriodicOrbit,
        value: f64,
        parameter: ContinuationParameter<'_>,
    ) -> Result<bool> {
        for branch in &self.branches {
            if is_on_branch(&branch.nodes(), (orbit, value), parameter)? {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Whether one of the branches has orbits of another.
    fn has_branch(&self, branch: &Branch, parameter: ContinuationParameter<'_>) -> Result<bool> {
        let last = branch.orbits.len() - 1;
        for k in 1..=COMPARED_ORBITS {
            let k = k * last / (COMPARED_ORBITS + 1);
            if self.has(&branch.orbits[k], branch.parameter[k], parameter)? {
                return Ok(true);
            }
        }
        Ok(false)
    }
}

/// Whether a branch has an orbit at its value, or its mirror image.
pub(crate) fn is_on_branch(
    nodes: &[BranchNode<'_>],
    (orbit, value): (&PeriodicOrbit, f64),
    parameter: ContinuationParameter<'_>,
) -> Result<bool> {
    let Some(first) = nodes.first().map(|node| node.orbit) else {
        return Ok(false);
    };
    if first.n_periods() != orbit.n_periods() || first.impacts().len() != orbit.impacts().len() {
        return Ok(false);
    }
    let there = orbits_at(nodes, parameter, value)?;
    if there.iter().any(|own| are_one_orbit(own, orbit)) {
        return Ok(true);
    }
    // Of a scene that is not odd there is none.
    let image = orbit.mirrored();
    Ok(image.is_ok_and(|image| there.iter().any(|own| are_one_orbit(own, &image))))
}
