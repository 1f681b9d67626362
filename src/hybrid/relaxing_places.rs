//! The places of elements that relax, known in closed form whatever moves the bodies (theory 22).

use crate::law::{ElementState, Law, Regime, Relaxation};
use crate::quantity::positive_part;

/// The place of an element that relaxes, and the time after which it is back.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RelaxingPlace {
    pub element: usize,
    pub relaxation: Relaxation,
    pub place: f64,
    pub left: f64,
}

impl RelaxingPlace {
    /// That of an element by its law, if this relaxes.
    fn of(law: &Law, element: usize, place: f64) -> Option<Self> {
        let relaxation = law.by_state().relaxation(ElementState::Relaxing)?;
        let left = relaxation.duration(place);
        Some(Self {
            element,
            relaxation,
            place,
            left,
        })
    }
}

/// Those of all that relax.
#[derive(Debug, Clone, Default)]
pub(crate) struct RelaxingPlaces(Vec<RelaxingPlace>);

impl RelaxingPlaces {
    /// Knows none.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// All of them.
    pub fn iter(&self) -> std::slice::Iter<'_, RelaxingPlace> {
        self.0.iter()
    }

    /// That of an element, if it relaxes.
    pub fn of(&self, element: usize) -> Option<&RelaxingPlace> {
        self.0.iter().find(|own| own.element == element)
    }

    /// Keeps those that relax in a regime.
    pub fn keep(&mut self, regime: &Regime) {
        self.0
            .retain(|own| regime.state(own.element) == ElementState::Relaxing);
    }

    /// The elements that begin to relax in a regime.
    pub fn begun(&self, regime: &Regime) -> Vec<usize> {
        let relaxing = regime.in_state(ElementState::Relaxing);
        relaxing.filter(|own| self.of(*own).is_none()).collect()
    }

    /// Lets an element begin to relax from where the body is, whose gap there it has.
    pub fn begin(&mut self, law: &Law, element: usize, gap: f64) {
        self.0
            .extend(RelaxingPlace::of(law, element, positive_part(-gap)));
    }

    /// Puts those that are about to relax at their places.
    pub fn put<'l>(
        &mut self,
        laws: impl Fn(usize) -> Option<&'l Law>,
        places: impl Iterator<Item = (usize, f64)>,
    ) {
        let own =
            places.filter_map(|(element, place)| RelaxingPlace::of(laws(element)?, element, place));
        self.0 = own.collect();
    }

    /// Takes the times after which they are back.
    pub fn take_left(&mut self, left: impl Iterator<Item = f64>) {
        for (own, left) in self.0.iter_mut().zip(left) {
            own.left = left;
        }
    }

    /// Lets them relax for a time.
    #[inline]
    pub fn relax(&mut self, span: f64) {
        for own in &mut self.0 {
            own.place = own.relaxation.after(own.place, span);
            own.left -= span;
        }
    }

    /// The place of an element.
    pub fn place(&self, element: usize) -> f64 {
        self.of(element).map_or(0.0, |own| own.place)
    }

    /// The element that is back first, and when.
    pub fn first_back(&self) -> Option<(usize, f64)> {
        let times = self.0.iter().map(|own| (own.element, own.left.max(0.0)));
        times.min_by(|a, b| a.1.total_cmp(&b.1))
    }
}
