//! The state of a motion in modal coordinates.

use crate::linalg::plane::Pair;
use std::ops::{Deref, DerefMut};

/// A pair of numbers for each block of the modal form: the whole motion. A flow moves a state of its own, which it makes of this.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct ModalState(Vec<Pair>);

impl ModalState {
    /// A state to be filled, with room for so many pairs.
    pub fn with_capacity(n: usize) -> Self {
        Self(Vec::with_capacity(n))
    }
}

impl Deref for ModalState {
    type Target = Vec<Pair>;

    #[inline]
    fn deref(&self) -> &Vec<Pair> {
        &self.0
    }
}

impl DerefMut for ModalState {
    #[inline]
    fn deref_mut(&mut self) -> &mut Vec<Pair> {
        &mut self.0
    }
}

impl From<Vec<Pair>> for ModalState {
    #[inline]
    fn from(pairs: Vec<Pair>) -> Self {
        Self(pairs)
    }
}

impl FromIterator<Pair> for ModalState {
    fn from_iter<I: IntoIterator<Item = Pair>>(pairs: I) -> Self {
        Self(pairs.into_iter().collect())
    }
}

impl<'a> IntoIterator for &'a ModalState {
    type Item = &'a Pair;
    type IntoIter = std::slice::Iter<'a, Pair>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}
