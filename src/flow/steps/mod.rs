//! Methods of integration, step by step: a method is a file, or a folder, and implements [`Stepper`]; of an explicit one the tableau is all.

pub(crate) mod chosen;
#[cfg(test)]
mod contract;
pub(crate) mod control;
pub(crate) mod dense_output;
mod dop853;
mod dormand_prince;
#[cfg(test)]
pub(crate) mod example;
mod explicit_rk;
#[cfg(test)]
mod explicit_rk_tests;
#[cfg(test)]
mod order_conditions;
mod radau;
pub(crate) mod state;
mod stepper;

pub(crate) use dense_output::{Dense, DenseOutput};
pub(crate) use dop853::Dop853;
pub(crate) use dormand_prince::DormandPrince;
#[cfg(test)]
pub(crate) use radau::Radau;
pub(crate) use state::State;
pub(crate) use stepper::{StepStart, Stepper, Tolerance};
