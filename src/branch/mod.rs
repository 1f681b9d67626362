//! Branches: periodic motions followed over a number of their scene (theory 19).
//!
//! Unknown are a periodic motion, as the states (q, v) at which its flights begin and the times of its events (`parametric_loop.rs`), and
//! the value p of the number. They are scaled: positions and velocities by units of the motion, times by the forcing, so that they are
//! phases \[rad\], and p by the range over which it may go; arclength \[-\] is the mean square of those of the motion beside that of p.
//! `equations.rs` has the equations and their Jacobian, `predictor.rs` and `corrector.rs` one step, `step_control.rs` its length, `walk.rs`
//! one half of a branch; `test_functions.rs` says what changes sign where, `locator.rs` and `interpolation_locator.rs` find it,
//! `boundary.rs` names the rule of contact that is broken there, `switching.rs` finds the branches that begin there. `curve` follows
//! special points over two numbers.

mod accumulation;
mod advance;
mod beyond_boundary;
mod bifurcations;
mod border;
mod boundary;
mod candidate;
mod collapse;
mod continued;
mod corrector;
mod crossings;
mod curve;
mod doubling_end;
mod end;
mod energy;
mod equations;
mod half_branch;
mod interpolation_locator;
mod landing;
mod locator;
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
mod step_control;
mod switching;
mod symmetry;
mod test_functions;
mod touch;
mod walk;

pub use accumulation::{accumulation, accumulation_of};
pub use candidate::Candidate;
pub use continued::{continuation, continuation_of, continuation_over_energy};
pub use curve::{BifurcationCurve, CurveOf, CurvePoint, bifurcation_curve, bifurcation_curve_of};
pub use end::{BranchEnd, EndReason};
pub use options::{ContinuationOptions, Heading, Virtual};
pub use result::Branch;
pub use special::{Special, SpecialKind};
pub use switching::{branches, branches_of, branches_over_energy};

pub(crate) use problem::{check_same, stretched};
