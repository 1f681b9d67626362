//! `bifurcation_curve`: from a special point to the curve in the plane of two numbers that it is on.

use crate::branch::corrector::{Missed, met};
use crate::branch::curve::condition::Condition;
use crate::branch::curve::corrector::{Found, length, weighted};
use crate::branch::curve::one::{BifurcationCurve, CurvePoint};
use crate::branch::curve::plane::{Plane, Spot};
use crate::branch::end::{BranchEnd, EndReason};
use crate::branch::family::Family;
use crate::branch::instants::{period, turned};
use crate::branch::options::{ContinuationOptions, Heading};
use crate::branch::place::Place;
use crate::branch::special::{Special, SpecialKind};
use crate::branch::zero::{Tried, zero_between};
use crate::error::{Error, Result, digits};
use crate::linalg::rank;
use crate::model::{Parameter, Scene, value_of};
use crate::orbit::{Event, PeriodicOrbit};
use crate::quantity::finite;
use nalgebra::DVector;
use std::ops::ControlFlow;

/// What a curve is followed from.
#[derive(Debug, Clone, Copy)]
pub enum CurveOf<'a> {
    /// A special point of a branch.
    Special(&'a Special),
    /// An orbit that hits stops at one instant.
    Orbit(&'a PeriodicOrbit),
}

impl CurveOf<'_> {
    /// Its orbit.
    pub fn orbit(&self) -> &PeriodicOrbit {
        match self {
            Self::Special(special) => &special.orbit,
            Self::Orbit(orbit) => orbit,
        }
    }

    fn kind(&self) -> Option<SpecialKind> {
        match self {
            Self::Special(special) => Some(special.kind),
            Self::Orbit(_) => None,
        }
    }
}

/// A step is refused if the second correction is longer than this part of the first, or if the curve turns by more than this angle.
const MOST_CONTRACTION: f64 = 0.5;
const MOST_ANGLE: f64 = 0.35;
const USUAL_ANGLE: f64 = 0.15;
const USUAL_CONTRACTION: f64 = 0.1;
/// A curve that comes back has this part of its direction there.
const SAME_WAY: f64 = 0.9;

