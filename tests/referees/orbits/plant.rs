//! Linear scenes in plain matrices, their motion by an exponential of their own, and random ones of every kind.

use crate::random::Random;
use crate::roots::eigenvalues;
use nalgebra::{Complex, DMatrix, DVector};
use vibroimpact::{Harmonic, LinearSystem, Reaction, Scene, Stop};

/// Terms of the exponential of a small matrix: `0.25^16/16!` is far below rounding.
const TERMS: usize = 16;

/// A stop: gap `clearance - normal.q`; its impulses push along minus the reaction.
#[derive(Debug, Clone)]
pub struct Face {
    pub normal: DVector<f64>,
    pub clearance: f64,
    pub restitution: f64,
    pub reaction: DVector<f64>,
    pub law: Reaction,
}

/// `M q'' + C q' + K q = load + Re(force e^{i(w t + phase)})` with its stops.
#[derive(Debug, Clone)]
pub struct Plant {
    pub kind: &'static str,
    pub mass: DMatrix<f64>,
    pub damping: DMatrix<f64>,
    pub stiffness: DMatrix<f64>,
    pub load: DVector<f64>,
    pub force: DVector<Complex<f64>>,
    pub w: f64,
    pub faces: Vec<Face>,
}

/// `e^A` by a Taylor series of `A/2^k`, squared k times.
pub fn exponential(a: &DMatrix<f64>) -> DMatrix<f64> {
    let size = a.abs().row_sum().amax();
    let halvings = (4.0 * size).log2().ceil().max(0.0) as i32;
    let small = a * 0.5f64.powi(halvings);
    let identity = DMatrix::identity(a.nrows(), a.ncols());
    let mut sum = identity.clone();
    for k in (1..=TERMS).rev() {
        sum = &identity + &small * sum / k as f64;
    }
    for _ in 0..halvings {
        sum = &sum * &sum;
    }
    sum
}

impl Plant {
    pub fn n(&self) -> usize {
        self.load.len()
    }

    /// The rate in which velocities are measured: that of the stiffest direction, or of the forcing.
    pub fn rate(&self) -> f64 {
        let inverse = self.inverse_mass();
        let stiff = (&inverse * &self.stiffness).amax().sqrt();
        stiff.max((inverse * &self.damping).amax()).max(self.w)
    }

    fn inverse_mass(&self) -> DMatrix<f64> {
        self.mass.clone().try_inverse().expect("positive definite")
    }

    /// The matrix of `(q, v, 1, cos, sin)`, the angle of cos and sin being that of the forcing.
    pub fn enlarged(&self) -> DMatrix<f64> {
        let (n, inverse) = (self.n(), self.inverse_mass());
        let mut big = DMatrix::zeros(2 * n + 3, 2 * n + 3);
        big.view_mut((0, n), (n, n)).fill_with_identity();
        let lower = [&self.stiffness, &self.damping].map(|m| -(&inverse * m));
        big.view_mut((n, 0), (n, n)).copy_from(&lower[0]);
        big.view_mut((n, n), (n, n)).copy_from(&lower[1]);
        big.view_mut((n, 2 * n), (n, 1))
            .copy_from(&(&inverse * &self.load));
        let (re, im) = (self.force.map(|f| f.re), self.force.map(|f| f.im));
        big.view_mut((n, 2 * n + 1), (n, 1))
            .copy_from(&(&inverse * re));
        big.view_mut((n, 2 * n + 2), (n, 1))
            .copy_from(&-(&inverse * im));
        big[(2 * n + 1, 2 * n + 2)] = -self.w;
        big[(2 * n + 2, 2 * n + 1)] = self.w;
        big
    }

    /// A state and the forcing's angle as a vector that [`enlarged`](Self::enlarged) moves.
    pub fn lifted(&self, q: &DVector<f64>, v: &DVector<f64>, angle: f64) -> DVector<f64> {
        let forcing = [1.0, angle.cos(), angle.sin()];
        let state = q.iter().chain(v.iter()).copied().chain(forcing);
        DVector::from_iterator(2 * self.n() + 3, state)
    }

