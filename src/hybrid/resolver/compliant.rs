//! Elements that give way (theory 22): each decides for itself, by the first derivative of its guards that is not zero. Where their
//! forces jump, what is held or in contact beside them is judged anew.

use super::{Resolved, Resolver, Unresolved};
use crate::error::Result;
use crate::event::next::LATE;
use crate::flow::GuardDerivatives;
use crate::hybrid::recorder::Recorder;
use crate::hybrid::system::HybridSystem;
use crate::law::{ElementState, Guard, GuardKind, Outcome};
use crate::quantity::larger;
use crate::tolerance::TIME_ROUNDING;

/// Changes of state at one instant, at the most. [work]
const MOST_CHANGES: usize = 64;

impl Resolver {
    /// An element goes on in another state; what is in contact beside it is judged anew.
    #[cold]
    pub(super) fn enter_state<Y: HybridSystem + ?Sized, R: Recorder>(
        &mut self,
        system: &mut Y,
        (element, state): (usize, ElementState),
        recorder: &mut R,
    ) -> Resolved {
        let is_met_before = self.state_of(element).is_met();
        self.n_contacts += usize::from(state.is_met() && !is_met_before);
        self.held.retain(|own| *own != element);
        self.regime = self.regime.without(element);
        // Whether its seat bears it is judged with what is in contact beside it.
        if state == ElementState::Held {
            self.zero_speed.push(element);
        } else {
            self.regime = self.regime.with(element, state);
        }
        self.enter(system)?;
        self.impulses.clear();
        // What the impacts of this instant were about is in contact, though they leave gaps of some roundings, and at rest where they say so.
        let struck = std::mem::take(&mut self.touching);
        let still = std::mem::take(&mut self.zero_speed);
        self.find_touching(system)?;
        for (all, own) in [(&mut self.touching, struck), (&mut self.zero_speed, still)] {
            let missing = own.into_iter().filter(|stop| !all.contains(stop));
            let missing: Vec<usize> = missing.collect();
            all.extend(missing);
        }
        self.judge_touching(system, recorder)
    }

    /// Lets those elements give way whose guards have fallen through zero at an instant that has been resolved.
    #[inline]
    pub(super) fn settle_compliant<Y: HybridSystem + ?Sized, R: Recorder>(
        &mut self,
        system: &mut Y,
        resolved: std::result::Result<(), Unresolved>,
        recorder: &mut R,
    ) -> Resolved {
        if self.compliant.is_empty() || resolved.is_err() {
            return Ok(resolved);
        }
        self.pass_compliant(system, recorder)
    }

    #[cold]
    fn pass_compliant<Y: HybridSystem + ?Sized, R: Recorder>(
        &mut self,
        system: &mut Y,
        recorder: &mut R,
    ) -> Resolved {
        for _ in 0..MOST_CHANGES {
            let Some(change) = self.next_change(system, |_| true)? else {
                return Ok(Ok(()));
            };
            if let Err(unresolved) = self.enter_state(system, change, recorder)? {
                return Ok(Err(unresolved));
            }
        }
        let reason = "stops that give way change their states without end at one instant";
        let reason = reason.to_owned();
        Ok(Err(Unresolved { reason }))
    }

    /// The states in which a motion begins, where nothing is held yet: what seats bear is judged with all that is in contact.
    pub(super) fn begin_compliant<Y: HybridSystem + ?Sized>(
        &mut self,
        system: &mut Y,
    ) -> Result<()> {
        if self.compliant.is_empty() {
            return Ok(());
        }
        let mut known = self.given.regime.holding_instead(&[]);
        // Of another law they are none.
        for &(element, state) in self.given.regime.others() {
            if !system.element_law(element).has_state(state) {
                known = known.without(element);
            }
        }
        if !known.is_free() {
            self.regime = known;
            system.set_places(&self.given.places);
            self.enter(system)?;
        }
        for _ in 0..MOST_CHANGES {
            let Some((element, state)) = self.next_change(system, |state| !state.is_held())? else {
                break;
            };
            self.regime = self.regime.with(element, state);
            self.enter(system)?;
        }
        let relaxing = self.regime.in_state(ElementState::Relaxing);
        let is_open = |own: &usize| self.given.places.iter().all(|known| known.0 != *own);
        self.assumed = relaxing.filter(is_open).collect();
        Ok(())
    }

    /// The elements that give way, lie at their seats and rest there: their preloads may bear them.
    pub(super) fn seats_at_rest<Y: HybridSystem + ?Sized>(&self, system: &Y) -> Vec<usize> {
        let rests = |&element: &usize| {
            let may_bear = system.element_law(element).by_state().seat().is_some()
                && self.regime.leaves_free(element);
            // What was borne is so at rest, but for an impact.
            let is_borne = self.impulses.is_empty() && self.were_held.contains(&element);
            // What has come to its seat is there, whatever flights as low as the last ones leave of its gap.
            let has_come = self.zero_speed.contains(&element);
            let is_there = || self.is_at_zero(system, element) && self.is_still(system, element);
            may_bear && (is_borne || has_come || is_there())
        };
        self.compliant.iter().copied().filter(rests).collect()
    }

