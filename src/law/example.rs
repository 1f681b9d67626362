#![cfg(test)]
//! A law of contact that is none of the library's, from which those who write one may begin, and which tests use.

use crate::law::contact_law::{Action, ContactLaw, LinearForce, Outcome};
use crate::law::element_law::Law;
use crate::law::guard::GuardKind;
use crate::law::regime::ElementState;
use std::sync::Arc;

/// A stop that gives way: a spring and a dashpot against the approach, until the gap opens.
#[derive(Debug)]
pub(crate) struct Cushion(LinearForce);

impl ContactLaw for Cushion {
    fn action(&self, state: ElementState) -> Action {
        match state {
            ElementState::Pressed => Action::Force(self.0),
            _ => Action::Nothing,
        }
    }

    fn guards(&self, state: ElementState) -> &'static [GuardKind] {
        match state {
            ElementState::Pressed => &[GuardKind::Approach],
            _ => &[GuardKind::Gap],
        }
    }

    fn outcome(&self, state: ElementState, _guard: GuardKind) -> Outcome {
        Outcome::Enters(match state {
            ElementState::Pressed => ElementState::Free,
            _ => ElementState::Pressed,
        })
    }

    fn stored(&self, state: ElementState, gap: f64) -> f64 {
        match state {
            ElementState::Pressed => 0.5 * self.0.stiffness * gap * gap,
            _ => 0.0,
        }
    }
}

impl Cushion {
    /// The law of a stiffness \[N/m\] and a damping \[N s/m\].
    pub fn law(stiffness: f64, damping: f64) -> Law {
        Law::OfTest(Arc::new(Self(LinearForce {
            stiffness,
            damping,
            preload: 0.0,
        })))
    }
}
