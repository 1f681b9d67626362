//! A stop that gives way, by a spring and a dashpot.

use crate::error::Result;
use crate::law::contact_law::{Action, ContactLaw, LinearForce, Outcome};
#[cfg(test)]
use crate::law::element_law::Law;
use crate::law::guard::GuardKind;
use crate::law::regime::ElementState;
use crate::quantity::finite;

/// A stop that gives way: a spring and a dashpot against the approach, until the gap opens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cushion(LinearForce);

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
    ///
    /// # Errors
    /// A number that is not finite.
    pub fn new(stiffness: f64, damping: f64) -> Result<Self> {
        Ok(Self(LinearForce {
            stiffness: finite("stiffness", stiffness)?,
            damping: finite("damping", damping)?,
            preload: 0.0,
        }))
    }

    /// The stiffness \[N/m\].
    pub fn stiffness(&self) -> f64 {
        self.0.stiffness
    }

    /// The damping \[N s/m\].
    pub fn damping(&self) -> f64 {
        self.0.damping
    }

    /// The law of a stiffness \[N/m\] and a damping \[N s/m\] that are known to be finite.
    #[cfg(test)]
    pub(crate) fn law(stiffness: f64, damping: f64) -> Law {
        Law::Cushion(Self::new(stiffness, damping).expect("finite"))
    }
}
