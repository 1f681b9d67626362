//! A branch of one degree of freedom with one impact over its force, round a fold: the time of all its points, whose number is printed,
//! beside that of as many orbits found one from another; what is born where its stop is touched; the curve of its fold over force and
//! frequency. Branches of many modes. `cargo bench --bench branches`.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use vibroimpact::nalgebra::{DVector, dmatrix, dvector};
use vibroimpact::{
    ContinuationOptions, CurveOf, Harmonic, Kind, LinearSystem, Motion, OrbitOptions, PaperOptions,
    Parameter, Pattern, PeriodicOrbit, Scene, SegmentKind, SimulateOptions, Solver, SpecialKind,
    Stop, Virtual, bifurcation_curve, branches as born, continuation, find_orbit, paper_scene,
    periodic_orbits, simulate,
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
        let branch = continuation(orbit, Parameter::ForcingScale, (0.2, 5.0), &options);
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
                let scene = scene
                    .replace(Parameter::ForcingScale.change(scale))
                    .expect("valid");
                last = find_orbit(&scene, &last, None).expect("an orbit");
                black_box(last.is_admissible());
            }
            last
        });
    });
    group.finish();

    let stop_at = ContinuationOptions::default();
    let ended = continuation(orbit, Parameter::ForcingScale, (0.2, 5.0), &stop_at);
    let special = ended.expect("a branch").special;
    let of = |kind: SpecialKind| special.iter().find(|own| own.kind == kind).expect("it");
    let (fold, graze) = (of(SpecialKind::Fold), of(SpecialKind::Graze));
    let plane = [Parameter::Frequency, Parameter::ForcingScale];
    let curve = || {
        let own = CurveOf::Special(fold);
        let between = [(2.2, 3.4), (0.5, 2.0)];
        bifurcation_curve(own, plane, between, &stop_at).expect("a curve")
    };
    let count = curve().x.len();
    criterion.bench_function(&format!("a curve of {count} folds"), |b| {
        b.iter(|| black_box(curve()));
    });
    criterion.bench_function("the branches at a graze", |b| {
        b.iter(|| black_box(born(graze, Parameter::ForcingScale, (0.2, 5.0)).expect("branches")));
    });
}

/// Many modes, hit at one end: each point with its certificate and the count of its multipliers.
fn many_modes(criterion: &mut Criterion) {
    for n in [30, 100, 300, 1000] {
        let frequencies = DVector::from_fn(n, |i, _| 1.0 + i as f64);
        let stiffness = frequencies.map(|w| w * w);
        let damping = frequencies.map(|w| 0.02 * w);
        let ones = DVector::from_element(n, 1.0);
        let system = LinearSystem::new(ones.clone(), damping, stiffness).expect("valid");
        let force = DVector::from_fn(n, |i, _| (1.0 / (1.0 + i as f64)).into());
        let force = Harmonic::new(force, 2.4, 0.0).expect("valid");
        // A place that sees all modes, less of the higher ones.
        let normal = DVector::from_fn(n, |i, _| 1.0 / (1.0 + 0.1 * i as f64));
        let stop = Stop::new(normal, 0.3, 0.8).expect("valid");
        let scene = Scene::new(system, force, [stop]).expect("valid");
        let found = periodic_orbits(&scene, &Pattern::single(0), &OrbitOptions::default());
        let orbit = &found.expect("some")[0];
        let options = ContinuationOptions {
            beyond: Virtual::Keep,
            max_points: 40,
            ..ContinuationOptions::default()
        };
        let follow = || {
            let branch = continuation(orbit, Parameter::ForcingScale, (0.5, 2.0), &options);
            branch.expect("a branch")
        };
        let count = follow().orbits.len();
        criterion.bench_function(&format!("{count} points of {n} modes"), |b| {
            b.iter(|| black_box(follow()));
        });
        // Each forcing has a motion that passes the stop.
        let found = periodic_orbits(&scene, &Pattern::none(), &OrbitOptions::default());
        let rest = &found.expect("one")[0];
        let name = format!("of {n} modes that hit nothing");
        time_branch(criterion, &name, rest, (0.9, 1.1));
    }
}

/// Two masses before two stops, hit three times and then on and on until one is held.
fn chatter(criterion: &mut Criterion) {
    let stiffness = dmatrix![5.2, -2.9; -2.9, 2.9];
    let system = LinearSystem::new(dvector![1.0, 1.0], &stiffness * 0.28, stiffness);
    let force = Harmonic::new(dvector![0.0.into(), 2.0.into()], 0.64, 0.0).expect("valid");
    let stops = [(0, -0.11), (1, 0.39)].map(|(i, at)| Stop::new(i, at, 0.41).expect("valid"));
    let scene = Scene::new(system.expect("valid"), force, stops).expect("valid");
    let (q, v) = (dvector![-0.5, -0.5], dvector![0.0, 0.0]);
    let until = 80.0 * scene.period().expect("forced");
    let run = simulate(&scene, &q, &v, (0.0, until), &SimulateOptions::default());
    let orbit = find_orbit(&scene, &run.expect("a run"), None).expect("an orbit");
    let segments = orbit.segments().expect("kept");
    assert!(segments.iter().any(|own| own.kind == SegmentKind::Chatter));
    time_branch(criterion, "with a chatter", &orbit, (0.95, 1.02));
}

/// The paper's double pendulum with large motions, which hits both walls; the same motion integrated once, as closely, beside it.
fn pendulum(criterion: &mut Criterion) {
    let large = PaperOptions {
        linear: false,
        ..PaperOptions::default()
    };
    let scene = paper_scene(Kind::Three, &large).expect("valid");
    let (q, v) = (dvector![0.1, -0.1], dvector![0.0, 0.0]);
    let until = 120.0 * scene.period().expect("forced");
    let run = simulate(&scene, &q, &v, (0.0, until), &SimulateOptions::default());
    let orbit = find_orbit(&scene, &run.expect("a run"), None).expect("an orbit");
    assert_eq!(orbit.impacts().len(), 4);
    time_branch(criterion, "of a pendulum", &orbit, (0.97, 1.03));
    time_branch(
        criterion,
        "of a pendulum, none special",
        &orbit,
        (0.997, 1.003),
    );
    let (q, v) = (orbit.q0(), orbit.v0());
    let close = SimulateOptions {
        solver: Solver {
            rtol: 1e-13,
            atol: Some(1e-15),
            ..Solver::default()
        },
        ..SimulateOptions::default()
    };
    let (scene, period) = (orbit.scene(), orbit.period());
    criterion.bench_function("the pendulum integrated", |b| {
        b.iter(|| black_box(simulate(scene, &q, &v, (0.0, period), &close).expect("a run")));
    });
}

/// The branch of an orbit over its frequency, in parts of that.
fn time_branch(criterion: &mut Criterion, name: &str, orbit: &PeriodicOrbit, range: (f64, f64)) {
    let w = std::f64::consts::TAU * orbit.n_periods() as f64 / orbit.period();
    let options = ContinuationOptions {
        beyond: Virtual::Keep,
        ..ContinuationOptions::default()
    };
    let follow = || {
        let range = (range.0 * w, range.1 * w);
        continuation(orbit, Parameter::Frequency, range, &options).expect("a branch")
    };
    let count = follow().orbits.len();
    criterion.bench_function(&format!("{count} points {name}"), |b| {
        b.iter(|| black_box(follow()));
    });
}

criterion_group!(benches, branches, many_modes, chatter, pendulum);
criterion_main!(benches);
