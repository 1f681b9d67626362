//! What is asked of a search for periodic orbits.

use crate::model::Parameter;

/// The parameter that is one more unknown of a pattern whose stops are hit together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FreeParameter {
    /// The clearances of the stops hit, all times one factor (equal ones stay equal).
    Clearance,
    /// A parameter of the scene, searched in a range.
    Parameter(Parameter),
}

impl std::fmt::Display for FreeParameter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Clearance => write!(f, "clearance"),
            Self::Parameter(parameter) => write!(f, "{parameter}"),
        }
    }
}

/// Options of [`crate::periodic_orbits`].
#[derive(Debug, Clone, PartialEq)]
pub struct OrbitOptions {
    /// Forcing periods in one period of the orbit, 1 or more.
    pub n_periods: usize,
    /// A given forcing phase at the first impact \[rad\]: the clearances come out. `None`: clearances given, phase found.
    pub phase: Option<f64>,
    /// One more unknown, as stops hit together need.
    pub free: Option<FreeParameter>,
    /// The range of the free parameter.
    pub between: Option<(f64, f64)>,
}

impl Default for OrbitOptions {
    fn default() -> Self {
        Self {
            n_periods: 1,
            phase: None,
            free: None,
            between: None,
        }
    }
}
