//! Families of free motions that keep their energy, one at each energy, which is the parameter of the branch. The closing equations of such
//! a loop depend on each other; they do not with one unknown more, by how much the loop is open up the gradient of the energy, which is
//! zero on the branch (theory 19, "Families"). Energies in \[J\].

use crate::branch::parametric_loop::{BranchDirection, ParametricLoop};
use crate::branch::problem::BranchProblem;
use crate::continuation::ScaledDirection;
use crate::error::{Error, Result};
use crate::hybrid::halves;
use crate::model::Energetics;
use crate::orbit::{Linearised, PeriodicOrbit, ShootingState};
use crate::path::ImpactSide;
use crate::tolerance::{CENTRAL_DIFFERENCE_STEP, ENERGY_OPENING};
use nalgebra::{DMatrix, DVector};

/// The energy of a loop: that of its first state.
pub(super) fn energy_of(energetics: &Energetics, state: &ShootingState) -> Result<f64> {
    let (q, v) = halves(&state.states[0]);
    energetics.total(&q, &v)
}

/// The energy of an orbit.
///
/// # Errors
/// A scene with a forcing or a moving stop, a system given by functions without its mass matrix or its potential.
pub(super) fn energy_at(orbit: &PeriodicOrbit) -> Result<(Energetics, f64)> {
    let scene = orbit.scene();
    if scene.frequency().is_some() {
        let rule = "a motion keeps its energy without forcing only";
        return Err(Error::bad_value("parameter", "\"energy\"", rule));
    }
    let energetics = Energetics::new(scene)?;
    let (q, v) = orbit.state_at(0.0, ImpactSide::After);
    let energy = energetics.total(&q, &v)?;
    Ok((energetics, energy))
}

/// Whether a direction leads to loops that are open, as motions are that lose energy or gain it.
pub(super) fn opens(direction: &BranchDirection) -> bool {
    let open = direction.loop_part.iter().next_back();
    open.is_some_and(|open| open.abs() > ENERGY_OPENING * direction.length())
}

impl BranchProblem<'_> {
    /// The equations of a loop with the row of its energy and the column of the unknown by which it is open; unchanged where the energy is
    /// not the parameter.
    pub fn with_energy(
        &self,
        place: &ParametricLoop,
        linear: &Linearised,
    ) -> Result<(DMatrix<f64>, DVector<f64>)> {
        let (rows, right) = (linear.rows.clone(), linear.right.clone());
        let Some(energetics) = self.energetics else {
            return Ok((rows, right));
        };
        let first = &place.state.states[0];
        let (n, last) = (first.len() / 2, rows.shape());
        let rate = |i: usize| {
            let unit = if i < n {
                self.units.position
            } else {
                self.units.velocity
            };
            let at = |s: f64| {
                let mut state = first.clone();
                state[i] += s * unit;
                let (q, v) = halves(&state);
                energetics.total(&q, &v)
            };
            Ok(
                (at(CENTRAL_DIFFERENCE_STEP)? - at(-CENTRAL_DIFFERENCE_STEP)?)
                    / (2.0 * CENTRAL_DIFFERENCE_STEP),
            )
        };
        let rates = (0..2 * n).map(rate).collect::<Result<Vec<f64>>>()?;
        let rates = DVector::from_vec(rates);
        let mut rows = rows.insert_row(last.0, 0.0).insert_column(last.1, 0.0);
        // The closing rows are the last ones of the loop.
        let gap = &rates / rates.norm();
        rows.view_mut((last.0 - 2 * n, last.1), (2 * n, 1))
            .copy_from(&gap);
        rows.view_mut((last.0, 0), (1, 2 * n))
            .copy_from(&(rates / self.span()).transpose());
        let lacks = (place.value - energy_of(energetics, &place.state)?) / self.span();
        Ok((rows, right.push(lacks)))
    }
}
