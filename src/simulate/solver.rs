//! By which method a motion is computed, and how exactly: asked of every run, whatever runs it.

use crate::error::Result;
use crate::flow::characteristic_length::Tolerances;
use crate::flow::steps::Tolerance;
use crate::quantity::not_negative;
use crate::simulate::method::Method;

/// The method of a run, with its tolerances.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solver {
    /// How the flights are computed.
    pub method: Method,
    /// Relative tolerance, default 1e-9, of each step of an integration. With every method it says when impacts that accumulate are
    /// completed, and how deep inside a stop a start may lie; in exact flights the latter where it is stricter than the default.
    pub rtol: f64,
    /// Absolute tolerance, as `rtol`. Default: 1e-12 of how far the motion goes, of each gap by itself: of the largest of its
    /// clearance, the motion of its stop, the terms of `n.q` at the start and in the steady response of a linear scene, and of
    /// `n.v` at the start times the time of a turn; where steps are taken the smallest of those of gaps and coordinates; 1e-12
    /// where all are zero. A number is absolute, in the units of the coordinates. [`Stats::atol`](crate::Stats::atol) has the one that
    /// was used.
    pub atol: Option<f64>,
}

impl Default for Solver {
    fn default() -> Self {
        Method::default().into()
    }
}

impl From<Method> for Solver {
    /// The method with the tolerances that are not given.
    fn from(method: Method) -> Self {
        Self {
            method,
            rtol: Tolerance::USUAL.relative,
            atol: None,
        }
    }
}

impl Solver {
    /// The tolerances.
    pub(crate) fn tolerances(&self) -> Tolerances {
        Tolerances {
            relative: self.rtol,
            absolute: self.atol,
        }
    }

    /// Whether the tolerances are ones.
    ///
    /// # Errors
    /// A tolerance that is negative or not finite.
    pub(crate) fn check(&self) -> Result<()> {
        let given = [("rtol", Some(self.rtol)), ("atol", self.atol)];
        for (name, value) in given.iter().filter_map(|(name, x)| Some((*name, (*x)?))) {
            not_negative(name, value)?;
        }
        Ok(())
    }
}
