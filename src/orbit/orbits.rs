//! The list of all orbits of a pattern with the verdict on the periodic problem, and what is asked for it.

use crate::orbit::PeriodicOrbit;
use nalgebra::DMatrix;

/// The verdict on a periodic problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// There are isolated orbits.
    Found,
    /// There is none.
    None,
    /// There is a family of orbits with one parameter or more.
    Family,
}

/// The directions of a family of orbits.
#[derive(Debug, Clone)]
pub struct Family {
    /// Directions of the contact state (q, v) in which the orbit may be changed, shape `(2n, dimension)`.
    pub basis: DMatrix<f64>,
}

/// Options of [`crate::periodic_orbits`].
#[derive(Debug, Clone, PartialEq)]
pub struct OrbitOptions {
    /// Forcing periods in one period of the orbit, 1 or more.
    pub n_periods: usize,
    /// A given forcing phase at the first impact \[rad\]: the clearances come out. `None`: clearances given, phase found.
    pub phase: Option<f64>,
    /// One more unknown, as stops hit together need.
    pub free: Option<crate::orbit::Free>,
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

/// Every orbit of a pattern: stable and admissible ones first, then admissible ones, then those of which the search could not
/// decide it, then by depth of violation. In systems
/// of more than 60 degrees of freedom stability has no say in the order: the multipliers, which cost O(n^3), are computed
/// only when asked for.
#[derive(Debug, Clone)]
pub struct Orbits {
    pub(crate) all: Vec<PeriodicOrbit>,
    pub(crate) verdict: Verdict,
    pub(crate) reason: String,
    pub(crate) margin: Option<f64>,
    pub(crate) family: Option<Family>,
}

impl Orbits {
    /// Whether orbits were found, or a family, or none.
    pub fn verdict(&self) -> Verdict {
        self.verdict
    }

    /// Why, in words.
    pub fn reason(&self) -> &str {
        &self.reason
    }

    /// `1 - |d|/|alpha|`: how far the parameters are from the fold at which the orbits meet and vanish; negative: none.
    pub fn margin(&self) -> Option<f64> {
        self.margin
    }

    /// The family, where the verdict is one.
    pub fn family(&self) -> Option<&Family> {
        self.family.as_ref()
    }
}

impl IntoIterator for Orbits {
    type Item = PeriodicOrbit;
    type IntoIter = std::vec::IntoIter<PeriodicOrbit>;

    fn into_iter(self) -> Self::IntoIter {
        self.all.into_iter()
    }
}

impl std::ops::Deref for Orbits {
    type Target = [PeriodicOrbit];

    fn deref(&self) -> &[PeriodicOrbit] {
        &self.all
    }
}
