//! The label of a state: the attractor that its motion leads to, or why there is none. It has no unit; attractors are counted from 0 in the
//! order of their list.

/// Where a state leads to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Label {
    /// To the attractor of this index.
    Attractor(usize),
    /// Undecided within the periods given.
    #[default]
    Undecided,
    /// Far away from the box.
    Lost,
    /// Nowhere: it lies inside a stop.
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
    /// The label of a number; of what nobody has worked out, -3, that of what is no basin.
    #[cfg(feature = "python")]
    pub(crate) fn from_number(number: f64) -> Self {
        match number as i64 {
            0 => Self::Undecided,
            -1 => Self::Lost,
            k => usize::try_from(k - 1).map_or(Self::Inside, Self::Attractor),
        }
    }
}
