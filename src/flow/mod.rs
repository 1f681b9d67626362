//! Smooth motion between impacts (theory 8).

mod block;
mod dense;
mod derivative;
mod drive;
mod gap_row;
pub(crate) mod integrate;
pub(crate) mod jet;
mod linear;
mod pendulum_series;
pub(crate) mod registers;
pub(crate) mod runge_kutta;
mod scene;
mod series_of;
mod shaking;
mod split;
pub(crate) mod step_size;
mod stuck;
pub(crate) mod tableau;
pub(crate) mod taylor;

pub(crate) use block::BlockFlow;
pub(crate) use dense::DenseFlow;
pub(crate) use drive::{Drive, HarmonicDrive, Loaded, Undriven};
pub(crate) use gap_row::{Derivatives, GapRow, Quantity, TERM_ROUNDINGS};
pub(crate) use linear::{LinearFlow, carry, forward};
pub(crate) use pendulum_series::PendulumSeries;
pub(crate) use scene::{ModalScene, SceneFlow, TimedScene, along, modal_flow, with_flow};
pub(crate) use series_of::{Motion, SeriesOf};
pub(crate) use split::SplitFlow;
pub(crate) use stuck::{CANCELLED, StuckMotion};
