//! Motions without forcing: families over their energy, whose action grows with it as the period says, and motions that feed
//! themselves.

use crate::branches::body::{Body, Number};
use crate::branches::draw;
use crate::branches::integrated::check_orbit;
use crate::branches::library::followed;
use crate::branches::look::Look;
use crate::branches::plant::Plant;
use crate::branches::stepper::{motion, step};
use crate::branches::tally::Tally;
use crate::pendulums::chain::{Chain, Face, Kind};
use crate::random::Random;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::{PI, TAU};
use vibroimpact::{
    Branch, ContinuationOptions, Guess, ImpactSide, Motion, PeriodicOrbit, SimulateOptions,
    continuation_over_energy, find_orbit, simulate,
};

/// An energy of a state that is known to 1e-11.
const ENERGY: f64 = 1e-9;
/// An action from steps and nodes that are as good as the motion, of two orbits that close to 1e-11: where it differs by little,
/// that is what is left.
const ACTION: f64 = 1e-9;

/// Gauss's rule of five nodes on (-1, 1).
const NODES: [(f64, f64); 5] = [
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
];

/// A linear system or a chain without damping and forcing before elastic stops.
fn conservative(random: &mut Random) -> Body {
    let n = random.of(&[1, 1, 2]);
    let faces = |random: &mut Random, size: f64| -> Vec<Face> {
        let side = random.of(&[1.0, -1.0]);
        let room = if random.chance(20) {
            0.0
        } else {
            size * random.between(0.1, 0.5)
        };
        let mut normal = vec![0.0; n];
        normal[n - 1] = side;
        let kind = Kind::Plane {
            normal,
            clearance: room,
        };
        vec![Face {
            kind,
            restitution: 1.0,
        }]
    };
    if random.chance(50) {
        let half = random.matrix(n);
        let stiffness = DMatrix::identity(n, n) + &half * half.transpose();
        let mass = DMatrix::from_diagonal_element(n, n, random.between(0.5, 2.0));
        return Body::Plant(Plant {
            inverse: mass.clone().try_inverse().expect("positive masses"),
            mass,
            damping: DMatrix::zeros(n, n),
            stiffness,
            force: DVector::zeros(n),
            wave: None,
            faces: faces(random, 1.0),
            pads: Vec::new(),
        });
    }
    let mut some =
        |low: f64, high: f64| -> Vec<f64> { (0..n).map(|_| random.between(low, high)).collect() };
    let (masses, lengths) = (some(0.3, 2.0), some(0.4, 1.2));
    let mut faces = faces(random, 1.0);
    if random.chance(60)
        && let Kind::Plane { normal, clearance } = &faces[0].kind
    {
        let side = normal[n - 1];
        let reach: f64 = lengths.iter().sum();
        faces[0].kind = Kind::Wall {
            bob: n - 1,
            at: side * clearance * 0.7 * reach,
            side,
        };
    }
    Body::Chain(Chain {
        damping: DMatrix::zeros(n, n),
        gravity: random.of(&[1.0, 9.81]),
        base: None,
        masses,
        lengths,
        faces,
    })
}

/// The slowest small motion of a body, and its frequency, by inverse iteration on its accelerations.
fn slowest(body: &Body) -> (DVector<f64>, f64) {
    let n = body.n();
    let small = 1e-6;
    let columns: Vec<DVector<f64>> = (0..n)
        .map(|i| {
            let mut x = vec![0.0; 2 * n];
            x[i] = small;
            -body.acceleration(0.0, &x, None).0 / small
        })
        .collect();
    let solver = DMatrix::from_columns(&columns).lu();
    let mut mode = DVector::from_element(n, 1.0);
    let mut slow = 1.0;
    for _ in 0..200 {
        let next = solver.solve(&mode).expect("a system that is held");
        slow = next.norm();
        mode = next / slow;
    }
    (mode, slow.recip().sqrt())
}

