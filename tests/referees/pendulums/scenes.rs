//! Random pendulums before walls and stops, for the referee and for the library.

use crate::pendulums::chain::{Chain, Face, Kind, damped};
use crate::random::Random;
use nalgebra::DVector;
use vibroimpact::{
    BaseMotion, Constraint, DoublePendulum, Forcing, Method, PendulumChain, Scene, Side, Stop,
    Wall, WallSide,
};

/// A scene, where it starts, and how it is asked for.
#[derive(Debug, Clone)]
pub struct Case {
    pub chain: Chain,
    /// The ratios of masses and lengths where the library is given a double pendulum.
    pub pair: Option<(f64, f64)>,
    pub start: Vec<f64>,
    pub end: f64,
    pub method: Method,
    pub rtol: f64,
}

fn restitution(random: &mut Random) -> f64 {
    match random.below(6) {
        0 | 1 => 0.0,
        2 => 1.0,
        3 => 0.5,
        _ => random.between(0.1, 0.95),
    }
}

fn face(random: &mut Random, lengths: &[f64], start: &[f64]) -> Face {
    let n = lengths.len();
    let restitution = restitution(random);
    let room = if random.chance(25) {
        0.0
    } else {
        random.between(0.02, 0.6)
    };
    let kind = if random.chance(65) {
        let (bob, side) = (random.below(n), if random.chance(50) { 1.0 } else { -1.0 });
        let reach: f64 = (0..=bob).map(|i| lengths[i] * start[i].sin()).sum();
        // What hangs straight down touches a wall at zero without rounding.
        Kind::Wall {
            bob,
            at: reach + side * room,
            side,
        }
    } else {
        let mut normal = vec![0.0; n];
        let side = if random.chance(50) { 1.0 } else { -1.0 };
        let at = random.below(n);
        normal[at] = side;
        if n > 1 && random.chance(40) {
            normal[(at + 1) % n] = -side;
        }
        let along: f64 = normal.iter().zip(start).map(|(n, q)| n * q).sum();
        Kind::Plane {
            normal,
            clearance: along + room,
        }
    };
    Face { kind, restitution }
}

/// The scene of a number.
pub fn scene(random: &mut Random) -> Case {
    let is_pair = random.chance(40);
    let n = if is_pair { 2 } else { 1 + random.below(3) };
    let dampers: Vec<f64> = (0..n)
        .map(|_| {
            if random.chance(50) {
                0.0
            } else {
                random.between(0.0, 0.3)
            }
        })
        .collect();
    let (masses, lengths, gravity, pair) = if is_pair {
        let (m, mu) = (random.between(0.1, 4.0), random.between(0.3, 3.0));
        (
            vec![1.0 / (1.0 + m), m / (1.0 + m)],
            vec![1.0, 1.0 / mu],
            1.0 / (1.0 + m),
            Some((m, mu)),
        )
    } else {
        let mut some = |low: f64, high: f64| (0..n).map(|_| random.between(low, high)).collect();
        let (masses, lengths): (Vec<f64>, Vec<f64>) = (some(0.2, 3.0), some(0.2, 1.5));
        (
            masses,
            lengths,
            if random.chance(30) { 1.0 } else { 9.81 },
            None,
        )
    };
    let base = random.chance(60).then(|| {
        let phase = if random.chance(50) {
            0.0
        } else {
            random.between(-3.0, 3.0)
        };
        [random.between(0.01, 0.3), random.between(0.3, 6.0), phase]
    });
    let hangs = random.chance(30);
    let angle = if random.chance(70) { 0.5 } else { 2.5 };
    let mut start: Vec<f64> = (0..2 * n).map(|_| random.between(-angle, angle)).collect();
    if hangs {
        start[..n].fill(0.0);
    }
    if random.chance(40) {
        start[n..].fill(0.0);
    }
    let faces = (0..random.below(4))
        .map(|_| face(random, &lengths, &start))
        .collect();
    let method = if random.chance(60) {
        Method::Taylor
    } else {
        [Method::Rk45, Method::Dop853, Method::Radau][random.below(3)]
    };
    let digits = 5 + random.below(7);
    Case {
        chain: Chain {
            masses,
            lengths,
            damping: damped(&dampers),
            gravity,
            base,
            faces,
        },
        pair,
        start,
        end: random.between(2.0, 15.0),
        method,
        rtol: 10f64.powi(-i32::try_from(digits).expect("few")),
    }
}

impl Case {
    /// The scene as the library has it.
    pub fn scene(&self) -> Scene {
        let chain = &self.chain;
        let forcing = chain.base.map_or(Forcing::Unforced, |[a, w, phase]| {
            BaseMotion::new(a, w, phase).expect("valid").into()
        });
        let stops: Vec<Constraint> = chain.faces.iter().map(constraint).collect();
        let damping = chain.damping.clone();
        if let Some((m, mu)) = self.pair {
            let system = DoublePendulum::with_damping_matrix(m, mu, damping).expect("valid");
            return Scene::new(system, forcing, stops).expect("valid");
        }
        let [masses, lengths] =
            [&chain.masses, &chain.lengths].map(|x| DVector::from_column_slice(x));
        let system = PendulumChain::with_damping_matrix(masses, lengths, damping, chain.gravity);
        Scene::new(system.expect("valid"), forcing, stops).expect("valid")
    }
}

fn constraint(face: &Face) -> Constraint {
    match &face.kind {
        Kind::Wall { bob, at, side } => {
            let side = if *side > 0.0 {
                WallSide::Right
            } else {
                WallSide::Left
            };
            Wall::new(*bob, *at, face.restitution, side)
                .expect("valid")
                .into()
        }
        Kind::Plane { normal, clearance } => {
            let normal = DVector::from_column_slice(normal);
            let stop = Stop::new(normal, *clearance, face.restitution).expect("valid");
            stop.on_side(Side::Upper).into()
        }
    }
}
