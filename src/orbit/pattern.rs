//! Patterns: the stops hit in one period, instant by instant.

use crate::error::{Error, Result};
use crate::impact::check_stops;

/// The stops hit in one period, in order; those of one inner list are hit at one instant.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Pattern(Vec<Vec<usize>>);

impl Pattern {
    /// A pattern of instants; none of them may be empty.
    ///
    /// # Errors
    /// `Error::BadValue` for an empty instant or a stop that stands twice in one.
    pub fn new(instants: Vec<Vec<usize>>) -> Result<Self> {
        for (k, instant) in instants.iter().enumerate() {
            if instant.is_empty() {
                return Err(Error::bad_value(
                    format!("pattern[{k}]"),
                    "empty",
                    "an instant needs a stop; a pattern without impacts is empty itself",
                ));
            }
            check_stops(&format!("pattern[{k}]"), instant, usize::MAX)?;
        }
        Ok(Self(instants))
    }

    /// No impact at all.
    pub fn none() -> Self {
        Self::default()
    }

    /// One stop hit once.
    pub fn single(stop: usize) -> Self {
        Self(vec![vec![stop]])
    }

    /// Several stops hit together.
    ///
    /// # Errors
    /// As [`Pattern::new`].
    pub fn together(stops: &[usize]) -> Result<Self> {
        Self::new(vec![stops.to_vec()])
    }

    /// The instants.
    pub fn instants(&self) -> &[Vec<usize>] {
        &self.0
    }

    /// Checks the stops against a scene of `count` stops.
    pub(crate) fn check(&self, count: usize) -> Result<()> {
        self.0
            .iter()
            .enumerate()
            .try_for_each(|(k, instant)| check_stops(&format!("pattern[{k}]"), instant, count))
    }
}
