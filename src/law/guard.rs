//! Guards: quantities of a motion that are positive while a regime lasts. Where one falls through zero the regime ends.

use crate::law::regime::ElementState;

/// What a guard is a quantity of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum GuardKind {
    /// The gap of an element that is free, h.
    Gap,
    /// The approach of an element that is met, p = -h.
    Approach,
    /// The contact force of an element that is held, L.
    Force,
    /// What is left of the preload of one that is held and gives way under a larger force, F0 - L.
    Excess,
    /// The force of an element that is pressed, f.
    Push,
    /// The force that an element which is idle would have, -f.
    Pull,
    /// The distance of an element that relaxes from the body, r - p.
    Distance,
    /// The place of an element that relaxes, r: it is back where it was when nothing of that is left.
    Place,
}

impl GuardKind {
    /// All of them, in the order in which they are written as plain numbers.
    pub const ALL: [Self; 8] = [
        Self::Gap,
        Self::Approach,
        Self::Force,
        Self::Excess,
        Self::Push,
        Self::Pull,
        Self::Distance,
        Self::Place,
    ];

    /// What is zero from where this one has fallen to zero, or was below it, on, in the state that follows, with the number of its derivatives,
    /// itself one of them, that are: the place of an element that relaxes begins where the body is, and, the force being zero, with its speed;
    /// what was held has no speed, and, its force being that of the next state, no acceleration.
    pub fn leaves_at_zero(self, next: ElementState, was_zero: bool) -> Option<(Self, usize)> {
        match (self, next, was_zero) {
            (Self::Gap, ElementState::Pressed, true) => Some((Self::Approach, 1)),
            (Self::Approach, ElementState::Free, true) => Some((Self::Gap, 1)),
            (Self::Push, ElementState::Idle, true) => Some((Self::Pull, 1)),
            (Self::Push, ElementState::Relaxing, _) => {
                Some((Self::Distance, 1 + usize::from(was_zero)))
            }
            (Self::Pull, ElementState::Pressed, true) => Some((Self::Push, 1)),
            (Self::Excess, ElementState::Pressed, _) => {
                Some((Self::Approach, 2 + usize::from(was_zero)))
            }
            (Self::Force, ElementState::Free, _) => Some((Self::Gap, 2 + usize::from(was_zero))),
            _ => None,
        }
    }

    /// Whether it is one of positions alone, of the body's and of the element's own.
    pub fn is_gap(self) -> bool {
        matches!(self, Self::Gap | Self::Approach | Self::Distance)
    }

    /// Whether it depends on velocities.
    pub fn has_speeds(self) -> bool {
        matches!(self, Self::Force | Self::Excess | Self::Push | Self::Pull)
    }
}

/// A guard of one element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Guard {
    /// The element: the stop, by its place in the scene.
    pub element: usize,
    pub kind: GuardKind,
}

impl Guard {
    /// The gap of an element.
    pub const fn gap(element: usize) -> Self {
        Self {
            element,
            kind: GuardKind::Gap,
        }
    }

    /// The contact force of an element.
    pub const fn force(element: usize) -> Self {
        Self {
            element,
            kind: GuardKind::Force,
        }
    }

    /// The place of an element that relaxes.
    pub const fn place(element: usize) -> Self {
        Self {
            element,
            kind: GuardKind::Place,
        }
    }

    /// Whether it is zero where the body is at the place of the element that nothing has pushed.
    pub fn is_seat(self) -> bool {
        matches!(self.kind, GuardKind::Gap | GuardKind::Approach)
    }

    /// Whether it is a row of positions alone.
    pub fn is_gap(self) -> bool {
        self.kind.is_gap()
    }

    /// Whether the body comes near the element where it is small: a touch of it is one of the element.
    pub fn is_clearance(self) -> bool {
        matches!(self.kind, GuardKind::Gap | GuardKind::Distance)
    }
}
