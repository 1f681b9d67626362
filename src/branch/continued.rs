//! `continuation`: from an orbit to the branch on which it lies.

use crate::branch::energy_level::energy_at;
use crate::branch::half_branch::both_halves;
use crate::branch::options::{ContinuationOptions, Virtual, check_range};
use crate::branch::parametric_loop::{BranchDirection, ParametricLoop};
use crate::branch::predictor::AcceptedPoint;
use crate::branch::problem::{BranchProblem, Formulation};
use crate::branch::result::Branch;
use crate::branch::special::Special;
use crate::branch::test_functions::TestFunctionValues;
use crate::branch::touch_outcome::TouchMultipliers;
use crate::branch::walk::BranchWalk;
use crate::branch::zero_problem::directions;
use crate::continuation::{ScaledDirection, corrected, walk};
use crate::error::{Error, Result, digits};
use crate::model::{Parameter, Scene};
use crate::observer::ProgressRange;
use crate::orbit::PeriodicOrbit;
use crate::tolerance::{ORBIT_CLOSED, ORBIT_OF_ANOTHER_SCENE};

/// Follows a periodic orbit over a number of its scene, through folds. Both ways, by arclength: from each point a step along the
/// branch and Newton's method back to it. Every orbit of the branch has the pattern of the first one.
///
/// The observer of the thread ([`with_observer`](crate::with_observer)) is told after each point how far its value is in the range; when it
/// breaks off, the branch so far is the result, with
/// [`EndReason::Interrupted`](crate::EndReason::Interrupted).
///
/// Between two points that follow each other nothing is proved: a violation that comes and goes there is not seen.
///
/// # Errors
/// A number that the scene does not have, or that its stops do not share; a range that is empty, not finite or without the orbit in it, or
/// whose ends the number may not take; steps that are not in order; an orbit that breaks a rule of contact, unless such orbits are kept;
/// stops that are hit together; a motion without forcing and without an impact whose stop gives it a phase; orbits that form a family at
/// one value (elastic impacts without damping).
///
/// # References
/// Theory section 19; E. J. Doedel, H. B. Keller and J. P. Kernevez, Int. J. Bifurcation Chaos 1 (1991) 745.
///
/// # Examples
/// ```
/// use vibroimpact::{ContinuationOptions, EndReason, OrbitOptions, Parameter, Pattern, continuation, periodic_orbits};
/// use vibroimpact::nalgebra::{dmatrix, dvector};
/// use vibroimpact::{Harmonic, LinearSystem, Scene, Stop};
/// let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0])?;
/// let force = Harmonic::new(dvector![8.5.into()], 2.4, 0.0)?;
/// let scene = Scene::new(system, force, [Stop::new(0, 1.0, 0.8)?])?;
/// let orbits = periodic_orbits(&scene, &Pattern::single(0), &OrbitOptions::default())?;
/// let options = ContinuationOptions::default();
/// let branch = continuation(&orbits[0], Parameter::ForcingScale, (0.1, 2.0), &options)?;
/// // Down to where the impact has no speed, F = 4.766.
/// assert_eq!(branch.ends[0].reason, EndReason::Boundary);
/// assert!((8.5 * branch.parameter[0] - 4.766_046_58).abs() < 1e-8);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn continuation(
    orbit: &PeriodicOrbit,
    parameter: Parameter,
    between: (f64, f64),
    options: &ContinuationOptions,
) -> Result<Branch> {
    let scene = orbit.scene();
    let start = scene.start_of(parameter, "parameter")?;
    for end in [between.0, between.1] {
        let allowed = parameter.check(end);
        allowed.map_err(|error| error.at(format_args!("between")))?;
    }
    let make = |value: f64| scene.with_value(parameter, value);
    continuation_of(orbit, &make, start, between, options)
}

/// The same over scenes of any kind, one for each value; the orbit is that of the scene of a value.
///
/// # Errors
/// As [`continuation`]; a scene of that value in which the orbit does not close; what `make` says, but for a value that it refuses
/// (`Error::BadValue`), where the branch ends.
pub fn continuation_of(
    orbit: &PeriodicOrbit,
    make: &dyn Fn(f64) -> Result<Scene>,
    start: f64,
    between: (f64, f64),
    options: &ContinuationOptions,
) -> Result<Branch> {
    options.check()?;
    check_range("between", between, start)?;
    let begun = BranchProblem::around(orbit, make, start, between)?;
    from_orbit(orbit, begun, options)
}

