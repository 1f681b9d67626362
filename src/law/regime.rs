//! The regime of a motion: the state of each contact element. In a regime the motion has one smooth flow.

/// The state of a contact element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum ElementState {
    /// Its gap is open, and it does nothing.
    Free,
    /// Its gap is kept at zero by a contact force that pushes.
    Held,
    /// Its gap is negative, and a force pushes against that.
    Pressed,
    /// Its gap is negative, and its force would pull: there is none.
    Idle,
    /// It was left where its force was zero, and goes back to its place by itself.
    Relaxing,
}

impl ElementState {
    /// Those that are written as plain numbers, in the order of these.
    const WRITTEN: [Self; 4] = [Self::Held, Self::Pressed, Self::Idle, Self::Relaxing];

    /// Whether the element has a force of its own, or one that holds it.
    pub fn is_met(self) -> bool {
        matches!(self, Self::Held | Self::Pressed)
    }

    /// Its name, of an element that is rigid or not: one that gives way is held by its preload alone, on its seat.
    pub fn name(self, is_rigid: bool) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Held if is_rigid => "held",
            Self::Held => "seated",
            Self::Pressed => "pressed",
            Self::Idle => "idle",
            Self::Relaxing => "relaxing",
        }
    }

    /// Whether in the next state an element that relaxed is back at its place: nothing happens to a motion there.
    pub fn is_back(self, next: Self) -> bool {
        (self, next) == (Self::Relaxing, Self::Free)
    }

    /// Whether its gap is kept at zero.
    pub fn is_held(self) -> bool {
        self == Self::Held
    }
}

/// More elements than a scene has, by which states are told in plain numbers. [exact]
const ELEMENTS: usize = 1 << 24;

/// The state of each contact element; those that are not listed are free.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash)]
pub(crate) struct Regime {
    /// The elements that are held.
    held: Vec<usize>,
    /// Those in another state that is not free.
    others: Vec<(usize, ElementState)>,
}

impl Regime {
    /// All elements free.
    pub fn free() -> &'static Self {
        static FREE: Regime = Regime {
            held: Vec::new(),
            others: Vec::new(),
        };
        &FREE
    }

    /// Some elements held, in this order, and all others free.
    pub fn holding(elements: impl Into<Vec<usize>>) -> Self {
        Self {
            held: elements.into(),
            others: Vec::new(),
        }
    }

    /// The same with other elements held; one that is held is in no other state.
    pub fn holding_instead(&self, elements: &[usize]) -> Self {
        let others = self.others.iter().copied();
        Self {
            held: elements.to_vec(),
            others: others.filter(|own| !elements.contains(&own.0)).collect(),
        }
    }

    /// Whether all elements are free.
    #[inline]
    pub fn is_free(&self) -> bool {
        self.held.is_empty() && self.others.is_empty()
    }

    /// The elements whose gaps are kept at zero.
    #[inline]
    pub fn constrained(&self) -> &[usize] {
        &self.held
    }

    /// The elements in other states.
    pub fn others(&self) -> &[(usize, ElementState)] {
        &self.others
    }

    /// The number of directions of the state space that are gone in it: of each constraint a position and a speed.
    pub fn n_lost_directions(&self) -> usize {
        2 * self.held.len()
    }

    /// As plain numbers: the elements that are held, then those in other states, each with its state in the digits above [`ELEMENTS`].
    pub fn written(&self) -> Vec<usize> {
        let code =
            |state: ElementState| (0..).zip(ElementState::WRITTEN).find(|own| own.1 == state);
        let other =
            |own: &(usize, ElementState)| own.0 + ELEMENTS * code(own.1).map_or(0, |own| own.0);
        let others = self.others.iter().map(other);
        self.held.iter().copied().chain(others).collect()
    }

    /// The regime that was written as plain numbers; `None` where these are those of no regime.
    pub fn read(numbers: &[usize]) -> Option<Self> {
        let mut own = Self::default();
        for number in numbers {
            let (element, state) = (number % ELEMENTS, number / ELEMENTS);
            if !own.leaves_free(element) {
                return None;
            }
            match ElementState::WRITTEN.get(state)? {
                ElementState::Held => own.held.push(element),
                state => own.others.push((element, *state)),
            }
        }
        Some(own)
    }

    /// The elements that are not free.
    pub fn elements(&self) -> impl Iterator<Item = usize> + '_ {
        let others = self.others.iter().map(|own| own.0);
        self.held.iter().copied().chain(others)
    }

    /// How many elements are held in it that were not before.
    pub fn n_new_constraints(&self, before: &Self) -> usize {
        self.held.iter().filter(|own| !before.holds(**own)).count()
    }

    /// The first element that is in contact.
    pub fn contact(&self) -> Option<usize> {
        self.elements().next()
    }

    /// The state of an element.
    pub fn state(&self, element: usize) -> ElementState {
        if self.holds(element) {
            return ElementState::Held;
        }
        let own = self.others.iter().find(|own| own.0 == element);
        own.map_or(ElementState::Free, |own| own.1)
    }

    /// Whether the gap of an element is kept at zero.
    pub fn holds(&self, element: usize) -> bool {
        self.held.contains(&element)
    }

    /// The elements that are pressed.
    pub fn pressed(&self) -> impl Iterator<Item = usize> + '_ {
        self.in_state(ElementState::Pressed)
    }

    /// The elements that have forces: those held, and those that are pressed.
    pub fn pushing(&self) -> impl Iterator<Item = usize> + '_ {
        self.held.iter().copied().chain(self.pressed())
    }

    /// The elements in a state that is neither free nor held.
    pub fn in_state(&self, state: ElementState) -> impl Iterator<Item = usize> + '_ {
        let own = self.others.iter();
        own.filter(move |own| own.1 == state).map(|own| own.0)
    }

    /// Whether an element is pressed.
    pub fn is_pressed(&self, element: usize) -> bool {
        self.pressed().any(|own| own == element)
    }

    /// Whether an element is free.
    pub fn leaves_free(&self, element: usize) -> bool {
        self.state(element) == ElementState::Free
    }

    /// The same regime with an element in another state; all are in ascending order.
    pub fn with(&self, element: usize, state: ElementState) -> Self {
        let mut other = self.without(element);
        match state {
            ElementState::Free => {}
            ElementState::Held => {
                other.held.push(element);
                other.held.sort_unstable();
            }
            state => {
                other.others.push((element, state));
                other.others.sort_unstable_by_key(|own| own.0);
            }
        }
        other
    }

    /// The same regime with one element free.
    pub fn without(&self, element: usize) -> Self {
        let (held, others) = (self.held.iter().copied(), self.others.iter().copied());
        Self {
            held: held.filter(|own| *own != element).collect(),
            others: others.filter(|own| own.0 != element).collect(),
        }
    }

    /// The regime of the mirror image of a motion, by the image of each element.
    pub fn mirrored(&self, images: &[usize]) -> Self {
        let mut held: Vec<usize> = self.held.iter().map(|&own| images[own]).collect();
        let others = self.others.iter();
        let mut others: Vec<_> = others.map(|own| (images[own.0], own.1)).collect();
        held.sort_unstable();
        others.sort_unstable_by_key(|own| own.0);
        Self { held, others }
    }
}
