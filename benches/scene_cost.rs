//! What each part of a scene costs: nanoseconds and instructions for one impact of an exact flight, one Runge-Kutta step or one
//! step along a Taylor series, with and without forcing, damping, damping that is not proportional, further stops, and a
//! motion that is kept; and what a call takes whatever its length. Forces and damping are so small that the motion, and with
//! it the search, stays the same: what differs is the machinery.
//! `cargo bench --bench scene_cost`; instructions are counted where valgrind is installed.
//!
//! Times are medians of runs in turn. Instructions of a unit are those of a run of 2 N units less those of a run of N, so that
//! what is done once falls out; those of a call are what a further run of one unit takes, less its units.
//! `scene_cost --count CASE UNITS TIMES` makes such runs and prints their units and, as bits, the state in which they end.

use std::hint::black_box;
use std::process::Command;
use std::time::Instant;
use vibroimpact::nalgebra::{DVector, dmatrix, dvector};
use vibroimpact::{
    BaseMotion, Coefficient, DoublePendulum, Forcing, Harmonic, Keep, LinearSystem, Method, Scene,
    Side, SimulateOptions, Solver, Stop, Trajectory, Wall, WallSide, simulate,
};

/// Runs of each case.
const ROUNDS: usize = 15;
/// Units in a timed run, and in a counted one.
const TIMED: usize = 20_000;
const COUNTED: usize = 2_000;
/// Runs of one unit, timed or counted together.
const CALLS: usize = 50;
/// Small enough to change nothing.
const SMALL: f64 = 1e-9;

/// A scene, how it is moved and what is kept of it.
struct Case {
    name: &'static str,
    scene: Scene,
    keep: Keep,
    method: Method,
}

impl Case {
    /// Runs about so many impacts, or steps where there are any.
    fn run(&self, units: usize) -> Trajectory {
        // The impacts are 3.2 time units apart, the steps 0.1.
        let pace = if self.is_stepped() { 0.1 } else { 3.2 };
        let options = SimulateOptions {
            solver: Solver {
                method: self.method,
                rtol: 1e-6,
                ..Solver::default()
            },
            keep: self.keep,
            ..Default::default()
        };
        let span = (0.0, pace * units as f64);
        let n = self.scene.n_dof();
        let (q0, v0) = (DVector::zeros(n), DVector::from_element(n, 0.7));
        simulate(&self.scene, &q0, &v0, span, &options).expect("the scenes are valid")
    }

    fn is_stepped(&self) -> bool {
        self.method != Method::Exact
    }

    /// How many impacts or steps a run had.
    fn units(&self, run: &Trajectory) -> usize {
        let stats = run.stats();
        if self.is_stepped() {
            stats.n_steps
        } else {
            stats.n_impacts
        }
    }
}

fn stop(coordinate: usize, clearance: f64) -> Stop {
    Stop::new(coordinate, clearance, 1.0).expect("valid")
}

fn stops(count: usize) -> Vec<Stop> {
    let all = [
        stop(0, 0.1),
        stop(1, 50.0),
        stop(1, 60.0).on_side(Side::Lower),
        stop(0, 70.0).on_side(Side::Lower),
    ];
    all.into_iter().take(count).collect()
}

fn harmonic() -> Forcing {
    let force = Harmonic::new(dvector![SMALL.into(), SMALL.into()], 0.77, 0.0);
    force.expect("valid").into()
}

fn system(damping: Coefficient) -> LinearSystem {
    let (mass, stiffness) = (dmatrix![2.0, 0.5; 0.5, 1.0], dmatrix![5.0, -2.0; -2.0, 3.0]);
    LinearSystem::new(mass, damping, stiffness).expect("valid")
}

fn linear(damping: Coefficient, forcing: Forcing, stops: Vec<Stop>) -> Scene {
    Scene::new(system(damping), forcing, stops).expect("valid")
}

fn loaded(damping: Coefficient, stops: Vec<Stop>) -> Scene {
    let system = system(damping).with_load(dvector![SMALL, SMALL]);
    Scene::new(system.expect("valid"), Forcing::Unforced, stops).expect("valid")
}