/// Follows a special point of a branch over two numbers of its scene: folds, period doublings, pitchforks, grazes, impacts without speed and
/// corners; or an orbit that hits stops at one instant, which one number alone cannot keep. Both ways, by arclength.
///
/// A curve of grazes shows the orbits that touch; one of corners those that hit both stops at once. It is followed wherever its equations
/// go: whether its orbits keep the rules of contact is said by each.
///
/// # Errors
/// A torus, a crossing, a chatter border and a rise, which have no equation here; otherwise as [`continuation`](crate::continuation), with
/// a pair of numbers, of ranges and of values.
///
/// # References
/// Theory section 20.
///
/// # Examples
/// ```
/// use std::ops::ControlFlow;
/// use vibroimpact::{ContinuationOptions, CurveOf, OrbitOptions, Parameter, Pattern, SpecialKind, bifurcation_curve, continuation, periodic_orbits};
/// use vibroimpact::nalgebra::{dmatrix, dvector};
/// use vibroimpact::{Harmonic, LinearSystem, Scene, Stop};
/// let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0])?;
/// let force = Harmonic::new(dvector![7.0.into()], 2.4, 0.0)?;
/// let scene = Scene::new(system, force, [Stop::new(0, 1.0, 0.8)?])?;
/// let orbits = periodic_orbits(&scene, &Pattern::single(0), &OrbitOptions::default())?;
/// let options = ContinuationOptions::default();
/// let go_on = &mut |_| ControlFlow::Continue(());
/// let branch = continuation(&orbits[0], Parameter::ForcingScale, (0.5, 2.0), &options, go_on)?;
/// let doubling = branch.special.iter().find(|own| own.kind == SpecialKind::PeriodDoubling).expect("one");
/// let plane = [Parameter::Frequency, Parameter::Clearance];
/// let curve = bifurcation_curve(CurveOf::Special(doubling), plane, [(2.1, 3.0), (0.5, 1.5)], &options, go_on)?;
/// assert!(curve.x.len() > 10);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn bifurcation_curve(
    of: CurveOf<'_>,
    parameters: [Parameter; 2],
    between: [(f64, f64); 2],
    options: &ContinuationOptions,
    observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<BifurcationCurve> {
    let scene = of.orbit().scene();
    let mut start = [0.0; 2];
    for (axis, parameter) in parameters.into_iter().enumerate() {
        start[axis] = value_of(scene, parameter, "parameters")?;
        for end in [between[axis].0, between[axis].1] {
            let allowed = parameter.check(end);
            allowed.map_err(|error| error.at(format_args!("between[{axis}]")))?;
        }
        if parameter == Parameter::Phase || !start[axis].is_finite() {
            let rule = "each must be a number that the scene of the orbit has, and that changes its motion";
            return Err(Error::bad_value(
                "parameters",
                format!("\"{parameter}\""),
                rule,
            ));
        }
    }
    if parameters[0] == parameters[1] {
        let value = format!("\"{}\" twice", parameters[0]);
        return Err(Error::bad_value("parameters", value, "they must be two"));
    }
    let make = |x: f64, y: f64| {
        parameters[0].check(x)?;
        parameters[1].check(y)?;
        let scene = scene.replace(parameters[0].change(x))?;
        scene.replace(parameters[1].change(y))
    };
    bifurcation_curve_of(of, &make, start, between, options, observer)
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
    observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<BifurcationCurve> {
    options.check()?;
    for (axis, (low, high)) in between.into_iter().enumerate() {
        for value in [low, high, start[axis]] {
            finite("between", value)?;
        }
        let value = format!("({low}, {high})");
        let name = format!("between[{axis}]");
        if low >= high {
            return Err(Error::bad_value(
                &name,
                value,
                "the first must be the lower one",
            ));
        }
        if !(low..=high).contains(&start[axis]) {
            let rule = format!("the orbit is at {}: it must lie inside", start[axis]);
            return Err(Error::bad_value(&name, value, rule));
        }
    }
    let (plane, spot) = begun(of, make, start, between)?;
    let first = first_point(&plane, spot)?;
    let mut way = |sign: f64| followed(&plane, &first, sign, options, observer).map(Some);
    let up = if options.heading == Heading::Down {
        None
    } else {
        way(1.0)?
    };
    let has_closed = up
        .as_ref()
        .is_some_and(|way| way.end.reason == EndReason::Closed);
    let down = if options.heading == Heading::Up || has_closed {
        None
    } else {
        way(-1.0)?
    };
    joined(of.kind(), &plane, &first, up, down)
}

/// The plane about a special point, and its loop there.
fn begun<'a>(
    of: CurveOf<'_>,
    make: &'a dyn Fn(f64, f64) -> Result<Scene>,
    start: [f64; 2],
    between: [(f64, f64); 2],
) -> Result<(Plane<'a>, Spot)> {
    let along = |value: f64| make(value, start[1]);
    let (whole, place) = Family::around(of.orbit(), &along, start[0], between[0])?;
    let half = || -> Result<(Family<'_>, Place)> {
        let half = whole.half(&place)?;
        half.ok_or_else(|| refused("a pitchfork of a scene that is not odd over the first number"))
    };
    let (condition, (family, place)) = match of {
        CurveOf::Orbit(_) => (Condition::Together, (whole, place)),
        CurveOf::Special(special) => match (special.kind, special.stop.zip(special.time)) {
            (SpecialKind::Fold, _) if special.direction.len() <= whole.n_unknowns(&place) => {
                (Condition::Multiplier(1.0), half()?)
            }
            (SpecialKind::Fold, _) => (Condition::Multiplier(1.0), (whole, place)),
            (SpecialKind::PeriodDoubling, _) => (Condition::Multiplier(-1.0), (whole, place)),
            (SpecialKind::Pitchfork, _) => (Condition::Multiplier(-1.0), half()?),
            (SpecialKind::Graze, Some(touch)) => {
                let (family, place, instant) = whole.with_touch(&place, touch)?;
                (Condition::NoSpeed(instant), (family, place))
            }
            (SpecialKind::LostImpact, Some(touch)) => {
                let instant = whole.instant_of(&place, touch);
                let instant =
                    instant.ok_or_else(|| refused("a lost impact that the orbit has not"))?;
                (Condition::NoSpeed(instant), (whole, place))
            }
            (SpecialKind::Corner, _) => {
                let together = together(&whole, &place)?;
                let together = together.ok_or_else(|| {
                    refused("a corner of impacts that are not next to each other")
                })?;
                (Condition::Together, together)
            }
            (kind, _) => return Err(refused(&format!("a {}", kind.name()))),
        },
    };
    let touch = match (of.kind(), condition) {
        (Some(SpecialKind::Graze), Condition::NoSpeed(instant)) => Some(instant),
        _ => None,
    };
    let plane = Plane {
        make,
        between,
        signature: family.signature.clone(),
        phase: family.phase,
        is_free: family.is_free,
        units: family.units,
        condition,
        touch,
    };
    let second = start[1];
    Ok((plane, Spot { place, second }))
}

