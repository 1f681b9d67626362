//! The derivatives of an orbit from orbits that are solved beside it.

use std::f64::consts::{PI, TAU};
use vibroimpact::nalgebra::Complex;
use vibroimpact::{
    Motion, OrbitDerivatives, PeriodicOrbit, Result, Scene, SegmentKind, find_orbit,
};

/// The attributes of an orbit that are differentiated, each a list.
#[derive(Debug, Clone)]
pub struct Attributes(pub Vec<(&'static str, Vec<f64>)>);

/// The attributes; the phase within half a turn of that of an orbit nearby, the multipliers in its order.
fn attributes(orbit: &PeriodicOrbit, nearby: &PeriodicOrbit) -> Attributes {
    let phase = nearby.phase() + (orbit.phase() - nearby.phase() + PI).rem_euclid(TAU) - PI;
    let impacts = orbit.impacts();
    let multipliers = in_order(&multipliers(orbit), &multipliers(nearby));
    Attributes(vec![
        ("q0", orbit.q0().as_slice().to_vec()),
        ("v0", orbit.v0().as_slice().to_vec()),
        ("phase", vec![phase]),
        ("period", vec![orbit.period()]),
        (
            "speeds_before",
            impacts.iter().map(|i| i.approach).collect(),
        ),
        ("times", impacts.iter().map(|i| i.time).collect()),
        ("min_gap", orbit.min_gap().expect("gaps")),
        (
            "max_displacement",
            orbit.max_displacement().expect("positions"),
        ),
        (
            "multipliers",
            multipliers.iter().flat_map(|mu| [mu.re, mu.im]).collect(),
        ),
    ])
}

fn multipliers(orbit: &PeriodicOrbit) -> Vec<Complex<f64>> {
    let orders = &orbit.stability().expect("multipliers").orders;
    orders
        .first()
        .map_or(Vec::new(), |order| order.multipliers.as_slice().to_vec())
}

/// Some numbers in the order of others to which they are next.
fn in_order(numbers: &[Complex<f64>], like: &[Complex<f64>]) -> Vec<Complex<f64>> {
    let mut left = numbers.to_vec();
    let mut next = |wanted: &Complex<f64>| {
        let off = |x: &Complex<f64>| (x - wanted).norm();
        let nearest = (0..left.len()).min_by(|&i, &j| off(&left[i]).total_cmp(&off(&left[j])));
        nearest.map(|i| left.remove(i))
    };
    like.iter().filter_map(&mut next).collect()
}

/// Central differences of fourth order of the orbits of scenes at offsets of some steps.
fn differences(
    orbit: &PeriodicOrbit,
    make: &dyn Fn(f64) -> Result<Scene>,
    step: f64,
) -> Option<Attributes> {
    let at = |steps: f64| {
        let scene = make(steps * step).expect("a scene");
        let found = find_orbit(&scene, orbit, None).ok()?;
        Some(attributes(&found, orbit))
    };
    let [a, b, c, d] = [at(-2.0)?, at(-1.0)?, at(1.0)?, at(2.0)?];
    let mut all = b.clone();
    for (i, (_, values)) in all.0.iter_mut().enumerate() {
        let [a, b, c, d] = [&a, &b, &c, &d].map(|own| &own.0[i].1);
        if [a, c, d].iter().any(|own| own.len() != b.len()) {
            return None;
        }
        for (j, value) in values.iter_mut().enumerate() {
            *value = (a[j] - d[j] + 8.0 * (c[j] - b[j])) / (12.0 * step);
        }
    }
    Some(all)
}

/// A derivative by one number as lists.
fn column(found: &OrbitDerivatives, i: usize) -> Attributes {
    let multipliers = found.multipliers.column(i);
    Attributes(vec![
        ("q0", found.q0.column(i).as_slice().to_vec()),
        ("v0", found.v0.column(i).as_slice().to_vec()),
        ("phase", vec![found.phase[i]]),
        ("period", vec![found.period[i]]),
        (
            "speeds_before",
            found.speeds_before.column(i).as_slice().to_vec(),
        ),
        ("times", found.times.column(i).as_slice().to_vec()),
        ("min_gap", found.min_gap.column(i).as_slice().to_vec()),
        (
            "max_displacement",
            found.max_displacement.column(i).as_slice().to_vec(),
        ),
        (
            "multipliers",
            multipliers.iter().flat_map(|mu| [mu.re, mu.im]).collect(),
        ),
    ])
}

fn size(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |size, x| size.max(x.abs()))
}

/// What is unknown of the speeds of impacts that accumulate, and of what grows by them, in parts of the largest: rounding of a gap over the time of
/// the last flights.
const OF_SHORT_FLIGHTS: f64 = 2e-8;

/// The same of differences over a step of some attribute.
fn unknown(orbit: &PeriodicOrbit, name: &str, step: f64) -> f64 {
    let feels = ["speeds_before", "multipliers"].contains(&name);
    let segments = orbit.segments().expect("kept");
    if !feels || segments.iter().all(|own| own.kind != SegmentKind::Chatter) {
        return 0.0;
    }
    let all = attributes(orbit, orbit).0;
    let own = all
        .iter()
        .find(|own| own.0 == name)
        .map_or(0.0, |own| size(&own.1));
    OF_SHORT_FLIGHTS * own / step
}

/// How many numbers are compared with differences that two steps agree on, each within a tolerance of itself and of a part of the largest of
/// its attribute.
pub fn compare(
    orbit: &PeriodicOrbit,
    found: (&OrbitDerivatives, usize),
    make: &dyn Fn(f64) -> Result<Scene>,
    (step, tolerance, floor): (f64, f64, f64),
    case: &str,
) -> usize {
    let own = column(found.0, found.1);
    let coarse = differences(orbit, make, step);
    let fine = differences(orbit, make, 0.5 * step);
    let (Some(coarse), Some(fine)) = (coarse, fine) else {
        return 0;
    };
    let mut count = 0;
    let largest = own.0.iter().map(|(_, x)| size(x)).fold(0.0, f64::max);
    for (((name, own), (_, coarse)), (_, fine)) in own.0.iter().zip(&coarse.0).zip(&fine.0) {
        // Impacts that accumulate may be one more or less beside.
        if ["speeds_before", "times"].contains(name) && orbit.impacts().len() != fine.len() {
            continue;
        }
        assert_eq!(own.len(), fine.len(), "{case} {name}");
        let whole = floor * size(fine) + 1e-3 * largest;
        let unknown = unknown(orbit, name, 0.5 * step);
        for ((own, coarse), fine) in own.iter().zip(coarse).zip(fine) {
            let room = tolerance * (fine.abs() + whole) + unknown;
            let is_smooth = (coarse - fine).abs() < 0.3 * room;
            if !is_smooth || own.is_nan() {
                continue;
            }
            assert!(
                (own - fine).abs() < room,
                "{case} {name}: {own:e} and {fine:e}, {}\n{:?}\n{:?}\n{:?}",
                found.0.reason,
                multipliers(orbit),
                orbit.impacts(),
                found.0.multipliers.column(found.1)
            );
            count += 1;
        }
    }
    count
}
