//! Where arcs of an itinerary become short: what happens where one has no duration left (theory 19, "Landing", "Rise").

use crate::itinerary::list::Itinerary;

/// What happens where an instant coincides with the next one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Coincidence {
    /// An impact throws the motion off a stop to which it comes back at once: both lose their speed together.
    LowBounce,
    /// A stop is left without an impact and met again.
    Departure,
    /// After an impact its stop is left, or held, at once.
    Landing,
    /// Lasting contact has no duration.
    Contact,
    /// Two stops are met at one instant.
    Corner,
}

impl Itinerary {
    /// What happens where an instant coincides with the next one.
    pub fn coincidence(&self, k: usize) -> Coincidence {
        let (own, next) = (self.stage(k), self.stage(k + 1));
        let stop = next.transition.element();
        let is_same = stop.is_some_and(|stop| own.transition.elements().contains(&stop));
        let (is_impact, is_again) = (own.transition.is_strike(), next.transition.is_strike());
        let is_landing = next.transition.is_release() || is_again && !next.regime.is_free();
        if self.is_low_bounce(k) {
            Coincidence::LowBounce
        } else if own.transition.is_release() && is_same {
            Coincidence::Departure
        } else if is_impact && is_same && is_landing {
            Coincidence::Landing
        } else if !own.regime.is_free() {
            Coincidence::Contact
        } else {
            Coincidence::Corner
        }
    }

    /// Whether an instant is an impact that throws the motion off a held stop to which it comes back at the next instant.
    pub fn is_low_bounce(&self, k: usize) -> bool {
        let (before, own, next) = (self.before(k), self.stage(k), self.stage(k + 1));
        let mut thrown = before.constrained().iter();
        self.len() > 2
            && own.transition.is_strike()
            && next.regime == *before
            && thrown.any(|&stop| !own.regime.holds(stop) && next.transition.meets(stop))
    }

    /// The instants at which a stop is left to be held again, with the time for which it is left: one flight after an impact, or after a
    /// departure flights with impacts on it. `span` is the duration of the arc behind an instant.
    pub fn returns(&self, span: impl Fn(usize) -> f64) -> impl Iterator<Item = (usize, f64)> {
        let count = self.len();
        let comes_back = move |k: usize| {
            let left = &self.stage(k).transition;
            let own = left.element().filter(|_| !left.is_chatter())?;
            let is_released = left.is_release();
            let (mut late, mut at) = (0.0, k);
            while !self.stage(at).regime.holds(own) {
                late += span(at);
                at = (at + 1) % count;
                let next = &self.stage(at).transition;
                let is_landing = next.meets(own) && (is_released || next.is_strike());
                let is_last = is_released || !next.is_strike();
                let is_back = self.stage(at).regime.holds(own);
                if !is_landing || !(is_back || is_last) || at == k {
                    return None;
                }
            }
            (at != k).then_some((k, late))
        };
        (0..count).filter_map(comes_back)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::{Regime, Stage};

    fn landing(stop: usize) -> Stage {
        Stage {
            regime: Regime::holding([stop]),
            ..Stage::impact(&[stop])
        }
    }

    fn departure(stop: usize) -> Stage {
        Stage::departure(stop, Regime::default())
    }

    #[test]
    fn what_coincides_is_named_by_both_instants() {
        let hit = |stop: usize| Stage::impact(&[stop]);
        let kind = |stages: Vec<Stage>| Itinerary::from_iter(stages).coincidence(0);
        assert_eq!(kind(vec![hit(0), hit(1)]), Coincidence::Corner);
        assert_eq!(kind(vec![landing(0), departure(0)]), Coincidence::Landing);
        assert_eq!(kind(vec![hit(0), landing(0)]), Coincidence::Landing);
        assert_eq!(kind(vec![departure(0), landing(0)]), Coincidence::Departure);
        assert_eq!(kind(vec![landing(0), departure(1)]), Coincidence::Contact);
        // Thrown off stop 0 by an impact on stop 1, and back on it at once.
        let thrown = vec![hit(1), landing(0), departure(0), landing(0)];
        assert_eq!(kind(thrown), Coincidence::LowBounce);
    }

    #[test]
    fn a_stop_is_back_where_it_is_held_again() {
        let own = [landing(0), departure(0), Stage::impact(&[0]), landing(0)];
        let own: Itinerary = own.into_iter().collect();
        // After a departure flights with impacts on the stop; after an impact a flight to a landing alone.
        let found: Vec<_> = own.returns(|k| (k + 1) as f64).collect();
        assert_eq!(found, [(1, 5.0), (2, 3.0)]);
        let other = [landing(0), departure(0), Stage::impact(&[1])];
        let other: Itinerary = other.into_iter().collect();
        assert_eq!(other.returns(|_| 1.0).count(), 0);
    }
}
