//! Trajectories as plain numbers, from which they can be made again without running them: for pickling and files.

use crate::model::Ramp;
use crate::path::Samples;

/// A trajectory as plain numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct SavedTrajectory {
    /// Start and end.
    pub span: (f64, f64),
    /// Name of the status.
    pub status: String,
    /// How the run ended, in words.
    pub message: String,
    /// The counts of [`Stats`](crate::Stats), that of contacts last and only where there were any.
    pub stats: Vec<usize>,
    /// The absolute tolerance of the run, NaN of what was saved without it.
    pub atol: f64,
    /// Time, stop, speed before, speed after, impulse and forcing phase of each impact.
    pub impacts: Vec<(f64, usize, f64, f64, f64, f64)>,
    /// Time, stop and depth of each graze.
    pub grazes: Vec<(f64, usize, f64)>,
    /// Final position \[m\] and velocity \[m/s\], shape `(n_dof,)` each.
    pub last: (Vec<f64>, Vec<f64>),
    /// The motion kept, of each chapter of the run: one where there was no ramp.
    pub motion: Option<Vec<SavedMotion>>,
    /// The ramps, and the time up to which the run was to go.
    pub ramps: (Vec<Ramp>, f64),
    /// Start and end of each chapter, and the number of its first impact.
    pub chapters: Vec<(f64, f64, usize)>,
    /// What another run goes on from; `None` of what was saved without it.
    pub left: Option<SavedLeft>,
    /// The contacts of a run that keeps its impacts alone, ten numbers each in the order of [`ContactRecord`](crate::ContactRecord), shape
    /// `(10 n_contacts,)`, \[mixed\].
    pub contacts: Option<Vec<f64>>,
    /// The samples at `t_eval`.
    pub samples: Option<Samples>,
}

/// What a run leaves behind for the next one, as plain numbers: the elements that are not free, each with its state in the digits above it;
/// the place of each that relaxes; the tolerances and the numbers of the flight under way.
pub type SavedLeft = (
    Vec<usize>,
    Vec<(usize, f64)>,
    Option<(f64, Option<f64>, Vec<f64>)>,
);

/// A motion as plain numbers: clock reading and span of each piece; the numbers of the pieces, one after the other; name,
/// stops and first piece of each segment; the degree of the polynomials of steps, below 8, or the order of
/// series; zero for exact flights.
pub type SavedMotion = (
    Vec<[f64; 3]>,
    Vec<f64>,
    Vec<(String, Vec<usize>, usize)>,
    usize,
);