/// The same over the energy of the motion, of orbits without forcing, damping and loss at impacts: one at each energy, in one scene (the
/// backbone of what it does with a little forcing and damping). None of them attracts; stable are those near which deviations grow but
/// with the difference of their periods. Tori are not looked for, as all multipliers lie on the unit circle where none has left it.
///
/// # Errors
/// As [`continuation`]; a scene with a forcing; a system given by functions without its mass matrix or its potential; an orbit that does
/// not keep its energy when it is changed a little, as one of a family does.
///
/// # References
/// Theory section 19, "Families"; J. Sepulchre and R. S. `MacKay`, Nonlinearity 10 (1997) 679.
///
/// # Examples
/// ```
/// use vibroimpact::nalgebra::{dmatrix, dvector};
/// use vibroimpact::{ContinuationOptions, Forcing, Guess, LinearSystem, Scene, Stop, continuation_over_energy, find_orbit};
/// let system = LinearSystem::new(dvector![1.0], dmatrix![0.0], dmatrix![1.0])?;
/// let scene = Scene::new(system, Forcing::Unforced, [Stop::new(0, 1.0, 1.0)?])?;
/// let (q, v) = (dvector![-2.0], dvector![0.0]);
/// let guess = Guess::State { q: &q, v: &v, period: Some(4.2) };
/// let orbit = find_orbit(&scene, guess, None)?;
/// let branch = continuation_over_energy(&orbit, (0.5, 8.0), &ContinuationOptions::default())?;
/// // The amplitude is 4 at the end: from the stop at 1 round to it again.
/// let last = branch.orbits.last().expect("at least one");
/// let half = std::f64::consts::PI - 0.25f64.acos();
/// assert!((last.period() - 2.0 * half).abs() < 1e-10);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn continuation_over_energy(
    orbit: &PeriodicOrbit,
    between: (f64, f64),
    options: &ContinuationOptions,
) -> Result<Branch> {
    options.check()?;
    let (energetics, energy) = energy_at(orbit)?;
    // The energy of an orbit at an end of the range differs from that by rounding.
    let (low, high) = between;
    let nearest = if low < high {
        energy.clamp(low, high)
    } else {
        energy
    };
    let is_it = (nearest - energy).abs() <= ORBIT_CLOSED * energy.abs();
    let start = if is_it { nearest } else { energy };
    check_range("between", between, start)?;
    let make = |_: f64| Ok(orbit.scene().clone());
    let (problem, place) = BranchProblem::around(orbit, &make, start, between)?;
    let problem = BranchProblem {
        formulation: Formulation::EnergyLevel(&energetics),
        ..problem
    };
    from_orbit(orbit, (problem, place), options)
}

