//! Methods of integration, step by step: a method is one file and implements [`Stepper`].

pub(crate) mod control;
pub(crate) mod dense_output;
mod dormand_prince;
pub(crate) mod state;
mod stepper;
mod tableau;

pub(crate) use dense_output::{Dense, DenseOutput};
pub(crate) use dormand_prince::DormandPrince;
pub(crate) use state::State;
pub(crate) use stepper::{Start, StepEnds, Stepper, Tolerance};
