//! Functions of orbits along a branch, and where they are zero: test functions that a user gives.

use crate::branch::at_value::{BranchNode, orbit_between};
use crate::branch::continuation_parameter::ContinuationParameter;
use crate::branch::result::Branch;
use crate::continuation::{LocatedZero, TestEvaluation, locate_zero};
use crate::error::{Error, Result};
use crate::orbit::PeriodicOrbit;
use crate::quantity::finite;
use crate::tolerance::ZERO_VALUE;

/// A function of orbits, by which a branch is monitored.
pub(crate) type MonitorFn<'a> = &'a mut dyn FnMut(&PeriodicOrbit) -> Result<f64>;

/// A point of a branch at which a function is zero.
#[derive(Debug, Clone)]
pub struct MonitorZero {
    /// The number of the branch there.
    pub parameter: f64,
    /// The error of that: the last change of the search, or the width of its bracket.
    pub error: f64,
    /// How far along the branch it is, in scaled unknowns \[-\]; between its neighbours in parts of the number.
    pub arclength: f64,
    /// The orbit there.
    pub orbit: PeriodicOrbit,
}

/// A function of orbits along a branch of m points.
#[derive(Debug, Clone)]
pub struct MonitoredBranch {
    /// Its value at each point, shape `(m,)`, \[its own unit\].
    pub values: Vec<f64>,
    /// Where it is zero, in the order of the branch.
    pub zeros: Vec<MonitorZero>,
}

impl Branch {
    /// A function of its orbits, by a name for messages: at each point, and where it is zero between two of them.
    ///
    /// A change of its sign between two neighbours is located by orbits followed to values between; where the function does not become
    /// small it jumps, and has no zero.
    ///
    /// # Errors
    /// A value that is not finite; what the function says, and what makes scenes.
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
    /// let branch = continuation(&orbits[0], Parameter::ForcingScale, (0.6, 1.5), &options)?;
    /// // Where the impact has a speed of 2.
    /// let number = ContinuationParameter::Number(Parameter::ForcingScale);
    /// let found = branch.monitored(number, "fast", &mut |own| Ok(own.impacts()[0].approach - 2.0))?;
    /// assert!((found.zeros[0].orbit.impacts()[0].approach - 2.0).abs() < 1e-9);
    /// # Ok::<(), vibroimpact::Error>(())
    /// ```
    pub fn monitored(
        &self,
        parameter: ContinuationParameter<'_>,
        name: &str,
        measure: &mut dyn FnMut(&PeriodicOrbit) -> Result<f64>,
    ) -> Result<MonitoredBranch> {
        monitored(&self.nodes(), parameter, name, measure)
    }
}

/// A function along a branch.
pub(crate) fn monitored(
    nodes: &[BranchNode<'_>],
    parameter: ContinuationParameter<'_>,
    name: &str,
    measure: MonitorFn<'_>,
) -> Result<MonitoredBranch> {
    let (folds, points): (Vec<usize>, Vec<usize>) =
        (0..nodes.len()).partition(|&i| nodes[i].is_fold);
    let mut all = vec![0.0; nodes.len()];
    for (k, &i) in points.iter().enumerate() {
        let value = measure(nodes[i].orbit)?;
        all[i] = finite(&format!("monitor['{name}'] at point {k}"), value)?;
    }
    for i in folds {
        all[i] = measure(nodes[i].orbit)?;
    }
    let values = points.iter().map(|&i| all[i]).collect();
    let each = nodes.iter().map(|node| node.parameter);
    let (low, high) = each.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), own| {
        (low.min(own), high.max(own))
    });
    let mut zeros = Vec::new();
    for (ends, of) in nodes.windows(2).zip(all.windows(2)) {
        if of[0] * of[1] < 0.0 && ends[0].parameter != ends[1].parameter {
            let ends = [&ends[0], &ends[1]];
            zeros.extend(zero(
                ends,
                [of[0], of[1]],
                (parameter, high - low),
                measure,
            )?);
        }
    }
    Ok(MonitoredBranch { values, zeros })
}

/// The zero between two nodes, with the values there; the abscissa of the search is the part of the way from one to the other.
fn zero(
    ends: [&BranchNode<'_>; 2],
    [before, after]: [f64; 2],
    (over, span): (ContinuationParameter<'_>, f64),
    measure: MonitorFn<'_>,
) -> Result<Option<MonitorZero>> {
    let between = |part: f64, of: fn(&BranchNode<'_>) -> f64| {
        let (here, there) = (of(ends[0]), of(ends[1]));
        here + part * (there - here)
    };
    let mut point = |part: f64| {
        let parameter = between(part, |node| node.parameter);
        let orbit = match orbit_between(ends, over, parameter) {
            Ok(orbit) => orbit.into_owned(),
            Err(Error::NotReached { .. }) => return Ok(None),
            Err(error) => return Err(error),
        };
        let value = measure(&orbit)?;
        let point = (orbit, value);
        Ok(Some(TestEvaluation {
            point,
            parameter,
            value,
        }))
    };
    let found = locate_zero([1.0, before, after], span, &mut point)?;
    let small = ZERO_VALUE * before.abs().max(after.abs());
    let zero = found.filter(|zero| zero.point.1.abs() <= small);
    Ok(zero.map(
        |LocatedZero {
             point,
             along,
             error,
         }| MonitorZero {
            parameter: between(along, |node| node.parameter),
            error: error.max(f64::EPSILON * span),
            arclength: between(along, |node| node.arclength),
            orbit: point.0,
        },
    ))
}