/// An orbit of a body that reaches its stop from its slowest motion, if one is found there.
fn orbit(random: &mut Random, body: &Body) -> Option<PeriodicOrbit> {
    let n = body.n();
    let (mode, w) = slowest(body);
    let zero = vec![0.0; 2 * n];
    let normal = match body {
        Body::Chain(chain) => chain.normal(0, &zero[..n]),
        Body::Plant(plant) => plant.normal(0),
    };
    let along = normal.dot(&mode);
    let room = body.gap(0, &zero) / along.abs();
    let far = (room * random.between(1.1, 1.8)).max(0.3);
    let q = mode * (-far * along.signum());
    let period = Some(2.0 * (PI - (room / far).acos()) / w);
    let v = DVector::zeros(n);
    let guess = Guess::State {
        q: &q,
        v: &v,
        period,
    };
    find_orbit(&body.scene().expect("valid"), guess, None).ok()
}

/// The action of an orbit, the integral of twice the kinetic energy over a period, by Gauss's rule on each step.
fn action(look: &Look<'_>) -> f64 {
    let flights = look.script.flights();
    let flights = flights.iter().map(|flight| {
        let x = look.state(flight.start, false);
        let all = motion(&look.body, None, (flight.start, &x), flight.end);
        let parts = all.windows(2).map(|pair| {
            let ((start, x), (end, _)) = (&pair[0], &pair[1]);
            let dt = end - start;
            let nodes = NODES.map(|(at, weight)| {
                let y = step(&look.body, None, (*start, x), 0.5 * (1.0 + at) * dt);
                weight * look.body.energies(&y)[0]
            });
            dt * nodes.iter().sum::<f64>()
        });
        parts.sum::<f64>()
    });
    flights.sum()
}

/// The polynomial through points, and its slope.
fn through(points: &[[f64; 2]], x: f64) -> [f64; 2] {
    let mut all = [0.0; 2];
    for (i, [xi, yi]) in points.iter().enumerate() {
        let others = || points.iter().enumerate().filter(move |(j, _)| *j != i);
        let factors = others().map(|(_, [xj, _])| (x - xj) / (xi - xj));
        let whole: f64 = factors.product();
        // The product rule: each factor's slope times the other factors.
        let slopes = others().map(|(j, [xj, _])| {
            let rest = others().filter(|(k, _)| *k != j);
            let rest: f64 = rest.map(|(_, [xk, _])| (x - xk) / (xi - xk)).product();
            rest / (xi - xj)
        });
        all = [all[0] + yi * whole, all[1] + yi * slopes.sum::<f64>()];
    }
    all
}

/// Between two points the action grows by the integral of the period over the energy, both along the branch, where they are
/// smooth at a touch too.
fn check_action(branch: &Branch, k: usize, body: &Body, tally: &mut Tally) -> Result<(), String> {
    let along = |value: &dyn Fn(usize) -> f64| -> Vec<[f64; 2]> {
        let point = |k: usize| [branch.arclength[k], value(k)];
        (k - 2..k + 4).map(point).collect()
    };
    let energies = along(&|k| branch.parameter[k]);
    let periods = along(&|k| branch.orbits[k].period());
    let ends = [k, k + 1].map(|k| Look::new(&branch.orbits[k], body).map(|look| action(&look)));
    let [Ok(before), Ok(after)] = ends else {
        tally.left_out("an action that is not told");
        return Ok(());
    };
    let over = |range: std::ops::Range<usize>| {
        let (from, to) = (branch.arclength[k], branch.arclength[k + 1]);
        let parts = NODES.map(|(at, weight)| {
            let s = from + 0.5 * (1.0 + at) * (to - from);
            weight
                * through(&periods[range.clone()], s)[0]
                * through(&energies[range.clone()], s)[1]
        });
        0.5 * (to - from) * parts.iter().sum::<f64>()
    };
    let expected = over(0..6);
    let off = (after - before - expected).abs();
    // What polynomials through four of the points say otherwise: two powers more bring less than the last two.
    let rough = [0..4, 1..5, 2..6].map(|four| (expected - over(four)).abs());
    let allowed = rough.into_iter().fold(0.0, f64::max) + ACTION * after;
    tally.saw("actions", off / after);
    if off > allowed {
        let grown = after - before;
        return Err(format!(
            "grown by {grown:e}, expected {expected:e}, off by {off:e}, allowed {allowed:e}"
        ));
    }
    Ok(())
}

