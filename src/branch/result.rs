//! The result of a continuation: orbits over a parameter, their special points and ends.

use crate::branch::multipliers::{is_free, n_outside, own_multipliers};
use crate::branch::special::Special;
use crate::continuation::BranchEnd;
use crate::error::Result;
use crate::orbit::{PeriodicOrbit, decides};

/// Periodic orbits of one pattern over a number of their scene: a sequence of m orbits, each beside those that it comes from.
#[derive(Debug, Clone)]
pub struct Branch {
    /// The motions, shape `(m,)`.
    pub orbits: Vec<PeriodicOrbit>,
    /// The number at each, shape `(m,)`, \[unit of the parameter\].
    pub parameter: Vec<f64>,
    /// How far along the branch each is from the orbit that was given, shape `(m,)`, \[-\], in scaled unknowns.
    pub arclength: Vec<f64>,
    /// Where it turns, where a multiplier passes through -1, and the boundaries at its ends, in their order.
    pub special: Vec<Special>,
    /// What it ends with, at its first point and at its last.
    pub ends: [BranchEnd; 2],
    /// Whether its last point is its first one again.
    pub is_closed: bool,
    /// Whether the number is the energy of motions that keep it.
    pub keeps_energy: bool,
    /// In a scene of many modes, whose branch is followed by impulses: how many multipliers of each orbit lie outside the unit circle,
    /// `None` where that is not decided. Shape `(m,)`.
    pub outside: Option<Vec<Option<usize>>>,
}

impl Branch {
    /// How many multipliers of each orbit lie outside the unit circle, by more than rounding; `None` where the return map has no
    /// derivative. Shape `(m,)`.
    ///
    /// # Errors
    /// `Error::NoConvergence` if an eigenvalue iteration fails.
    pub fn n_unstable(&self) -> Result<Vec<Option<usize>>> {
        if let Some(outside) = &self.outside {
            return Ok(outside.clone());
        }
        let count = |orbit| n_outside(orbit, self.keeps_energy);
        self.orbits.iter().map(count).collect()
    }

    /// Whether small deviations from each orbit die out, without forcing but for a shift in time; of motions that keep their energy, whether
    /// they do not grow, but for what differs by the energy. `None` where that is not decided. Shape `(m,)`.
    ///
    /// # Errors
    /// `Error::NoConvergence` if an eigenvalue iteration fails.
    pub fn is_stable(&self) -> Result<Vec<Option<bool>>> {
        if self.keeps_energy || self.outside.is_some() {
            let counts = self.n_unstable()?.into_iter();
            return Ok(counts.map(|count| count.map(|count| count == 0)).collect());
        }
        let is_stable = |orbit: &PeriodicOrbit| match own_multipliers(orbit)? {
            Some(own) if is_free(orbit) => {
                let largest = own.iter().map(|mu| mu.norm()).fold(0.0, f64::max);
                Ok(decides(largest))
            }
            _ => Ok(orbit.stability()?.is_stable),
        };
        self.orbits.iter().map(is_stable).collect()
    }
}
