//! Basins: the label of each state of a grid is the attractor that its motion leads to. A label is unknown until the state, compared once
//! in each period of the forcing with the points of the attractors in parts of the state box \[-\], has followed one of them for some
//! periods (`targets.rs`); `boundary.rs` says how intricate the boundary between them is. Source: docs/theory.md, section 18.

mod batch;
mod boundary;
mod cells;
mod label;
mod targets;

pub use boundary::{
    BasinEntropy, PowerLaw, basin_entropy, boundary_dimension, uncertainty_exponent,
};
pub use cells::{BasinCells, BasinOptions, basin_cells};
pub use label::Label;
