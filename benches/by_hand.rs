//! Exact flights beside the same motion written by hand for its one scene: modes, a grid of steps on which signs are looked at,
//! Newton's method. It proves nothing, and passes contacts that begin and end between two of its looks; it is what a flight costs
//! without everything else. `cargo bench --bench by_hand` prints both for one trajectory of 50 periods, and for 2000 on one thread.

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use std::f64::consts::TAU;
use std::hint::black_box;
use vibroimpact::nalgebra::{DMatrix, DVector, dmatrix, dvector};
use vibroimpact::{
    Harmonic, Keep, LinearSystem, Scene, Side, SimulateOptions, Stop, SweepOptions, simulate,
    simulate_many,
};

const FREQUENCY: f64 = 1.1;
const FORCE: [f64; 2] = [0.5, 0.1];
const RATIO: f64 = 0.02;
const CLEARANCES: [f64; 2] = [0.3, 0.25];
const RESTITUTIONS: [f64; 2] = [0.8, 0.6];
const PERIODS: f64 = 50.0;
const STARTS: usize = 200;
/// Starts of an ensemble.
const MANY: usize = 2000;
/// Looks in a period of the fastest mode: fewer pass impacts that are no touches.
const LOOKS: f64 = 12.0;

/// Two unit masses between springs; modes `(1, 1)` and `(1, -1)` over the root of two.
const STIFFNESSES: [f64; 2] = [1.0, 3.0];

fn scene() -> Scene {
    let stiffness = dmatrix![2.0, -1.0; -1.0, 2.0];
    let shapes = dmatrix![1.0, 1.0; 1.0, -1.0] * 0.5f64.sqrt();
    let dampers = DVector::from_iterator(2, STIFFNESSES.iter().map(|k| 2.0 * RATIO * k.sqrt()));
    let damping: DMatrix<f64> = &shapes * DMatrix::from_diagonal(&dampers) * shapes.transpose();
    let system = LinearSystem::new(dvector![1.0, 1.0], damping, stiffness).expect("valid");
    let amplitude = DVector::from_iterator(2, FORCE.iter().map(|&f| f.into()));
    let force = Harmonic::new(amplitude, FREQUENCY, 0.0).expect("valid");
    let stop = |i: usize| Stop::new(i, CLEARANCES[i], RESTITUTIONS[i]).expect("valid");
    Scene::new(system, force, [stop(0), stop(1).on_side(Side::Lower)]).expect("valid")
}

/// A mode: rate of decay, damped frequency, steady response.
#[derive(Clone, Copy)]
struct Mode {
    eta: f64,
    turn: f64,
    steady: [f64; 2],
}

/// A mode's own motion `e^{-eta t} (a cos + b sin)`, as its value and slope.
type Own = [f64; 2];

struct ByHand {
    modes: [Mode; 2],
    step: f64,
    /// What a step does to each mode's own motion, and to the phasor of the force.
    carried: [[f64; 4]; 2],
    turned: [f64; 2],
}

impl Mode {
    fn over(&self, t: f64) -> [f64; 4] {
        let (sin, cos) = (self.turn * t).sin_cos();
        let decay = (-self.eta * t).exp();
        let (c, s) = (decay * cos, decay * sin / self.turn);
        let square = self.eta * self.eta + self.turn * self.turn;
        [c + self.eta * s, s, -square * s, c - self.eta * s]
    }
}

fn times(m: &[f64; 4], x: Own) -> Own {
    [m[0] * x[0] + m[1] * x[1], m[2] * x[0] + m[3] * x[1]]
}

impl ByHand {
    fn new() -> Self {
        let modes = [0, 1].map(|j| {
            let w = STIFFNESSES[j].sqrt();
            let force = 0.5f64.sqrt() * (FORCE[0] + if j == 0 { FORCE[1] } else { -FORCE[1] });
            let (a, b) = (
                STIFFNESSES[j] - FREQUENCY * FREQUENCY,
                2.0 * RATIO * w * FREQUENCY,
            );
            let size = a * a + b * b;
            Mode {
                eta: RATIO * w,
                turn: w * (1.0 - RATIO * RATIO).sqrt(),
                steady: [force * a / size, -force * b / size],
            }
        });
        let step = TAU / STIFFNESSES[1].sqrt() / LOOKS;
        let (sin, cos) = (FREQUENCY * step).sin_cos();
        Self {
            carried: [modes[0].over(step), modes[1].over(step)],
            modes,
            step,
            turned: [cos, sin],
        }
    }

    /// Positions and velocities of both masses.
    fn masses(&self, own: &[Own; 2], u: [f64; 2]) -> [[f64; 2]; 2] {
        let whole = [0, 1].map(|j| {
            let [re, im] = self.modes[j].steady;
            let value = own[j][0] + re * u[0] - im * u[1];
            [value, own[j][1] - FREQUENCY * (re * u[1] + im * u[0])]
        });
        let half = 0.5f64.sqrt();
        [0, 1].map(|c| {
            [
                half * (whole[0][c] + whole[1][c]),
                half * (whole[0][c] - whole[1][c]),
            ]
        })
    }

    /// Gaps and opening speeds.
    fn gaps(&self, own: &[Own; 2], u: [f64; 2]) -> [[f64; 2]; 2] {
        let [q, v] = self.masses(own, u);
        [[CLEARANCES[0] - q[0], -v[0]], [CLEARANCES[1] + q[1], v[1]]]
    }

