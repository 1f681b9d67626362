//! Contacts with elements that give way among the instants of a period: one that begins where an element is touched, and a period without
//! one (theory 22, "Touches"). At a duration of zero both are one motion.

use crate::itinerary::instant::Instant;
use crate::itinerary::list::Itinerary;
use crate::law::{ContactLaw, ElementState, GuardKind, Outcome, Transition};
use crate::tolerance::PLACE_FORGOTTEN;

impl Itinerary {
    /// How many instants after the one with which a contact of an element that gives way begins it is left; none where none begins.
    pub fn contact_length(&self, k: usize) -> Option<usize> {
        let element = self.stage(k).transition.press()?;
        let is_left = |j: &usize| is_apart(self.stage(k + j).regime.state(element));
        (1..self.len()).find(is_left)
    }
}

/// Whether an element does nothing to the body in a state, which is not inside of its place.
fn is_apart(state: ElementState) -> bool {
    matches!(state, ElementState::Free | ElementState::Relaxing)
}

/// The states of an element in a contact of next to no duration, from that in which it is pressed to that in which it is left.
pub(crate) fn states_of_touch(law: &dyn ContactLaw) -> Vec<ElementState> {
    let mut states = vec![ElementState::Pressed];
    while let Some(&state) = states.last()
        && !is_apart(state)
        && let Outcome::Enters(next) = law.outcome(state, law.guards(state)[0])
    {
        states.push(next);
    }
    states
}

/// The instants of a period without a contact of an element: the k-th of them, and those up to where the element is left.
pub(crate) fn without_contact(
    instants: &[Instant],
    (k, length): (usize, usize),
    (element, law): (usize, &dyn ContactLaw),
    period: f64,
) -> Vec<Instant> {
    let count = instants.len();
    let mut rest = Vec::with_capacity(count);
    for (i, instant) in instants.iter().enumerate() {
        let late = (i + count - k) % count;
        let mut own = instant.clone();
        if late < length {
            own.stage.regime = own.stage.regime.without(element);
        }
        if late > length || own.stage.transition.elements() != [element] {
            rest.push(own);
        }
    }
    if rest.is_empty() {
        let mut own = instants[k].clone();
        own.stage.transition = Transition::Nothing;
        own.stage.regime = own.stage.regime.without(element);
        rest.push(own);
    }
    relaxed(&mut rest, (element, law), period);
    rest
}

/// Sets how an element that relaxes is found between its contacts: on its way back from the one before, and met there or at its place. Where it
/// has a seat it depends on how far it was pushed when it is back there: what is known of it stays.
pub(crate) fn relaxed(
    instants: &mut [Instant],
    (element, law): (usize, &dyn ContactLaw),
    period: f64,
) {
    let relaxation = law.relaxation(ElementState::Relaxing);
    let Some(relaxation) = relaxation.filter(|own| own.beyond == 0.0) else {
        return;
    };
    let count = instants.len();
    let is = |own: &Instant, of: fn(&Transition) -> Option<usize>| {
        of(&own.stage.transition) == Some(element)
    };
    for instant in &mut *instants {
        if instant.stage.regime.state(element) == ElementState::Relaxing {
            instant.stage.regime = instant.stage.regime.without(element);
        }
    }
    for left in 0..count {
        if !is(&instants[left], Transition::left_to_relax) {
            continue;
        }
        for k in (left..left + count).map(|k| k % count) {
            if k != left && is(&instants[k], Transition::press) {
                let time = (instants[k].time - instants[left].time).rem_euclid(period);
                let is_back = relaxation.rate * time >= PLACE_FORGOTTEN;
                if let Transition::Change(guard, _) = &mut instants[k].stage.transition {
                    guard.kind = if is_back {
                        GuardKind::Gap
                    } else {
                        GuardKind::Distance
                    };
                }
                break;
            }
            let regime = &mut instants[k].stage.regime;
            *regime = regime.with(element, ElementState::Relaxing);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::{ContactRelease, Guard, Regime, Spring, Stage};
    use nalgebra::dvector;

    fn spring(release: ContactRelease) -> Spring {
        Spring::new(20.0, 0.5, Some(release)).expect("valid")
    }

    fn instant(time: f64, guard: GuardKind, to: ElementState) -> Instant {
        let guard = Guard {
            element: 0,
            kind: guard,
        };
        Instant {
            stage: Stage {
                transition: Transition::Change(guard, to),
                regime: Regime::default().with(0, to),
            },
            time,
            start: time,
            state: dvector![0.5, 0.0],
        }
    }

    #[test]
    fn a_touch_goes_through_the_states_of_its_law() {
        use ElementState::{Free, Idle, Pressed, Relaxing};
        let states = |release| states_of_touch(&spring(release));
        assert_eq!(states(ContactRelease::Gap), [Pressed, Free]);
        assert_eq!(states(ContactRelease::Clipped), [Pressed, Idle, Free]);
        assert_eq!(states(ContactRelease::Force), [Pressed, Relaxing]);
        // A slow body is back at a seat before the force is zero.
        let seated = spring(ContactRelease::Force).with_preload(0.3);
        assert_eq!(states_of_touch(&seated.expect("valid")), [Pressed, Free]);
    }

    #[test]
    fn a_stop_without_its_contact_is_met_at_its_place_again() {
        use ElementState::{Pressed, Relaxing};
        let law = spring(ContactRelease::Force);
        let of_two = [
            instant(0.0, GuardKind::Distance, Pressed),
            instant(0.1, GuardKind::Push, Relaxing),
            instant(0.5, GuardKind::Distance, Pressed),
            instant(0.6, GuardKind::Push, Relaxing),
        ];
        let list: Itinerary = of_two.iter().map(|own| own.stage.clone()).collect();
        assert_eq!(
            (list.contact_length(0), list.contact_length(1)),
            (Some(1), None)
        );
        // 36 c/k = 0.9: in a period of 2 it is back, in one of 0.95 it is not.
        for (period, kind) in [(2.0, GuardKind::Gap), (0.95, GuardKind::Distance)] {
            let rest = without_contact(&of_two, (0, 1), (0, &law), period);
            assert_eq!(rest.len(), 2);
            let Transition::Change(guard, _) = rest[0].stage.transition else {
                panic!("{rest:?}")
            };
            assert_eq!((guard.kind, rest[0].time), (kind, 0.5));
        }
        // Without any it is free.
        let alone = without_contact(&of_two[2..], (0, 1), (0, &law), 2.0);
        assert!(alone.len() == 1 && alone[0].stage.transition.is_nothing());
        assert!(alone[0].stage.regime.is_free());
    }
}
