//! What happens along an orbit, in words: the signature by which searches for orbits know motions.

use crate::hybrid::joined;
use crate::itinerary::{folded, instants_of_arcs};
use crate::orbit::periodic_orbit::PeriodicOrbit;
use crate::path::ImpactSide;

impl PeriodicOrbit {
    /// What happens in one period, with the stop to which it does, in order: "strike", "chatter" and "release" of rigid stops, of those that
    /// give way "press", "leave" and "relax". Impacts that accumulate are one "chatter".
    pub fn signature(&self) -> Vec<(&'static str, usize)> {
        let state = |time: f64| joined(&self.state_at(time, ImpactSide::After));
        let instants = instants_of_arcs(self.flights(), self.impacts(), state);
        let stages = folded(instants, self.scene()).into_iter();
        let events = stages.map(|own| own.instant.stage.transition.events());
        events.flatten().collect()
    }
}
