//! Transitions from one regime to the next.

use crate::law::regime::Regime;

/// What happens at an instant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Transition {
    /// Nothing: a period without instants begins here.
    Nothing,
    /// These elements are struck together; one that is held and receives an impulse with them is one of them.
    Strike(Vec<usize>),
    /// The impacts on this element accumulate, from here to their limit.
    Chatter(usize),
    /// This element is let go, its contact force at zero.
    Release(usize),
}

impl Transition {
    /// The elements that are struck at one instant.
    pub fn struck(&self) -> &[usize] {
        match self {
            Self::Strike(stops) => stops,
            _ => &[],
        }
    }

    /// Whether elements are struck.
    pub fn is_strike(&self) -> bool {
        matches!(self, Self::Strike(_))
    }

    /// Whether impacts accumulate.
    pub fn is_chatter(&self) -> bool {
        matches!(self, Self::Chatter(_))
    }

    /// Whether an element is let go.
    pub fn is_release(&self) -> bool {
        matches!(self, Self::Release(_))
    }

    /// Whether an element is met: struck, or until its impacts have accumulated.
    pub fn meets(&self, element: usize) -> bool {
        match self {
            Self::Strike(stops) => stops.contains(&element),
            Self::Chatter(stop) => *stop == element,
            Self::Release(_) | Self::Nothing => false,
        }
    }

    /// The element that it is about, the first of several.
    pub fn element(&self) -> Option<usize> {
        match self {
            Self::Strike(stops) => stops.first().copied(),
            Self::Chatter(stop) | Self::Release(stop) => Some(*stop),
            Self::Nothing => None,
        }
    }

    /// Whether nothing happens.
    pub fn is_nothing(&self) -> bool {
        *self == Self::Nothing
    }

    /// The same with the mirror image of each element.
    pub fn mirrored(&self, images: &[usize]) -> Self {
        let image = |own: &usize| images[*own];
        match self {
            Self::Nothing => Self::Nothing,
            Self::Strike(stops) => Self::Strike(stops.iter().map(image).collect()),
            Self::Chatter(stop) => Self::Chatter(image(stop)),
            Self::Release(stop) => Self::Release(image(stop)),
        }
    }
}

/// An instant of an itinerary, and the regime from it to the next one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Stage {
    pub transition: Transition,
    pub regime: Regime,
}

impl Stage {
    /// A transition to the free regime.
    pub fn free(transition: Transition) -> Self {
        Self {
            transition,
            regime: Regime::default(),
        }
    }

    /// The same with the mirror image of each element.
    pub fn mirrored(&self, images: &[usize]) -> Self {
        Self {
            transition: self.transition.mirrored(images),
            regime: self.regime.mirrored(images),
        }
    }
}
