//! Random bodies: chains of pendulums before walls, and linear systems before planes.

use crate::branches::body::{Body, Number};
use crate::branches::plant::{Pad, Plant};
use crate::pendulums::chain::{Chain, Face, Kind, damped};
use crate::random::Random;
use nalgebra::{Complex, DMatrix, DVector};

pub fn restitution(random: &mut Random) -> f64 {
    match random.below(8) {
        0 => 0.0,
        1 => 1.0,
        2 => 0.5,
        _ => random.between(0.2, 0.95),
    }
}

fn sign(random: &mut Random) -> f64 {
    random.of(&[1.0, -1.0])
}

/// Walls and planes about a chain that hangs.
fn faces(random: &mut Random, lengths: &[f64]) -> Vec<Face> {
    let n = lengths.len();
    let first = sign(random);
    let count = 1 + random.below(2);
    let face = |k: usize, random: &mut Random| {
        let side = if k == 0 { first } else { -first };
        let room = if random.chance(15) {
            0.0
        } else {
            random.between(-0.05, 0.3)
        };
        // Two opposite ones leave room between them.
        let room = if count == 2 { room.abs() + 0.05 } else { room };
        let bob = random.below(n);
        let kind = if random.chance(60) {
            Kind::Wall {
                bob,
                at: side * room * lengths[..=bob].iter().sum::<f64>(),
                side,
            }
        } else {
            let mut normal = vec![0.0; n];
            normal[bob] = side;
            if n > 1 && random.chance(30) {
                normal[(bob + 1) % n] = -side;
            }
            Kind::Plane {
                normal,
                clearance: room,
            }
        };
        Face {
            kind,
            restitution: restitution(random),
        }
    };
    (0..count).map(|k| face(k, random)).collect()
}

/// A chain of so many links whose base is shaken near to its slowest swing or above it.
pub fn chain(n: usize, random: &mut Random) -> Body {
    let are_equal = random.chance(30);
    let mut some = |low: f64, high: f64| -> Vec<f64> {
        let one = random.between(low, high);
        let each = |_| {
            if are_equal {
                one
            } else {
                random.between(low, high)
            }
        };
        (0..n).map(each).collect()
    };
    let (masses, lengths) = (some(0.3, 2.0), some(0.4, 1.2));
    let gravity = random.of(&[1.0, 9.81]);
    let total: f64 = lengths.iter().sum();
    let slow = (gravity / total).sqrt();
    let weight = masses.iter().sum::<f64>() * total * total * slow;
    let dampers: Vec<f64> = (0..n)
        .map(|_| {
            if random.chance(20) {
                0.0
            } else {
                weight * random.between(0.005, 0.1)
            }
        })
        .collect();
    let frequency = slow * random.between(0.8, 3.0);
    let phase = if random.chance(50) {
        0.0
    } else {
        random.between(-3.0, 3.0)
    };
    let faces = faces(random, &lengths);
    Body::Chain(Chain {
        base: Some([total * random.between(0.02, 0.2), frequency, phase]),
        masses,
        damping: damped(&dampers),
        gravity,
        faces,
        lengths,
    })
}

/// A linear system of so many degrees that is shaken, before a plane or two.
pub fn plant(n: usize, random: &mut Random) -> Body {
    let half = random.matrix(n);
    let stiffness = DMatrix::identity(n, n) + &half * half.transpose();
    let mass = if random.chance(30) {
        DMatrix::identity(n, n)
    } else {
        DMatrix::from_fn(n, n, |i, j| {
            if i == j {
                random.between(0.5, 2.0)
            } else {
                0.0
            }
        })
    };
    let damping = &stiffness * random.between(0.005, 0.1);
    let mut force = random.vector(n);
    force[0] += 1.0;
    let phase = if random.chance(50) {
        0.0
    } else {
        random.between(-3.0, 3.0)
    };
    let plane = |side: f64, random: &mut Random, at: usize| {
        let mut normal = vec![0.0; n];
        normal[at] = side;
        Face {
            kind: Kind::Plane {
                normal,
                clearance: random.between(0.0, 0.6),
            },
            restitution: restitution(random),
        }
    };
    let mut faces = vec![plane(1.0, random, n - 1)];
    if random.chance(40) {
        let at = random.below(n);
        faces.push(plane(-1.0, random, at));
    } else if random.chance(50)
        && let Kind::Plane { clearance, .. } = &mut faces[0].kind
    {
        *clearance = random.between(-0.3, 0.0);
    }
    Body::Plant(Plant {
        inverse: mass.clone().try_inverse().expect("positive masses"),
        mass,
        damping,
        stiffness,
        force,
        wave: Some([random.between(0.5, 3.0), phase]),
        faces,
        pads: Vec::new(),
    })
}

