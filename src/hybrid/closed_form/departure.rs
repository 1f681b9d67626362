//! Where the last flight of a linear scene began, beside its state.

use crate::hybrid::clock::Clock;
use crate::hybrid::relaxing_places::RelaxingPlaces;
use crate::modal::Pair;

/// Where a flight began; `None` for a clock before the first.
#[derive(Default)]
pub(super) struct Departure {
    pub clock: Option<Clock>,
    /// The level of the steps of its search.
    pub level: usize,
    /// What the rounding of positions left unknown of each gap, shape `(n_stops,)` or none, \[m\].
    pub placed: Vec<f64>,
    pub extents: Vec<Pair>,
    pub places: RelaxingPlaces,
}
