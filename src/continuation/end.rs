//! Where a branch ends, and why.

/// Why a branch ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EndReason {
    /// The end of the range was reached.
    Range,
    /// The branch came back to where it began.
    Closed,
    /// It has as many points as were asked for.
    Points,
    /// Newton's method came no further.
    Step,
    /// Beyond it the orbits break a rule of contact.
    Boundary,
    /// It has come to the motion of half its period from which it is doubled; beyond that it would come back over itself.
    Doubling,
    /// Beyond it there is no scene.
    Domain,
    /// The observer broke it off.
    Interrupted,
    /// It is the orbit that was given: the branch was followed the other way alone.
    Start,
}

impl EndReason {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Range,
        Self::Closed,
        Self::Points,
        Self::Step,
        Self::Boundary,
        Self::Doubling,
        Self::Domain,
        Self::Interrupted,
        Self::Start,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Range => "range",
            Self::Closed => "closed",
            Self::Points => "points",
            Self::Step => "step",
            Self::Boundary => "boundary",
            Self::Doubling => "doubling",
            Self::Domain => "domain",
            Self::Interrupted => "interrupted",
            Self::Start => "start",
        }
    }
}

/// An end of a branch.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BranchEnd {
    /// Why.
    pub reason: EndReason,
    /// The same in words, with numbers.
    pub detail: String,
}

impl BranchEnd {
    pub(crate) fn new(reason: EndReason, detail: String) -> Self {
        Self { reason, detail }
    }
}