/// A linear system of so many degrees that is shaken, and reaches a spring on one side of it, or one on each of two alike, at about the
/// amplitude that it has without.
pub fn sprung(n: usize, random: &mut Random) -> Body {
    let Body::Plant(mut plant) = plant(n, random) else {
        unreachable!("a plant is drawn")
    };
    plant.faces.clear();
    let [w, _] = plant.wave.expect("shaken");
    let dynamic = DMatrix::from_fn(n, n, |i, j| {
        let real = plant.stiffness[(i, j)] - w * w * plant.mass[(i, j)];
        Complex::new(real, w * plant.damping[(i, j)])
    });
    let steady = dynamic.lu().solve(&plant.force.map(Complex::from));
    let at = random.below(n);
    let far = steady.expect("damped")[at].norm();
    let (room, stiffness) = (far * random.between(0.9, 1.3), random.log(0.5, 40.0));
    let sides: &[f64] = if random.chance(30) {
        &[1.0, -1.0]
    } else {
        &[1.0]
    };
    plant.pads = sides
        .iter()
        .map(|side| Pad {
            normal: (0..n).map(|i| if i == at { *side } else { 0.0 }).collect(),
            room,
            stiffness,
        })
        .collect();
    Body::Plant(plant)
}

/// A linear system before a stop on which it stays, and another that throws it off.
pub fn staying(random: &mut Random) -> Body {
    let Body::Plant(mut plant) = plant(2, random) else {
        unreachable!("a plant is drawn")
    };
    let face = |at: usize, side: f64, restitution: f64, random: &mut Random| {
        let mut normal = vec![0.0; 2];
        normal[at] = side;
        normal[1 - at] = random.between(-0.5, 0.5);
        let clearance = random.between(0.0, 0.3);
        let kind = Kind::Plane { normal, clearance };
        Face { kind, restitution }
    };
    let (first, second) = (sign(random), sign(random));
    let lively = random.between(0.2, 0.9);
    plant.faces = vec![face(0, first, 0.0, random), face(1, second, lively, random)];
    plant.force *= random.between(1.0, 4.0);
    Body::Plant(plant)
}

/// A number to follow an orbit over, and its range.
pub fn number(random: &mut Random, body: &Body) -> (Number, (f64, f64)) {
    let stop = random.below(body.faces().len());
    let number = random.of(&[
        Number::Frequency,
        Number::Frequency,
        Number::Forcing,
        Number::Forcing,
        Number::Damping,
        Number::Restitution(stop),
        Number::Room(stop),
    ]);
    (number, range(number, body))
}

/// The range of a number about its value.
pub fn range(number: Number, body: &Body) -> (f64, f64) {
    let value = body.value(number);
    match number {
        Number::Frequency => (0.75 * value, 1.4 * value),
        Number::Forcing => (0.4, 2.0),
        Number::Damping => (0.2, 3.0),
        Number::Restitution(_) => ((value - 0.4).max(0.0), (value + 0.4).min(1.0)),
        Number::Room(_) => (value - 0.15, value + 0.15),
    }
}

/// A start of a body, not far from where it hangs.
pub fn start(random: &mut Random, body: &Body) -> [DVector<f64>; 2] {
    let n = body.n();
    let side = |k: usize| {
        let x = vec![0.0; 2 * n];
        body.gap(k, &x)
    };
    let is_inside = (0..body.faces().len()).any(|k| side(k) < 0.0);
    let mut q = DVector::zeros(n);
    if is_inside {
        // Behind a stop that presses: away from it.
        for k in 0..body.faces().len() {
            let normal = match body {
                Body::Chain(chain) => chain.normal(k, &vec![0.0; n]),
                Body::Plant(plant) => plant.normal(k),
            };
            let gap = side(k);
            if gap < 0.0 {
                q += &normal * (1.5 * gap / normal.norm_squared());
            }
        }
    }
    [q, random.vector(n) * 0.3]
}
