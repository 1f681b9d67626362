//! What each part of a scene costs: nanoseconds and instructions for one impact of an exact flight or one Runge-Kutta step,
//! with and without forcing, damping, damping that is not proportional, further stops, and a motion that is kept. Forces and
//! damping are so small that the motion, and with it the search, stays the same: what differs is the machinery.
//! `cargo bench --bench scene_cost`; instructions are counted where valgrind is installed.
//!
//! Times are medians of runs in turn. Instructions are those of a run of 2 N units less those of a run of N, so that what is
//! done once falls out. `scene_cost --count CASE N` is one such run.

use std::process::Command;
use std::time::Instant;
use vibroimpact::nalgebra::{DVector, dmatrix, dvector};
use vibroimpact::{
    Coefficient, DoublePendulum, Forcing, Harmonic, Keep, LinearSystem, Method, Scene, Side,
    SimulateOptions, Stop, Wall, WallSide, simulate,
};

/// Runs of each case.
const ROUNDS: usize = 15;
/// Units in a timed run, and in a counted one.
const TIMED: usize = 20_000;
const COUNTED: usize = 2_000;
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
    /// Runs about so many impacts, or steps where there are any, and says how many there were.
    fn run(&self, units: usize) -> usize {
        let is_stepped = self.method == Method::Rk45;
        // The impacts are 3.2 time units apart, the steps 0.1.
        let pace = if is_stepped { 0.1 } else { 3.2 };
        let options = SimulateOptions {
            method: self.method,
            rtol: 1e-6,
            keep: self.keep,
            ..Default::default()
        };
        let span = (0.0, pace * units as f64);
        let n = self.scene.n_dof();
        let (q0, v0) = (DVector::zeros(n), DVector::from_element(n, 0.7));
        let stats = simulate(&self.scene, &q0, &v0, span, &options).map(|run| run.stats());
        let stats = stats.expect("the scenes are valid");
        if is_stepped {
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

fn pendulum(is_walled: bool) -> Scene {
    let wall = Wall::new(1, 0.1, 1.0, WallSide::Right).expect("valid");
    let walls = is_walled.then_some(wall);
    let system = DoublePendulum::new(1.0, 2.0, (0.0, 0.0)).expect("valid");
    Scene::new(system, Forcing::Unforced, walls).expect("valid")
}

fn cases() -> Vec<Case> {
    let none = || Coefficient::from(dmatrix![0.0, 0.0; 0.0, 0.0]);
    let proportional = || Coefficient::from(dmatrix![5.0, -2.0; -2.0, 3.0] * SMALL);
    let other = || Coefficient::from(dmatrix![1.0, 0.0; 0.0, 0.0] * SMALL);
    let free = || Forcing::Unforced;
    let exact = |name, scene, keep| Case {
        name,
        scene,
        keep,
        method: Method::Exact,
    };
    let stepped = |name, scene, keep| Case {
        name,
        scene,
        keep,
        method: Method::Rk45,
    };
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
        stepped("rk45: pendulum", pendulum(false), last),
        stepped("rk45: walled pendulum", pendulum(true), last),
    ]
}

/// Nanoseconds for one unit of each case: medians of runs in turn.
fn times(cases: &[Case]) -> Vec<f64> {
    let mut all = vec![Vec::new(); cases.len()];
    for _ in 0..ROUNDS {
        for (case, times) in cases.iter().zip(&mut all) {
            let start = Instant::now();
            let units = case.run(TIMED);
            times.push(start.elapsed().as_secs_f64() * 1e9 / units as f64);
        }
    }
    let median = |mut times: Vec<f64>| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    };
    all.into_iter().map(median).collect()
}

/// Instructions and units of a run of a case in a process of its own; `None` without valgrind.
fn counted(case: usize, units: usize) -> Option<(f64, f64)> {
    let binary = std::env::current_exe().ok()?;
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(binary)
        .args(["--count", &case.to_string(), &units.to_string()])
        .output()
        .ok()?;
    let (texts, units) = (
        String::from_utf8_lossy(&output.stderr).into_owned(),
        String::from_utf8_lossy(&output.stdout)
            .trim()
            .parse()
            .ok()?,
    );
    let line = texts.lines().find(|line| line.contains("Collected :"))?;
    let count = line.rsplit(' ').next()?.parse().ok()?;
    Some((count, units))
}

/// Instructions for one unit of a case.
fn instructions(case: usize) -> Option<f64> {
    let (few, many) = (counted(case, COUNTED)?, counted(case, 2 * COUNTED)?);
    Some((many.0 - few.0) / (many.1 - few.1))
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let cases = cases();
    if let [_, mode, case, units] = arguments.as_slice()
        && mode == "--count"
    {
        let number = |text: &str| text.parse::<usize>().expect("a number");
        println!("{}", cases[number(case)].run(number(units)));
        return;
    }
    println!(
        "{:28} {:>8} {:>13}",
        "one impact or step", "ns", "instructions"
    );
    for (k, (case, time)) in cases.iter().zip(times(&cases)).enumerate() {
        let count = instructions(k).map_or_else(|| "-".to_owned(), |n| format!("{n:.0}"));
        println!("{:28} {time:8.0} {count:>13}", case.name);
    }
}
