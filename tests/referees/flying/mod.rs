//! A referee for bodies that fly: points, rods and dice among walls and round obstacles whose gaps are functions with a true bound on
//! their curvature. Their flights are known in closed form, position quadratic and angle linear in time, so that each impact of the
//! library is held against the first zero of any gap on the flight from the library's own state, found by looking densely.

mod draw;
mod judge;
mod shapes;

use crate::random::{Cases, Random};
use judge::Count;
use nalgebra::DVector;
use shapes::{Body, Face, Gap};
use std::f64::consts::{PI, TAU};
use vibroimpact::{
    Forcing, Method, PendulumChain, Scene, SimulateOptions, Wall, WallSide, simulate,
};

const METHODS: [Method; 4] = [Method::Taylor, Method::Rk45, Method::Dop853, Method::Radau];

#[test]
fn bodies_fly_to_the_first_stop_on_their_way() {
    let cases = Cases::new(1, 300);
    let (mut count, mut failed) = (Count::default(), Vec::new());
    for (number, mut random) in cases.each() {
        let case = draw::case(&mut random);
        if cases.is_one() {
            println!("{case:?}");
        }
        if let Some(wrong) = judge::wrong(&case, &mut count) {
            println!(
                "case {number} of seed {}, {:?} {:e}: {wrong}",
                cases.seed, case.method, case.rtol
            );
            failed.push(number);
        }
    }
    let looked = cases.numbers().len();
    if !cases.is_one() {
        crate::soak::note("flying bodies", cases.seed, looked, failed.len());
    }
    println!("{looked} cases, {count:?}");
    assert!(failed.is_empty(), "{} wrong: {failed:?}", failed.len());
    assert!(cases.have(count.impacts, 300), "{count:?}");
}

/// Where gravity is next to nothing no error holds the steps of a pendulum down, and it turns far in one.
#[test]
fn a_link_that_hardly_feels_gravity_is_stopped_by_its_wall() {
    let one = || DVector::from_element(1, 1.0);
    let chain = PendulumChain::new(one(), one(), &DVector::zeros(1), 1e-9).expect("valid");
    for (at, method) in [0.5, 0.9, 0.99, 0.9999]
        .into_iter()
        .flat_map(|at| METHODS.map(|m| (at, m)))
    {
        let wall = Wall::new(0, at, 1.0, WallSide::Right).expect("valid");
        let scene = Scene::new(chain.clone(), Forcing::Unforced, [wall]).expect("valid");
        for (from, speed) in [(0.0, 10.0), (0.1, -3.0), (-1.5, 0.7), (-3.0, 200.0)] {
            let (q0, v0) = (one() * from, one() * speed);
            let options = SimulateOptions {
                solver: method.into(),
                max_impacts: Some(1),
                ..Default::default()
            };
            let run = simulate(&scene, &q0, &v0, (0.0, 50.0), &options).expect("runs");
            // Angles at which its sine is that of the wall and grows on the way.
            let angles = [at.asin(), PI - at.asin()];
            let turns = (-40..40).map(|k| f64::from(k) * TAU);
            let times = turns.flat_map(|turn| angles.map(|angle| (angle + turn - from) / speed));
            let first = times.filter(|t| *t > 0.0).fold(f64::INFINITY, f64::min);
            let found = run.impacts()[0].time;
            let case = format!("{method:?} {at} {speed}: {found}, not {first}");
            assert!((found - first).abs() < 1e-6, "{case}");
        }
    }
}

/// What a referee is told must be true.
#[test]
fn gradients_are_those_of_the_gaps_and_curvatures_bound_them() {
    let mut random = Random::new(7);
    for _ in 0..300 {
        let centre = [random.between(-1.0, 1.0), random.between(-1.0, 1.0)];
        let (radius, arm) = (random.between(0.2, 1.0), random.between(0.1, 1.0));
        let axes = [radius, radius * random.between(0.5, 1.0)];
        let angle = random.between(-3.0, 3.0);
        let oval = |power: i32| Face::Oval {
            centre,
            axes,
            power,
        };
        let faces = [
            Face::Floor { height: 0.3 },
            Face::Disc { centre, radius },
            Face::Squared { centre, radius },
            oval(2),
            oval(4),
        ];
        let bodies = [
            Body::Point,
            Body::Upright { arm, angle },
            Body::Free { arm, angle },
        ];
        let gap = Gap {
            body: random.of(&bodies),
            face: random.of(&faces),
        };
        let n = gap.body.n();
        let q: Vec<f64> = (0..n).map(|_| random.between(-2.0, 2.0)).collect();
        if gap.value(&q) < 0.0 {
            continue;
        }
        let d: Vec<f64> = random.vector(n).normalize().as_slice().to_vec();
        let at = |s: f64| -> Vec<f64> { q.iter().zip(&d).map(|(q, d)| q + s * d).collect() };
        let slope = |s: f64| -> f64 {
            let slopes = gap.slopes(&at(s));
            slopes.iter().zip(&d).map(|(g, d)| g * d).sum()
        };
        let s = 1e-5;
        let difference = (gap.value(&at(s)) - gap.value(&at(-s))) / (2.0 * s);
        let bend = (slope(s) - slope(-s)) / (2.0 * s);
        let size = 1.0 + slope(0.0).abs();
        assert!(
            (difference - slope(0.0)).abs() < 1e-7 * size.powi(3),
            "{gap:?}"
        );
        assert!(
            bend.abs() <= gap.curvature(5.0) * (1.0 + 1e-6) + 1e-6,
            "{gap:?} {bend}"
        );
    }
}
