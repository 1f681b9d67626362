//! Options of the search for attractors. Periods count those of the forcing, phases are in \[rad\].

use crate::simulate::{Keep, SimulateOptions, Solver};
use crate::sweep::SweepOptions;

/// Options of [`find_attractors`](crate::find_attractors).
#[derive(Debug, Clone, PartialEq)]
pub struct AttractorOptions {
    /// The phase of the forcing at which motions begin and points are taken, default 0 \[rad\].
    pub phase: f64,
    /// The longest period that is looked for, in periods of the forcing, default 32.
    pub longest_period: usize,
    /// Periods that are left out, default 200.
    pub transient: usize,
    /// Periods after which a motion that has not settled is told by its exponents, default 2000.
    pub max_periods: usize,
    /// As for [`simulate`](crate::simulate()).
    pub solver: Solver,
    /// Threads.
    pub sweep: SweepOptions,
}

impl Default for AttractorOptions {
    fn default() -> Self {
        Self {
            phase: 0.0,
            longest_period: 32,
            transient: 200,
            max_periods: 2000,
            solver: Solver::default(),
            sweep: SweepOptions::default(),
        }
    }
}

impl AttractorOptions {
    /// The options of a run that keeps `keep`.
    pub(crate) fn run(&self, keep: Keep) -> SimulateOptions {
        SimulateOptions::by(self.solver, keep)
    }
}
