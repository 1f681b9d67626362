//! Where a flight of a linear scene began, from where it is gone again to the bit.

use super::departure::Departure;
use super::system::ClosedForm;
use crate::error::Result;
use crate::flow::LinearFlow;
use crate::hybrid::memory::FlowMemory;
use crate::hybrid::system::{Gaps, Present};
use crate::law::Regime;
use crate::modal::Pair;

impl<F: LinearFlow> ClosedForm<'_, F> {
    /// A flight begins in the free regime; its state is put aside at its end.
    #[inline]
    pub(super) fn depart(&mut self) {
        let departure = &mut self.departure;
        (departure.clock, departure.level) = (Some(self.clock), self.search.level());
        departure.placed.clone_from(&self.placed);
        departure.extents.clear();
        departure.places.clear();
    }

    /// A flight begins in another regime.
    pub(super) fn depart_in_regime(&mut self) {
        self.depart();
        self.departure.extents = self.extents();
        self.departure.places.clone_from(&self.compliant.places);
        self.arrived.clone_from(&self.state);
    }

    /// The largest sizes seen of each gap on the last flight.
    fn extents(&self) -> Vec<Pair> {
        let stops = 0..self.allowed.len();
        stops.map(|stop| self.search.extent(stop)).collect()
    }

    fn memory(&self, departure: &Departure, state: &[Pair]) -> Option<FlowMemory> {
        let places = departure.places.iter();
        Some(FlowMemory {
            clock: departure.clock?.written(),
            level: departure.level,
            state: state.to_vec(),
            placed: departure.placed.clone(),
            allowed: self.allowed.clone(),
            extents: departure.extents.clone(),
            places: places
                .map(|own| (own.element, [own.place, own.left]))
                .collect(),
        })
    }

    /// Where the last flight began.
    pub(super) fn departed_memory(&self) -> Option<FlowMemory> {
        self.memory(&self.departure, &self.arrived)
    }

    /// Where it is.
    pub(super) fn present_memory(&self) -> Option<FlowMemory> {
        let here = Departure {
            clock: Some(self.clock),
            level: self.search.level(),
            placed: self.placed.clone(),
            extents: self.extents(),
            places: self.compliant.places.clone(),
        };
        self.memory(&here, &self.state)
    }

    /// Puts elements that are about to relax at their places.
    pub(super) fn put_places(&mut self, places: impl Iterator<Item = (usize, f64)>) {
        let laws = &self.scene.geometry.laws;
        self.compliant
            .places
            .put(|element| laws.get(element), places);
    }

    /// Goes where a flight began; whether the memory is one of such a flow.
    pub(super) fn go_back_to(&mut self, memory: &FlowMemory, regime: &Regime) -> Result<bool> {
        let n_stops = self.allowed.len();
        let is_of_stops = |numbers: usize| numbers == n_stops || numbers == 0;
        let is_its = memory.state.len() == self.state.len()
            && memory.allowed.len() == n_stops
            && is_of_stops(memory.placed.len())
            && is_of_stops(memory.extents.len())
            && memory.level <= self.search.deepest_level();
        if !is_its {
            return Ok(false);
        }
        self.clock = self.clock.read(memory.clock);
        self.search.restart_at(memory.level, &memory.extents);
        self.state.clone_from(&memory.state);
        self.placed.clone_from(&memory.placed);
        self.allowed.clone_from(&memory.allowed);
        self.regime_motion = if regime.is_free() {
            None
        } else {
            Some(self.motion_in(regime)?)
        };
        if !regime.others().is_empty() {
            self.compliant.motion = Some(self.motion_in(&regime.holding_instead(&[]))?);
            self.put_places(memory.places.iter().map(|own| (own.0, own.1[0])));
            let left = memory.places.iter().map(|own| own.1[1]);
            self.compliant.places.take_left(left);
        }
        self.evaluate_gaps()?;
        let is_finite = self.state.iter().flatten().all(|number| number.is_finite());
        Ok(is_finite
            && self.compliant.places.iter().len() == memory.places.len()
            && self.clock().time().is_finite())
    }
}
