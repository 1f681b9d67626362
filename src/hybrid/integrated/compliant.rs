//! Elements that give way along steps (theory 22): what is watched of their gaps, their guards at a state, the places of those that relax,
//! which are known in closed form.

use super::scene::Integrated;
use crate::error::Result;
use crate::event::polynomial::EndValues;
use crate::flow::GuardDerivatives;
use crate::flow::steps::{State, Stepper};
use crate::hybrid::relaxing_places::RelaxingPlace;
use crate::hybrid::root_orders::RootOrders;
use crate::hybrid::system::{Accelerations, Gaps};
use crate::law::{ElementState, Guard, GuardKind};
use crate::model::{Dynamics, GapValue, WatchedGap, quintic_step};
use crate::tolerance::{GAP_ROUNDING, TERM_ROUNDINGS};

impl<S: State, D: Dynamics, P: Stepper<S>> Integrated<'_, S, D, P> {
    /// What is watched of the gap of an element in a state.
    pub(super) fn watched(&self, element: usize, state: ElementState) -> WatchedGap {
        let place = self.places_back.of(element);
        match place.filter(|_| state == ElementState::Relaxing) {
            Some(own) => WatchedGap::Distance {
                relaxation: own.relaxation,
                place: own.place,
            },
            None => WatchedGap::of(state),
        }
    }

    /// What is watched of the gap of an element in the present regime.
    #[inline]
    pub(super) fn watched_now(&self, element: usize) -> WatchedGap {
        if self.regime.others().is_empty() {
            return WatchedGap::Gap;
        }
        self.watched(element, self.regime.state(element))
    }

    /// The guard that it is.
    pub(super) fn watched_guard(&self, element: usize) -> Guard {
        let kind = self.watched_now(element).kind();
        Guard { element, kind }
    }

    /// Whether a zero of it ends the present regime.
    pub(super) fn watches_gap(&self, element: usize) -> bool {
        let law = self.contacts[element].law.by_state();
        let mut guards = law.guards(self.regime.state(element)).iter();
        guards.any(|own| own.is_gap())
    }

    /// The orders of the roots of what is watched of the gaps.
    pub(super) fn watched_orders(&self, orders: &RootOrders) -> Vec<usize> {
        let elements = 0..self.contacts.len();
        elements
            .map(|own| orders.of(self.watched_guard(own)))
            .collect()
    }

    /// Takes the forces whose zeros end the present regime.
    pub(super) fn take_force_guards(&mut self) {
        let (regime, contacts) = (&self.regime, &self.contacts);
        let guards = regime.elements().flat_map(|element| {
            let guards = contacts[element].law.by_state();
            let guards = guards.guards(regime.state(element)).iter();
            let guards = guards.filter(|own| own.has_speeds());
            guards.map(move |&kind| Guard { element, kind })
        });
        self.force_guards = guards.collect();
        self.peak_forces.clear();
        self.peak_forces.resize(self.force_guards.len(), 0.0);
    }

    /// Lets those elements relax that begin to in the present regime, from where the body is.
    pub(super) fn enter_places(&mut self) {
        self.places_back.keep(&self.regime);
        for element in self.places_back.begun(&self.regime) {
            let gap = self.contacts[element]
                .gap(&self.x.slice()[..self.n()], self.moment())
                .unwrap_or(0.0);
            let law = &self.contacts[element].law;
            self.places_back.begin(law, element, gap);
        }
    }

    /// What is watched of the gap of an element in the present regime, and its acceleration: gaps are taken in the motion without what is held,
    /// beside which they bend otherwise.
    fn watched_beside(&self, element: usize) -> Result<(GapValue, f64)> {
        let mut value = self.gaps[element];
        if self.regime.constrained().is_empty() {
            return Ok((value, self.gap(element).acceleration));
        }
        let watched = self.watched_now(element);
        let [bend, _] = self.drawn(element, &self.regime)?;
        watched.turn_back(&mut value);
        value.acceleration = bend;
        watched.turn(&mut value, 0.0);
        Ok((value, bend))
    }

    /// A guard of the present regime; `None` of one that cannot change, or is not looked at here.
    pub(super) fn present_guard(&self, guard: Guard) -> Result<Option<GuardDerivatives>> {
        let element = guard.element;
        let (value, acceleration) = self.watched_beside(element)?;
        let gap = TERM_ROUNDINGS * value.size;
        let bend = GAP_ROUNDING * self.acceleration_sizes(&[element])?[0];
        let speed = GAP_ROUNDING * self.speed_size(element);
        let unknown = [0.0, f64::INFINITY];
        if guard.is_gap() {
            return Ok(Some([
                [value.gap, gap],
                [value.speed, speed],
                [value.acceleration, bend],
                unknown,
            ]));
        }
        let sign = match guard.kind {
            GuardKind::Push => 1.0,
            GuardKind::Pull => -1.0,
            GuardKind::Excess => return self.excess(guard).map(Some),
            _ => return Ok(None),
        };
        let now = self.gap(element);
        let law = self.contacts[element].law.by_state();
        let grip = law.grip(-now.gap, -now.speed);
        let rate = -grip.by_approach * now.speed - grip.by_rate * acceleration;
        Ok(Some([
            [sign * grip.value, grip.change_at(gap, speed)],
            [sign * rate, grip.change_at(speed, bend)],
            unknown,
            unknown,
        ]))
    }

    /// Whether an element that relaxes is not met along the step last taken, as the body stays where its place is when it is back.
    pub(super) fn stays_outside(&self, element: usize, h: f64) -> bool {
        let watched = self.watched_now(element);
        if !matches!(watched, WatchedGap::Distance { .. }) || self.says_little(element, h) {
            return false;
        }
        let without = |value: GapValue, time: f64| {
            let [place, speed, acceleration] = watched.place(time);
            [
                value.gap - place,
                value.speed - speed,
                value.acceleration - acceleration,
            ]
        };
        let (start, end) = (self.gaps[element], self.ahead[element]);
        let margin = self.margin_of(start).max(self.margin_of(end));
        EndValues::new(without(start, 0.0), without(end, h), h, 0).are_far(2.0 * margin)
    }

    /// A shorter step than the one last taken where a body may meet an element on it whose place goes back too fast to be told from the ends.
    #[cold]
    pub(super) fn shorter_beside_places(&self, h: f64) -> Option<f64> {
        let known = |own: &RelaxingPlace| {
            let allowed = self.tolerance.absolute + self.tolerance.relative * own.place;
            let sixth = own.relaxation.rate.powi(5) * own.relaxation.speed(own.place).abs();
            quintic_step(allowed, sixth)
        };
        let may_meet = self
            .places_back
            .iter()
            .filter(|own| !self.stays_outside(own.element, h));
        let longest = may_meet.map(known).fold(f64::INFINITY, f64::min);
        (longest < h).then_some(longest)
    }
}
