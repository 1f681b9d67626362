//! The instants of one period with their times and states: turned, and with one less.

use crate::itinerary::list::Itinerary;
use crate::law::{Stage, Transition};
use nalgebra::DVector;

/// An instant of a motion, and the arc that begins after it.
#[derive(Debug, Clone)]
pub(crate) struct Instant {
    /// What happens at it, and the regime behind it.
    pub stage: Stage,
    /// Its time \[s\].
    pub time: f64,
    /// The time at which its arc begins \[s\]: later than the instant where impacts accumulate.
    pub start: f64,
    /// The state (q, v) at the start of the arc, shape `(2 n_dof,)`, \[m\] and \[m/s\].
    pub state: DVector<f64>,
}

impl Instant {
    /// The instant at a later time.
    pub fn later(mut self, by: f64) -> Self {
        self.time += by;
        self.start += by;
        self
    }
}

/// What happens at some instants.
fn itinerary(instants: &[Instant]) -> Itinerary {
    instants.iter().map(|own| own.stage.clone()).collect()
}

/// The instants of the period that begins with another one of them.
pub(crate) fn turned(mut instants: Vec<Instant>, first: usize, period: f64) -> Vec<Instant> {
    let later = instants.split_off(first);
    let earlier = instants.into_iter().map(|own| own.later(period));
    later.into_iter().chain(earlier).collect()
}

/// The instants of the period that begins with an impact, with the first one after a departure if there is one; none if no impact is left but
/// those that accumulate. Where nothing happens there is no other beginning.
pub(crate) fn begun_with_impact(instants: Vec<Instant>, period: f64) -> Option<Vec<Instant>> {
    let list = itinerary(&instants);
    if !list.is_empty() && list.is_uneventful() {
        return Some(instants);
    }
    let first = list.first_contact()?;
    Some(turned(instants, first, period))
}

/// The instants without the first arc, which takes no time: a stop that is held for no time is left at once, one that is left for no time stays
/// held, all period long if nothing else happens. None where it is another arc.
pub(crate) fn without_first(mut instants: Vec<Instant>) -> Option<Vec<Instant>> {
    let next = instants.get(1)?.stage.clone();
    match (instants[0].stage.transition.clone(), next.transition) {
        (Transition::Strike(_), Transition::Release(stop)) => {
            instants[0].stage.regime = instants[0].stage.regime.without(stop);
            instants.remove(1);
        }
        (Transition::Strike(_), Transition::Strike(_)) => {
            instants[0].stage.regime = next.regime;
            instants.remove(1);
        }
        (Transition::Release(stop), _) => {
            let is_back = |own: &Instant| own.stage.regime.holds(stop);
            let back = instants.iter().position(is_back)?;
            let landed = instants[back].clone();
            instants.drain(..=back);
            if instants.is_empty() {
                // From where the motion had come to rest.
                instants.push(Instant {
                    time: landed.start,
                    stage: Stage::uneventful(landed.stage.regime.clone()),
                    ..landed
                });
            }
        }
        _ => return None,
    }
    Some(instants)
}

/// The instants without one of several, an impact, and without the low bounce that this makes; none where no impact is left with which a
/// period could begin.
pub(crate) fn without_impact(
    mut instants: Vec<Instant>,
    k: usize,
    period: f64,
) -> Option<Vec<Instant>> {
    let back = (k + 1) % instants.len();
    let is_low_bounce = itinerary(&instants).is_low_bounce(k);
    instants.remove(k);
    if is_low_bounce {
        instants.remove(if back > k { back - 1 } else { back });
    }
    // A period begins with an impact after which nothing is held.
    let is_beginning =
        |own: &Instant| own.stage.transition.is_strike() && own.stage.regime.is_free();
    let from = if k > 0 && !(is_low_bounce && back == 0) {
        0
    } else {
        instants.iter().position(is_beginning)?
    };
    Some(turned(instants, from, period))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::Regime;
    use nalgebra::dvector;

    fn instant(time: f64, stage: Stage) -> Instant {
        Instant {
            stage,
            time,
            start: time,
            state: dvector![0.0, time],
        }
    }

    fn landing(stop: usize) -> Stage {
        Stage {
            regime: Regime::holding([stop]),
            ..Stage::impact(&[stop])
        }
    }

    #[test]
    fn a_turned_period_has_the_same_instants_in_the_same_order() {
        let own: Vec<_> = (0..3).map(|k| instant(f64::from(k), landing(0))).collect();
        let times = |all: &[Instant]| -> Vec<f64> { all.iter().map(|own| own.time).collect() };
        let once = turned(own, 2, 10.0);
        assert_eq!(times(&once), [2.0, 10.0, 11.0]);
        assert_eq!(times(&turned(once, 1, 10.0)), [10.0, 11.0, 12.0]);
    }

    #[test]
    fn what_takes_no_time_is_left_out() {
        let leaves = Stage::departure(0, Regime::default());
        let stick = vec![instant(0.0, landing(0)), instant(1.0, leaves.clone())];
        let left = without_first(stick).expect("a stick");
        assert!(left.len() == 1 && left[0].stage == Stage::impact(&[0]));
        // Where nothing but a short flight interrupts a contact it lasts for good.
        let flight = vec![instant(0.0, leaves), instant(1.0, landing(0))];
        let lasts = without_first(flight).expect("a flight");
        let always = Stage::uneventful(Regime::holding([0]));
        assert!(lasts.len() == 1 && lasts[0].stage == always);
        assert_eq!(begun_with_impact(lasts, 2.0).map(|own| own.len()), Some(1));
        let hits = (0..2).map(|k| instant(f64::from(k), Stage::impact(&[0])));
        let rest = without_impact(hits.collect(), 0, 2.0).expect("another impact");
        assert_eq!((rest.len(), rest[0].time), (1, 1.0));
    }
}
