//! Smooth motion between impacts (theory 8).

pub(crate) mod block;
pub(crate) mod characteristic_length;
mod constrained;
mod constrained_dynamics;
mod dense;
mod derivative;
pub(crate) mod differences;
pub(crate) mod drive;
pub(crate) mod gap_model;
mod gap_row;
mod imposed_motion;
pub(crate) mod integrate;
mod linear;
mod many_drive;
mod modal_scene;
pub(crate) mod own_time;
mod pendulum_series;
pub(crate) mod registers;
pub(crate) mod samples;
mod scene_flow;
mod series_forcing;
mod series_of;
mod series_tangents;
mod split;
pub(crate) mod steps;
pub(crate) mod taylor;
mod timed_scene;
pub(crate) mod variational;
mod written_series;

pub(crate) use constrained::ConstrainedMotion;
pub(crate) use constrained_dynamics::ConstrainedDynamics;
pub(crate) use dense::DenseFlow;
#[cfg(test)]
pub(crate) use gap_row::Quantity;
pub(crate) use gap_row::{Derivatives, GapRow};
pub(crate) use linear::{FlowRows, LinearFlow, PropagatorCache, propagate};
pub(crate) use modal_scene::{FlowCache, ModalScene, along};
pub(crate) use pendulum_series::PendulumSeries;
pub(crate) use scene_flow::{SceneFlow, with_flow};
pub(crate) use series_of::{BatchMotion, SeriesOf};
pub(crate) use series_tangents::{SeriesTangents, TANGENT_LANES, TangentLanes};
pub(crate) use timed_scene::TimedScene;
pub(crate) use written_series::{read_series, series_width, write_series};
