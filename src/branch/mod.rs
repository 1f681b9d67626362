//! Branches: periodic motions followed over a number of their scene (theory 19).
//!
//! Unknown are a periodic motion, as the states (q, v) at which its flights begin and the times of its events (`parametric_loop.rs`), and
//! the value p of the number. They are scaled: positions and velocities by units of the motion, times by the forcing, so that they are
//! phases \[rad\], and p by the range over which it may go; arclength \[-\] is the mean square of those of the motion beside that of p.
//! `equations.rs` has the equations and their Jacobian, `zero_problem.rs` hands them to `continuation`, which makes the steps; `advance.rs`
//! judges a step, `walk.rs` says what is done at each; `test_functions.rs` says what changes sign where, `bifurcations.rs` and
//! `interpolation_locator.rs` find it, `boundary.rs` names the rule of contact that is broken there, `switching.rs` finds the branches
//! that begin there. `curve` follows special points over two numbers.

mod accumulation;
mod advance;
mod beyond_boundary;
mod bifurcations;
mod border;
mod boundary;
mod candidate;
mod collapse;
mod continued;
mod crossings;
mod curve;
mod doubling_end;
mod energy;
mod equations;
mod half_branch;
mod interpolation_locator;
mod landing;
mod many_modes;
mod multipliers;
mod options;
mod parametric_loop;
mod predictor;
mod problem;
mod reduced_motion;
mod release_onset;
mod result;
mod shooting_nodes;
mod simulated;
mod special;
mod switching;
mod symmetry;
mod test_functions;
mod touch;
mod walk;
mod zero_problem;

pub use crate::continuation::{BranchEnd, EndReason};
pub use accumulation::{accumulation, accumulation_of};
pub use candidate::Candidate;
pub use continued::{continuation, continuation_of, continuation_over_energy};
pub use curve::{BifurcationCurve, CurveOf, CurvePoint, bifurcation_curve, bifurcation_curve_of};
pub use options::{ContinuationOptions, Heading, Virtual};
pub use result::Branch;
pub use special::{Special, SpecialKind};
pub use switching::{branches, branches_of, branches_over_energy};

pub(crate) use problem::{check_same, stretched};