    /// Moves a lifted state over a span in small steps; `see` is shown each.
    pub fn carry(&self, x: &mut DVector<f64>, span: f64, mut see: impl FnMut(f64, &DVector<f64>)) {
        let (n, rate) = (self.n(), self.rate());
        let turn = |x: &mut DVector<f64>, factor: f64| {
            x.rows_mut(n, n).scale_mut(factor);
        };
        let mut scaled = self.enlarged();
        scaled.columns_mut(n, n).scale_mut(rate);
        scaled.rows_mut(n, n).scale_mut(1.0 / rate);
        // The unit of the load and the forcing is the size of the state that they move.
        let count = ((rate * span * 2.0).max(1.0).log2().ceil() as i32).min(24);
        let step = span * 0.5f64.powi(count);
        let one = exponential(&(scaled * step));
        turn(x, 1.0 / rate);
        for k in 1..=1u32 << count {
            *x = &one * &*x;
            turn(x, rate);
            see(step * f64::from(k), x);
            turn(x, 1.0 / rate);
        }
        turn(x, rate);
    }

    pub fn scene(&self) -> Scene {
        let parts = (
            self.mass.clone(),
            self.damping.clone(),
            self.stiffness.clone(),
        );
        let system = LinearSystem::new(parts.0, parts.1, parts.2);
        let system = system
            .and_then(|s| s.with_load(self.load.clone()))
            .expect("valid");
        let stops = self.faces.iter().map(|f| {
            let stop = Stop::new(f.normal.clone(), f.clearance, f.restitution);
            stop.and_then(|s| s.with_reaction(f.law.clone()))
                .expect("valid")
        });
        let forcing = Harmonic::new(self.force.clone(), self.w, 0.0).expect("valid");
        Scene::new(system, forcing, stops).expect("valid")
    }
}

/// The stiffness of a chain without ground, and what dashpots beside its springs are.
pub fn chain(springs: &[f64]) -> DMatrix<f64> {
    let mut k = DMatrix::zeros(springs.len() + 1, springs.len() + 1);
    for (i, &spring) in springs.iter().enumerate() {
        k[(i, i)] += spring;
        k[(i + 1, i + 1)] += spring;
        k[(i, i + 1)] -= spring;
        k[(i + 1, i)] -= spring;
    }
    k
}

/// Kinds of random plants.
pub const KINDS: [&str; 8] = [
    "full",
    "proportional",
    "undamped",
    "gyroscopic",
    "free chain",
    "free chain, dashpot to the ground, weight",
    "bouncing chain",
    "coordinates",
];

/// Mass, damping, stiffness, load of a kind.
type Matrices = (DMatrix<f64>, DMatrix<f64>, DMatrix<f64>, DVector<f64>);

fn matrices(random: &mut Random, kind: &str, n: usize) -> Matrices {
    let identity = DMatrix::<f64>::identity(n, n);
    let (a, b) = (random.matrix(n), random.matrix(n));
    let mass = &identity + &a * a.transpose() * 0.3;
    let stiffness =
        &identity * random.between(0.2, 2.0) + &b * b.transpose() * random.between(0.5, 4.0);
    let load = if random.unit() < 0.5 {
        DVector::zeros(n)
    } else {
        random.vector(n) * 0.2
    };
    let springs = |random: &mut Random| {
        let level = [1.0, 10.0, 1000.0][random.below(3)];
        let each: Vec<f64> = (1..n).map(|_| level * random.between(0.5, 1.5)).collect();
        chain(&each)
    };
    let lumped = |random: &mut Random| {
        DMatrix::from_diagonal(&DVector::from_fn(n, |_, _| random.between(0.5, 2.0)))
    };
    match kind {
        "full" => {
            let c = random.matrix(n);
            let damping = &c * c.transpose() * random.between(0.02, 0.3) + &identity * 0.02;
            (mass, damping, stiffness, load)
        }
        "proportional" => {
            let (alpha, beta) = (random.between(0.0, 0.05), random.between(0.001, 0.1));
            let damping = &mass * alpha + &stiffness * beta;
            (mass, damping, stiffness, load)
        }
        "undamped" => (mass, DMatrix::zeros(n, n), stiffness, load),
        "gyroscopic" => {
            let g = random.matrix(n);
            let damping = (&g - g.transpose()) + &identity * [0.0, 0.05, 0.3][random.below(3)];
            (mass, damping, stiffness, load)
        }
        "free chain" => {
            let mass = lumped(random);
            let stiffness = springs(random);
            let damping = &stiffness * [0.0, 2e-3, 0.02][random.below(3)];
            (mass, damping, stiffness, DVector::zeros(n))
        }
        "free chain, dashpot to the ground, weight" => {
            let mass = lumped(random);
            let stiffness = springs(random);
            let mut damping = &stiffness * [0.0, 0.01][random.below(2)];
            damping[(0, 0)] += random.between(0.05, 1.0);
            let load = mass.diagonal() * random.between(0.1, 1.0);
            (mass, damping, stiffness, load)
        }
        "bouncing chain" => {
            let mass = lumped(random);
            let stiffness = springs(random);
            let damping = &stiffness * [0.0, 2e-3, 0.02][random.below(3)];
            let load = mass.diagonal() * random.between(0.1, 1.0);
            (mass, damping, stiffness, load)
        }
        _ => {
            let each = |random: &mut Random, low, high| {
                DMatrix::from_diagonal(&DVector::from_fn(n, |_, _| random.between(low, high)))
            };
            let held = random.unit() < 0.6;
            let mut stiffness = each(random, 0.3, 4.0);
            if !held {
                stiffness[(0, 0)] = 0.0;
            }
            let damping = &stiffness * random.between(0.0, 0.1);
            (each(random, 0.5, 2.0), damping, stiffness, load)
        }
    }
}

