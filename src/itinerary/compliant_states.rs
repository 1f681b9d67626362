//! The states of elements that give way along a motion that is read part by part. Where one that relaxes is back at its place nothing happens
//! to the motion: that is no change.

use crate::error::Result;
use crate::itinerary::list::unsupported;
use crate::law::{ElementState, Law, Regime, Transition};
use crate::model::{Constraint, Scene};

/// The state of an element that gives way.
#[derive(Debug, Clone, Copy)]
struct CompliantState {
    element: usize,
    state: ElementState,
}

/// A change of such a state.
#[derive(Debug, Clone, Copy)]
pub(super) struct StateChange {
    from: CompliantState,
    to: ElementState,
}

/// The states of all elements of a scene that give way.
pub(super) struct CompliantStates<'a> {
    laws: Vec<&'a Law>,
    /// Those along the last part, empty before the first.
    states: Vec<CompliantState>,
}

impl<'a> CompliantStates<'a> {
    /// Those of a scene, before the first part of a motion.
    pub fn new(scene: &'a Scene) -> Self {
        Self {
            laws: scene.stops().iter().map(Constraint::contact).collect(),
            states: Vec::new(),
        }
    }

    /// Takes the states of the next part; returns what has changed with it.
    pub fn take(&mut self, regime: &Regime) -> Vec<StateChange> {
        if self.states.is_empty() {
            let compliant = (0..self.laws.len()).filter(|&i| !self.laws[i].is_rigid());
            let begun = compliant.map(|element| CompliantState {
                element,
                state: regime.state(element),
            });
            self.states = begun.collect();
            return Vec::new();
        }
        let mut changes = Vec::new();
        for own in &mut self.states {
            let to = regime.state(own.element);
            if own.state != to && !own.state.is_back(to) {
                changes.push(StateChange { from: *own, to });
            }
            own.state = to;
        }
        changes
    }

    /// The transition that some changes at a time are; one, where nothing else happens.
    ///
    /// # Errors
    /// What has no Jacobian yet.
    pub fn transition(
        &self,
        changes: &[StateChange],
        is_alone: bool,
        time: f64,
    ) -> Result<Transition> {
        let [StateChange { from, to }] = *changes else {
            let what = "several stops that give way which change their states at one time";
            return Err(unsupported(what, time));
        };
        if !is_alone {
            let what = "a stop that gives way which changes its state with another event";
            return Err(unsupported(what, time));
        }
        let element = from.element;
        let found = match (from.state, to) {
            (ElementState::Held, _) | (_, ElementState::Held) => None,
            (from, to) => Transition::change(self.laws[element].by_state(), element, [from, to]),
        };
        found.ok_or_else(|| unsupported("a body that comes to a seat or leaves it", time))
    }
}
