//! What holds at special points, by the referee's own motion, and by how much an orbit misses it.

use crate::branches::look::Look;
use crate::branches::map::Map;
use crate::branches::rules::turns;
use crate::branches::script::Event;
use crate::branches::stepper::{motion, moved, step, zero};
use crate::roots::eigenvalues;
use nalgebra::{Complex, DMatrix};
use vibroimpact::{PeriodicOrbit, SpecialKind};

/// By how much an orbit misses what holds at a special point; or why this referee cannot tell.
pub fn miss(look: &Look<'_>, kind: SpecialKind, stop: Option<usize>) -> Result<f64, &'static str> {
    match kind {
        SpecialKind::Fold | SpecialKind::Pitchfork | SpecialKind::BranchPoint => {
            Ok(from_real(&derivative(look)?, 1.0))
        }
        SpecialKind::PeriodDoubling => Ok(from_real(&derivative(look)?, -1.0)),
        SpecialKind::Torus => Ok(from_circle(&multipliers(look)?)),
        SpecialKind::Graze | SpecialKind::Touch | SpecialKind::BorderCollision => {
            Ok(touch(look, stop.ok_or("a graze of no stop")?))
        }
        SpecialKind::LostImpact => {
            let stop = stop.ok_or("a lost impact on no stop")?;
            slowest(look, stop).ok_or("a lost impact on a stop that is not hit")
        }
        SpecialKind::Rise => Ok(weakest(look)),
        SpecialKind::LandingBorder => Ok(flattest(look)),
        SpecialKind::ReleaseBorder => Ok(shortest(look)),
        SpecialKind::Corner => Err("a corner, whose impacts are one"),
        SpecialKind::ChatterBorder => Err("a chatter border"),
        SpecialKind::VanishingImpacts => {
            Err("impacts that vanish, of which the last orbit has some")
        }
    }
}

/// The derivative of the map of a period.
fn derivative(look: &Look<'_>) -> Result<DMatrix<f64>, &'static str> {
    let map = Map::new(look).ok_or("an orbit that never flies")?;
    map.derivative().ok_or("an impact too slow for differences")
}

/// The multipliers of the referee's map.
pub fn multipliers(look: &Look<'_>) -> Result<Vec<Complex<f64>>, &'static str> {
    Ok(eigenvalues(&derivative(look)?).iter().copied().collect())
}

/// The part of a derivative by which it is off from one with a real multiplier: what it is known to in itself, however its
/// multipliers lie.
fn from_real(derivative: &DMatrix<f64>, multiplier: f64) -> f64 {
    let n = derivative.nrows();
    let off = derivative - DMatrix::identity(n, n) * multiplier;
    off.singular_values().min() / derivative.norm().max(1.0)
}

/// How far the pair of conjugate multipliers, or of two on one side of the real axis, is from a product of one, in parts of the
/// largest.
pub fn from_circle(all: &[Complex<f64>]) -> f64 {
    let largest = all.iter().map(|mu| mu.norm()).fold(1.0, f64::max);
    let pairs = all.iter().enumerate().flat_map(|(i, a)| {
        let others = all[..i].iter();
        others.map(move |b| (a * b - 1.0).norm())
    });
    pairs.fold(f64::INFINITY, f64::min) / largest
}

/// The gap of a stop that is nearest to zero where it turns from closing to opening, in parts of its reach.
fn touch(look: &Look<'_>, face: usize) -> f64 {
    let least = lowest(look, face).into_iter().map(f64::abs);
    least.fold(f64::INFINITY, f64::min) / look.reach(face)
}

/// The gaps of a stop where it turns from closing to opening.
fn lowest(look: &Look<'_>, face: usize) -> Vec<f64> {
    let flights = look.script.flights();
    let flights = flights.iter().filter(|own| own.held != Some(face));
    let all = flights.flat_map(|own| turns(look, own, face));
    all.map(|(_, gap)| gap).collect()
}

/// The speed of the slowest impact on a stop.
fn slowest(look: &Look<'_>, stop: usize) -> Option<f64> {
    let speeds = look.script.flights().into_iter().filter_map(|flight| {
        let over = flight.over?;
        let is_own = matches!(over.event, Event::Hit { face, .. } if face == stop);
        is_own.then(|| {
            let x = look.state(flight.start, false);
            let end = moved(&look.body, flight.held, (flight.start, &x), flight.end);
            look.body.speed(stop, &end).abs() / look.units[1]
        })
    });
    speeds.min_by(f64::total_cmp)
}

/// The contact force that is nearest to zero where it turns from falling to rising, in parts of the largest.
fn weakest(look: &Look<'_>) -> f64 {
    let stays = look
        .script
        .flights()
        .into_iter()
        .filter(|own| own.held.is_some());
    let least = stays.map(|stay| {
        let force = |t: f64, x: &[f64]| look.body.acceleration(t, x, stay.held).1;
        let x = look.state(stay.start, false);
        let all = motion(&look.body, stay.held, (stay.start, &x), stay.end);
        let most = all.iter().map(|(t, x)| force(*t, x).abs());
        let most = most.fold(f64::MIN_POSITIVE, f64::max);
        let slope = |(t, x): (f64, &[f64]), dt: f64| {
            let h = 1e-4 * (stay.end - stay.start);
            let at = |dt: f64| force(t + dt, &step(&look.body, stay.held, (t, x), dt));
            (at(dt + h) - at(dt - h)) / (2.0 * h)
        };
        let turns = all.windows(2).filter_map(|pair| {
            let ((start, x), (end, _)) = (&pair[0], &pair[1]);
            let slope = |dt: f64| slope((*start, x), dt);
            (slope(0.0) < 0.0 && slope(end - start) >= 0.0).then(|| {
                let dt = zero(slope, 0.0, end - start);
                force(start + dt, &step(&look.body, stay.held, (*start, x), dt)) / most
            })
        });
        let begun = force(stay.start, &x).abs() / most;
        turns.map(f64::abs).fold(begun, f64::min)
    });
    least.fold(f64::INFINITY, f64::min)
}

/// The acceleration of the gap behind an impact without rebound that is nearest to zero, in parts of the motion's.
fn flattest(look: &Look<'_>) -> f64 {
    let unit = look.units[1] * look.units[1] / look.units[0];
    let flights = look.script.flights().into_iter();
    let openings = flights.filter_map(|flight| {
        let Event::Hit { face, .. } = flight.begun?.event else {
            return None;
        };
        let x = look.state(flight.start, false);
        let is_left = look.body.speed(face, &x).abs() < 1e-9 * look.units[1];
        is_left.then(|| look.body.opening(face, flight.start, &x).abs() / unit)
    });
    openings.fold(f64::INFINITY, f64::min)
}

/// The shortest flight or stay, in parts of the period.
pub fn shortest(look: &Look<'_>) -> f64 {
    let flights = look.script.flights().into_iter();
    let spans = flights.map(|flight| flight.end - flight.start);
    spans.fold(f64::INFINITY, f64::min) / look.script.period
}

/// By how much two stops that are hit at one instant are not there at the end of the flight before it, in parts of their reach.
pub fn apart(orbit: &PeriodicOrbit, look: &Look<'_>) -> Option<f64> {
    let impacts = orbit.impacts();
    let period = orbit.period();
    let late = |k: usize| {
        let next = (k + 1) % impacts.len();
        (impacts[next].time - impacts[k].time).rem_euclid(period)
    };
    let near = |k: &usize| late(*k).min(period - late(*k)) < 1e-9 * period;
    let first = (0..impacts.len()).find(near)?;
    let faces = [
        impacts[first].stop,
        impacts[(first + 1) % impacts.len()].stop,
    ];
    let before = impacts[(first + impacts.len() - 1) % impacts.len()].time;
    let span = (impacts[first].time - before).rem_euclid(period);
    let span = if span < 1e-9 * period { period } else { span };
    let end = moved(
        &look.body,
        None,
        (before, &look.state(before, false)),
        before + span,
    );
    let gaps = faces.map(|face| look.body.gap(face, &end).abs() / look.reach(face));
    Some(gaps[0].max(gaps[1]))
}

/// By how much a stop is not reached at an impact on another, in parts of its reach: of all impacts the one that is nearest to it.
pub fn reached(orbit: &PeriodicOrbit, look: &Look<'_>, stop: usize) -> Option<f64> {
    let (impacts, period) = (orbit.impacts(), orbit.period());
    let gaps = impacts.iter().enumerate().map(|(k, own)| {
        let before = impacts[(k + impacts.len() - 1) % impacts.len()].time;
        let span = (own.time - before).rem_euclid(period);
        let span = if impacts.len() == 1 { period } else { span };
        let start = look.state(before, false);
        let end = moved(&look.body, None, (before, &start), before + span);
        look.body.gap(stop, &end).abs() / look.reach(stop)
    });
    gaps.min_by(f64::total_cmp)
}

/// By how much a corner is none: of two impacts, or of one at which another stop is reached.
pub fn cornered(orbit: &PeriodicOrbit, look: &Look<'_>, stop: Option<usize>) -> Option<f64> {
    apart(orbit, look).or_else(|| reached(orbit, look, stop?))
}
