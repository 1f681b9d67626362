//! The formulation of families of free motions that keep their energy, one at each energy, which is the parameter of the branch: shooting
//! on a level of energy. The closing equations of such a loop depend on each other; they do not with one unknown more, by how much the
//! loop is open up the gradient of the energy, which is zero on the branch (theory 19, "Families"). Energies in \[J\].

use crate::branch::equations::{Equations, ParameterDerivative};
use crate::branch::parametric_loop::{BranchDirection, ParametricLoop};
use crate::branch::problem::BranchProblem;
use crate::continuation::ScaledDirection;
use crate::error::{Error, Result};
use crate::hybrid::halves;
use crate::model::Energetics;
use crate::orbit::PeriodicOrbit;
use crate::path::ImpactSide;
use crate::tolerance::{BRANCH_AT_REST, CENTRAL_DIFFERENCE_STEP, ENERGY_OPENING};
use nalgebra::DVector;

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

/// Derivatives by the energy, which is in its own equation alone.
pub(super) fn derivative_by_energy(equations: &Equations) -> ParameterDerivative {
    let flights = equations.flights();
    let none = DVector::zeros(flights.rows.ncols());
    ParameterDerivative {
        column: DVector::zeros(flights.rows.nrows()).push(-1.0),
        flights: flights.deviations(&none),
    }
}

impl BranchProblem<'_> {
    /// The equations of shooting with the row of the energy of the first state and the column of the unknown by which the loop is open.
    pub fn on_energy_level(
        &self,
        place: &ParametricLoop,
        shooting: Equations,
        energetics: &Energetics,
    ) -> Result<Equations> {
        let first = &place.state.states[0];
        let energy = |state: &DVector<f64>| {
            let (q, v) = halves(state);
            energetics.total(&q, &v)
        };
        let rate = |i: usize| {
            let unit = self.unit_before_times(place, i);
            let at = |s: f64| {
                let mut state = first.clone();
                state[i] += s * unit;
                energy(&state)
            };
            Ok(
                (at(CENTRAL_DIFFERENCE_STEP)? - at(-CENTRAL_DIFFERENCE_STEP)?)
                    / (2.0 * CENTRAL_DIFFERENCE_STEP),
            )
        };
        let two_n = first.len();
        let rates = (0..two_n).map(rate).collect::<Result<Vec<f64>>>()?;
        let rates = DVector::from_vec(rates);
        let (below, beside) = shooting.rows.shape();
        let mut rows = shooting
            .rows
            .insert_row(below, 0.0)
            .insert_column(beside, 0.0);
        // The closing rows are the last ones of the loop.
        let gap = &rates / rates.norm();
        rows.view_mut((below - two_n, beside), (two_n, 1))
            .copy_from(&gap);
        rows.view_mut((below, 0), (1, two_n))
            .copy_from(&(rates / self.span()).transpose());
        let lacks = (place.value - energy(first)?) / self.span();
        Ok(Equations {
            rows,
            right: shooting.right.push(lacks),
            ..shooting
        })
    }

    /// Whether a direction leads to loops that are open, as motions are that were to keep their energy and lose it or gain it.
    pub fn opens(&self, direction: &BranchDirection) -> bool {
        let open = direction.loop_part.iter().next_back();
        let open = open.filter(|_| self.formulation.keeps_energy());
        open.is_some_and(|open| open.abs() > ENERGY_OPENING * direction.length())
    }

    /// Whether a motion that keeps its energy has come to rest.
    pub fn is_at_rest(&self, place: &ParametricLoop) -> bool {
        let fastest = place.state.states.iter().map(|x| {
            let n = x.len() / 2;
            x.rows(n, n).amax()
        });
        self.formulation.keeps_energy()
            && fastest.fold(0.0, f64::max) <= BRANCH_AT_REST * self.units.velocity
    }
}
