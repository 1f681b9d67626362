//! Branches: periodic motions followed over a number of their scene (theory 19).

mod boundary;
mod continued;
mod corrector;
mod end;
mod equations;
mod family;
mod one;
mod options;
mod place;
mod special;
mod step;
mod walk;

pub use continued::{continuation, continuation_of};
pub use end::{BranchEnd, EndReason};
pub use one::Branch;
pub use options::{ContinuationOptions, Heading, Virtual};
pub use special::{Special, SpecialKind};

pub(crate) use family::{check_same, stretched};
