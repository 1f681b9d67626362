//! A scene that is integrated: moved in the steps of a method, or along Taylor series; its contacts found along each step and
//! reached by a step of their own (theory 8).

mod certify;
mod complete_chatter;
mod compliant;
mod contact;
mod flight_pieces;
mod flow;
mod free;
mod jerk;
mod landing;
mod maps;
mod normal;
mod pendulum;
mod release;
mod scene;
mod series;
mod series_flow;
mod steps;
mod system;

pub(crate) use flight_pieces::{FlightPieces, OrbitDense, OrbitStep};
pub(crate) use flow::IntegratedFlow;
pub(crate) use maps::IntegratedMaps;
pub(crate) use pendulum::{Pendulum, has_series, series_order};
pub(crate) use series::{SeriesStep, Taylor};
pub(crate) use series_flow::SeriesPiece;
pub(crate) use steps::InSteps;
