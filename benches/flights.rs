//! Microseconds per impact of exact flights: the two linear pendulums of the paper's third case, nothing kept but the end.
//! `cargo bench --bench flights`; ratios to `SciPy`: `python benches/against_scipy.py`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use vibroimpact::nalgebra::dvector;
use vibroimpact::{Keep, Kind, PaperOptions, SimulateOptions, paper_scene, simulate};

/// Length of the run: some thousand impacts.
const SPAN: f64 = 20_000.0;

fn flights(criterion: &mut Criterion) {
    let scene = paper_scene(Kind::Three, &PaperOptions::default()).expect("valid");
    let (q0, v0) = (dvector![0.02, -0.1], dvector![0.0, 0.3]);
    let options = SimulateOptions {
        keep: Keep::Final,
        ..Default::default()
    };
    let run = || simulate(black_box(&scene), &q0, &v0, (0.0, SPAN), &options).expect("valid");
    let impacts = run().stats().n_impacts;
    let mut group = criterion.benchmark_group("flights");
    group.throughput(Throughput::Elements(impacts as u64));
    group.bench_function("one impact", |bencher| bencher.iter(run));
    group.finish();
}

criterion_group!(benches, flights);
criterion_main!(benches);