/// The turning rates of the free motion, zeros left out.
pub fn frequencies(plant: &Plant) -> Vec<f64> {
    let n = plant.n();
    let a = plant.enlarged().view((0, 0), (2 * n, 2 * n)).into_owned();
    let roots = eigenvalues(&a);
    let turning = roots.iter().map(|root| root.im);
    turning.filter(|&im| im > 1e-3).collect()
}

/// A random plant of a kind, with one to three stops.
pub fn random_plant(random: &mut Random, kind: &'static str) -> Plant {
    let n = 1 + random.below(4);
    let (mass, damping, stiffness, load) = matrices(random, kind, n);
    let inverse = mass.clone().try_inverse().expect("positive definite");
    let is_chain = kind.contains("chain");
    let count = 1 + random.below(3.min(n + 1));
    let mut faces: Vec<Face> = Vec::new();
    for _ in 0..count {
        let mut normal = if is_chain || random.unit() < 0.6 {
            let along = random.below(n);
            DVector::from_fn(n, |i, _| f64::from(u8::from(i == along)))
        } else {
            random.vector(n)
        };
        if !faces.is_empty() && random.unit() < if is_chain { 0.6 } else { 0.3 } {
            normal = -&faces[0].normal;
        }
        let pick = random.below(3);
        let (law, reaction) = match pick {
            1 => (Reaction::Coordinate, normal.clone()),
            2 => {
                let b = &inverse * &normal * (1.0 + random.unit()) + random.vector(n) * 0.1;
                (Reaction::Direction(b.clone()), b)
            }
            _ => (Reaction::Inertia, &inverse * &normal),
        };
        if normal.dot(&reaction) < 0.1 * normal.norm() * reaction.norm() {
            continue;
        }
        faces.push(Face {
            normal,
            clearance: random.between(-0.05, 0.5),
            restitution: [0.0, 0.05, 0.5, 0.9, 1.0][random.below(5)],
            reaction,
            law,
        });
    }
    let force = random.vector(n).zip_map(&random.vector(n), Complex::new);
    let force = if random.unit() < 0.7 {
        force.map(|f| f.re.into())
    } else {
        force
    };
    let mut plant = Plant {
        kind,
        mass,
        damping,
        stiffness,
        load,
        force,
        w: random.between(0.5, 3.0),
        faces,
    };
    let natural = frequencies(&plant);
    if !natural.is_empty() && random.unit() < 0.3 {
        let off = 10f64.powf(-random.between(2.0, 12.0)) * [1.0, -1.0][random.below(2)];
        plant.w = natural[random.below(natural.len())]
            * (1.0 + off)
            * [1.0, 1.0, 0.5, 2.0][random.below(4)];
    }
    plant
}
