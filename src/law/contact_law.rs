//! A law of contact, by the states of its element: what the element adds to the equations of motion in each, the guards that end it, and what
//! follows where one of them falls through zero. `hybrid` and `flow` know elements by this alone.

use crate::error::Result;
use crate::law::guard::GuardKind;
use crate::law::newton::Newton;
use crate::law::regime::ElementState;
use crate::quantity::Restitution;

/// What an element adds to the equations of motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Action {
    Nothing,
    /// A force that keeps its gap at zero.
    Constraint,
    /// A force against its approach.
    #[cfg_attr(not(test), expect(dead_code, reason = "the laws of tests alone push"))]
    Force(LinearForce),
}

/// A force `f = k p + c p' + F0` on the approach `p = -h`: the generalised force is `-n f`, or it acts along the reaction of the stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LinearForce {
    /// k \[N/m\].
    pub stiffness: f64,
    /// c \[N s/m\].
    pub damping: f64,
    /// F0 \[N\].
    pub preload: f64,
}

impl LinearForce {
    /// The force at a gap and its opening speed.
    pub fn at(self, gap: f64, speed: f64) -> f64 {
        self.preload - self.stiffness * gap - self.damping * speed
    }
}

/// What follows where a guard falls through zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// An impact, after which the element is free or held.
    Impact,
    /// It is let go, unless it is held after all.
    Release,
    /// It goes on in another state.
    #[cfg_attr(not(test), expect(dead_code, reason = "the laws of tests alone push"))]
    Enters(ElementState),
}

/// A law of contact.
pub(crate) trait ContactLaw: std::fmt::Debug + Send + Sync {
    /// What the element adds in a state.
    fn action(&self, state: ElementState) -> Action;
    /// The guards that end a state.
    fn guards(&self, state: ElementState) -> &'static [GuardKind];
    /// What follows where a guard of a state falls through zero.
    fn outcome(&self, state: ElementState, guard: GuardKind) -> Outcome;
    /// The law of its impacts, of a rigid stop.
    fn impacts(&self) -> Option<Newton> {
        None
    }
}

/// The law of one element.
#[derive(Debug, Clone)]
pub(crate) enum Law {
    Newton(Newton),
    #[cfg(test)]
    OfTest(std::sync::Arc<dyn ContactLaw>),
}

impl PartialEq for Law {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Newton(own), Self::Newton(other)) => own == other,
            #[cfg(test)]
            (Self::OfTest(own), Self::OfTest(other)) => std::sync::Arc::ptr_eq(own, other),
            #[cfg(test)]
            _ => false,
        }
    }
}

impl Law {
    /// Newton's law of a restitution in [0, 1].
    pub fn newton_of(restitution: f64) -> Result<Self> {
        let restitution = Restitution::new(restitution)?;
        Ok(Self::Newton(Newton::new(restitution.value())))
    }

    /// The restitution of its impacts, zero of one without any.
    pub fn restitution(&self) -> Restitution {
        Restitution::known(self.newton().restitution)
    }

    /// The law by its states.
    pub fn by_state(&self) -> &dyn ContactLaw {
        match self {
            Self::Newton(newton) => newton,
            #[cfg(test)]
            Self::OfTest(law) => &**law,
        }
    }

    /// The law of its impacts; one without any takes all speed.
    #[inline]
    pub fn newton(&self) -> Newton {
        match self {
            Self::Newton(newton) => *newton,
            #[cfg(test)]
            Self::OfTest(law) => law.impacts().unwrap_or(Newton::new(0.0)),
        }
    }

    /// Whether the element is rigid: its gap is never negative.
    pub fn is_rigid(&self) -> bool {
        self.by_state().impacts().is_some()
    }
}
