//! Microseconds per cell of an existence map: two degrees of freedom, one stop hit, on one thread. `none`: every cell
//! beyond the fold, so existence and phase alone; `orbits`: 1.5 orbits a cell, with admissibility and multipliers.
//! `cargo bench --bench existence`; ratios to `SciPy`: `python benches/against_scipy.py`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::Duration;
use vibroimpact::{Axis, Kind, PaperOptions, Pattern, SweepOptions, existence_map, paper_scene};

/// Cells along one side of the maps.
const SIDE: u32 = 100;

fn axis(name: &str, low: f64, high: f64) -> Axis {
    let step = (high - low) / f64::from(SIDE);
    Axis::new(
        name.parse().expect("a name"),
        (0..SIDE).map(|i| low + step * (f64::from(i) + 0.5)),
    )
}

fn existence(criterion: &mut Criterion) {
    let scene = paper_scene(Kind::Two, &PaperOptions::default()).expect("valid");
    let pattern = Pattern::single(0);
    let mut group = criterion.benchmark_group("existence_map");
    group
        .throughput(Throughput::Elements(u64::from(SIDE * SIDE)))
        .measurement_time(Duration::from_secs(5));
    for (label, scale) in [("none", (0.0, 0.01)), ("orbits", (0.2, 2.2))] {
        let (x, y) = (
            axis("frequency", 1.0, 2.0),
            axis("forcing_scale", scale.0, scale.1),
        );
        group.bench_function(label, |bencher| {
            bencher.iter(|| {
                let options = SweepOptions { threads: Some(1) };
                existence_map(black_box(&scene), &pattern, (&x, &y), 2, options).expect("solved")
            });
        });
    }
    group.finish();
}

criterion_group!(benches, existence);
criterion_main!(benches);
