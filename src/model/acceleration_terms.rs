//! Sizes of the terms of an acceleration: its rounding is a part of those, not of what is left of them.

use crate::model::linear::{Coefficient, LinearSystem};
use nalgebra::DVector;

/// Sizes of the terms of the forces on each coordinate of a linear system, at a state; `given` are those of what acts beside its own
/// load.
pub(crate) fn force_terms(
    system: &LinearSystem,
    given: &DVector<f64>,
    (q, v): (&DVector<f64>, &DVector<f64>),
) -> DVector<f64> {
    system.load().abs() + given + sizes(system.stiffness(), q) + sizes(system.damping(), v)
}

/// Size of the terms of `normal . q''` under forces whose terms have given sizes.
pub(crate) fn acceleration_size(
    system: &LinearSystem,
    normal: &DVector<f64>,
    forces: &DVector<f64>,
) -> f64 {
    system.solve_mass(normal).abs().dot(forces)
}

/// Sums of the sizes of the terms of a matrix times a vector.
fn sizes(matrix: &Coefficient, x: &DVector<f64>) -> DVector<f64> {
    match matrix {
        Coefficient::Diagonal(d) => d.component_mul(x).abs(),
        Coefficient::Dense(m) => {
            let size = |i: usize, j: usize| (m[(i, j)] * x[j]).abs();
            DVector::from_fn(x.len(), |i, _| (0..x.len()).map(|j| size(i, j)).sum())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{dmatrix, dvector};

    #[test]
    fn what_cancels_counts() {
        let stiffness = dmatrix![3.0, -3.0; -3.0, 3.0];
        let system = LinearSystem::new(dvector![2.0, 1.0], dvector![0.5, 0.0], stiffness)
            .and_then(|system| system.with_load(dvector![-1.0, 0.0]))
            .expect("a system");
        let given = dvector![4.0, 0.0];
        let state = (&dvector![1.0, 1.0], &dvector![2.0, 5.0]);
        let terms = force_terms(&system, &given, state);
        let size = acceleration_size(&system, &dvector![-1.0, 0.0], &terms);
        assert_eq!(size, (1.0 + 4.0 + 3.0 + 3.0 + 1.0) / 2.0);
    }
}
