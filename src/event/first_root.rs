//! The first root of a quantity along a flight: of a gap it is a contact, of a contact force a release.

/// The first root of one quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum FirstRoot {
    /// It stays above zero, or touches it.
    None,
    /// It falls through zero at a place, and is below at a later one.
    Crossing { at: f64, passed: f64 },
    /// At a place a root could not be told from none.
    Undecided { at: f64 },
}

impl FirstRoot {
    /// Where it is; nowhere, infinitely far.
    #[inline]
    pub fn at(self) -> f64 {
        match self {
            Self::None => f64::INFINITY,
            Self::Crossing { at, .. } | Self::Undecided { at } => at,
        }
    }
}

/// The first of the roots of several stops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FirstEvent {
    /// The stop whose root it is; any, where there is none.
    pub stop: usize,
    pub root: FirstRoot,
}

impl FirstEvent {
    /// None yet.
    pub const NONE: Self = Self {
        stop: 0,
        root: FirstRoot::None,
    };

    /// Takes note of the root of a stop, if it is the first.
    #[inline]
    pub fn note(&mut self, stop: usize, root: FirstRoot) {
        if root.at() < self.root.at() {
            *self = Self { stop, root };
        }
    }
}
