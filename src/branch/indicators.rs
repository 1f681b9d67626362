//! Numbers that tell bifurcations of a branch by their signs (theory 19).

use crate::branch::equations::Foot;
use crate::branch::family::Family;
use crate::branch::multipliers::n_outside;
use crate::error::Result;
use crate::orbit::PeriodicOrbit;

/// Numbers of a point of a branch.
#[derive(Debug, Clone, Copy)]
pub(super) struct Indicators {
    /// The part of the number in the direction of the branch: it changes its sign at a fold.
    pub fold: f64,
    /// It changes its sign where a multiplier passes through -1, of half a motion that of half a period.
    pub doubling: f64,
    /// It changes its sign where another branch is crossed.
    pub crossing: f64,
    /// How many multipliers lie outside the unit circle; where the energy is kept no torus is looked for, and they are not counted.
    pub outside: Option<usize>,
}

impl Indicators {
    /// The same of the other direction, for a sign of -1.
    pub fn along(self, sign: f64) -> Self {
        Self {
            fold: self.fold * sign,
            crossing: self.crossing * sign,
            ..self
        }
    }

    pub fn at(
        family: &Family<'_>,
        (place, equations, tangent): Foot<'_>,
        orbit: &PeriodicOrbit,
    ) -> Result<Self> {
        let is_alone = orbit.scene().n_dof() == 1;
        Ok(Self {
            fold: tangent.value_part,
            // The multipliers of one coordinate that keeps its energy are both 1.
            doubling: if is_alone && family.energetics.is_some() {
                1.0
            } else {
                family.multiplier_test((place, Some(equations)), -1.0)?
            },
            crossing: equations.crossing(tangent),
            outside: if family.energetics.is_some() {
                None
            } else if family.has_pulses {
                family.n_outside_of_pulses(place)
            } else {
                n_outside(orbit, false)?
            },
        })
    }
}
