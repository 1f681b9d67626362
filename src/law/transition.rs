//! Transitions from one regime to the next.

use crate::law::contact_law::{ContactLaw, Outcome};
use crate::law::guard::{Guard, GuardKind};
use crate::law::regime::{ElementState, Regime};

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
    /// An element that gives way goes on in another state where one of its guards is zero.
    Change(Guard, ElementState),
}

impl Transition {
    /// The elements that it is about.
    pub fn elements(&self) -> &[usize] {
        match self {
            Self::Nothing => &[],
            Self::Strike(stops) => stops,
            Self::Chatter(stop) | Self::Release(stop) => std::slice::from_ref(stop),
            Self::Change(guard, _) => std::slice::from_ref(&guard.element),
        }
    }

    /// The change of an element that gives way from one state to another, if its law has such a one.
    pub fn change(
        law: &dyn ContactLaw,
        element: usize,
        [from, to]: [ElementState; 2],
    ) -> Option<Self> {
        let mut guards = law.guards(from).iter();
        let leads = |kind: &&GuardKind| law.outcome(from, **kind) == Outcome::Enters(to);
        let kind = *guards.find(leads)?;
        Some(Self::Change(Guard { element, kind }, to))
    }

    /// A touch of an element that gives way: its gap closes without a speed, and it stays free.
    pub const fn touch(element: usize) -> Self {
        Self::Change(Guard::gap(element), ElementState::Free)
    }

    /// The element that is touched without a speed.
    pub fn touched(&self) -> Option<usize> {
        match *self {
            Self::Change(guard, ElementState::Free) if guard.kind == GuardKind::Gap => {
                Some(guard.element)
            }
            _ => None,
        }
    }

    /// The element that begins to be pressed where nothing pushed it.
    pub fn press(&self) -> Option<usize> {
        match self {
            Self::Change(guard, ElementState::Pressed) if guard.is_clearance() => {
                Some(guard.element)
            }
            _ => None,
        }
    }

    /// What it is called, for each element that it is about.
    pub fn events(&self) -> Vec<(&'static str, usize)> {
        let name = match self {
            Self::Nothing => return Vec::new(),
            Self::Strike(_) => "strike",
            Self::Chatter(_) => "chatter",
            Self::Release(_) => "release",
            Self::Change(guard, state) => match state {
                ElementState::Pressed if guard.kind == GuardKind::Excess => "yield",
                ElementState::Pressed => "press",
                ElementState::Free => "leave",
                ElementState::Idle | ElementState::Relaxing => "relax",
                ElementState::Held => "seat",
            },
        };
        let elements = self.elements().iter();
        elements.map(|&element| (name, element)).collect()
    }

    /// The element that relaxes and is met here before it is back at its place.
    pub fn met_again(&self) -> Option<usize> {
        match self {
            Self::Change(guard, _) if guard.kind == GuardKind::Distance => Some(guard.element),
            _ => None,
        }
    }

    /// The element that begins to relax here.
    pub fn left_to_relax(&self) -> Option<usize> {
        match self {
            Self::Change(guard, ElementState::Relaxing) => Some(guard.element),
            _ => None,
        }
    }

    /// The elements with which contacts begin: those struck, or one that is pressed from here on.
    pub fn begun(&self) -> Vec<usize> {
        let pressed = self.press().into_iter();
        self.struck().iter().copied().chain(pressed).collect()
    }

    /// The element that it is about, the first of several.
    pub fn element(&self) -> Option<usize> {
        self.elements().first().copied()
    }

    /// The elements that are struck at one instant.
    pub fn struck(&self) -> &[usize] {
        match self {
            Self::Strike(stops) => stops,
            _ => &[],
        }
    }

    /// The elements that are struck and were free before: their gaps close here.
    pub fn closing<'a>(&'a self, before: &'a Regime) -> impl Iterator<Item = usize> + 'a {
        let stops = self.struck().iter().copied();
        stops.filter(|&stop| before.leaves_free(stop))
    }

    /// The element whose impacts accumulate.
    pub fn accumulation(&self) -> Option<usize> {
        self.element().filter(|_| self.is_chatter())
    }

    /// The element that is left without an impact.
    pub fn departure(&self) -> Option<usize> {
        self.element().filter(|_| self.is_release())
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
            Self::Change(..) => self.press() == Some(element),
            _ => !self.is_release() && self.elements().contains(&element),
        }
    }

    /// The impacts of two instants at one; `None` where one of them has none.
    pub fn together(&self, other: &Self) -> Option<Self> {
        let (Self::Strike(one), Self::Strike(others)) = (self, other) else {
            return None;
        };
        let mut stops = [one.as_slice(), others].concat();
        stops.sort_unstable();
        Some(Self::Strike(stops))
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
            Self::Change(guard, state) => {
                let element = image(&guard.element);
                Self::Change(Guard { element, ..*guard }, *state)
            }
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

    /// An element that is left without an impact, to a regime.
    pub fn departure(element: usize, regime: Regime) -> Self {
        Self {
            transition: Transition::Release(element),
            regime,
        }
    }

    /// Nothing, in a regime.
    pub fn uneventful(regime: Regime) -> Self {
        Self {
            transition: Transition::Nothing,
            regime,
        }
    }

    /// Impacts on some elements together, after which all are free; nothing if there are none.
    pub fn impact(elements: &[usize]) -> Self {
        Self::free(if elements.is_empty() {
            Transition::Nothing
        } else {
            Transition::Strike(elements.to_vec())
        })
    }

    /// The same with the mirror image of each element.
    pub fn mirrored(&self, images: &[usize]) -> Self {
        Self {
            transition: self.transition.mirrored(images),
            regime: self.regime.mirrored(images),
        }
    }
}
