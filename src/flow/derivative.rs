//! Time derivatives of any order of a linear motion, by its equation: what decides at a contact where all lower ones vanish.

use crate::flow::{CANCELLED, ModalScene};
use nalgebra::{Complex, DMatrix, DVector};

/// A derivative of the position from order 2 on, `x^(k+2) = P M^-1 (f^(k) - K x^(k) - C x^(k+1))` under `f + Re(F e^{i w t})`, and
/// what rounding, that of the state and that of every sum, leaves unknown of each of its entries. P is what the contact forces of
/// stops that are held leave of an acceleration; none where nothing is held.
pub(crate) fn derivative(
    scene: &ModalScene,
    along: Option<&DMatrix<f64>>,
    angle: f64,
    (q, v): (DVector<f64>, DVector<f64>),
    order: usize,
) -> (DVector<f64>, DVector<f64>) {
    let (system, n) = (&scene.system, q.len());
    let (stiffness, damping) = (system.stiffness().to_dense(), system.damping().to_dense());
    let unit = |i: usize| DVector::from_fn(n, |j, _| f64::from(u8::from(i == j)));
    let columns: Vec<_> = (0..n).map(|i| system.solve_mass(&unit(i))).collect();
    let mut inverse = DMatrix::from_columns(&columns);
    if let Some(along) = along {
        inverse = along * inverse;
    }
    let lost = |x: &DVector<f64>| DVector::from_element(n, CANCELLED * x.amax());
    let (mut x, mut next) = ((q.clone(), lost(&q)), (v.clone(), lost(&v)));
    let mut force = scene.amplitude.map(|f| f * Complex::cis(angle));
    let turn = Complex::new(0.0, scene.frequency);
    for k in 2..=order {
        let load = if k == 2 {
            system.load().clone()
        } else {
            DVector::zeros(n)
        };
        let sum = &load + force.map(|f| f.re) - &stiffness * &x.0 - &damping * &next.0;
        let (k_size, c_size) = (stiffness.abs(), damping.abs());
        let terms =
            load.abs() + force.map(Complex::norm) + &k_size * x.0.abs() + &c_size * next.0.abs();
        let unknown = CANCELLED * terms + k_size * x.1 + c_size * &next.1;
        x = next;
        next = (&inverse * sum, inverse.abs() * unknown);
        force *= turn;
    }
    next
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Forcing, Harmonic, LinearSystem, Scene, Stop};
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
        for t in [0.0f64, 0.4, 2.0] {
            let x = |k: i32, t: f64| {
                let turn = 0.5 * std::f64::consts::PI * f64::from(k);
                (t + turn).cos() - 2f64.powi(k) * (2.0 * t + turn).cos()
            };
            let state = (dvector![x(0, t)], dvector![x(1, t)]);
            for order in 2..12 {
                let (value, unknown) = derivative(&scene, None, t, state.clone(), order);
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
