//! How a motion goes on beyond a boundary at which its branch ends, and how that is asked.

use crate::attractor::Attractor;
use crate::branch::candidate::Candidate;

/// How a motion may go on beyond a boundary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BeyondOutcome {
    /// As near to the last orbit as one likes, on a stable orbit of another branch or as what simulations come to.
    Continues,
    /// The branch meets an orbit that is not stable, and both end.
    NonsmoothFold,
    /// Neither, and simulations lead away however near to the boundary they begin.
    Jumps,
    /// That is not known.
    Undecided,
}

impl BeyondOutcome {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::Continues,
        Self::NonsmoothFold,
        Self::Jumps,
        Self::Undecided,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Continues => "continues",
            Self::NonsmoothFold => "nonsmooth_fold",
            Self::Jumps => "jumps",
            Self::Undecided => "undecided",
        }
    }
}

/// What becomes of a motion beyond a boundary.
#[derive(Debug, Clone)]
pub struct Beyond {
    /// How it goes on.
    pub outcome: BeyondOutcome,
    /// The branches that meet the branch there.
    pub candidates: Vec<Candidate>,
    /// Unless it continues, what a simulation comes to that begins next to the orbit, beyond the boundary.
    pub attractor: Option<Attractor>,
    /// How that was found, with the distance from the boundary and the length of the simulation.
    pub reason: String,
}

/// Options of [`beyond`](fn@crate::beyond).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeyondOptions {
    /// How far beyond the boundary it is looked, \[unit of the number\]; default 1e-3 of the range.
    pub delta: Option<f64>,
    /// Periods of the forcing that a simulation is given to settle, default 500.
    pub periods: usize,
}

impl Default for BeyondOptions {
    fn default() -> Self {
        Self {
            delta: None,
            periods: 500,
        }
    }
}
