//! Families of motions of one degree of freedom: a diagram of 800 values of 250 periods beside as many runs of a loop, and a chaotic motion
//! with its exponents beside the same without. `cargo bench --bench families` prints medians of all.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use vibroimpact::nalgebra::{dmatrix, dvector};
use vibroimpact::{
    Axis, DiagramOptions, Harmonic, Keep, LinearSystem, LyapunovOptions, Parameter, Scene,
    SimulateOptions, Stop, SweepOptions, bifurcation_diagram, lyapunov_exponents, simulate,
};

const VALUES: usize = 800;
const TRANSIENT: usize = 200;
const PERIODS: usize = 50;
/// Time in which the motion has some 10 000 impacts.
const TIME: f64 = 38_000.0;

/// `x'' + 0.1 x' + x = F cos 2.4 t` before a stop at one, restitution 0.8.
fn oscillator(force: f64) -> Scene {
    let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0]).expect("valid");
    let force = Harmonic::new(dvector![force.into()], 2.4, 0.0).expect("valid");
    let stop = Stop::new(0, 1.0, 0.8).expect("valid");
    Scene::new(system, force, [stop]).expect("valid")
}

fn families(criterion: &mut Criterion) {
    let scene = oscillator(1.0);
    let factors: Vec<f64> = (0..VALUES)
        .map(|k| 4.5 + 4.0 * k as f64 / VALUES as f64)
        .collect();
    let axis = Axis::new(Parameter::ForcingScale, factors.iter().copied());
    let options = DiagramOptions {
        transient: TRANSIENT,
        periods: PERIODS,
        sweep: SweepOptions { threads: Some(1) },
        ..DiagramOptions::default()
    };
    let mut group = criterion.benchmark_group("diagram of 800 values");
    group.sample_size(10);
    group.bench_function("bifurcation_diagram", |b| {
        b.iter(|| black_box(bifurcation_diagram(&scene, &axis, &options).expect("a diagram")));
    });
    group.bench_function("a loop of runs", |b| {
        b.iter(|| {
            let (mut q, mut v) = (dvector![0.0], dvector![0.0]);
            let keep = SimulateOptions {
                keep: Keep::Final,
                ..SimulateOptions::default()
            };
            for &factor in &factors {
                let scene = scene
                    .replace(Parameter::ForcingScale.change(factor))
                    .expect("valid");
                let span = (
                    0.0,
                    (TRANSIENT + PERIODS) as f64 * scene.period().expect("forced"),
                );
                let run = simulate(&scene, &q, &v, span, &keep).expect("a run");
                (q, v) = (run.last().0.clone(), run.last().1.clone());
            }
            black_box((q, v))
        });
    });
    group.finish();
    let (chaotic, rest) = (oscillator(5.0), dvector![0.0]);
    let mut group = criterion.benchmark_group("10 000 impacts");
    group.sample_size(10);
    group.bench_function("with exponents", |b| {
        let options = LyapunovOptions::default();
        b.iter(|| lyapunov_exponents(&chaotic, &rest, &rest, (0.0, TIME), black_box(&options)));
    });
    for (name, keep) in [("without", Keep::Final), ("kept", Keep::Motion)] {
        let options = SimulateOptions {
            keep,
            ..SimulateOptions::default()
        };
        group.bench_function(name, |b| {
            b.iter(|| simulate(&chaotic, &rest, &rest, (0.0, TIME), black_box(&options)));
        });
    }
    group.finish();
}

criterion_group!(benches, families);
criterion_main!(benches);
