//! The law of one element, as a scene has it.

use crate::error::Result;
use crate::law::contact_law::ContactLaw;
use crate::law::newton::Newton;
use crate::quantity::Restitution;

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
            Self::OfTest(law) => Newton::new(law.restitution().unwrap_or(0.0)),
        }
    }

    /// Whether the element is rigid: its gap is never negative.
    pub fn is_rigid(&self) -> bool {
        self.by_state().restitution().is_some()
    }
}
