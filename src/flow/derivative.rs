//! Time derivatives of any order of a linear motion, from its equation of motion: at a contact the first one that does not vanish decides.

use crate::flow::modal_scene::ModalScene;
use crate::law::LinearForce;
use crate::model::{LinearSystem, Moment, PhysicalState};
use crate::tolerance::CANCELLED;
use nalgebra::{Complex, DMatrix, DVector};
use std::ops::Range;

/// The matrices of `x'' = P M^-1 (f - K x - C x')` and the sizes of their entries. P projects accelerations onto those
/// that the stops held allow; it is left out where none is held.
#[derive(Debug, Clone)]
pub(crate) struct LinearEquations {
    inverse: WithSizes,
    stiffness: WithSizes,
    damping: WithSizes,
    /// What is constant beside the load of the scene.
    load: DVector<f64>,
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

/// One time derivative of a motion with its error: its entries, the rounding of each, and their sizes.
struct DerivativeEstimate {
    value: DVector<f64>,
    unknown: DVector<f64>,
    size: DVector<f64>,
}

impl LinearEquations {
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
            load: DVector::zeros(n),
        }
    }

    /// With a force `F0 + k p + c p'`, `p = n.x - clearance`, that pushes against a direction, M times its reaction.
    pub fn push(
        &mut self,
        direction: &DVector<f64>,
        normal: &DVector<f64>,
        (force, clearance): (LinearForce, f64),
    ) {
        let across = direction * normal.transpose();
        for (matrix, factor) in [
            (&mut self.stiffness, force.stiffness),
            (&mut self.damping, force.damping),
        ] {
            matrix.entries += &across * factor;
            matrix.sizes += across.abs() * factor;
        }
        self.load += direction * (force.stiffness * clearance - force.preload);
    }

    /// Derivatives of the position of some orders from 2 on, `x^(k+2) = P M^-1 (f^(k) - K x^(k) - C x^(k+1))` under a scene's
    /// excitation, and what rounding, that of the state and that of every sum, leaves unknown of each of its entries;
    /// `lost` is what is unknown of position and velocity, where that is more than their rounding; `carried` what stops that are held
    /// and move add to the derivative of an order.
    pub fn derivatives(
        &self,
        scene: &ModalScene,
        at: Moment,
        (q, v): PhysicalState,
        lost: Option<[DVector<f64>; 2]>,
        (orders, carried): (Range<usize>, &dyn Fn(usize) -> Option<DVector<f64>>),
    ) -> Vec<(DVector<f64>, DVector<f64>)> {
        let n = q.len();
        let given = |value: DVector<f64>| DerivativeEstimate {
            unknown: DVector::from_element(n, CANCELLED * value.amax()),
            size: value.abs(),
            value,
        };
        let (mut x, mut next, mut after) = (given(q), given(v), given(DVector::zeros(n)));
        if let Some([of_q, of_v]) = lost {
            x.unknown = x.unknown.sup(&of_q);
            next.unknown = next.unknown.sup(&of_v);
        }
        let (mut sum, mut terms) = (DVector::zeros(n), DVector::zeros(n));
        let excitation = &scene.excitation;
        let rotations = scene
            .rotations
            .frequencies()
            .zip(scene.rotations.phasors(at));
        let mut forces: Vec<(Complex<f64>, DVector<Complex<f64>>)> = rotations
            .zip(&excitation.harmonics)
            .filter(|(_, part)| !part.force.is_empty())
            .map(|((w, u), part)| (Complex::new(0.0, w), part.force.map(|f| f * u)))
            .collect();
        let signals: Vec<(&DVector<f64>, Vec<f64>)> = excitation
            .signals
            .iter()
            .filter(|part| !part.force.is_empty())
            .map(|part| {
                let mut derivatives = vec![0.0; part.signal.degree() + 1];
                let put = |m: usize, x: f64| derivatives[m] = x;
                part.signal.derivatives(at.since, at.time, put);
                (&part.force, derivatives)
            })
            .collect();
        let (inverse, stiffness, damping) = (&self.inverse, &self.stiffness, &self.damping);
        let mut found = Vec::new();
        for k in 2..orders.end {
            sum.fill(0.0);
            terms.fill(0.0);
            for (turn, force) in &mut forces {
                sum.zip_apply(force, |sum, f| *sum += f.re);
                terms.zip_apply(force, |terms, f| *terms += f.norm());
                *force *= *turn;
            }
            for (direction, derivatives) in &signals {
                let x = derivatives.get(k - 2).copied().unwrap_or(0.0);
                sum.axpy(x, direction, 1.0);
                terms.zip_apply(direction, |terms, d| *terms += (d * x).abs());
            }
            if k == 2 && !excitation.load.is_empty() {
                sum += &excitation.load;
                terms += excitation.load.abs();
            }
            if k == 2 {
                sum += &self.load;
                terms += self.load.abs();
            }
            sum.gemv(-1.0, &stiffness.entries, &x.value, 1.0);
            sum.gemv(-1.0, &damping.entries, &next.value, 1.0);
            terms.gemv(1.0, &stiffness.sizes, &x.size, 1.0);
            terms.gemv(1.0, &damping.sizes, &next.size, 1.0);
            terms *= CANCELLED;
            terms.gemv(1.0, &stiffness.sizes, &x.unknown, 1.0);
            terms.gemv(1.0, &damping.sizes, &next.unknown, 1.0);
            inverse.entries.mul_to(&sum, &mut after.value);
            inverse.sizes.mul_to(&terms, &mut after.unknown);
            if let Some(own) = carried(k) {
                after.value += &own;
                after.unknown.axpy(CANCELLED, &own.abs(), 1.0);
            }
            after
                .size
                .zip_apply(&after.value, |size, value| *size = value.abs());
            std::mem::swap(&mut x, &mut next);
            std::mem::swap(&mut next, &mut after);
            if k >= orders.start {
                found.push((next.value.clone(), next.unknown.clone()));
            }
        }
        found
    }
}

/// `M^-1` times a matrix.
pub(super) fn solve_columns(system: &LinearSystem, m: &DMatrix<f64>) -> DMatrix<f64> {
    let columns: Vec<_> = m
        .column_iter()
        .map(|c| system.solve_mass(&c.into_owned()))
        .collect();
    DMatrix::from_columns(&columns)
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
        let equations = LinearEquations::new(&scene.system, None);
        for t in [0.0f64, 0.4, 2.0] {
            let x = |k: i32, t: f64| {
                let turn = 0.5 * std::f64::consts::PI * f64::from(k);
                (t + turn).cos() - 2f64.powi(k) * (2.0 * t + turn).cos()
            };
            let state = (dvector![x(0, t)], dvector![x(1, t)]);
            let at = Moment::of_angle(t);
            let derivatives = equations.derivatives(&scene, at, state, None, (2..12, &|_| None));
            assert_eq!(derivatives.len(), 10);
            for (order, (value, unknown)) in (2..).zip(derivatives) {
                let off = value[0] - x(order, t);
                assert!(
                    off.abs() <= unknown[0],
                    "{t} {order} {off:e} {}",
                    unknown[0]
                );
                assert!(unknown[0] < 1e-12 * 2f64.powi(order));
            }
        }
    }
}
