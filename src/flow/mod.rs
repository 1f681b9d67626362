//! Smooth motion between impacts (theory 8).

mod drive;
mod linear;
mod split;

pub(crate) use drive::{Drive, HarmonicDrive, Undriven};
pub(crate) use linear::{BlockFlow, DenseFlow, GapRow, LinearFlow};
pub(crate) use split::SplitFlow;
