//! Guards: quantities of a motion that are positive while a regime lasts. Where one falls through zero the regime ends.

use crate::law::regime::Regime;

/// What a guard is a quantity of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum GuardKind {
    /// The gap of an element that is free, h.
    Gap,
    /// The approach of an element that is pressed, p = -h.
    Approach,
    /// The contact force of an element that is held, L.
    Force,
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

    /// The gap of an element in a state, or its approach if it is pressed.
    pub fn gap_in(regime: &Regime, element: usize) -> Self {
        if regime.is_pressed(element) {
            let kind = GuardKind::Approach;
            return Self { element, kind };
        }
        Self::gap(element)
    }

    /// Whether it is a gap, or an approach: it is a row of positions alone.
    pub fn is_gap(self) -> bool {
        self.kind != GuardKind::Force
    }
}
