//! Smooth motion between impacts (theory 8).

mod drive;
mod linear;

pub(crate) use drive::{Drive, HarmonicDrive, Undriven};
pub(crate) use linear::{BlockFlow, DenseFlow, GapRow, LinearFlow};
