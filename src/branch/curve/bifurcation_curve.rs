//! `bifurcation_curve`: from a special point to the curve in the plane of two numbers on which it lies.

use crate::branch::curve::condition::Condition;
use crate::branch::curve::direction::CurveDirection;
use crate::branch::curve::point::AcceptedCurvePoint;
use crate::branch::curve::predictor::step_to_number;
use crate::branch::curve::problem::{CurveProblem, TwoParameterLoop};
use crate::branch::curve::result::{BifurcationCurve, CurvePoint};
use crate::branch::curve::start::{CurveOf, begun};
use crate::branch::curve::walk::CurveWalk;
use crate::branch::half_branch::both_halves;
use crate::branch::options::{ContinuationOptions, check_range};
use crate::continuation::{ScaledDirection, ZeroProblem, corrected, walk};
use crate::error::{Error, Result, digits};
use crate::linalg::rank;
use crate::model::{Parameter, Scene};
use crate::observer::ProgressRange;
use crate::tolerance::ELSEWHERE_ON_CURVE;

/// Follows a special point of a branch over two numbers of its scene. Folds, period doublings, tori, pitchforks, grazes, impacts
/// without speed and corners; or an orbit that hits stops at one instant, which one number alone cannot keep. Both ways, by
/// arclength.
///
/// A curve of grazes shows the orbits that touch; one of corners those that hit both stops at once, or, where one is hit alone, those that
/// reach the other there. It is followed wherever its equations go: whether its orbits keep the rules of contact is said by each.
///
/// # Errors
/// A crossing, a chatter border and a rise, which have no equation here; otherwise as [`continuation`](fn@crate::continuation), with
/// a pair of numbers, of ranges and of values.
///
/// # References
/// Theory section 20.
///
/// # Examples
/// ```
/// use vibroimpact::{ContinuationOptions, CurveOf, OrbitOptions, Parameter, Pattern, SpecialKind, bifurcation_curve, continuation, periodic_orbits};
/// use vibroimpact::nalgebra::{dmatrix, dvector};
/// use vibroimpact::{Harmonic, LinearSystem, Scene, Stop};
/// let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0])?;
/// let force = Harmonic::new(dvector![7.0.into()], 2.4, 0.0)?;
/// let scene = Scene::new(system, force, [Stop::new(0, 1.0, 0.8)?])?;
/// let orbits = periodic_orbits(&scene, &Pattern::single(0), &OrbitOptions::default())?;
/// let options = ContinuationOptions::default();
/// let branch = continuation(&orbits[0], Parameter::ForcingScale, (0.5, 2.0), &options)?;
/// let doubling = branch.special.iter().find(|own| own.kind == SpecialKind::PeriodDoubling).expect("one");
/// let plane = [Parameter::Frequency, Parameter::CLEARANCE];
/// let curve = bifurcation_curve(CurveOf::Special(doubling), plane, [(2.1, 3.0), (0.5, 1.5)], &options)?;
/// assert!(curve.x.len() > 10);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn bifurcation_curve(
    of: CurveOf<'_>,
    parameters: [Parameter; 2],
    between: [(f64, f64); 2],
    options: &ContinuationOptions,
) -> Result<BifurcationCurve> {
    let scene = of.orbit().scene();
    let mut start = [0.0; 2];
    for (axis, parameter) in parameters.into_iter().enumerate() {
        start[axis] = scene.start_of(parameter, "parameters")?;
        for end in [between[axis].0, between[axis].1] {
            let allowed = parameter.check(end);
            allowed.map_err(|error| error.at(format_args!("between[{axis}]")))?;
        }
    }
    if parameters[0] == parameters[1] {
        let value = format!("\"{}\" twice", parameters[0]);
        return Err(Error::bad_value("parameters", value, "they must be two"));
    }
    let make = |x: f64, y: f64| {
        let scene = scene.with_value(parameters[0], x)?;
        scene.with_value(parameters[1], y)
    };
    bifurcation_curve_of(of, &make, start, between, options)
}

