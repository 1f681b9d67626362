//! The kinds of attractors, by how the motion on them repeats itself.

#[cfg(feature = "python")]
use crate::error::{Error, Result};

/// What a motion settles on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AttractorKind {
    /// It repeats itself.
    Periodic,
    /// It runs on a torus.
    Torus,
    /// It is chaotic.
    Chaotic,
    /// It stands still.
    Rest,
}

impl AttractorKind {
    /// The name used in Python.
    pub fn name(self) -> &'static str {
        match self {
            Self::Periodic => "periodic",
            Self::Torus => "torus",
            Self::Chaotic => "chaotic",
            Self::Rest => "rest",
        }
    }

    /// The kind of a name.
    #[cfg(feature = "python")]
    pub(crate) fn from_name(name: &str) -> Result<Self> {
        let all = [Self::Periodic, Self::Torus, Self::Chaotic, Self::Rest];
        let found = all.into_iter().find(|kind| kind.name() == name);
        found.ok_or_else(|| Error::bad_value("kind", name, "there is no such kind of attractor"))
    }
}
