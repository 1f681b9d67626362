//! Whether states, motions that repeat themselves, and sets are one: the one judgement of it (theory 15). At which phase attractors are
//! compared, and what becomes of sets that these do not tell apart, is said in `attractor/same_attractor.rs`.

mod cycle;
mod measure;
mod set;

pub(crate) use cycle::{Advance, advance, are_one_cycle, least_period, repeats_after};
pub(crate) use measure::{Measure, shorter};
pub(crate) use set::{Sets, comes_back, compared};
