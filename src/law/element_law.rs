//! The law of one element, as a user gives it and as a scene has it.

use crate::error::Result;
use crate::law::contact_law::{Action, ContactLaw, LinearForce, Outcome};
use crate::law::hertz::Hertz;
use crate::law::newton::Newton;
use crate::law::regime::ElementState;
use crate::law::spring::Spring;
use crate::quantity::Restitution;

/// A law of contact: what happens where the gap of a stop closes.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum Law {
    /// A rigid stop with a restitution.
    Newton(Newton),
    /// A stop that gives way.
    Spring(Spring),
    /// One of elastic bodies that touch.
    Hertz(Hertz),
    /// One of the library's own tests.
    #[cfg(test)]
    #[doc(hidden)]
    #[expect(private_interfaces, reason = "tests alone have it")]
    OfTest(std::sync::Arc<dyn ContactLaw>),
}

/// A number of a law of contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LawNumber {
    /// e \[-\] of a rigid one.
    Restitution,
    /// k \[N/m\] of one that gives way.
    Stiffness,
    /// c \[N s/m\].
    Damping,
    /// F0 \[N\].
    Preload,
    /// m \[-\].
    Exponent,
}

/// What says which law of contact a stop has: a law, or the restitution \[-\] of a rigid one.
pub trait IntoLaw {
    /// The law.
    ///
    /// # Errors
    /// A restitution outside [0, 1].
    fn into_law(self) -> Result<Law>;
}

impl IntoLaw for f64 {
    fn into_law(self) -> Result<Law> {
        Newton::new(self).map(Law::Newton)
    }
}

impl IntoLaw for Law {
    fn into_law(self) -> Result<Law> {
        Ok(self)
    }
}

impl IntoLaw for Newton {
    fn into_law(self) -> Result<Law> {
        Ok(Law::Newton(self))
    }
}

impl IntoLaw for Spring {
    fn into_law(self) -> Result<Law> {
        Ok(Law::Spring(self))
    }
}

impl IntoLaw for Hertz {
    fn into_law(self) -> Result<Law> {
        Ok(Law::Hertz(self))
    }
}

impl PartialEq for Law {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Newton(own), Self::Newton(other)) => own == other,
            (Self::Spring(own), Self::Spring(other)) => own == other,
            (Self::Hertz(own), Self::Hertz(other)) => own == other,
            #[cfg(test)]
            (Self::OfTest(own), Self::OfTest(other)) => std::sync::Arc::ptr_eq(own, other),
            _ => false,
        }
    }
}

impl Law {
    /// The restitution of its impacts; `None` of one that gives way.
    pub fn restitution(&self) -> Option<Restitution> {
        let restitution = self.by_state().restitution();
        restitution.map(Restitution::known)
    }

    /// A number of it, if it has that.
    pub(crate) fn number(&self, number: LawNumber) -> Option<f64> {
        match (self, number) {
            (Self::Newton(own), LawNumber::Restitution) => Some(own.restitution()),
            (Self::Spring(own), LawNumber::Stiffness) => Some(own.stiffness()),
            (Self::Spring(own), LawNumber::Damping) => Some(own.damping()),
            (Self::Spring(own), LawNumber::Preload) => Some(own.preload()),
            (Self::Hertz(own), LawNumber::Stiffness) => Some(own.stiffness()),
            (Self::Hertz(own), LawNumber::Damping) => Some(own.damping()),
            (Self::Hertz(own), LawNumber::Exponent) => Some(own.exponent()),
            _ => None,
        }
    }

    /// The same law with another value of a number that it has.
    ///
    /// # Errors
    /// A value beyond the domain of the number.
    pub(crate) fn with(&self, number: LawNumber, value: f64) -> Result<Self> {
        let own = match self {
            Self::Spring(own) => own,
            Self::Hertz(own) => {
                let made = match number {
                    LawNumber::Stiffness => own.with_stiffness(value),
                    LawNumber::Damping => own.with_damping(value),
                    _ => own.with_exponent(value),
                };
                return made.map(Self::Hertz);
            }
            _ => return value.into_law(),
        };
        let spring = |stiffness, damping, preload| {
            Spring::new(stiffness, damping, own.release())?.with_preload(preload)
        };
        let (k, c, preload) = (own.stiffness(), own.damping(), own.preload());
        let made = match number {
            LawNumber::Stiffness => spring(value, c, preload),
            LawNumber::Damping => spring(k, value, preload),
            _ => spring(k, c, value),
        };
        made.map(Self::Spring)
    }

    /// Its name.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            Self::Newton(_) => "Newton",
            Self::Spring(_) => "Spring",
            Self::Hertz(_) => "Hertz",
            #[cfg(test)]
            Self::OfTest(_) => "a law of a test",
        }
    }

    /// The law by its states.
    pub(crate) fn by_state(&self) -> &dyn ContactLaw {
        match self {
            Self::Newton(newton) => newton,
            Self::Spring(spring) => spring,
            Self::Hertz(hertz) => hertz,
            #[cfg(test)]
            Self::OfTest(law) => &**law,
        }
    }

    /// The law of its impacts; one without any takes all speed.
    #[inline]
    pub(crate) fn newton(&self) -> Newton {
        match self {
            Self::Newton(newton) => *newton,
            Self::Spring(_) | Self::Hertz(_) => Newton::known(0.0),
            #[cfg(test)]
            Self::OfTest(law) => Newton::known(law.restitution().unwrap_or(0.0)),
        }
    }

    /// The force that it has where it is pressed, none of one that is rigid.
    pub(crate) fn pressed_force(&self) -> LinearForce {
        let force = self.by_state().force(ElementState::Pressed);
        force.unwrap_or(LinearForce::NOTHING)
    }

    /// Whether its force is linear: of others there are no exact flights.
    pub(crate) fn is_linear(&self) -> bool {
        self.by_state().action(ElementState::Pressed) != Action::Curve
    }

    /// Whether it goes back to its place by itself, in a time.
    pub(crate) fn relaxes(&self) -> bool {
        self.has_state(ElementState::Relaxing)
    }

    /// Whether its element may be in a state.
    pub(crate) fn has_state(&self, state: ElementState) -> bool {
        let (law, pressed) = (self.by_state(), ElementState::Pressed);
        let mut guards = law.guards(pressed).iter();
        match state {
            ElementState::Free => true,
            ElementState::Held => self.may_hold(),
            ElementState::Pressed => !self.is_rigid(),
            _ => guards.any(|guard| law.outcome(pressed, *guard) == Outcome::Enters(state)),
        }
    }

    /// Whether it may keep its gap at zero: a rigid one by any force, one that gives way by no more than its preload.
    pub(crate) fn may_hold(&self) -> bool {
        self.is_rigid() || self.by_state().seat().is_some()
    }

    /// Whether the element is rigid: its gap is never negative.
    pub(crate) fn is_rigid(&self) -> bool {
        self.by_state().restitution().is_some()
    }
}
