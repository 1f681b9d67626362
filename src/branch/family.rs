//! The scenes of a branch, one for each value of its parameter.

use crate::branch::place::{Direction, Place};
use crate::error::{Error, Result};
use crate::model::Scene;
use crate::orbit::{Clocked, ScaledUnits, ShootingState, Signature, with_phase};
use nalgebra::DVector;
use std::f64::consts::TAU;

/// A range of so small a part of its numbers is measured by these: steps in parts of it would be lost in their rounding.
const SHORT: f64 = 1e-3;

/// The scenes of a branch, what happens along its orbits, and the units of its unknowns.
pub(super) struct Family<'a> {
    pub make: &'a dyn Fn(f64) -> Result<Scene>,
    /// The range that is asked for.
    pub range: (f64, f64),
    pub signature: Signature,
    /// The phase of the forcing at time zero, for all of them; whether there is none, and the first instant is at time zero.
    pub phase: f64,
    pub is_free: bool,
    /// Units of positions and velocities, and of time where nothing gives one.
    pub units: ScaledUnits,
}

impl Family<'_> {
    /// The scene of a value.
    pub fn scene(&self, value: f64) -> Result<Scene> {
        let scene = (self.make)(value)?;
        with_phase(&scene, self.phase, self.signature.depends_on_time)
    }

    /// The unit of the parameter: the width of the range, unless that is next to nothing of it.
    pub fn span(&self) -> f64 {
        let (low, high) = self.range;
        (high - low).max(SHORT * low.abs().max(high.abs()))
    }

    /// The step of a difference by the parameter.
    pub fn difference(&self, value: f64) -> f64 {
        let size = value.abs().max(1e-3 * self.span());
        6e-6 * self.span().min(size)
    }

    /// The units in a scene, where times count in angles of its forcing.
    pub fn units_in(&self, scene: &Scene) -> ScaledUnits {
        match self.signature.clocked(scene) {
            Clocked::Forced { period } => ScaledUnits {
                time: period / (TAU * self.signature.n_periods as f64),
                ..self.units
            },
            Clocked::Free => self.units,
        }
    }

    /// The way from a loop to another, in the scaled unknowns.
    pub fn between(&self, from: &Place, to: &Place, unknowns: usize) -> Direction {
        let two_n = from.state.states[0].len();
        let first = usize::from(self.is_free);
        let part = |i: usize| {
            if i < two_n {
                let unit = if i < two_n / 2 {
                    self.units.position
                } else {
                    self.units.velocity
                };
                (to.state.states[0][i] - from.state.states[0][i]) / unit
            } else {
                let k = i - two_n + first;
                to.state.times[k] / to.clock - from.state.times[k] / from.clock
            }
        };
        Direction {
            loop_part: DVector::from_fn(unknowns, |i, _| part(i)),
            value_part: (to.value - from.value) / self.span(),
        }
    }
}

/// A loop of one scene in another, instants at the phases that they have.
pub(crate) fn stretched(state: &ShootingState, from: &Scene, to: &Scene) -> ShootingState {
    let factor = match (from.frequency(), to.frequency()) {
        (Some(from), Some(to)) => from / to,
        _ => 1.0,
    };
    let stretch = |times: &[f64]| times.iter().map(|t| t * factor).collect();
    ShootingState {
        times: stretch(&state.times),
        starts: stretch(&state.starts),
        states: state.states.clone(),
    }
}

/// Refuses scenes in which a loop of another has no meaning.
pub(crate) fn check_same(one: &Scene, other: &Scene, value: f64) -> Result<()> {
    let shape = |scene: &Scene| {
        (
            scene.n_dof(),
            scene.stops().len(),
            scene.frequency().is_some(),
        )
    };
    if shape(one) == shape(other) {
        return Ok(());
    }
    let (n, stops, forced) = shape(other);
    let forcing = if forced { "a" } else { "no" };
    let found = format!("of {n} coordinates, {stops} stops and {forcing} forcing at {value}");
    let rule = "it must have as many coordinates and stops as the scene of the orbit, and a forcing where that has one";
    Err(Error::bad_value(
        "parameter",
        format!("a scene {found}"),
        rule,
    ))
}