    /// Whether the bounces of a body that arrives at the seat of an element rise no higher, and sink no deeper, than the tolerance: with a
    /// dashpot they are lower each time, without ever ending, and are left out (theory 22).
    pub(super) fn comes_to_its_seat<Y: HybridSystem + ?Sized>(
        &mut self,
        system: &mut Y,
        guard: Guard,
    ) -> Result<bool> {
        let element = guard.element;
        let own = system.element_law(element).by_state();
        let force = own.force(ElementState::Pressed);
        let force = force.filter(|force| force.damping > 0.0 && force.preload > 0.0);
        let Some(force) = force.filter(|_| guard.kind == GuardKind::Gap) else {
            return Ok(false);
        };
        let reach = system.flight_sizes(element).reach;
        self.reaches[element] = larger(self.reaches[element], reach);
        let state = system.gap(element);
        let pull = -self.drawn(system, (element, state), &self.held)?;
        let stopped = force.preload * self.give_beside_held(system, element)? - pull;
        let weakest = pull.min(stopped);
        if weakest <= 0.0 {
            return Ok(false);
        }
        let height = 0.5 * state.speed.powi(2) / weakest;
        let time = -2.0 * state.speed / weakest;
        let lasts = time * system.free_jerk(element)?.abs() < weakest;
        Ok(lasts && height < system.tolerance(element, self.reaches[element]))
    }

    /// Takes note of what is zero from where a guard has fallen through zero on; of one that had been below zero the place of the element alone
    /// is that of the body.
    pub(super) fn note_zero(&mut self, guard: Guard, next: ElementState, was_zero: bool) {
        if let Some((kind, count)) = guard.kind.leaves_at_zero(next, was_zero) {
            let own = Guard { kind, ..guard };
            self.zeros.push((own, count, self.n_impacts));
        }
    }

    /// How many derivatives of a guard are zero at this instant, itself one of them, as far as impacts leave them so.
    fn n_zero(&self, guard: Guard) -> usize {
        let own = self.zeros.iter().rev().find(|own| own.0 == guard);
        own.map_or(0, |&(_, count, impacts)| {
            let is_struck = self.n_impacts > impacts;
            let left = usize::from(!guard.kind.has_speeds());
            if is_struck { left } else { count }
        })
    }

    /// An element that goes on in another state of those that are asked for, as one of its guards is below zero or about to be; without one
    /// the orders of the roots of all guards are known.
    fn next_change<Y: HybridSystem + ?Sized>(
        &mut self,
        system: &mut Y,
        is_wanted: impl Fn(ElementState) -> bool,
    ) -> Result<Option<(usize, ElementState)>> {
        for k in 0..self.compliant.len() {
            let element = self.compliant[k];
            let change = self.change_of(system, element)?;
            if let Some(state) = change.filter(|state| is_wanted(*state)) {
                return Ok(Some((element, state)));
            }
        }
        Ok(None)
    }

    /// The state in which an element goes on, where that is another one.
    fn change_of<Y: HybridSystem + ?Sized>(
        &mut self,
        system: &mut Y,
        element: usize,
    ) -> Result<Option<ElementState>> {
        let flight = self.flight_time(system);
        let state = self.state_of(element);
        let law = system.element_law(element).by_state();
        let has_seat = law.seat().is_some();
        let outcomes = law.guards(state).iter();
        let outcomes = outcomes.map(|&kind| (Guard { element, kind }, law.outcome(state, kind)));
        for (guard, outcome) in outcomes.collect::<Vec<_>>() {
            let Outcome::Enters(next) = outcome else {
                continue;
            };
            let Some(derivatives) = system.guard_derivatives(guard)? else {
                continue;
            };
            let (order, is_above) = sign_after(derivatives, flight, self.n_zero(guard));
            if !is_above {
                // What comes to its seat without a speed may be borne there.
                let is_at_rest = has_seat && guard.is_seat() && order > 1;
                let next = if is_at_rest { ElementState::Held } else { next };
                self.note_zero(guard, next, order > 0);
                return Ok(Some(next));
            }
            self.root_orders.note(guard, order.min(LATE));
        }
        Ok(None)
    }
}

/// The order of the first derivative of a guard that is not zero, and whether it is above zero just after an instant to which a flight of
/// some time has led; one that stays at zero is above. So many of the first are zero, whatever rounding makes of them.
fn sign_after(derivatives: GuardDerivatives, flight: f64, n_zero: usize) -> (usize, bool) {
    let by_time = |order: usize| {
        let rate = derivatives.get(order + 1).map_or(0.0, |next| next[0]);
        TIME_ROUNDING * flight * rate.abs()
    };
    let known = |&(order, [value, unknown]): &(usize, [f64; 2])| {
        value.abs() > larger(unknown, by_time(order))
    };
    let first = derivatives.into_iter().enumerate().skip(n_zero).find(known);
    first.map_or((LATE, true), |(order, [value, _])| (order, value > 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_derivative_that_is_not_zero_decides() {
        let derivatives = |values: [f64; 4]| values.map(|value| [value, 1e-12]);
        let after = |values, flight| sign_after(derivatives(values), flight, 0);
        assert_eq!(after([1e-3, -1.0, 0.0, 0.0], 1.0), (0, true));
        assert_eq!(after([-1e-3, 1.0, 0.0, 0.0], 1.0), (0, false));
        assert_eq!(after([1e-14, -1.0, 0.0, 0.0], 1.0), (1, false));
        assert_eq!(after([-1e-14, 0.0, 2.0, 0.0], 1.0), (2, true));
        assert_eq!(after([0.0, 0.0, 0.0, -2.0], 1.0), (3, false));
        assert_eq!(after([0.0; 4], 1.0), (LATE, true));
        // After a long flight the time is known to less.
        assert_eq!(after([1e-11, -1.0, 0.0, 0.0], 1e5), (1, false));
        // What is known to be zero is not asked.
        let rounding = derivatives([1e-9, -1e-9, 2.0, 0.0]);
        assert_eq!(sign_after(rounding, 1.0, 2), (2, true));
    }
}
