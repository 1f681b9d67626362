//! Random scenes of which a twin is made too.

use crate::random::Random;
use crate::twin::{Samples, Tone, Twin, TwinStop};
use nalgebra::{DMatrix, DVector};
use vibroimpact::Reaction;

/// A random scene, and what it starts with.
pub struct Case {
    pub twin: Twin,
    pub reactions: Vec<Reaction>,
    pub is_nonlinear: bool,
    pub q: DVector<f64>,
    pub v: DVector<f64>,
    pub span: (f64, f64),
    pub times: Vec<f64>,
}

/// Mass, damping and stiffness, and whether the last coordinate is by itself.
fn matrices(random: &mut Random, n: usize) -> ([DMatrix<f64>; 3], bool) {
    let root = random.matrix(n);
    let mut mass = &root * root.transpose() * 0.4 + DMatrix::identity(n, n);
    let root = random.matrix(n);
    let mut stiffness = &root * root.transpose() + DMatrix::identity(n, n) * 0.3;
    if random.chance(15) {
        stiffness.fill(0.0);
    }
    let mut damping = (&stiffness * 0.05 + &mass * 0.03) * random.between(0.0, 1.0);
    if random.chance(30) {
        let root = random.matrix(n);
        damping += &root * root.transpose() * 0.1;
    }
    let is_apart = n > 1 && random.chance(25);
    if is_apart {
        for matrix in [&mut mass, &mut stiffness, &mut damping] {
            for i in 0..n - 1 {
                (matrix[(i, n - 1)], matrix[(n - 1, i)]) = (0.0, 0.0);
            }
        }
    }
    ([mass, damping, stiffness], is_apart)
}

fn tones(random: &mut Random, n: usize) -> Vec<Tone> {
    let count = random.of(&[0, 1, 1, 2]);
    let w = random.between(0.5, 3.0);
    let mut tones = Vec::new();
    for k in 0..count {
        let is_multiple = random.chance(50);
        let w = if k == 0 {
            w
        } else if is_multiple {
            2.0 * w
        } else {
            w * random.between(1.1, 1.9)
        };
        tones.push(Tone {
            w,
            phase: random.between(0.0, 6.0),
            re: random.vector(n) * 2.0,
            im: random.vector(n),
        });
    }
    tones
}

/// Samples that reach over a span.
fn samples(random: &mut Random, n: usize, span: (f64, f64)) -> Samples {
    let pieces = 4 + random.below(40);
    let length = (span.1 - span.0 + 2.0) / pieces as f64;
    let times = (0..=pieces).map(|k| span.0 - 1.0 + length * k as f64);
    Samples {
        direction: random.vector(n),
        times: times.collect(),
        values: (0..=pieces).map(|_| random.between(-1.5, 1.5)).collect(),
    }
}

/// The motion of a stop, which has a tone of its own.
fn motion(random: &mut Random, n: usize, tones: &mut Vec<Tone>) -> (usize, f64) {
    let w = if tones.is_empty() || random.chance(50) {
        random.between(0.5, 2.0)
    } else {
        tones[0].w
    };
    let none = DVector::zeros(n);
    tones.push(Tone {
        w,
        phase: random.between(0.0, 6.0),
        re: none.clone(),
        im: none,
    });
    (tones.len() - 1, random.between(0.02, 0.2))
}

pub fn drawn(random: &mut Random) -> Case {
    let n = 1 + random.below(3);
    let ([mass, damping, stiffness], is_apart) = matrices(random, n);
    let far = if random.chance(10) {
        random.of(&[-1000.0, 300.0])
    } else {
        0.0
    };
    let span = (far, far + random.between(4.0, 9.0));
    let mut load = random.vector(n);
    let mut tones = tones(random, n);
    let samples = random.chance(35).then(|| samples(random, n, span));
    let (mut stops, mut reactions) = (Vec::new(), Vec::new());
    let law = random.of(&[Reaction::Inertia, Reaction::Inertia, Reaction::Coordinate]);
    let inverse = mass.clone().try_inverse().expect("regular");
    let struck = if is_apart { n - 1 } else { n };
    for j in 0..=random.below(3) {
        let mut normal = DVector::zeros(n);
        let is_upper = j < 2 && random.chance(70);
        normal[j % struck] = if is_upper { 1.0 } else { -1.0 };
        if random.chance(20) && !is_apart {
            normal += random.vector(n) * 0.3;
        }
        let reaction = match &law {
            Reaction::Inertia => &inverse * &normal,
            _ => normal.clone(),
        };
        if j == 0 && random.chance(70) {
            load += &normal * random.between(1.0, 5.0);
        }
        let motion = random.chance(20).then(|| motion(random, n, &mut tones));
        let restitution = match random.below(4) {
            0 => 0.0,
            1 => random.between(0.05, 0.4),
            2 => random.between(0.4, 0.8),
            _ => random.between(0.8, 0.97),
        };
        stops.push(TwinStop {
            normal,
            reaction,
            clearance: random.between(0.25, 0.9),
            restitution,
            motion,
        });
        reactions.push(law.clone());
    }
    let is_nonlinear = samples.is_none() && random.chance(15);
    let mut times: Vec<f64> = (0..3).map(|_| random.between(span.0, span.1)).collect();
    times.push(span.1);
    times.sort_by(f64::total_cmp);
    let (q, v) = (random.vector(n) * 0.1, random.vector(n) * 2.0);
    let twin = Twin {
        mass,
        damping,
        stiffness,
        load,
        tones,
        samples,
        stops,
    };
    Case {
        twin,
        reactions,
        is_nonlinear,
        q,
        v,
        span,
        times,
    }
}
