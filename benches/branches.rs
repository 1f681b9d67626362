//! A branch of one degree of freedom with one impact over its force, round a fold: the time of all its points, whose number is printed,
//! beside that of as many orbits found one from another. `cargo bench --bench branches`.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::ops::ControlFlow;
use vibroimpact::nalgebra::{dmatrix, dvector};
use vibroimpact::{
    Change, ContinuationOptions, Harmonic, LinearSystem, OrbitOptions, Parameter, Pattern, Scene,
    Stop, Virtual, continuation, find_orbit, periodic_orbits,
};

fn branches(criterion: &mut Criterion) {
    let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0]).expect("valid");
    let force = Harmonic::new(dvector![1.0.into()], 2.8, 0.0).expect("valid");
    let stop = Stop::new(0, -0.5, 0.8).expect("valid");
    let scene = Scene::new(system, force, [stop]).expect("valid");
    let found = periodic_orbits(&scene, &Pattern::single(0), &OrbitOptions::default());
    let orbit = &found.expect("some")[0];
    let options = ContinuationOptions {
        beyond: Virtual::Keep,
        ..ContinuationOptions::default()
    };
    let follow = || {
        let go_on = &mut |_| ControlFlow::Continue(());
        let branch = continuation(orbit, Parameter::ForcingScale, (0.2, 5.0), &options, go_on);
        branch.expect("a branch")
    };
    let count = follow().orbits.len();
    let mut group = criterion.benchmark_group(format!("{count} points"));
    group.bench_function("a branch", |b| b.iter(|| black_box(follow())));
    group.bench_function("a branch with its multipliers", |b| {
        b.iter(|| black_box(follow().n_unstable()));
    });
    group.bench_function("orbits one from another", |b| {
        b.iter(|| {
            let mut last = orbit.clone();
            for k in 0..count {
                let scale = 1.0 + 0.5 * k as f64 / count as f64;
                let scene = scene.replace(Change::ForcingScale(scale)).expect("valid");
                last = find_orbit(&scene, &last, None).expect("an orbit");
                black_box(last.is_admissible());
            }
            last
        });
    });
    group.finish();
}

criterion_group!(benches, branches);
criterion_main!(benches);
