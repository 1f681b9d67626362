//! Basins: the label of each state of a grid is the attractor that its motion leads to. A label is unknown until the state, compared once
//! in each period of the forcing with the points of the attractors in parts of the state box \[-\], has followed one of them for some
//! periods (`targets.rs`). Source: docs/theory.md, section 18.

mod batch;
mod cells;
mod label;
mod targets;

pub use cells::{BasinCells, BasinOptions, basin_cells};
pub use label::Label;
