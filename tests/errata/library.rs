//! The library's public values for a case, in the paper's order of state and scaling of modes.

use crate::motion::shapes;
use crate::system::Case;
use nalgebra::{DVector, Vector2, Vector4, dvector};
use vibroimpact::{
    Harmonic, LinearSystem, OrbitOptions, Orbits, Pattern, PeriodicOrbit, Reaction, Scene, Stop,
    paper_system, periodic_orbits,
};

/// A dense system of two coordinates from fixed matrices.
fn dense(matrix: nalgebra::Matrix2<f64>) -> nalgebra::DMatrix<f64> {
    nalgebra::DMatrix::from_fn(2, 2, |i, j| matrix[(i, j)])
}

impl Case {
    /// The paper's own system, or, with damping that it does not have, one from matrices.
    pub fn linear_system(&self) -> LinearSystem {
        if self.mass_damping == 0.0 {
            paper_system(self.m, self.mu, 0.5 * self.stiffness_damping).expect("valid")
        } else {
            let mass = self.mass();
            let [damping, stiffness] = [self.damping(), self.stiffness()].map(|c| dense(mass * c));
            LinearSystem::new(dense(mass), damping, stiffness).expect("valid")
        }
    }

    /// The case with both stops; their clearances stand where an orbit touches, once its phase is given.
    pub fn scene(&self) -> Scene {
        let force = dvector![self.f10, self.f10 * self.alpha()].map(Into::into);
        let stops = [0, 1].map(|i| {
            Stop::new(i, 10.0, self.e)
                .and_then(|stop| stop.with_reaction(Reaction::Coordinate))
                .expect("valid")
        });
        let forcing = Harmonic::new(force, self.w, self.phase).expect("valid");
        Scene::new(self.linear_system(), forcing, stops).expect("valid")
    }

    /// The stops of R1, R2, R3.
    pub fn stops(kind: u8) -> &'static [usize] {
        match kind {
            1 => &[0, 1],
            2 => &[0],
            _ => &[1],
        }
    }

    /// The library's orbits of a kind at the phase of the case.
    pub fn orbits(&self, kind: u8) -> Orbits {
        let options = OrbitOptions {
            n_periods: self.n as usize,
            phase: Some(self.phase),
            ..Default::default()
        };
        let pattern = Pattern::together(Self::stops(kind)).expect("valid");
        periodic_orbits(&self.scene(), &pattern, &options).expect("solved")
    }

    /// The lengths of the library's shapes in the paper's unit columns, higher frequency first, with the sign.
    pub fn shape_scales(&self) -> [f64; 2] {
        let modes = vibroimpact::modes(&self.linear_system()).expect("real");
        [1, 0].map(|j| {
            let shape = modes.shapes.column(j).map(|z| z.re);
            shape.norm() * shape[0].signum()
        })
    }

    /// `(a1, a2, b1, b2)` and `[(A_j, B_j)]` of an orbit in the paper's scaling and order.
    pub fn paper_coefficients(&self, orbit: &PeriodicOrbit) -> (Vector4<f64>, [(f64, f64); 2]) {
        let c = orbit.coefficients().expect("real modes");
        let [one, two] = self.shape_scales();
        let free = Vector4::new(c.a[1] * one, c.a[0] * two, c.b[1] * one, c.b[0] * two);
        (
            free,
            [
                (c.sine[1] * one, c.cosine[1] * one),
                (c.sine[0] * two, c.cosine[0] * two),
            ],
        )
    }
}

/// `(q1, v1, q2, v2)`.
pub fn interleaved(q: &DVector<f64>, v: &DVector<f64>) -> Vector4<f64> {
    Vector4::new(q[0], v[0], q[1], v[1])
}

/// The library's shapes against (11), up to the order and the length: each parallel to the paper's.
pub fn shape_errors(case: &Case) -> f64 {
    let modes = vibroimpact::modes(&case.linear_system()).expect("real");
    let phi = shapes(case);
    [1, 0]
        .into_iter()
        .enumerate()
        .map(|(paper, ours)| {
            let shape = Vector2::from_fn(|i, _| modes.shapes[(i, ours)].re);
            shape.perp(&phi.column(paper).into_owned()).abs()
        })
        .fold(0.0, f64::max)
}
