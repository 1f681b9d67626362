//! What certainty costs near grazing: instructions of exact flights and of steps for one approach of a stop, from an impact at an
//! angle over shallower and shallower ones to a touch and a stop that is just missed.
//! `cargo bench --bench grazes` (with valgrind installed); the same file runs in older trees, to compare them.
//!
//! The motion is `sin t` beside an elastic stop, the same at every approach. Instructions of an approach are those of a run of 2 N
//! of them less those of a run of N. `grazes --count METHOD OVERSHOOT APPROACHES` makes such a run and prints its impacts and
//! touches.

use std::f64::consts::TAU;
use std::process::Command;
use vibroimpact::nalgebra::dvector;
use vibroimpact::{
    Forcing, Keep, LinearSystem, Method, Scene, SimulateOptions, Solver, Stop, Trajectory, simulate,
};

/// How far the motion would go beyond the stop, in parts of its amplitude.
const OVERSHOOTS: [f64; 10] = [0.5, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-13, 0.0, -1e-6];
const METHODS: [(&str, Method); 2] = [("exact", Method::Exact), ("rk45", Method::Rk45)];
/// Approaches in the shorter of two counted runs.
const COUNTED: usize = 200;

fn run(method: Method, overshoot: f64, approaches: usize) -> Trajectory {
    let system = LinearSystem::new(dvector![1.0], dvector![0.0], dvector![1.0]).expect("valid");
    let stop = Stop::new(0, 1.0 - overshoot, 1.0).expect("valid");
    let scene = Scene::new(system, Forcing::Unforced, [stop]).expect("valid");
    // From impact to impact the angle leaves out what lies beyond the stop.
    let period = TAU - 2.0 * (1.0 - overshoot).min(1.0).acos();
    let options = SimulateOptions {
        solver: Solver {
            method,
            rtol: 1e-9,
            ..Solver::default()
        },
        keep: Keep::Impacts,
        ..Default::default()
    };
    let span = (0.0, period * approaches as f64);
    simulate(&scene, &dvector![0.0], &dvector![1.0], span, &options).expect("valid")
}

/// Instructions of a run in a process of its own, its impacts and its touches; `None` without valgrind.
fn counted(method: &str, overshoot: f64, approaches: usize) -> Option<(f64, String)> {
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(std::env::current_exe().ok()?)
        .args([
            "--count",
            method,
            &overshoot.to_string(),
            &approaches.to_string(),
        ])
        .output()
        .ok()?;
    let told = String::from_utf8_lossy(&output.stderr);
    let line = told.lines().find(|line| line.contains("Collected :"))?;
    let count = line.rsplit(' ').next()?.parse().ok()?;
    let printed = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    Some((count, printed))
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if let [_, mode, method, overshoot, approaches] = arguments.as_slice()
        && mode == "--count"
    {
        let method = METHODS.iter().find(|(name, _)| name == method);
        let (_, method) = method.expect("a method");
        let overshoot = overshoot.parse().expect("a number");
        let run = run(*method, overshoot, approaches.parse().expect("a number"));
        println!("{} {}", run.impacts().len(), run.grazes().len());
        return;
    }
    println!(
        "{:8} {:>10} {:>14} {:>18}",
        "method", "overshoot", "instructions", "impacts, touches"
    );
    for (method, _) in METHODS {
        for overshoot in OVERSHOOTS {
            let both = [COUNTED, 2 * COUNTED].map(|count| counted(method, overshoot, count));
            let [Some((few, _)), Some((many, seen))] = both else {
                println!("valgrind is not there");
                return;
            };
            let each = (many - few) / COUNTED as f64;
            println!("{method:8} {overshoot:10.0e} {each:14.0} {seen:>18}");
        }
    }
}
