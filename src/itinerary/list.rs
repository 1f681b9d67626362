//! The itinerary of a motion: a transition, the regime behind it, the next transition; and what one asks of it. Instants are counted from
//! zero; of a periodic motion the first follows the last.

use crate::error::{Error, Result};
use crate::law::{ElementState, GuardKind, Outcome, Regime, Stage, Transition};
use crate::model::{Scene, contacts};
use std::ops::{Deref, DerefMut};

/// The transitions of a motion in their order, each with the regime behind it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Itinerary(Vec<Stage>);

impl Deref for Itinerary {
    type Target = Vec<Stage>;

    fn deref(&self) -> &Vec<Stage> {
        &self.0
    }
}

impl DerefMut for Itinerary {
    fn deref_mut(&mut self) -> &mut Vec<Stage> {
        &mut self.0
    }
}

impl FromIterator<Stage> for Itinerary {
    fn from_iter<I: IntoIterator<Item = Stage>>(stages: I) -> Self {
        Self(stages.into_iter().collect())
    }
}

impl Itinerary {
    /// Impacts on the stops of each of some instants, while all else is free.
    pub fn of_impacts(instants: &[Vec<usize>]) -> Self {
        instants.iter().map(|stops| Stage::impact(stops)).collect()
    }

    /// The transition at an instant, and the regime behind it.
    pub fn stage(&self, k: usize) -> &Stage {
        &self.0[k % self.0.len()]
    }

    /// The regime before an instant.
    pub fn before(&self, k: usize) -> &Regime {
        &self.stage(k + self.0.len() - 1).regime
    }

    /// Whether nothing happens along the motion: a period is one arc.
    pub fn is_uneventful(&self) -> bool {
        self.0[0].transition.is_nothing()
    }

    /// Whether all elements are free throughout.
    pub fn is_free(&self) -> bool {
        self.0.iter().all(|stage| stage.regime.is_free())
    }

    /// Whether impacts accumulate somewhere.
    pub fn accumulates(&self) -> bool {
        self.0.iter().any(|stage| stage.transition.is_chatter())
    }

    /// The most directions of the state space that are gone in one of its regimes.
    pub fn n_lost_directions(&self) -> usize {
        let each = self.0.iter().map(|stage| stage.regime.n_lost_directions());
        each.max().unwrap_or(0)
    }

    /// The element whose impacts accumulate at an instant.
    pub fn accumulation(&self, k: usize) -> Option<usize> {
        self.stage(k).transition.accumulation()
    }

    /// The stop that is hit at an instant, the first of several.
    pub fn impact(&self, k: usize) -> Option<usize> {
        self.stage(k).transition.struck().first().copied()
    }

    /// The stop that is hit at an instant, the first of several, or touched.
    pub fn reached(&self, k: usize) -> Option<usize> {
        self.impact(k)
            .or_else(|| self.stage(k).transition.touched())
    }

    /// The instants at which a stop is hit.
    pub fn impacts_on(&self, stop: usize) -> impl Iterator<Item = usize> + '_ {
        let is_on = move |k: &usize| self.stage(*k).transition.struck().contains(&stop);
        (0..self.0.len()).filter(is_on)
    }

    /// The instants at which stops are hit.
    pub fn impacts(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.0.len()).filter(|&k| self.impact(k).is_some())
    }

    /// The element that is left without an impact at an instant.
    pub fn departure(&self, k: usize) -> Option<usize> {
        self.stage(k).transition.departure()
    }

    /// The first stops that are hit at one instant.
    pub fn hit_together(&self) -> Option<&[usize]> {
        let mut all = self.0.iter().map(|stage| stage.transition.struck());
        all.find(|stops| stops.len() > 1)
    }

    /// The stops that are hit, where that is one at each instant and all is free between them; none where nothing happens.
    pub fn single_impacts(&self) -> Option<Vec<usize>> {
        if !self.is_free() {
            return None;
        }
        let some = self.0.iter().map(|stage| &stage.transition);
        let some = some.filter(|transition| !transition.is_nothing());
        let one = |transition: &Transition| match transition.struck() {
            [stop] => Some(*stop),
            _ => None,
        };
        some.map(one).collect()
    }

    /// The beginning of a contact with which a period begins: the first one behind the first departure, if there is one.
    pub fn first_contact(&self) -> Option<usize> {
        let departs = |k: &usize| self.departure(*k).is_some();
        let after = (0..self.0.len()).find(departs).map_or(0, |k| k + 1);
        let mut in_order = (after..self.0.len()).chain(0..after);
        in_order.find(|&k| !self.stage(k).transition.begun().is_empty())
    }

    /// How many instants each of some equal rounds has, one where nothing happens; `None` if it does not consist of such rounds.
    pub fn round(&self, rounds: usize) -> Option<usize> {
        if self.is_uneventful() {
            return Some(1);
        }
        let (own, count) = (self.0.len() / rounds, self.0.len());
        let is_again = own > 0 && (own..count).all(|k| self.0[k] == self.0[k - own]);
        is_again.then_some(own)
    }

    /// How many departures there are, and how many impacts, which are not counted if some accumulate.
    pub fn n_changes(&self) -> (usize, usize) {
        let departs = |k: &usize| self.departure(*k).is_some();
        let n_departures = (0..self.0.len()).filter(departs).count();
        let n_impacts = self.0.len() - n_departures;
        (n_departures, if self.accumulates() { 0 } else { n_impacts })
    }

    /// The elements that each instant is about, but for those about none.
    pub fn elements(&self) -> Vec<Vec<usize>> {
        let each = self.0.iter().map(|stage| stage.transition.elements());
        let some = each.filter(|elements| !elements.is_empty());
        some.map(<[usize]>::to_vec).collect()
    }
}

