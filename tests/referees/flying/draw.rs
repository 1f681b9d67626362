//! Random scenes of bodies that fly: points in boxes with obstacles, rods and dice that fall and spin.

use crate::flying::shapes::{Body, Face, Gap};
use crate::random::Random;
use nalgebra::{Complex, DVector};
use vibroimpact::{
    Constraint, Forcing, Harmonic, LinearSystem, Method, NonlinearStop, Scene, Side,
    SimulateOptions, Solver, Stop, StopMotion,
};

/// A stop as the referee has it.
#[derive(Debug, Clone)]
pub struct Barrier {
    pub kind: Kind,
    pub restitution: f64,
    /// Amplitude, frequency and phase of what it adds to its gap by its own motion.
    pub motion: Option<[f64; 3]>,
}

#[derive(Debug, Clone, Copy)]
pub enum Kind {
    /// `side (at - q_i)`
    Wall {
        i: usize,
        at: f64,
        side: f64,
    },
    Curved(Gap),
}

/// A scene, its start, and how it is asked for.
#[derive(Debug, Clone)]
pub struct Case {
    pub mass: Vec<f64>,
    pub load: Vec<f64>,
    pub barriers: Vec<Barrier>,
    /// Its positions stay within this distance of the origin, at contacts and before them.
    pub reach: f64,
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    pub span: (f64, f64),
    pub method: Method,
    pub rtol: f64,
    pub atol: f64,
}

impl Barrier {
    /// The gap at a position, without the motion of the stop.
    pub fn gap(&self, q: &[f64]) -> f64 {
        match self.kind {
            Kind::Wall { i, at, side } => side * (at - q[i]),
            Kind::Curved(gap) => gap.value(q),
        }
    }

    pub fn slopes(&self, q: &[f64]) -> Vec<f64> {
        match self.kind {
            Kind::Wall { i, side, .. } => {
                let mut slopes = vec![0.0; q.len()];
                slopes[i] = -side;
                slopes
            }
            Kind::Curved(gap) => gap.slopes(q),
        }
    }

    /// What its motion adds at a time, and the rate of that.
    pub fn moved(&self, t: f64) -> [f64; 2] {
        self.motion.map_or([0.0; 2], |[a, w, phase]| {
            let (sin, cos) = (w * t + phase).sin_cos();
            [a * cos, -a * w * sin]
        })
    }

    /// A length over which its gap may turn.
    pub fn scale(&self) -> f64 {
        match self.kind {
            Kind::Wall { .. } => f64::INFINITY,
            Kind::Curved(gap) => gap.face.scale(),
        }
    }

    /// The coordinate that is an angle.
    pub fn turns(&self) -> Option<usize> {
        match self.kind {
            Kind::Curved(gap) => gap.body.turns(),
            Kind::Wall { .. } => None,
        }
    }

    fn constraint(&self, reach: f64) -> Constraint {
        let motion = self.motion.map(|[a, w, phase]| {
            let harmonic = Harmonic::new(DVector::from_element(1, Complex::from(a)), w, phase);
            StopMotion::harmonic(harmonic.expect("valid")).expect("one number")
        });
        match self.kind {
            Kind::Wall { i, at, side } => {
                let side = if side > 0.0 { Side::Upper } else { Side::Lower };
                let stop = Stop::new(i, at, self.restitution).expect("valid");
                stop.on_side(side).with_motion(None).into()
            }
            Kind::Curved(gap) => {
                let stop = NonlinearStop::new(gap, self.restitution).expect("valid");
                let stop = stop.with_curvature(gap.curvature(reach)).expect("finite");
                stop.with_motion(motion).into()
            }
        }
    }
}

impl Case {
    pub fn scene(&self) -> Scene {
        let n = self.mass.len();
        let zero = DVector::zeros(n);
        let mass = DVector::from_column_slice(&self.mass);
        let system = LinearSystem::new(mass, zero.clone(), zero).expect("valid");
        let system = system.with_load(DVector::from_column_slice(&self.load));
        let stops = self.barriers.iter().map(|b| b.constraint(self.reach));
        Scene::new(system.expect("finite"), Forcing::Unforced, stops).expect("valid")
    }

    pub fn options(&self) -> SimulateOptions {
        SimulateOptions {
            solver: Solver {
                method: self.method,
                rtol: self.rtol,
                atol: Some(self.atol),
            },
            max_impacts: Some(12),
            ..Default::default()
        }
    }
}

fn restitution(random: &mut Random) -> f64 {
    match random.below(4) {
        0 | 1 => 1.0,
        2 => random.between(0.5, 0.95),
        _ => random.between(0.8, 1.0),
    }
}

fn obstacle(random: &mut Random, centre: [f64; 2], radius: f64) -> Face {
    let axes = [radius, random.between(0.4, 1.0) * radius];
    match random.below(5) {
        0 | 1 => Face::Disc { centre, radius },
        2 => Face::Squared { centre, radius },
        3 => Face::Oval {
            centre,
            axes,
            power: 2,
        },
        _ => Face::Oval {
            centre,
            axes,
            power: 4,
        },
    }
}

/// The scene of a number, in units of its own.
pub fn case(random: &mut Random) -> Case {
    let mut case = match random.below(3) {
        0 => box_of_obstacles(random),
        1 => body(random, false),
        _ => body(random, true),
    };
    let methods = [Method::Auto, Method::Rk45, Method::Dop853, Method::Radau];
    case.method = random.of(&methods);
    case.rtol = random.of(&[1e-6, 1e-9, 1e-9, 1e-12]);
    case.atol = 1e-3 * case.rtol;
    let start = random.of(&[0.0, 0.0, 0.0, -3.7, 1e3, 1e6]);
    case.span = (start, start + case.span.1);
    case
}