/// The refusal of what has no curve.
fn refused(what: &str) -> Error {
    let rule = "a curve there is of a fold, a period_doubling, a pitchfork, a graze, a lost_impact, a corner, or of an orbit that hits \
                stops at one instant";
    Error::bad_value("special", what, rule)
}

/// A loop whose two stops of a corner are hit at one instant.
fn together<'a>(family: &Family<'a>, place: &Place) -> Result<Option<(Family<'a>, Place)>> {
    let mut instants = family.instants(&place.state);
    let Some(first) = family.shortest_flight(place) else {
        return Ok(None);
    };
    let whole = period(&place.state);
    instants = turned(instants, first, whole);
    let one = instants.remove(0);
    let (Event::Strike(mut stops), Event::Strike(others)) =
        (one.stage.event, instants[0].stage.event.clone())
    else {
        return Ok(None);
    };
    stops.extend(others);
    stops.sort_unstable();
    instants[0].stage.event = Event::Strike(stops);
    let length = (whole, family.signature.n_periods);
    family
        .with_instants(place.value, instants, length)
        .map(Some)
}

/// A point of a curve that was accepted.
struct Point {
    found: Found,
    arclength: f64,
    indicators: Vec<(&'static str, f64)>,
}

/// The point of the curve at the special point, its tangent towards larger first numbers.
fn first_point(plane: &Plane<'_>, spot: Spot) -> Result<Point> {
    let at = plane.conditions(&spot)?;
    let (rows, columns) = at.matrix.shape();
    if rows + 1 != columns {
        let rule =
            "a curve is of an orbit that hits stops at one instant, one such instant, two stops";
        return Err(Error::bad_value("special", "an orbit", rule));
    }
    let null = rank::weakest(&at.matrix, 1)?.column(0).into_owned();
    let normal = weighted(&null);
    let Ok(mut found) = plane.corrected(spot, &normal)? else {
        return Err(Error::NoConvergence {
            stage: "the special point on its curve",
            iterations: 0,
            residual: at.mismatch,
        });
    };
    let up = found.tangent[columns - 2] >= 0.0;
    if !up {
        found.tangent.neg_mut();
    }
    let indicators = indicators(plane, &found.spot)?;
    Ok(Point {
        found,
        arclength: 0.0,
        indicators,
    })
}

/// Numbers whose signs tell what else happens on a curve.
fn indicators(plane: &Plane<'_>, spot: &Spot) -> Result<Vec<(&'static str, f64)>> {
    plane.along(0, spot, |family| {
        let test = |multiplier: f64| family.multiplier_test(&spot.place, multiplier);
        let slowest = || -> Result<f64> {
            let stages = family.signature.stages.iter().enumerate();
            let struck = stages.filter(|(_, stage)| matches!(stage.event, Event::Strike(_)));
            let mut least = f64::INFINITY;
            for (k, _) in struck {
                let speed = family.approach(&spot.place, k)?;
                least = least.min(speed / family.units.velocity);
            }
            Ok(least)
        };
        Ok(match plane.condition {
            Condition::Multiplier(mu) => {
                vec![("fold_flip", test(-mu)?), ("resonant_graze", slowest()?)]
            }
            Condition::NoSpeed(_) => {
                vec![("graze_fold", test(1.0)?), ("resonant_graze", test(-1.0)?)]
            }
            Condition::Together => vec![("graze_corner", slowest()?)],
        })
    })
}

/// A way along a curve.
struct Way {
    points: Vec<Point>,
    special: Vec<CurvePoint>,
    end: BranchEnd,
}

/// Goes along a curve from a point, which is not among those that it gives.
fn followed(
    plane: &Plane<'_>,
    first: &Point,
    sign: f64,
    options: &ContinuationOptions,
    observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Way> {
    let mut way = Way {
        points: Vec::new(),
        special: Vec::new(),
        end: BranchEnd::new(EndReason::Points, String::new()),
    };
    let [smallest, usual, largest] = options.steps;
    let mut step = usual;
    let mut tangent = &first.found.tangent * sign;
    let mut farthest = 0.0f64;
    way.end = loop {
        let from = way.points.last().unwrap_or(first);
        let at = [from.found.spot.place.value, from.found.spot.second];
        if way.points.len() >= options.max_points {
            let detail = format!("{} points were asked for", options.max_points);
            break BranchEnd::new(EndReason::Points, detail);
        }
        if observer(at[0]).is_break() {
            let detail = format!("broken off at ({}, {})", digits(at[0]), digits(at[1]));
            break BranchEnd::new(EndReason::Interrupted, detail);
        }
        let reach = reached(plane, &from.found.spot, &tangent, step);
        let (ahead, normal) = match reach {
            Some((axis, ahead)) => (ahead, axis_row(tangent.len(), axis)),
            None => (step, weighted(&tangent)),
        };
        if let (Some((axis, _)), true) = (reach, ahead <= 0.0) {
            break range_end(axis, at[axis]);
        }
        let refused = match stepped(plane, &from.found, &tangent, ahead, &normal) {
            Err(Error::Interrupted) => {
                let detail = format!("broken off at ({}, {})", digits(at[0]), digits(at[1]));
                break BranchEnd::new(EndReason::Interrupted, detail);
            }
            Err(error) => return Err(error),
            Ok(Ok(found)) => match judged(&tangent, &found) {
                Ok(factor) => {
                    let gone = chord(plane, &from.found.spot, &found.spot);
                    let arclength = from.arclength + length(&gone);
                    let indicators = indicators(plane, &found.spot)?;
                    let point = Point {
                        found,
                        arclength,
                        indicators,
                    };
                    let special = passed(plane, from, &point, &tangent)?;
                    way.special.extend(special);
                    let side = point.found.tangent.dot(&weighted(&tangent)).signum();
                    tangent = &point.found.tangent * side;
                    let away = length(&chord(plane, &first.found.spot, &point.found.spot));
                    let is_same = sign * tangent.dot(&weighted(&first.found.tangent)) > SAME_WAY;
                    let has_closed = farthest > 2.0 * step && away < step && is_same;
                    farthest = farthest.max(away);
                    let now = [point.found.spot.place.value, point.found.spot.second];
                    way.points.push(point);
                    if has_closed {
                        let detail = "it came back to where it began".to_owned();
                        break BranchEnd::new(EndReason::Closed, detail);
                    }
                    if let Some((axis, _)) = reach {
                        break range_end(axis, now[axis]);
                    }
                    step = (step * factor).clamp(smallest, largest);
                    continue;
                }
                Err(reason) => BranchEnd::new(EndReason::Step, reason.to_owned()),
            },
            Ok(Err(missed)) => ended(missed),
        };
        if step <= smallest {
            break refused;
        }
        step = (0.5 * step).max(smallest);
    };
    Ok(way)
}

fn range_end(axis: usize, value: f64) -> BranchEnd {
    let name = ["first", "second"][axis];
    let detail = format!("the range of the {name} number ends at {}", digits(value));
    BranchEnd::new(EndReason::Range, detail)
}

fn ended(missed: Missed) -> BranchEnd {
    match missed {
        Missed::Stalled { value, reason } => {
            let detail = format!("Newton's method stalls at {}: {reason}", digits(value));
            BranchEnd::new(EndReason::Step, detail)
        }
        Missed::NoRest { value } => {
            let detail = format!(
                "at {} impacts that accumulated come to no rest",
                digits(value)
            );
            BranchEnd::new(EndReason::Boundary, detail)
        }
        Missed::Met { value, .. } => {
            let detail = format!("at {} an instant comes to the one before it", digits(value));
            BranchEnd::new(EndReason::Boundary, detail)
        }
        Missed::NoScene(reason) => BranchEnd::new(EndReason::Domain, reason),
    }
}

/// The row that holds one of the numbers.
fn axis_row(unknowns: usize, axis: usize) -> DVector<f64> {
    let mut row = DVector::zeros(unknowns);
    row[unknowns - 2 + axis] = 1.0;
    row
}

/// The number whose range ends within a step, and how far along that is.
fn reached(
    plane: &Plane<'_>,
    from: &Spot,
    tangent: &DVector<f64>,
    step: f64,
) -> Option<(usize, f64)> {
    let at = [from.place.value, from.second];
    let ahead = (0..2).filter_map(|axis| {
        let (low, high) = plane.between[axis];
        let rate = tangent[tangent.len() - 2 + axis] * plane.span(axis);
        let end = if rate > 0.0 { high } else { low };
        let ahead = (end - at[axis]) / rate;
        (ahead <= step).then_some((axis, ahead))
    });
    ahead.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// A step along a curve.
fn stepped(
    plane: &Plane<'_>,
    from: &Found,
    tangent: &DVector<f64>,
    ahead: f64,
    normal: &DVector<f64>,
) -> Result<std::result::Result<Found, Missed>> {
    let moved = plane.moved(&from.spot, &from.conditions, &(tangent * ahead));
    match moved {
        Ok(spot) if met(&spot.place).is_none() => plane.corrected(spot, normal),
        Ok(spot) => Ok(Err(Missed::Met {
            value: spot.place.value,
            instant: 0,
        })),
        Err(Error::BadValue { .. }) => Ok(Err(Missed::NoScene(
            "beyond it there is no scene".to_owned(),
        ))),
        Err(error) => Err(error),
    }
}

/// The way from a spot to another in scaled unknowns.
fn chord(plane: &Plane<'_>, from: &Spot, to: &Spot) -> DVector<f64> {
    let place = plane.along(0, from, |family| Ok(family.between(&from.place, &to.place)));
    let second = (to.second - from.second) / plane.span(1);
    place.map_or_else(|_| DVector::zeros(0), |own| own.numbers().push(second))
}

/// The factor on the next step; why a point is not to be trusted.
fn judged(tangent: &DVector<f64>, found: &Found) -> std::result::Result<f64, &'static str> {
    if found.contraction > MOST_CONTRACTION {
        return Err("Newton's method hardly converges");
    }
    let along = found.tangent.dot(&weighted(tangent)).abs().min(1.0);
    let angle = along.acos();
    if angle > MOST_ANGLE {
        return Err("the curve turns sharply");
    }
    let by_contraction = (USUAL_CONTRACTION / found.contraction).sqrt();
    Ok(by_contraction.min(USUAL_ANGLE / angle).clamp(0.25, 2.0))
}

/// What else happens on a step.
fn passed(
    plane: &Plane<'_>,
    from: &Point,
    to: &Point,
    tangent: &DVector<f64>,
) -> Result<Vec<CurvePoint>> {
    let mut found = Vec::new();
    let step = length(&chord(plane, &from.found.spot, &to.found.spot));
    let normal = &weighted(tangent);
    for (k, (kind, after)) in to.indicators.iter().enumerate() {
        let before = from.indicators[k].1;
        if before * after >= 0.0 {
            continue;
        }
        let mut seconds: Vec<f64> = Vec::new();
        let mut point = |along: f64| {
            let Ok(there) = stepped(plane, &from.found, tangent, along, normal)? else {
                return Ok(None);
            };
            seconds.push(there.spot.second);
            Ok(Some(Tried {
                parameter: there.spot.place.value,
                value: indicators(plane, &there.spot)?[k].1,
                point: there.spot,
            }))
        };
        let zero = zero_between([step, before, *after], plane.span(0), &mut point)?;
        let (spot, along, error) = match zero {
            Some(zero) => (zero.point, zero.along, zero.error),
            None => (to.found.spot.clone(), step, step * plane.span(0)),
        };
        let last = seconds
            .windows(2)
            .last()
            .map_or(step * plane.span(1), |two| (two[1] - two[0]).abs());
        found.push(CurvePoint {
            kind,
            parameters: [spot.place.value, spot.second],
            error: [error, last],
            arclength: from.arclength + along,
            orbit: plane.orbit(&spot)?,
        });
    }
    found.sort_by(|a, b| a.arclength.total_cmp(&b.arclength));
    Ok(found)
}

/// The curve of two ways from a point.
fn joined(
    kind: Option<SpecialKind>,
    plane: &Plane<'_>,
    first: &Point,
    up: Option<Way>,
    down: Option<Way>,
) -> Result<BifurcationCurve> {
    let none = || Way {
        points: Vec::new(),
        special: Vec::new(),
        end: BranchEnd::new(EndReason::Start, "it was followed the other way".to_owned()),
    };
    let (up, down) = (up.unwrap_or_else(none), down.unwrap_or_else(none));
    let is_closed = up.end.reason == EndReason::Closed;
    let turned = |own: CurvePoint| CurvePoint {
        arclength: -own.arclength,
        ..own
    };
    let special = down.special.into_iter().rev().map(turned);
    let mut curve = BifurcationCurve {
        kind,
        orbits: Vec::new(),
        x: Vec::new(),
        y: Vec::new(),
        arclength: Vec::new(),
        special: special.chain(up.special).collect(),
        ends: [if is_closed { up.end.clone() } else { down.end }, up.end],
    };
    let low = down.points.iter().rev().map(|point| (point, -1.0));
    let high = std::iter::once(first).chain(&up.points);
    for (point, sign) in low.chain(high.map(|point| (point, 1.0))) {
        let spot = &point.found.spot;
        curve.x.push(spot.place.value);
        curve.y.push(spot.second);
        curve.arclength.push(sign * point.arclength);
        curve.orbits.push(plane.orbit(spot)?);
    }
    Ok(curve)
}