/// Refuses motions along which a stop of a scene is in a state, or changes it, as its law of contact does not.
pub(crate) fn check_laws(scene: &Scene, itinerary: &Itinerary) -> Result<()> {
    for (k, stage) in itinerary.iter().enumerate() {
        let before = itinerary.before(k);
        let law = |element: usize| scene.stops()[element].contact();
        let may_be = |element: &usize| match stage.regime.state(*element) {
            ElementState::Held => law(*element).may_hold(),
            _ => !law(*element).is_rigid(),
        };
        let may_change = |element: &usize| match stage.transition {
            Transition::Change(guard, to) => {
                let law = law(*element).by_state();
                let from = match before.state(*element) {
                    // It is back at its place.
                    ElementState::Relaxing if guard.kind == GuardKind::Gap => ElementState::Free,
                    from => from,
                };
                let is_own = law.guards(from).contains(&guard.kind);
                is_own && law.outcome(from, guard.kind) == Outcome::Enters(to)
            }
            _ => law(*element).is_rigid(),
        };
        let changed = stage.transition.elements().iter().copied();
        let wrong = (stage.regime.elements().find(|own| !may_be(own)))
            .or_else(|| changed.clone().find(|own| !may_change(own)));
        if let Some(element) = wrong {
            let events = stage.transition.events();
            let event = events.iter().find(|own| own.1 == element);
            let what = event.map_or("is in contact", |own| own.0);
            let value = format!("a motion along which stop {element} has another law (\"{what}\")");
            let rule = format!("in the scene its law of contact is {}", law(element).name());
            return Err(Error::bad_value("guess", value, rule));
        }
    }
    Ok(())
}

/// Refuses motions that come to rest on a stop by an impact that takes not all speed.
pub(crate) fn check_landings(scene: &Scene, itinerary: &Itinerary) -> Result<()> {
    if itinerary.is_free() {
        return Ok(());
    }
    let contacts = contacts(scene);
    for (k, stage) in itinerary.iter().enumerate() {
        let before = itinerary.before(k);
        let mut caught =
            (stage.transition.struck().iter()).filter(|&&stop| stage.regime.holds(stop));
        if let Some(&stop) =
            caught.find(|&&stop| !before.holds(stop) && !contacts[stop].law().is_inelastic())
        {
            let rule = "its impacts must accumulate while no other stop is held or hit; of other contacts that come to rest \
                        with e > 0 there is no Jacobian";
            let value = format!("a motion that comes to rest on stop {stop} by an impact");
            return Err(Error::bad_value("guess", value, rule));
        }
    }
    Ok(())
}

/// The error of a guess that comes through what has no Jacobian.
pub(crate) fn unsupported(what: &str, time: f64) -> Error {
    let rule = "of an orbit through it there is no Jacobian";
    Error::bad_value(
        "guess",
        format!("a trajectory with {what} at t = {time}"),
        rule,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_period_begins_with_the_impact_behind_a_departure() {
        let on = |stop: usize| Regime::holding([stop]);
        let chatter = Stage {
            transition: Transition::Chatter(1),
            regime: on(1),
        };
        let departure = Stage::departure(1, Regime::default());
        let stages = [Stage::impact(&[0]), chatter, departure.clone()];
        let list: Itinerary = stages.iter().cloned().collect();
        assert_eq!(
            (list.first_contact(), list.departure(2)),
            (Some(0), Some(1))
        );
        assert_eq!((list.accumulation(1), list.accumulates()), (Some(1), true));
        assert_eq!((list.n_lost_directions(), list.n_changes()), (2, (1, 0)));
        assert_eq!(list.single_impacts(), None);
        let two = stages.into_iter().chain([Stage::impact(&[2])]).collect();
        assert_eq!(Itinerary::first_contact(&two), Some(3));
        let none: Itinerary = [departure].into_iter().collect();
        assert_eq!(none.first_contact(), None);
    }

    #[test]
    fn rounds_are_equal_parts() {
        let twice = Itinerary::of_impacts(&[vec![0], vec![1], vec![0], vec![1]]);
        assert_eq!((twice.round(2), twice.round(4)), (Some(2), None));
        assert_eq!(twice.single_impacts(), Some(vec![0, 1, 0, 1]));
        let none: Itinerary = [Stage::impact(&[])].into_iter().collect();
        assert_eq!(
            (none.round(3), none.single_impacts()),
            (Some(1), Some(vec![]))
        );
    }
}
