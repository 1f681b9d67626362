//! Pendulum chains from the places of their bobs: the mass matrix is `J^T m J`, the forces are what gravity, the base and the
//! turning of the links do to the bobs. No formula of the library's.

use nalgebra::{DMatrix, DVector};

/// What a chain may not cross, and how it comes off.
#[derive(Debug, Clone)]
pub struct Face {
    pub kind: Kind,
    pub restitution: f64,
}

#[derive(Debug, Clone)]
pub enum Kind {
    /// A bob stays on one side of a vertical wall: +1 where the wall is on its right.
    Wall { bob: usize, at: f64, side: f64 },
    /// `normal.q` stays below the clearance.
    Plane { normal: Vec<f64>, clearance: f64 },
}

/// A chain, its base `amplitude cos(frequency t + phase)`, and what it may not cross.
#[derive(Debug, Clone)]
pub struct Chain {
    pub masses: Vec<f64>,
    pub lengths: Vec<f64>,
    pub damping: DMatrix<f64>,
    pub gravity: f64,
    pub base: Option<[f64; 3]>,
    pub faces: Vec<Face>,
}

/// The damping matrix of dampers in the joints.
pub fn damped(dampers: &[f64]) -> DMatrix<f64> {
    let n = dampers.len();
    let mut damping = DMatrix::zeros(n, n);
    for (i, &c) in dampers.iter().enumerate() {
        damping[(i, i)] += c;
        if i > 0 {
            damping[(i - 1, i - 1)] += c;
            damping[(i - 1, i)] -= c;
            damping[(i, i - 1)] -= c;
        }
    }
    damping
}

impl Chain {
    pub fn n(&self) -> usize {
        self.masses.len()
    }

    /// The place of a bob beside and above the base.
    fn bob(&self, bob: usize, q: &[f64]) -> [f64; 2] {
        (0..=bob).fold([0.0; 2], |[x, y], i| {
            let (sin, cos) = q[i].sin_cos();
            [x + self.lengths[i] * sin, y - self.lengths[i] * cos]
        })
    }

    /// The mass matrix and the forces at rest of the acceleration, at a time.
    fn balance(&self, t: f64, q: &[f64], v: &[f64]) -> (DMatrix<f64>, DVector<f64>) {
        let n = self.n();
        let (mut mass, mut force) = (
            DMatrix::zeros(n, n),
            -(&self.damping * DVector::from_column_slice(v)),
        );
        let shaken = self
            .base
            .map_or(0.0, |[a, w, phase]| a * w * w * (w * t + phase).cos());
        for bob in 0..n {
            let slopes: Vec<[f64; 2]> = (0..=bob)
                .map(|i| [self.lengths[i] * q[i].cos(), self.lengths[i] * q[i].sin()])
                .collect();
            // What the bob does while the angles do not accelerate, against what pulls it.
            let turning = (0..=bob).fold([0.0; 2], |[x, y], i| {
                let pull = self.lengths[i] * v[i] * v[i];
                [x - pull * q[i].sin(), y + pull * q[i].cos()]
            });
            let pulled = [shaken - turning[0], -self.gravity - turning[1]];
            for (i, a) in slopes.iter().enumerate() {
                force[i] += self.masses[bob] * (a[0] * pulled[0] + a[1] * pulled[1]);
                for (j, b) in slopes.iter().enumerate() {
                    mass[(i, j)] += self.masses[bob] * (a[0] * b[0] + a[1] * b[1]);
                }
            }
        }
        (mass, force)
    }

    pub fn gap(&self, face: usize, q: &[f64]) -> f64 {
        match &self.faces[face].kind {
            Kind::Wall { bob, at, side } => side * (at - self.bob(*bob, q)[0]),
            Kind::Plane { normal, clearance } => {
                clearance - normal.iter().zip(q).map(|(n, q)| n * q).sum::<f64>()
            }
        }
    }

    /// Minus the slope of a gap.
    pub fn normal(&self, face: usize, q: &[f64]) -> DVector<f64> {
        match &self.faces[face].kind {
            Kind::Wall { bob, side, .. } => DVector::from_fn(self.n(), |i, _| {
                if i <= *bob {
                    side * self.lengths[i] * q[i].cos()
                } else {
                    0.0
                }
            }),
            Kind::Plane { normal, .. } => DVector::from_column_slice(normal),
        }
    }

    /// The part of a gap's acceleration that comes from its bend.
    fn bend(&self, face: usize, q: &[f64], v: &[f64]) -> f64 {
        match &self.faces[face].kind {
            Kind::Wall { bob, side, .. } => (0..=*bob)
                .map(|i| side * self.lengths[i] * q[i].sin() * v[i] * v[i])
                .sum(),
            Kind::Plane { .. } => 0.0,
        }
    }

    pub fn speed(&self, face: usize, q: &[f64], v: &[f64]) -> f64 {
        -self.normal(face, q).dot(&DVector::from_column_slice(v))
    }

    /// The accelerations while a face is held, or none; and its contact force.
    pub fn acceleration(
        &self,
        t: f64,
        q: &[f64],
        v: &[f64],
        held: Option<usize>,
    ) -> (DVector<f64>, f64) {
        let (mass, force) = self.balance(t, q, v);
        let solver = mass.cholesky().expect("positive masses");
        let free = solver.solve(&force);
        let Some(face) = held else {
            return (free, 0.0);
        };
        let normal = self.normal(face, q);
        let along = solver.solve(&normal);
        let opening = self.bend(face, q, v) - normal.dot(&free);
        let push = -opening / normal.dot(&along);
        (free - along * push, push)
    }

    /// The velocities after an impact, and its impulse.
    pub fn struck(&self, face: usize, q: &[f64], v: &[f64]) -> (Vec<f64>, f64) {
        let (mass, _) = self.balance(0.0, q, &vec![0.0; self.n()]);
        let normal = self.normal(face, q);
        let along = mass.cholesky().expect("positive masses").solve(&normal);
        let closing = -self.speed(face, q, v);
        let impulse = (1.0 + self.faces[face].restitution) * closing / normal.dot(&along);
        let after = v.iter().zip(along.iter()).map(|(v, a)| v - impulse * a);
        (after.collect(), impulse)
    }

    /// The second derivative of a gap in free motion.
    pub fn opening(&self, face: usize, t: f64, q: &[f64], v: &[f64]) -> f64 {
        let (free, _) = self.acceleration(t, q, v, None);
        self.bend(face, q, v) - self.normal(face, q).dot(&free)
    }
}
