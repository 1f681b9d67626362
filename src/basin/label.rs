//! What is said of a state.

/// Where a state leads to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Label {
    /// To the attractor of this place.
    Attractor(usize),
    /// It was not decided in the periods given.
    #[default]
    Undecided,
    /// It leaves the surroundings of the box.
    Lost,
    /// It lies inside a stop.
    Inside,
}

impl Label {
    /// The number used in Python: k + 1 of the k-th attractor, 0, -1, -2.
    pub fn number(self) -> i16 {
        match self {
            Self::Attractor(k) => i16::try_from(k + 1).unwrap_or(i16::MAX),
            Self::Undecided => 0,
            Self::Lost => -1,
            Self::Inside => -2,
        }
    }
}
