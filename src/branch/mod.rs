//! Branches: periodic motions followed over a number of their scene (theory 19).
//!
//! Unknown are a periodic motion, as the states (q, v) at which its flights begin and the times of its events (`parametric_loop.rs`), and
//! the value p of the number. They are scaled: positions and velocities by units of the motion, times by the forcing, so that they are
//! phases \[rad\], and p by the range over which it may go; arclength \[-\] is the mean square of those of the motion beside that of p.
//! `equations.rs` has the equations and their Jacobian, which are asked of the formulation (`formulation.rs`): `shooting.rs`, `impulses.rs`
//! in scenes of many modes, `energy_level.rs` where the energy is the number. `zero_problem.rs` hands them to `continuation`, which makes
//! the steps; `advance.rs` judges a step, `walk.rs` says what is done at each; `test_functions.rs` says what changes sign where,
//! `bifurcations.rs` finds it with `continuation/locator.rs`, `boundary.rs` names the rule of contact that is broken there, `switching.rs`
//! finds the branches that begin there. Of a branch that is there, `at_value.rs` gives the orbits at a value, `monitor.rs` the zeros of a
//! user's function, `tree.rs` the branches that it meets, `beyond.rs` what becomes of motions past its boundaries. `curve` follows special
//! points over two numbers.

mod accumulation;
mod advance;
mod at_value;
mod beyond;
mod beyond_boundary;
mod beyond_outcome;
mod bifurcations;
mod border;
mod boundary;
mod candidate;
mod collapse;
mod contact_nodes;
mod continuation_parameter;
mod continued;
mod crossings;
mod curve;
mod doubling_end;
mod energy_level;
mod equations;
mod formulation;
mod half_branch;
mod impulses;
mod interpolation_locator;
mod landing;
mod monitor;
mod multipliers;
mod options;
mod parametric_loop;
mod predictor;
mod problem;
mod reduced_motion;
mod release_onset;
mod result;
mod same_orbit;
mod shooting;
mod shooting_nodes;
mod simulated;
mod simulations_beyond;
mod special;
mod switching;
mod symmetry;
mod test_functions;
mod through_touch;
mod touch;
mod touch_multipliers;
mod touch_outcome;
mod tree;
mod walk;
mod zero_problem;

pub use crate::continuation::{BranchEnd, EndReason};
pub use accumulation::accumulation;
pub use beyond::beyond;
pub use beyond_outcome::{Beyond, BeyondOptions, BeyondOutcome};
pub use candidate::Candidate;
pub use continuation_parameter::ContinuationParameter;
pub use continued::{continuation, continuation_of, continuation_over_energy};
pub use curve::{BifurcationCurve, CurveOf, CurvePoint, bifurcation_curve, bifurcation_curve_of};
pub use monitor::{MonitorZero, MonitoredBranch};
pub use options::{ContinuationOptions, Heading, Virtual};
pub use result::Branch;
pub use special::{Special, SpecialKind};
pub use switching::branches;
pub use touch_outcome::{TouchMultipliers, TouchOutcome};
pub use tree::{BranchTree, TreeOptions, branch_tree};

#[cfg(feature = "python")]
pub(crate) use at_value::{BranchNode, nodes, orbits_at};
#[cfg(feature = "python")]
pub(crate) use monitor::monitored;
pub(crate) use problem::{check_same, stretched};
#[cfg(feature = "python")]
pub(crate) use tree::is_on_branch;
