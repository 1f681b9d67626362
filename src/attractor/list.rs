//! The list of attractors of a scene, with the seeds that led to each. Attractors and seeds are counted from 0.

use crate::attractor::record::Attractor;

/// The attractors of a scene that were found, the one that most starts led to first: a sequence of them.
#[derive(Debug, Clone)]
pub struct Attractors {
    /// The attractors.
    pub all: Vec<Attractor>,
    /// The index of the attractor of each start, shape `(k,)`; `None` where the start was not decided, was lost, drifts, or began inside a
    /// stop.
    pub of_seed: Vec<Option<usize>>,
    /// Starts that were not decided.
    pub n_undecided: usize,
    /// Starts that left the surroundings of the box.
    pub n_lost: usize,
    /// Starts whose motion drifts: it repeats itself but for a constant advance.
    pub n_drifting: usize,
    /// Starts inside a stop.
    pub n_inside: usize,
}
