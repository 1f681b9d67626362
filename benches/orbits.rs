//! Periodic orbits: one call for the paper's third case (two degrees of freedom, two orbits) up to the list, with
//! admissibility and multipliers of each, without an orbit, and with the phase given; and 10 000 modes with three stops
//! hit at one instant. `cargo bench --bench orbits`; ratios to `SciPy`: `python benches/against_scipy.py`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use nalgebra::{Complex, DVector};
use std::f64::consts::PI;
use std::hint::black_box;
use vibroimpact::{
    Harmonic, Kind, LinearSystem, OrbitOptions, PaperOptions, Parameter, Pattern, Scene, Stop,
    nalgebra, paper_scene, periodic_orbits,
};

/// Modes of the large system.
const MODES: usize = 10_000;

fn pair(criterion: &mut Criterion) {
    let scene = paper_scene(Kind::Three, &PaperOptions::default()).expect("valid");
    let far = scene
        .replace(Parameter::CLEARANCE.change(100.0))
        .expect("valid");
    let pattern = Pattern::single(1);
    let free = OrbitOptions {
        n_periods: 2,
        ..Default::default()
    };
    let given = OrbitOptions {
        phase: Some(2.0),
        ..free.clone()
    };
    let mut group = criterion.benchmark_group("pair");
    let count = periodic_orbits(&scene, &pattern, &free)
        .expect("solved")
        .len();
    group.throughput(Throughput::Elements(count as u64));
    group.bench_function("admissibility and multipliers", |bencher| {
        bencher.iter(|| {
            let orbits = periodic_orbits(black_box(&scene), &pattern, &free).expect("solved");
            for orbit in orbits.iter() {
                black_box((orbit.is_admissible(), orbit.stability().expect("converges")));
            }
            orbits
        });
    });
    group.throughput(Throughput::Elements(1));
    group.bench_function("none", |bencher| {
        bencher.iter(|| periodic_orbits(black_box(&far), &pattern, &free).expect("solved"));
    });
    group.bench_function("phase given", |bencher| {
        bencher.iter(|| periodic_orbits(black_box(&scene), &pattern, &given).expect("solved"));
    });
    group.finish();
}

/// A string with three stops along it.
fn string() -> Scene {
    let w = |j: usize| (j + 1) as f64;
    let each = |f: &dyn Fn(f64) -> f64| DVector::from_fn(MODES, |j, _| f(w(j)));
    let shape = |x: f64| each(&|w| 2.0f64.sqrt() * (PI * w * x).sin());
    let system = LinearSystem::new(each(&|_| 1.0), each(&|w| 0.04 * w), each(&|w| w * w));
    let forcing = Harmonic::new(shape(0.37).map(Complex::from), 1.5, 0.0);
    let stops = [0.2, 0.5, 0.7].map(|x| Stop::new(shape(x), 0.1, 0.8).expect("valid"));
    Scene::new(system.expect("valid"), forcing.expect("valid"), stops).expect("valid")
}

fn many_modes(criterion: &mut Criterion) {
    let scene = string();
    let pattern = Pattern::together(&[0, 1, 2]).expect("valid");
    let options = OrbitOptions {
        phase: Some(0.7),
        ..Default::default()
    };
    criterion.bench_function("10 000 modes, 3 stops at one instant", |bencher| {
        bencher.iter(|| periodic_orbits(black_box(&scene), &pattern, &options).expect("solved"));
    });
}

criterion_group!(benches, pair, many_modes);
criterion_main!(benches);
