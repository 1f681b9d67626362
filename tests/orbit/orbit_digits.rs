//! What an orbit knows to rounding: speeds after impacts that are little beside the motion, and where a stop is passed.

use crate::scenes::{oscillator, upper};
use nalgebra::dvector;
use std::f64::consts::PI;
use vibroimpact::{
    Forcing, FreeParameter, Harmonic, ImpactSide, Kind, Motion, OrbitOptions, Orbits, PaperOptions,
    Pattern, PeriodicOrbit, Side, Stop, paper_scene, periodic_orbits,
};

/// The orbits with one impact in a forcing period of a unit mass on a unit spring that hits the first stop.
fn orbits(damping: f64, (force, frequency): (f64, f64), stops: &[Stop]) -> Orbits {
    let force = dvector![force.into()];
    let forcing = Forcing::Harmonic(Harmonic::new(force, frequency, 0.0).expect("valid"));
    let scene = oscillator(damping, forcing, stops.iter().cloned());
    periodic_orbits(&scene, &Pattern::single(0), &OrbitOptions::default()).expect("solved")
}

#[test]
fn small_speeds_beside_a_fast_forcing_keep_their_digits() {
    // The forcing moves the mass at 5e-4; v+ = -e/(1 + e) p for a unit mass.
    let e = 0.7;
    for damping in [0.0, 0.02, 20.0] {
        let stop = upper(0, 1e-7, e);
        let found = orbits(damping, (1.0, 2000.0), &[stop]);
        assert_eq!(found.len(), 2);
        for orbit in found.iter() {
            let (impact, speed) = (orbit.impacts()[0], orbit.v0()[0]);
            let wanted = -e / (1.0 + e) * impact.impulse;
            assert!(wanted.abs() < 1e-9 && (speed / wanted - 1.0).abs() < 1e-15);
            assert!((speed / -e / impact.approach - 1.0).abs() < 1e-15);
        }
    }
}

#[test]
fn small_impulses_beside_a_fast_forcing_keep_their_digits() {
    // q = A cos(w t + phase) - p cos(t - T/2)/(2 sin(T/2)), at the stop v+ = -e/(1 + e) p: with c = cot(T/2)/2 and
    // g = (1 - e)/(2 w (1 + e)) the phase falls out of (d + c p)^2 + (g p)^2 = A^2.
    let (w, d, e) = (2000.0, 1e-7, 0.7);
    let amplitude = 1.0 / (w * w - 1.0);
    let (c, g) = (0.5 / f64::tan(PI / w), (1.0 - e) / (2.0 * w * (1.0 + e)));
    let square = c * c + g * g;
    let root = ((d * c).powi(2) + square * (amplitude - d) * (amplitude + d)).sqrt();
    let wanted = [(-d * c - root) / square, (-d * c + root) / square];
    let stop = upper(0, d, e);
    let mut found: Vec<f64> = orbits(0.0, (1.0, w), &[stop])
        .iter()
        .map(|orbit| orbit.impacts()[0].impulse)
        .collect();
    found.sort_by(f64::total_cmp);
    for (impulse, wanted) in found.iter().zip(wanted) {
        let error = (impulse / wanted - 1.0).abs();
        assert!(error < 1e-14, "{impulse:e} {wanted:e} {error:e}");
    }
}

#[test]
fn speeds_after_impacts_obey_their_law_at_every_instant() {
    let kinds = [(Kind::One, 3), (Kind::Two, 2), (Kind::Three, 2)];
    let patterns = [vec![vec![0, 1]], vec![vec![0]], vec![vec![1]]];
    for ((kind, n_periods), pattern) in kinds.into_iter().zip(patterns) {
        let scene = paper_scene(kind, &PaperOptions::default()).expect("valid");
        let options = OrbitOptions {
            n_periods,
            free: (kind == Kind::One).then_some(FreeParameter::Clearance),
            ..Default::default()
        };
        let pattern = Pattern::new(pattern).expect("valid");
        let found = periodic_orbits(&scene, &pattern, &options).expect("solved");
        assert!(!found.is_empty());
        for orbit in found.iter() {
            for impact in orbit.impacts() {
                let (_, after) = orbit.state(impact.time, ImpactSide::After).expect("a time");
                let (_, before) = orbit
                    .state(impact.time, ImpactSide::Before)
                    .expect("a time");
                let e = impact.departure / impact.approach;
                let left = after[impact.stop] + e * before[impact.stop];
                assert!(left.abs() <= 4.0 * f64::EPSILON * impact.approach.abs());
            }
        }
    }
}

#[test]
fn a_stop_that_is_passed_or_touched_is_so_where_the_motion_turns_back() {
    let hit = upper(0, 0.1, 0.7);
    let below = |clearance: f64| {
        let lower = upper(0, clearance, 0.7);
        orbits(0.2, (1.0, 1.7), &[hit.clone(), lower.on_side(Side::Lower)])
    };
    let smallest = |orbits: &Orbits| {
        let by_phase = |a: &&PeriodicOrbit, b: &&PeriodicOrbit| a.phase().total_cmp(&b.phase());
        orbits.iter().min_by(by_phase).expect("found").clone()
    };
    let passed = smallest(&below(0.1));
    let violation = passed.violation().expect("passed").clone();
    let (q, v) = passed
        .state(violation.time, ImpactSide::After)
        .expect("a time");
    assert!(v[0].abs() < 2e-15, "{:e}", v[0]);
    // A few roundings of a motion of size 1.
    let left = q[0] + 0.1 + violation.depth;
    assert!(left.abs() < 1e-14, "{left:e}");
    let touched = smallest(&below(0.1 + violation.depth));
    let touch = touched.touches()[0];
    assert!((touch.time - violation.time).abs() < 2e-15 && touched.is_admissible() == Some(true));
}