fn pendulum(dampers: f64, forcing: Forcing, n_walls: usize) -> Scene {
    let wall = |bob, place, side| Wall::new(bob, place, 1.0, side).expect("valid");
    let walls = [
        wall(1, 0.1, WallSide::Right),
        wall(1, -5.0, WallSide::Left),
        wall(0, 5.0, WallSide::Right),
    ];
    let system = DoublePendulum::new(1.0, 2.0, (dampers, dampers)).expect("valid");
    Scene::new(system, forcing, walls.into_iter().take(n_walls)).expect("valid")
}

fn cases() -> Vec<Case> {
    let none = || Coefficient::from(dmatrix![0.0, 0.0; 0.0, 0.0]);
    let proportional = || Coefficient::from(dmatrix![5.0, -2.0; -2.0, 3.0] * SMALL);
    let other = || Coefficient::from(dmatrix![1.0, 0.0; 0.0, 0.0] * SMALL);
    let free = || Forcing::Unforced;
    let base = || Forcing::from(BaseMotion::new(SMALL, 0.77, 0.0).expect("valid"));
    let by = |method| {
        move |name, scene, keep| Case {
            name,
            scene,
            keep,
            method,
        }
    };
    let (exact, stepped) = (by(Method::Exact), by(Method::Rk45));
    let series = by(Method::Taylor);
    let last = Keep::Final;
    vec![
        exact("exact: one stop", linear(none(), free(), stops(1)), last),
        exact(
            "exact: and forcing",
            linear(none(), harmonic(), stops(1)),
            last,
        ),
        exact("exact: and load", loaded(none(), stops(1)), last),
        exact(
            "exact: damping, load",
            loaded(proportional(), stops(1)),
            last,
        ),
        exact("exact: complex, load", loaded(other(), stops(1)), last),
        exact(
            "exact: and damping",
            linear(proportional(), free(), stops(1)),
            last,
        ),
        exact(
            "exact: and complex modes",
            linear(other(), free(), stops(1)),
            last,
        ),
        exact(
            "exact: complex, forcing",
            linear(other(), harmonic(), stops(1)),
            last,
        ),
        exact("exact: 2 stops", linear(none(), free(), stops(2)), last),
        exact("exact: 3 stops", linear(none(), free(), stops(3)), last),
        exact("exact: 4 stops", linear(none(), free(), stops(4)), last),
        exact(
            "exact: impacts kept",
            linear(none(), free(), stops(1)),
            Keep::Impacts,
        ),
        exact(
            "exact: motion kept",
            linear(none(), free(), stops(1)),
            Keep::Motion,
        ),
        stepped("rk45: no stop", linear(none(), free(), stops(0)), last),
        stepped(
            "rk45: and forcing",
            linear(none(), harmonic(), stops(0)),
            last,
        ),
        stepped("rk45: and damping", linear(other(), free(), stops(0)), last),
        stepped("rk45: 1 stop", linear(none(), free(), stops(1)), last),
        stepped("rk45: 2 stops", linear(none(), free(), stops(2)), last),
        stepped("rk45: 3 stops", linear(none(), free(), stops(3)), last),
        stepped("rk45: 4 stops", linear(none(), free(), stops(4)), last),
        stepped(
            "rk45: motion kept",
            linear(none(), free(), stops(0)),
            Keep::Motion,
        ),
        stepped("rk45: pendulum", pendulum(0.0, free(), 0), last),
        stepped("rk45: walled pendulum", pendulum(0.0, free(), 1), last),
        series("taylor: no wall", pendulum(0.0, free(), 0), last),
        series("taylor: base motion", pendulum(0.0, base(), 0), last),
        series("taylor: joint dampers", pendulum(SMALL, free(), 0), last),
        series("taylor: 1 wall", pendulum(0.0, free(), 1), last),
        series("taylor: 2 walls", pendulum(0.0, free(), 2), last),
        series("taylor: 3 walls", pendulum(0.0, free(), 3), last),
        series(
            "taylor: motion kept",
            pendulum(0.0, free(), 0),
            Keep::Motion,
        ),
    ]
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Nanoseconds for each case, by what is timed of it: medians of runs in turn.
fn times(cases: &[Case], time: impl Fn(&Case) -> f64) -> Vec<f64> {
    let mut all = vec![Vec::new(); cases.len()];
    for _ in 0..ROUNDS {
        for (case, times) in cases.iter().zip(&mut all) {
            times.push(time(case));
        }
    }
    all.into_iter().map(median).collect()
}

/// Nanoseconds for one unit.
fn unit(case: &Case) -> f64 {
    let start = Instant::now();
    let run = case.run(TIMED);
    start.elapsed().as_secs_f64() * 1e9 / case.units(&run) as f64
}

/// Nanoseconds for a call with one unit.
fn call(case: &Case) -> f64 {
    let start = Instant::now();
    for _ in 0..CALLS {
        black_box(case.run(1));
    }
    start.elapsed().as_secs_f64() * 1e9 / CALLS as f64
}

/// Instructions and units of runs of a case in a process of their own; `None` without valgrind.
fn counted(case: &Case, units: usize, times: usize) -> Option<(f64, f64)> {
    let binary = std::env::current_exe().ok()?;
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(binary)
        .args(["--count", case.name, &units.to_string(), &times.to_string()])
        .output()
        .ok()?;
    let (told, printed) = (
        String::from_utf8_lossy(&output.stderr),
        String::from_utf8_lossy(&output.stdout),
    );
    let line = told.lines().find(|line| line.contains("Collected :"))?;
    let count = line.rsplit(' ').next()?.parse().ok()?;
    Some((count, printed.split_whitespace().next()?.parse().ok()?))
}

/// Instructions for one unit of a case, and for a call beside its units.
fn instructions(case: &Case) -> Option<(f64, f64)> {
    let (few, many) = (counted(case, COUNTED, 1)?, counted(case, 2 * COUNTED, 1)?);
    let unit = (many.0 - few.0) / (many.1 - few.1);
    let (once, again) = (counted(case, 1, CALLS)?, counted(case, 1, 2 * CALLS)?);
    let call = (again.0 - once.0) / CALLS as f64;
    Some((unit, call - unit * (again.1 - once.1) / CALLS as f64))
}

/// Makes runs of a case; prints the units of all of them, and the bits of the state in which the last ends.
fn make(case: &Case, units: usize, times: usize) {
    let mut total = 0;
    let mut bits: Vec<String> = Vec::new();
    for k in 1..=times {
        let run = case.run(units);
        total += case.units(&run);
        if k == times {
            let (q, v) = run.last();
            let numbers = q.iter().chain(v.iter());
            bits = numbers.map(|x| format!("{:016x}", x.to_bits())).collect();
        }
    }
    println!("{total} {}", bits.join(" "));
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let cases = cases();
    if let [_, mode, name, units, times] = arguments.as_slice()
        && mode == "--count"
    {
        let number = |text: &str| text.parse::<usize>().expect("a number");
        let case = cases.iter().find(|case| case.name == name);
        make(case.expect("a case"), number(units), number(times));
        return;
    }
    println!(
        "{:28} {:>8} {:>13} {:>9} {:>13}",
        "one impact or step", "ns", "instructions", "call ns", "beside units"
    );
    let all = times(&cases, unit).into_iter().zip(times(&cases, call));
    for (case, (unit, call)) in cases.iter().zip(all) {
        let counts = instructions(case);
        let told = |of: fn((f64, f64)) -> f64| {
            counts.map_or_else(|| "-".to_owned(), |both| format!("{:.0}", of(both)))
        };
        let (count, fixed) = (told(|both| both.0), told(|both| both.1));
        println!(
            "{:28} {unit:8.0} {count:>13} {call:9.0} {fixed:>13}",
            case.name
        );
    }
}
