//! Methods of integration, step by step: a method is one file and implements [`Stepper`].

pub(crate) mod control;
pub(crate) mod dense_output;
mod dop853;
mod dop853_tableau;
mod dormand_prince;
pub(crate) mod state;
mod stepper;
mod tableau;

pub(crate) use dense_output::{Dense, DenseOutput};
pub(crate) use dop853::Dop853;
pub(crate) use dormand_prince::DormandPrince;
pub(crate) use state::State;
pub(crate) use stepper::{Start, Stepper, Tolerance};
