//! The columns of the library's ledger beside what its own motion says: energies are those of its states, and the balance is the sum
//! of the columns.

use crate::runs::case::Case;
use crate::runs::compare::Difference;
use nalgebra::{DMatrix, DVector, RowDVector};
use vibroimpact::{Energy, Motion, Trajectory};

/// Half of a quadratic form.
fn half(matrix: &DMatrix<f64>, x: &DVector<f64>) -> f64 {
    0.5 * x.dot(&(matrix * x))
}

/// What a column is off at some time, if it is by more than allowed.
fn off(name: &str, k: usize, (is, should): (f64, f64), allowed: f64) -> Option<Difference> {
    let differs = (is - should).abs() > allowed;
    differs.then(|| Difference {
        class: format!("{name} against the motion"),
        detail: format!("entry {k}: {is:e}, of the states {should:e}, allowed {allowed:e}"),
    })
}

/// Whether energies are those of the states, and the balance is the sum of the columns, to a limit.
pub fn columns_are_energies(
    case: &Case,
    run: &Trajectory,
    (energy, limit): (&Energy, f64),
) -> Option<Difference> {
    let (_, q, v) = run.samples().expect("motion is kept");
    let load = DVector::from_row_slice(&case.load);
    let sum = |k: usize| {
        let losses = energy.damping_loss[k] + energy.impact_loss[k];
        energy.kinetic[k] + energy.potential[k] - energy.forcing_work[k] + losses
    };
    let column = |row: RowDVector<f64>| row.transpose();
    (0..q.nrows()).find_map(|k| {
        let (q, v) = (column(q.row(k).into_owned()), column(v.row(k).into_owned()));
        let potential = half(&case.stiffness, &q) - load.dot(&q);
        let kinetic = half(&case.mass, &v);
        off("kinetic energy", k, (energy.kinetic[k], kinetic), limit)
            .or_else(|| {
                off(
                    "potential energy",
                    k,
                    (energy.potential[k], potential),
                    limit,
                )
            })
            .or_else(|| off("balance", k, (energy.balance[k], sum(k) - sum(0)), limit))
    })
}
