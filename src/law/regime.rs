//! The regime of a motion: the state of each contact element. In a regime the motion has one smooth flow.

/// The state of a contact element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum ElementState {
    /// Its gap is open, and it does nothing.
    Free,
    /// Its gap is kept at zero by a contact force that pushes.
    Held,
}

/// The state of each contact element; those that are not listed are free.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash)]
pub(crate) struct Regime {
    /// The elements whose gaps are kept at zero.
    constrained: Vec<usize>,
}

impl Regime {
    /// All elements free.
    pub fn free() -> &'static Self {
        static FREE: Regime = Regime {
            constrained: Vec::new(),
        };
        &FREE
    }

    /// Some elements held, in this order, and all others free.
    pub fn holding(elements: impl Into<Vec<usize>>) -> Self {
        Self {
            constrained: elements.into(),
        }
    }

    /// Whether all elements are free.
    #[inline]
    pub fn is_free(&self) -> bool {
        self.constrained.is_empty()
    }

    /// The elements whose gaps are kept at zero.
    #[inline]
    pub fn constrained(&self) -> &[usize] {
        &self.constrained
    }

    /// The state of an element.
    pub fn state(&self, element: usize) -> ElementState {
        if self.constrained.contains(&element) {
            ElementState::Held
        } else {
            ElementState::Free
        }
    }

    /// Whether the gap of an element is kept at zero.
    pub fn holds(&self, element: usize) -> bool {
        self.constrained.contains(&element)
    }

    /// Whether an element is free.
    pub fn leaves_free(&self, element: usize) -> bool {
        self.state(element) == ElementState::Free
    }

    /// The same regime with one element more held; all are in ascending order.
    pub fn with(&self, element: usize) -> Self {
        let mut constrained = self.constrained.clone();
        constrained.push(element);
        constrained.sort_unstable();
        Self { constrained }
    }

    /// The same regime with one element free.
    pub fn without(&self, element: usize) -> Self {
        let others = self.constrained.iter().copied();
        Self::holding(others.filter(|own| *own != element).collect::<Vec<_>>())
    }

    /// The regime of the mirror image of a motion, by the image of each element.
    pub fn mirrored(&self, images: &[usize]) -> Self {
        let mut constrained: Vec<usize> = self.constrained.iter().map(|&own| images[own]).collect();
        constrained.sort_unstable();
        Self { constrained }
    }
}