fn box_of_obstacles(random: &mut Random) -> Case {
    let e = restitution(random);
    let size = random.log(1e-2, 1e2);
    let wall = |i: usize, side: f64, random: &mut Random| Barrier {
        kind: Kind::Wall {
            i,
            at: if side > 0.0 { size } else { 0.0 },
            side,
        },
        restitution: if random.chance(70) { e } else { 1.0 },
        motion: None,
    };
    let mut barriers: Vec<Barrier> = [(0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0)]
        .into_iter()
        .map(|(i, side)| wall(i, side, random))
        .collect();
    for _ in 0..=random.below(3) {
        let centre = [0; 2].map(|_| size * random.between(0.15, 0.85));
        let radius = size * random.between(0.03, 0.2);
        let face = obstacle(random, centre, radius);
        let moves = random.chance(25);
        let motion = moves.then(|| {
            let a = 0.2 * radius * random.unit();
            [a, random.between(0.5, 6.0), random.between(-3.0, 3.0)]
        });
        barriers.push(Barrier {
            kind: Kind::Curved(Gap {
                body: Body::Point,
                face,
            }),
            restitution: restitution(random),
            motion,
        });
    }
    // One frequency for all that moves.
    let frequency = barriers.iter().find_map(|b| b.motion).map(|m| m[1]);
    for motion in barriers.iter_mut().filter_map(|b| b.motion.as_mut()) {
        motion[1] = frequency.unwrap_or(1.0);
    }
    let q = loop {
        let q: Vec<f64> = (0..2).map(|_| size * random.between(0.02, 0.98)).collect();
        let open = |b: &Barrier| {
            let room = b.motion.map_or(0.0, |m| m[0].abs());
            b.gap(&q) > room + 1e-3 * size
        };
        if barriers.iter().all(open) {
            break q;
        }
    };
    let speed = size * random.log(0.3, 30.0);
    let angle = random.between(0.0, 6.3);
    let mass = random.log(0.1, 10.0);
    let gravity = if random.chance(50) {
        0.0
    } else {
        -size * random.between(0.5, 10.0)
    };
    Case {
        mass: vec![mass; 2],
        load: vec![0.0, mass * gravity],
        barriers,
        reach: 2.0 * size,
        q,
        v: vec![speed * angle.cos(), speed * angle.sin()],
        span: (0.0, random.between(1.0, 4.0)),
        method: Method::Auto,
        rtol: 1e-9,
        atol: 1e-12,
    }
}

/// A rod or a die over a floor that may shake, or over that and discs.
fn body(random: &mut Random, is_free: bool) -> Case {
    let e = restitution(random);
    // Lengths of angles are one.
    let size = random.log(0.1, 3.0);
    let (corners, arm) = if random.chance(50) {
        (2, size * random.between(0.2, 0.6))
    } else {
        (4, size * random.between(0.2, 0.6))
    };
    let mut faces = vec![Face::Floor { height: 0.0 }];
    if is_free {
        for _ in 0..=random.below(2) {
            let radius = size * random.between(0.2, 0.8);
            let centre = [
                size * random.between(-2.0, 2.0),
                size * random.between(0.0, 1.0),
            ];
            faces.push(if random.chance(50) {
                Face::Disc { centre, radius }
            } else {
                let axes = [radius, random.between(0.5, 1.0) * radius];
                Face::Oval {
                    centre,
                    axes,
                    power: 2,
                }
            });
        }
    }
    let shaken = random.chance(25).then(|| {
        [
            0.1 * size * random.unit(),
            random.between(1.0, 12.0),
            random.between(-3.0, 3.0),
        ]
    });
    let mut barriers = Vec::new();
    for face in faces {
        let is_floor = matches!(face, Face::Floor { .. });
        for k in 0..corners {
            let angle = std::f64::consts::TAU * f64::from(k) / f64::from(corners);
            let body = if is_free {
                Body::Free { arm, angle }
            } else {
                Body::Upright { arm, angle }
            };
            barriers.push(Barrier {
                kind: Kind::Curved(Gap { body, face }),
                restitution: e,
                motion: shaken.filter(|_| is_floor),
            });
        }
    }
    let height = size * random.between(2.5, 5.0);
    let spin = random.log(0.3, 40.0) * random.of(&[-1.0, 1.0]);
    let up = size * random.between(-2.0, 3.0);
    let (mass, angle) = (random.log(0.2, 5.0), random.between(-3.0, 3.0));
    let inertia = mass * arm * arm * random.between(0.2, 0.9);
    let gravity = -size * random.between(3.0, 15.0);
    let (mut q, mut v, mut masses, mut load) = (
        vec![height, angle],
        vec![up, spin],
        vec![mass, inertia],
        vec![mass * gravity, 0.0],
    );
    if is_free {
        q.insert(0, size * random.between(-1.0, 1.0));
        v.insert(0, size * random.between(-2.0, 2.0));
        masses.insert(0, mass);
        load.insert(0, 0.0);
    }
    Case {
        mass: masses,
        load,
        barriers,
        reach: 60.0 * size,
        q,
        v,
        span: (0.0, random.between(2.0, 5.0)),
        method: Method::Auto,
        rtol: 1e-9,
        atol: 1e-12,
    }
}
