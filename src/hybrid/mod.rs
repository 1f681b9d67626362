//! A scene with its stops as a hybrid system (theory 8, 9): smooth motion, contacts, impacts, stops that are held; in closed form or
//! integrated. Whoever moves a scene uses this.

mod across;
pub(crate) mod chatter_map;
pub(crate) mod clock;
mod closed_form;
#[cfg(test)]
mod contract;
mod flow;
mod impact_outcome;
mod instant;
mod integrated;
mod landing;
mod maps;
mod memory;
mod pen;
pub(crate) mod recorder;
mod relaxing_places;
mod resolver;
mod root_orders;
mod scaled_units;
mod segment;
pub(crate) mod system;
mod timed;

pub(crate) use across::{
    across, across_free_impact, across_impacts, across_meeting, across_rest, closing_delays,
    place_left,
};
pub(crate) use closed_form::{ClosedForm, ClosedFormMaps, ModalImpacts, regime_motions};
pub(crate) use flow::{AnyLoop, Arrival, Counts, HybridFlow};
pub(crate) use impact_outcome::{ImpactOutcome, impact_outcome, landing_on};
pub(crate) use instant::{NO_CONDITION, arrival, condition, enter, pass, reset};
pub(crate) use integrated::{
    FlightPieces, InSteps, IntegratedFlow, IntegratedMaps, OrbitDense, OrbitStep, Pendulum,
    SeriesPiece, SeriesStep, Taylor, has_series, series_order,
};
pub(crate) use landing::Landing;
pub(crate) use maps::{GapAt, HybridMaps, carried, halves, joined, project_onto};
pub(crate) use memory::FlowMemory;
pub(crate) use pen::Pen;
pub(crate) use resolver::{ElementStates, Resolver, Unresolved, is_one_instant};
pub(crate) use root_orders::RootOrders;
pub(crate) use scaled_units::{ScaledUnits, largest_of};
pub use segment::{Graze, SegmentKind};
pub(crate) use system::{HybridSystem, Present};
pub(crate) use timed::Timed;
