//! Basins: which states of a scene lead to which attractor (theory 18).

mod abreast;
mod cells;
mod label;
mod targets;

pub use cells::{BasinCells, BasinOptions, basin_cells};
pub use label::Label;
