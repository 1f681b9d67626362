//! Elements that give way (theory 22): each decides for itself, by the first derivative of its guards that is not zero. Where their
//! forces jump, what is held or in contact beside them is judged anew.

use super::{Resolved, Resolver, Unresolved};
use crate::error::Result;
use crate::event::next::LATE;
use crate::flow::GuardDerivatives;
use crate::hybrid::recorder::Recorder;
use crate::hybrid::system::HybridSystem;
use crate::law::{ElementState, Guard, Outcome};
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
        self.n_contacts += usize::from(state == ElementState::Pressed);
        self.regime = self.regime.with(element, state);
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
            let Some(change) = self.next_change(system)? else {
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

    /// The states in which a motion begins, where nothing is held yet.
    pub(super) fn begin_compliant<Y: HybridSystem + ?Sized>(
        &mut self,
        system: &mut Y,
    ) -> Result<()> {
        if self.compliant.is_empty() {
            return Ok(());
        }
        for _ in 0..MOST_CHANGES {
            let Some((element, state)) = self.next_change(system)? else {
                break;
            };
            self.regime = self.regime.with(element, state);
            self.enter(system)?;
        }
        Ok(())
    }

    /// Takes note of what is zero from where a guard has fallen through zero on; of one that had been below zero the place of the element alone
    /// is that of the body.
    pub(super) fn note_zero(&mut self, guard: Guard, next: ElementState, was_zero: bool) {
        let zero = guard.kind.leaves_at_zero(next);
        let is_place = next == ElementState::Relaxing;
        if let Some((kind, count)) = zero.filter(|_| was_zero || is_place) {
            let own = Guard { kind, ..guard };
            let count = if was_zero { count } else { 1 };
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

    /// An element that goes on in another state, as one of its guards is below zero or about to be; without one the orders of the roots of
    /// all guards are known.
    fn next_change<Y: HybridSystem + ?Sized>(
        &mut self,
        system: &mut Y,
    ) -> Result<Option<(usize, ElementState)>> {
        let flight = self.flight_time(system);
        for k in 0..self.compliant.len() {
            let element = self.compliant[k];
            let state = self.regime.state(element);
            let law = system.element_law(element).by_state();
            let outcomes = law.guards(state).iter();
            let outcomes =
                outcomes.map(|&kind| (Guard { element, kind }, law.outcome(state, kind)));
            for (guard, outcome) in outcomes.collect::<Vec<_>>() {
                let Some(derivatives) = system.guard_derivatives(guard)? else {
                    continue;
                };
                let (order, is_above) = sign_after(derivatives, flight, self.n_zero(guard));
                if let Outcome::Enters(next) = outcome
                    && !is_above
                {
                    self.note_zero(guard, next, order > 0);
                    return Ok(Some((element, next)));
                }
                self.root_orders.note(guard, order.min(LATE));
            }
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