/// The same over scenes of any kind, one for each pair of values; the orbit is that of a pair.
///
/// # Errors
/// As [`bifurcation_curve`]; what `make` says, but for a pair that it refuses (`Error::BadValue`), where the curve ends.
pub fn bifurcation_curve_of(
    of: CurveOf<'_>,
    make: &dyn Fn(f64, f64) -> Result<Scene>,
    start: [f64; 2],
    between: [(f64, f64); 2],
    options: &ContinuationOptions,
) -> Result<BifurcationCurve> {
    options.check()?;
    for (axis, range) in between.into_iter().enumerate() {
        check_range(&format!("between[{axis}]"), range, start[axis])?;
    }
    let (plane, iterate) = begun(of, make, start, between)?;
    let open = plane.along(0, &iterate, |problem| problem.mismatch(&iterate.place))?;
    if open > ELSEWHERE_ON_CURVE && plane.condition == Condition::Together && of.kind().is_some() {
        let rule = format!(
            "its stops are coupled: hit at one instant they give the motion another velocity than one after the other, and it does not close (by {})",
            digits(open)
        );
        return Err(Error::bad_value("special", "a corner", rule));
    }
    if open > ELSEWHERE_ON_CURVE {
        let rule = format!(
            "the scene of ({}, {}) is not that of the orbit, which does not close in it (by {})",
            digits(start[0]),
            digits(start[1]),
            digits(open)
        );
        return Err(Error::bad_value("start", "of another scene", rule));
    }
    let first = first_point(&plane, iterate)?;
    let _range = ProgressRange::over(between[0].0, between[0].1);
    let joined = both_halves(&first, options.heading, |sign| {
        let mut first = first.clone();
        first.found.tangent = first.found.tangent.scaled(sign);
        let mut walker = CurveWalk { plane: &plane };
        walk(&mut walker, first, options.steps, options.max_points)
    })?;
    let special = joined.special.into_iter().map(|(own, sign)| CurvePoint {
        arclength: sign * own.arclength,
        ..own
    });
    let mut curve = BifurcationCurve {
        kind: of.kind(),
        orbits: Vec::new(),
        x: Vec::new(),
        y: Vec::new(),
        arclength: Vec::new(),
        is_virtual: Vec::new(),
        special: special.collect(),
        ends: joined.ends,
    };
    for (point, sign) in joined.points {
        let iterate = &point.found.iterate;
        curve.x.push(iterate.place.value);
        curve.y.push(iterate.second);
        curve.arclength.push(sign * point.arclength);
        curve.is_virtual.push(point.is_virtual);
        curve.orbits.push(point.orbit);
    }
    Ok(curve)
}

/// The point of the curve at the special point, its tangent towards larger first numbers.
fn first_point(plane: &CurveProblem<'_>, iterate: TwoParameterLoop) -> Result<AcceptedCurvePoint> {
    let at = plane.linearise(&iterate, None)?;
    let (rows, columns) = at.matrix.shape();
    if rows + 1 != columns {
        let rule =
            "a curve is of an orbit that hits stops at one instant, one such instant, two stops";
        return Err(Error::bad_value("special", "an orbit", rule));
    }
    let start = [iterate.place.value, iterate.second];
    let null = rank::weakest(&at.matrix, 1)?.column(0).into_owned();
    let Ok(mut found) = corrected(plane, iterate, &CurveDirection(null))? else {
        let rule = "the equations of its curve are singular at it: more than one thing happens there, and no curve begins";
        return Err(Error::bad_value("special", digits(start[0]), rule));
    };
    // The numbers of a special point are known better than its orbit: the number that changes more along the curve keeps its value.
    let numbers = found.tangent.numbers().abs();
    let axis = numbers.imax();
    if numbers[axis] > 0.0
        && let Ok(there) = step_to_number(plane, &found, 0.0, (axis, start[axis]))?
    {
        found = there;
    }
    if found.tangent.numbers()[0] < 0.0 {
        found.tangent = found.tangent.scaled(-1.0);
    }
    AcceptedCurvePoint::at(plane, found, 0.0)
}
