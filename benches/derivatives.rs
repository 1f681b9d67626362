//! An impact damper, a ball in a box on a structure that is shaken: the largest displacement of its orbit and the gradient by six numbers,
//! beside the 13 orbits that central differences take, and the minimum over clearance and restitution by the steps of a quasi-Newton method.
//! `cargo bench --bench derivatives`.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use vibroimpact::nalgebra::{dmatrix, dvector};
use vibroimpact::{
    Harmonic, LinearSystem, OrbitDerivatives, PeriodicOrbit, Result, Scene, SimulateOptions, Stop,
    derivatives_but_multipliers, derivatives_of, find_orbit, follow_orbit, simulate,
};

/// Room, restitution, mass of the ball, frequency, force, damping.
const START: [f64; 6] = [0.6, 0.6, 0.1, 1.0, 0.1, 0.02];

/// Coordinates: the structure, and the ball in the room.
fn make(p: &[f64]) -> Result<Scene> {
    let [room, restitution, mass, frequency, force, damping] = *p else {
        unreachable!("six numbers");
    };
    let system = LinearSystem::new(
        dmatrix![1.0 + mass, mass; mass, mass],
        dmatrix![damping, 0.0; 0.0, 0.0],
        dmatrix![1.0, 0.0; 0.0, 0.0],
    )?;
    let force = Harmonic::new(dvector![force.into(), 0.0.into()], frequency, 0.0)?;
    let wall = Stop::new(1, 0.5 * room, restitution)?;
    let other = wall.clone().on_side(vibroimpact::Side::Lower);
    Scene::new(system, force, [wall, other])
}

fn started() -> PeriodicOrbit {
    let scene = make(&START).expect("valid");
    let span = (0.0, 600.0 * scene.period().expect("forced"));
    let (q, v) = (dvector![0.1, 0.0], dvector![0.0, 0.3]);
    let run = simulate(&scene, &q, &v, span, &SimulateOptions::default()).expect("a run");
    find_orbit(&scene, &run, None).expect("an orbit")
}

fn value(orbit: &PeriodicOrbit) -> f64 {
    orbit.max_displacement().expect("positions")[0]
}

fn by_orbits(orbit: &PeriodicOrbit, p: &[f64]) -> (f64, Vec<f64>) {
    let at = |p: &[f64]| {
        let scene = make(p).expect("valid");
        value(&find_orbit(&scene, orbit, None).expect("an orbit"))
    };
    let rate = |i: usize| {
        let moved = |h: f64| {
            let mut p = p.to_vec();
            p[i] += h;
            at(&p)
        };
        let h = 1e-5 * p[i];
        (moved(h) - moved(-h)) / (2.0 * h)
    };
    (at(p), (0..p.len()).map(rate).collect())
}

fn by_derivatives(orbit: &PeriodicOrbit, p: &[f64]) -> (f64, OrbitDerivatives) {
    let scene = make(p).expect("valid");
    let found = find_orbit(&scene, orbit, None).expect("an orbit");
    let rates = derivatives_but_multipliers(&found, &make, p).expect("derivatives");
    (value(&found), rates)
}

/// Steps down the gradient by clearance and restitution, doubled while they lead down.
fn optimised(orbit: &PeriodicOrbit) -> ([f64; 2], f64, usize) {
    let at = |x: [f64; 2]| {
        let mut p = START;
        (p[0], p[1]) = (x[0], x[1]);
        p
    };
    let beside = |q: &[f64]| make(&at([q[0], q[1]]));
    let (mut x, mut last, mut count) = ([START[0], START[1]], orbit.clone(), 0);
    let mut step = 0.05;
    while step > 1e-8 && count < 300 {
        let rates = derivatives_but_multipliers(&last, &beside, &x).expect("derivatives");
        let slope = [
            rates.max_displacement[(0, 0)],
            rates.max_displacement[(0, 1)],
        ];
        let size = slope[0].hypot(slope[1]);
        let next = [
            x[0] - step * slope[0] / size,
            (x[1] - step * slope[1] / size).clamp(0.05, 0.95),
        ];
        count += 1;
        match follow_orbit(&last, &beside, (&x, &next)) {
            Ok(found) if found.is_admissible() == Some(true) && value(&found) < value(&last) => {
                (x, last, step) = (next, found, 1.5 * step);
            }
            _ => step *= 0.3,
        }
    }
    (x, value(&last), count)
}

fn benches(criterion: &mut Criterion) {
    let orbit = started();
    let beside: Vec<f64> = START.iter().map(|p| 1.001 * p).collect();
    let (exact, rates) = by_derivatives(&orbit, &beside);
    let (same, differences) = by_orbits(&orbit, &beside);
    assert!(
        (exact - same).abs() < 1e-12 && rates.reason.is_empty(),
        "{}",
        rates.reason
    );
    for (i, difference) in differences.iter().enumerate() {
        let own = rates.max_displacement[(0, i)];
        assert!(
            (own - difference).abs() < 1e-6 * (1.0 + own.abs()),
            "{i}: {own} {difference}"
        );
    }
    println!("pattern {:?}", orbit.pattern().instants());
    let (x, least, count) = optimised(&orbit);
    println!(
        "{:.4} at the start, {least:.4} at {x:.3?} after {count} steps",
        value(&orbit)
    );
    let mut group = criterion.benchmark_group("six numbers");
    group.bench_function("an orbit", |b| {
        let scene = make(&beside).expect("valid");
        b.iter(|| black_box(find_orbit(&scene, &orbit, None)));
    });
    group.bench_function("its extremes", |b| b.iter(|| black_box(value(&orbit))));
    group.bench_function("its derivatives", |b| {
        b.iter(|| black_box(derivatives_of(&orbit, &make, &START)));
    });
    group.bench_function("value and derivatives", |b| {
        b.iter(|| black_box(by_derivatives(&orbit, &beside)));
    });
    group.bench_function("13 orbits", |b| {
        b.iter(|| black_box(by_orbits(&orbit, &beside)));
    });
    group.bench_function("an optimisation", |b| {
        b.iter(|| black_box(optimised(&orbit)));
    });
    group.finish();
}

criterion_group!(all, benches);
criterion_main!(all);