/// Follows a branch both ways from the loop of an orbit.
fn from_orbit(
    orbit: &PeriodicOrbit,
    begun: (BranchProblem<'_>, ParametricLoop),
    options: &ContinuationOptions,
) -> Result<Branch> {
    if options.beyond == Virtual::Stop && orbit.is_admissible() == Some(false) {
        let reason = orbit
            .violation()
            .map_or(String::new(), |v| v.reason.clone());
        let rule = format!("it must be admissible, or virtual orbits are to be kept: {reason}");
        return Err(Error::bad_value(
            "orbit",
            "one that breaks a rule of contact",
            rule,
        ));
    }
    // Only the unknowns of all modes can keep the mirror image.
    let begun = if options.symmetric == Some(true) {
        begun
    } else {
        begun.0.by_impulses(begun.1)?
    };
    let (problem, place) = half_of(begun, options.symmetric)?;
    let first = first_point(&problem, place, orbit)?;
    let _range = ProgressRange::over(problem.range.0, problem.range.1);
    let joined = both_halves(&first, options.heading, |sign| {
        let turned = AcceptedPoint {
            tangent: first.tangent.scaled(sign),
            test_values: first.test_values.along(sign),
            ..first.clone()
        };
        let mut walker = BranchWalk {
            home: problem.clone(),
            problem: problem.clone(),
            passed: None,
            options,
            reached: None,
        };
        walk(&mut walker, turned, options.steps, options.max_points)
    })?;
    let special = joined.special.into_iter().map(|(own, sign)| Special {
        arclength: sign * own.arclength,
        touch: if sign < 0.0 {
            own.touch.map(TouchMultipliers::reversed)
        } else {
            own.touch
        },
        ..own
    });
    let mut branch = Branch {
        orbits: Vec::new(),
        parameter: Vec::new(),
        arclength: Vec::new(),
        special: special.collect(),
        ends: joined.ends,
        is_closed: joined.is_closed,
        keeps_energy: problem.formulation.keeps_energy(),
        outside: (problem.formulation.counts_multipliers()).then(Vec::new),
    };
    for (point, sign) in joined.points {
        branch.parameter.push(point.place.value);
        branch.arclength.push(sign * point.arclength);
        if let Some(outside) = &mut branch.outside {
            outside.push(point.test_values.outside);
        }
        branch.orbits.push(point.orbit);
    }
    Ok(branch)
}

/// The problem of half the period, where the motion is to stay its own mirror image; else the problem as it is.
fn half_of(
    (problem, place): (BranchProblem<'_>, ParametricLoop),
    symmetric: Option<bool>,
) -> Result<(BranchProblem<'_>, ParametricLoop)> {
    if symmetric == Some(false) {
        return Ok((problem, place));
    }
    match problem.half(&place)? {
        Some(half) => Ok(half),
        None if symmetric == Some(true) => {
            let rule = "the orbit must be its own mirror image half a period later, q(t + T/2) = -q(t), and so must be the scenes about it";
            Err(Error::bad_value("symmetric", "true", rule))
        }
        None => Ok((problem, place)),
    }
}

/// The first point of a branch, its tangent towards larger values.
fn first_point(
    problem: &BranchProblem<'_>,
    place: ParametricLoop,
    orbit: &PeriodicOrbit,
) -> Result<AcceptedPoint> {
    let mut equations = problem.equations(&place)?;
    let (rows, unknowns) = equations.rows.shape();
    if rows > unknowns {
        let rule = "stops that are hit together, or twice at one instant, need a second number to stay so: give each an instant of its own";
        return Err(Error::bad_value(
            "orbit",
            "one that hits several stops at one instant",
            rule,
        ));
    }
    if rows < unknowns {
        let rule = "without forcing it must hit a stop, which gives it a phase";
        return Err(Error::bad_value("orbit", "one without an impact", rule));
    }
    let (mut place, mut orbit) = (place, orbit.clone());
    if equations.mismatch > ORBIT_OF_ANOTHER_SCENE {
        let rule = format!(
            "the scene of {} is not that of the orbit, which does not close in it (by {}): it must be its value there",
            digits(place.value),
            digits(equations.mismatch)
        );
        return Err(Error::bad_value("start", place.value, rule));
    }
    if equations.mismatch > ORBIT_CLOSED {
        let there = corrected(problem, place, &BranchDirection::of_value(unknowns))?;
        let Ok(settled) = there else {
            return Err(Error::NoConvergence {
                stage: "the orbit in the scene of its value",
                iterations: 0,
                residual: equations.mismatch,
            });
        };
        (place, equations) = (settled.iterate, settled.equations);
        orbit = problem.closed_orbit(&place)?;
    }
    let all = directions(&equations)?;
    let [tangent] = all.as_slice() else {
        let (value, rule) = problem.formulation.several_directions(problem.is_free);
        return Err(Error::bad_value("orbit", value, rule));
    };
    if problem.opens(tangent) {
        let rule = "orbits beside it must keep their energy too: elastic impacts and no damping";
        return Err(Error::bad_value(
            "orbit",
            "one that is alone at its energy",
            rule,
        ));
    }
    let up = if tangent.value_part < 0.0 { -1.0 } else { 1.0 };
    let tangent = tangent.scaled(up);
    Ok(AcceptedPoint {
        test_values: TestFunctionValues::at(problem, (&place, &equations, &tangent), &orbit)?,
        tangent,
        place,
        equations,
        orbit,
        arclength: 0.0,
    })
}
