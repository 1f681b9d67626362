//! Linear scenes: `M q'' + C q' + K q = F cos(w t + phase)` before planes, by Newton's law as it stands.

use crate::pendulums::chain::{Face, Kind};
use nalgebra::{DMatrix, DVector};

/// A linear system, its force and what it may not cross.
#[derive(Debug, Clone)]
pub struct Plant {
    pub mass: DMatrix<f64>,
    /// The inverse of `mass`.
    pub inverse: DMatrix<f64>,
    pub damping: DMatrix<f64>,
    pub stiffness: DMatrix<f64>,
    pub force: DVector<f64>,
    /// The frequency and the phase of the force.
    pub wave: Option<[f64; 2]>,
    pub faces: Vec<Face>,
    /// What it presses against.
    pub pads: Vec<Pad>,
}

/// A spring on one side: it presses back along its normal where the motion is farther along that than its room.
#[derive(Debug, Clone)]
pub struct Pad {
    pub normal: Vec<f64>,
    pub room: f64,
    pub stiffness: f64,
}

impl Pad {
    /// How far it is pressed, below zero where it is not reached.
    pub fn pressed(&self, q: &[f64]) -> f64 {
        self.along(q) - self.room
    }

    /// A position or a velocity along its normal.
    pub fn along(&self, x: &[f64]) -> f64 {
        self.normal.iter().zip(x).map(|(n, x)| n * x).sum()
    }
}

impl Plant {
    /// The normal and the clearance of a face, which is a plane.
    pub fn plane(&self, face: usize) -> (&[f64], f64) {
        match &self.faces[face].kind {
            Kind::Plane { normal, clearance } => (normal, *clearance),
            Kind::Wall { .. } => panic!("a wall before a linear system"),
        }
    }

    pub fn normal(&self, face: usize) -> DVector<f64> {
        DVector::from_column_slice(self.plane(face).0)
    }

    pub fn gap(&self, face: usize, q: &[f64]) -> f64 {
        let (normal, clearance) = self.plane(face);
        clearance - normal.iter().zip(q).map(|(n, q)| n * q).sum::<f64>()
    }

    pub fn speed(&self, face: usize, v: &[f64]) -> f64 {
        -self
            .plane(face)
            .0
            .iter()
            .zip(v)
            .map(|(n, v)| n * v)
            .sum::<f64>()
    }

    /// The accelerations while a face is held, or none; and its contact force.
    pub fn acceleration(
        &self,
        t: f64,
        q: &[f64],
        v: &[f64],
        held: Option<usize>,
    ) -> (DVector<f64>, f64) {
        let wave = self.wave.map_or(0.0, |[w, phase]| (w * t + phase).cos());
        let force = DVector::from_fn(q.len(), |i, _| {
            let inner = (0..q.len())
                .map(|j| self.stiffness[(i, j)] * q[j] + self.damping[(i, j)] * v[j])
                .sum::<f64>();
            let press = |pad: &Pad| pad.normal[i] * pad.stiffness * pad.pressed(q).max(0.0);
            self.force[i] * wave - inner - self.pads.iter().map(press).sum::<f64>()
        });
        let free = &self.inverse * force;
        let Some(face) = held else {
            return (free, 0.0);
        };
        let normal = self.normal(face);
        let along = &self.inverse * &normal;
        let push = normal.dot(&free) / normal.dot(&along);
        (free - along * push, push)
    }

    /// The velocities after an impact, and its impulse.
    pub fn struck(&self, face: usize, v: &[f64]) -> (Vec<f64>, f64) {
        let normal = self.normal(face);
        let along = &self.inverse * &normal;
        let closing = -self.speed(face, v);
        let impulse = (1.0 + self.faces[face].restitution) * closing / normal.dot(&along);
        let after = v.iter().zip(along.iter()).map(|(v, a)| v - impulse * a);
        (after.collect(), impulse)
    }
}
