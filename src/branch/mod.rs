//! Branches: periodic motions followed over a number of their scene (theory 19).

mod accumulation;
mod advance;
mod behind;
mod bifurcations;
mod border;
mod boundary;
mod candidate;
mod continued;
mod corrector;
mod curve;
mod end;
mod energy;
mod equations;
mod family;
mod indicators;
mod instants;
mod interpolated;
mod landed;
mod lessened;
mod many_modes;
mod multipliers;
mod one;
mod options;
mod place;
mod risen;
mod special;
mod step;
mod step_size;
mod switching;
mod symmetry;
mod tip;
mod vanished;
mod walk;
mod way;
mod zero;

pub use accumulation::{accumulation, accumulation_of};
pub use candidate::Candidate;
pub use continued::{continuation, continuation_of, continuation_over_energy};
pub use curve::{BifurcationCurve, CurveOf, CurvePoint, bifurcation_curve, bifurcation_curve_of};
pub use end::{BranchEnd, EndReason};
pub use one::Branch;
pub use options::{ContinuationOptions, Heading, Virtual};
pub use special::{Special, SpecialKind};
pub use switching::{branches, branches_of, branches_over_energy};

pub(crate) use family::{check_same, stretched};
