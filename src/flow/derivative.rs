//! Time derivatives of any order of a linear motion, by its equation: what decides at a contact where all lower ones vanish.

use crate::flow::stuck::solve_columns;
use crate::flow::{CANCELLED, ModalScene};
use crate::model::LinearSystem;
use nalgebra::{Complex, DMatrix, DVector};

/// The matrices of `x'' = P M^-1 (f - K x - C x')` and the sizes of their entries. P is what the contact forces of stops that are held
/// leave of an acceleration; none where nothing is held.
#[derive(Debug, Clone)]
pub(crate) struct Equations {
    inverse: WithSizes,
    stiffness: WithSizes,
    damping: WithSizes,
}

/// A matrix and the sizes of its entries.
#[derive(Debug, Clone)]
struct WithSizes {
    entries: DMatrix<f64>,
    sizes: DMatrix<f64>,
}

impl From<DMatrix<f64>> for WithSizes {
    fn from(entries: DMatrix<f64>) -> Self {
        let sizes = entries.abs();
        Self { entries, sizes }
    }
}

impl Equations {
    pub fn new(system: &LinearSystem, along: Option<&DMatrix<f64>>) -> Self {
        let n = system.n_dof();
        let mut inverse = solve_columns(system, &DMatrix::identity(n, n));
        if let Some(along) = along {
            inverse = along * inverse;
        }
        Self {
            inverse: inverse.into(),
            stiffness: system.stiffness().to_dense().into(),
            damping: system.damping().to_dense().into(),
        }
    }

    /// A derivative of the position from order 2 on, `x^(k+2) = P M^-1 (f^(k) - K x^(k) - C x^(k+1))` under a scene's
    /// `f + Re(F e^{i w t})`, and what rounding, that of the state and that of every sum, leaves unknown of each of its entries.
    pub fn derivative(
        &self,
        scene: &ModalScene,
        angle: f64,
        (q, v): (DVector<f64>, DVector<f64>),
        order: usize,
    ) -> (DVector<f64>, DVector<f64>) {
        let n = q.len();
        let lost = |x: &DVector<f64>| DVector::from_element(n, CANCELLED * x.amax());
        let (lost_q, lost_v) = (lost(&q), lost(&v));
        let (mut x, mut next) = ((q, lost_q), (v, lost_v));
        let (mut size, mut next_size) = (x.0.abs(), next.0.abs());
        let mut force = scene.amplitude.map(|f| f * Complex::cis(angle));
        let turn = Complex::new(0.0, scene.frequency);
        let (inverse, stiffness, damping) = (&self.inverse, &self.stiffness, &self.damping);
        for k in 2..=order {
            let mut sum = force.map(|f| f.re);
            let mut terms = force.map(Complex::norm);
            if k == 2 {
                sum += scene.system.load();
                terms += scene.system.load().abs();
            }
            sum.gemv(-1.0, &stiffness.entries, &x.0, 1.0);
            sum.gemv(-1.0, &damping.entries, &next.0, 1.0);
            terms.gemv(1.0, &stiffness.sizes, &size, 1.0);
            terms.gemv(1.0, &damping.sizes, &next_size, 1.0);
            let mut unknown = terms * CANCELLED;
            unknown.gemv(1.0, &stiffness.sizes, &x.1, 1.0);
            unknown.gemv(1.0, &damping.sizes, &next.1, 1.0);
            x = next;
            next = (&inverse.entries * sum, &inverse.sizes * unknown);
            size = std::mem::replace(&mut next_size, next.0.abs());
            force *= turn;
        }
        next
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Forcing, Harmonic, Scene, Stop};
    use nalgebra::dvector;

    #[test]
    fn derivatives_of_a_forced_oscillator_are_those_of_its_motion() {
        // x'' + 4 x = 3 cos t from rest at zero: x = cos t - cos 2t.
        let system = LinearSystem::new(dvector![1.0], dvector![0.0], dvector![4.0]);
        let force = Harmonic::new(dvector![Complex::new(3.0, 0.0)], 1.0, 0.0).expect("valid");
        let scene = Scene::new(
            system.expect("valid"),
            Forcing::from(force),
            Vec::<Stop>::new(),
        )
        .expect("valid");
        let scene = ModalScene::new(&scene, "derivatives").expect("linear");
        let equations = Equations::new(&scene.system, None);
        for t in [0.0f64, 0.4, 2.0] {
            let x = |k: i32, t: f64| {
                let turn = 0.5 * std::f64::consts::PI * f64::from(k);
                (t + turn).cos() - 2f64.powi(k) * (2.0 * t + turn).cos()
            };
            let state = (dvector![x(0, t)], dvector![x(1, t)]);
            for order in 2..12 {
                let (value, unknown) = equations.derivative(&scene, t, state.clone(), order);
                let off = value[0] - x(i32::try_from(order).expect("small"), t);
                assert!(
                    off.abs() <= unknown[0],
                    "{t} {order} {off:e} {}",
                    unknown[0]
                );
                assert!(unknown[0] < 1e-12 * 2f64.powi(i32::try_from(order).expect("small")));
            }
        }
    }
}