/// A family over the energy.
fn check_family(random: &mut Random, tally: &mut Tally) -> Result<(), String> {
    let body = conservative(random);
    let Some(first) = orbit(random, &body) else {
        tally.left_out("no orbit");
        return Ok(());
    };
    let energy = |orbit: &PeriodicOrbit| {
        let (q, v) = orbit.state(0.0, ImpactSide::After).expect("a time");
        let x: Vec<f64> = q.iter().chain(v.iter()).copied().collect();
        body.energies(&x)[1]
    };
    let start = energy(&first);
    // Steps at which polynomials through six points are as good as what these are known to.
    let options = ContinuationOptions {
        max_points: 150,
        steps: [1e-8, 1e-3, 0.02],
        ..Default::default()
    };
    let branch = continuation_over_energy(&first, (0.3 * start, 3.0 * start), &options);
    let branch = match branch {
        Ok(branch) => branch,
        Err(error) => {
            tally.left_out("refused");
            tally.note(format!("refused: {error}"));
            return Ok(());
        }
    };
    tally.saw("families", 0.0);
    let count = branch.orbits.len();
    for (k, orbit) in branch.orbits.iter().enumerate() {
        let off = (energy(orbit) / branch.parameter[k] - 1.0).abs();
        tally.saw("energies", off);
        if off > ENERGY {
            return Err(format!("energy {} off by {off:e}", branch.parameter[k]));
        }
    }
    for k in [0, random.below(count), count - 1] {
        check_orbit(&branch.orbits[k], &body, tally)
            .map_err(|wrong| format!("energy {}: {wrong}", branch.parameter[k]))?;
    }
    if count > 6 {
        for _ in 0..2 {
            let k = 2 + random.below(count - 5);
            check_action(&branch, k, &body, tally)
                .map_err(|wrong| format!("energy {}: {wrong}", branch.parameter[k]))?;
        }
    }
    Ok(())
}

/// One mass that a damping below zero feeds as much as its impacts take.
fn check_fed(random: &mut Random, tally: &mut Tally) -> Result<(), String> {
    let one = |value: f64| DMatrix::from_element(1, 1, value);
    let (mass, stiffness) = (random.of(&[1.0, 1.7]), random.between(0.5, 3.0));
    let damping = -random.between(0.02, 0.15) * (mass * stiffness).sqrt();
    let kind = Kind::Plane {
        normal: vec![random.of(&[1.0, -1.0])],
        clearance: random.between(0.1, 0.5),
    };
    let body = Body::Plant(Plant {
        mass: one(mass),
        inverse: one(1.0 / mass),
        damping: one(damping),
        stiffness: one(stiffness),
        force: DVector::zeros(1),
        wave: None,
        faces: vec![Face {
            kind,
            restitution: random.between(0.2, 0.7),
        }],
        pads: Vec::new(),
    });
    let scene = body.scene().expect("valid");
    let (q, v) = (DVector::zeros(1), DVector::from_element(1, 0.5));
    let span = (0.0, 60.0 * TAU);
    let run = simulate(&scene, &q, &v, span, &SimulateOptions::default());
    let found = run.map(|run| find_orbit(&scene, &run, None));
    let Ok(Ok(first)) = found else {
        tally.left_out("no cycle");
        return Ok(());
    };
    let number = random.of(&[Number::Room(0), Number::Restitution(0), Number::Damping]);
    let (low, high) = draw::range(number, &body);
    let range = match number {
        Number::Room(_) => (0.05, 1.0),
        _ => (low, high.min(3.0)),
    };
    let options = ContinuationOptions {
        max_points: 40,
        ..Default::default()
    };
    let branch = followed(&first, &body, (number, range), &options);
    let branch = branch.map_err(|error| error.to_string())?;
    tally.saw("cycles", 0.0);
    for k in [
        0,
        random.below(branch.orbits.len()),
        branch.orbits.len() - 1,
    ] {
        check_orbit(
            &branch.orbits[k],
            &body.with(number, branch.parameter[k]),
            tally,
        )
        .map_err(|wrong| format!("{number:?} = {}: {wrong}", branch.parameter[k]))?;
    }
    Ok(())
}

/// A family, or a motion that feeds itself.
pub fn check(random: &mut Random, tally: &mut Tally) -> Result<(), String> {
    if random.chance(75) {
        check_family(random, tally)
    } else {
        check_fed(random, tally)
    }
}