    fn at(&self, own: &[Own; 2], since: f64, s: f64) -> ([Own; 2], [f64; 2]) {
        let (sin, cos) = (FREQUENCY * (since + s)).sin_cos();
        (
            [0, 1].map(|j| times(&self.modes[j].over(s), own[j])),
            [cos, sin],
        )
    }

    /// Impacts up to a time, and the positions then.
    fn run(&self, q: [f64; 2], v: [f64; 2], end: f64) -> (usize, [f64; 2]) {
        let half = 0.5f64.sqrt();
        let modal = |x: [f64; 2]| [half * (x[0] + x[1]), half * (x[0] - x[1])];
        let (y, w) = (modal(q), modal(v));
        let mut u = [1.0, 0.0];
        let mut own = [0, 1].map(|j| {
            let [re, im] = self.modes[j].steady;
            [y[j] - re, w[j] + FREQUENCY * im]
        });
        let (mut time, mut impacts, mut just) = (0.0, 0, usize::MAX);
        while time < end {
            let ahead = [
                times(&self.carried[0], own[0]),
                times(&self.carried[1], own[1]),
            ];
            let next = [
                u[0] * self.turned[0] - u[1] * self.turned[1],
                u[0] * self.turned[1] + u[1] * self.turned[0],
            ];
            let gaps = self.gaps(&ahead, next);
            let passed = |i: usize| gaps[i][0] < 0.0 && (i != just || gaps[i][1] < 0.0);
            let Some(first) = (0..2).find(|&i| passed(i)) else {
                (own, u, time, just) = (ahead, next, time + self.step, usize::MAX);
                continue;
            };
            let mut hit = (f64::INFINITY, first);
            for i in (first..2).filter(|&i| passed(i)) {
                let mut s = self.step - gaps[i][0] / gaps[i][1];
                for _ in 0..30 {
                    let (there, phasor) = self.at(&own, time, s);
                    let [gap, speed] = self.gaps(&there, phasor)[i];
                    let change = gap / speed;
                    s -= change;
                    if change.abs() < 1e-15 {
                        break;
                    }
                }
                if s < hit.0 {
                    hit = (s, i);
                }
            }
            let (s, i) = hit;
            let (mut there, phasor) = self.at(&own, time, s);
            let speed = self.gaps(&there, phasor)[i][1];
            let kick = (1.0 + RESTITUTIONS[i]) * speed * half;
            if i == 0 {
                there[0][1] += kick;
                there[1][1] += kick;
            } else {
                there[0][1] -= kick;
                there[1][1] += kick;
            }
            (own, u, time, just) = (there, phasor, time + s, i);
            impacts += 1;
        }
        let (there, phasor) = self.at(&own, time, end - time);
        (impacts, self.masses(&there, phasor)[0])
    }
}

fn starts(count: usize) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + Clone {
    (0..count).map(move |k| {
        let x = k as f64 / count as f64;
        (
            [0.1 * (TAU * x).cos(), 0.1 * (2.0 * TAU * x).sin()],
            [0.2 * x, 0.1 - 0.2 * x],
        )
    })
}

fn by_hand(criterion: &mut Criterion) {
    let (scene, own, end) = (scene(), ByHand::new(), PERIODS * TAU / FREQUENCY);
    let options = SimulateOptions {
        keep: Keep::Final,
        ..Default::default()
    };
    let whole = |(q, v): ([f64; 2], [f64; 2])| {
        let (q, v) = (dvector![q[0], q[1]], dvector![v[0], v[1]]);
        simulate(&scene, &q, &v, (0.0, end), &options).expect("valid")
    };
    let (mut same, mut impacts) = (0, 0);
    for start in starts(STARTS) {
        let run = whole(start);
        let (count, q) = own.run(start.0, start.1, end);
        impacts += run.stats().n_impacts;
        let off = (run.last().0[0] - q[0])
            .abs()
            .max((run.last().0[1] - q[1]).abs());
        same += usize::from(count == run.stats().n_impacts && off < 1e-9);
    }
    println!("{impacts} impacts from {STARTS} starts; {same} have the same end by hand");
    let mut group = criterion.benchmark_group("one trajectory of 50 periods");
    let mut all = starts(STARTS).cycle();
    let mut start = || all.next().expect("without end");
    group.bench_function("exact flights", |bencher| {
        bencher.iter_batched(
            &mut start,
            |start| whole(black_box(start)),
            BatchSize::SmallInput,
        );
    });
    let mut all = starts(STARTS).cycle();
    let mut start = || all.next().expect("without end");
    group.bench_function("by hand", |bencher| {
        let run = |(q, v): ([f64; 2], [f64; 2])| own.run(black_box(q), black_box(v), end);
        bencher.iter_batched(&mut start, run, BatchSize::SmallInput);
    });
    group.finish();
    let column = |of: fn(([f64; 2], [f64; 2])) -> [f64; 2]| {
        DMatrix::from_row_iterator(MANY, 2, starts(MANY).flat_map(of))
    };
    let (q, v) = (column(|start| start.0), column(|start| start.1));
    let sweep = SweepOptions { threads: Some(1) };
    let mut group = criterion.benchmark_group("2000 trajectories of 50 periods");
    group.sample_size(10);
    group.bench_function("exact flights", |bencher| {
        bencher
            .iter(|| simulate_many(&scene, (&q, &v), (0.0, end), &options, sweep).expect("valid"));
    });
    group.bench_function("by hand", |bencher| {
        let run = |(q, v)| own.run(black_box(q), black_box(v), end).0;
        bencher.iter(|| starts(MANY).map(run).sum::<usize>());
    });
    group.finish();
}

criterion_group!(benches, by_hand);
criterion_main!(benches);
