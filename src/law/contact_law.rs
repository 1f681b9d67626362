//! A law of contact, by the states of its element: what the element adds to the equations of motion in each, the guards that end it, and what
//! follows where one of them falls through zero. `hybrid` and `flow` know elements by this alone.

use crate::law::guard::GuardKind;
use crate::law::regime::ElementState;

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
    /// The energy that it stores in a state, at a gap \[J\].
    fn stored(&self, _state: ElementState, _gap: f64) -> f64 {
        0.0
    }
    /// A contact force without what rounding makes of it: a rigid element pushes, to the instant when its force is zero and it is let go.
    fn allowed(&self, force: f64) -> f64 {
        if self.restitution().is_some() {
            force.max(0.0)
        } else {
            force
        }
    }
    /// The restitution of its impacts, if it is rigid: its gap is never negative.
    fn restitution(&self) -> Option<f64> {
        None
    }
}
