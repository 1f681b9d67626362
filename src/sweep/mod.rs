//! Sweeps over parameters: many small computations in pieces, on any number of threads.

mod counted;
mod diagram;
mod ensemble;
mod existence;
mod parametric_scene;
pub(crate) mod tiles;
mod unranked_orbit;

pub use diagram::{
    BifurcationDiagram, DiagramOptions, Direction, bifurcation_diagram, bifurcation_diagram_of,
};
pub use ensemble::{Ensemble, Scenes, simulate_many};
pub use existence::{
    Axis, ExistenceMap, ExistencePoint, existence_at, existence_map, existence_tile,
};
pub use tiles::SweepOptions;
