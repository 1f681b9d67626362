//! Smooth motion between impacts (theory 8).

mod drive;
pub(crate) mod jet;
mod linear;
mod scene;
mod split;

pub(crate) use drive::{Drive, HarmonicDrive, Undriven};
pub(crate) use linear::{BlockFlow, DenseFlow, GapRow, LinearFlow, carry};
pub(crate) use scene::{ModalScene, SceneFlow, along, with_flow};
pub(crate) use split::SplitFlow;
