//! What a touch of a stop that gives way does to a branch (theory 22, "Touches"): the rule by which the multipliers on both sides decide.

use crate::tolerance::MARGINAL;
use nalgebra::Complex;

/// What becomes of a branch at a touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TouchOutcome {
    /// The orbits before and behind it are on the same side: they meet, and there are none on the other.
    Fold,
    /// It goes on, and an orbit of twice the period is born.
    Doubling,
    /// It goes on.
    Persists,
}

impl TouchOutcome {
    /// That of some numbers of real multipliers above 1 and below -1, before and behind, by M. I. Feigin's rule: an odd sum of those above 1
    /// is a fold, of those below -1 a doubling.
    pub fn of_counts(above_1: [usize; 2], below_minus_1: [usize; 2]) -> Self {
        let is_odd = |[before, after]: [usize; 2]| (before + after) % 2 == 1;
        if is_odd(above_1) {
            Self::Fold
        } else if is_odd(below_minus_1) {
            Self::Doubling
        } else {
            Self::Persists
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fold => "fold",
            Self::Doubling => "doubling",
            Self::Persists => "persists",
        }
    }
}

/// The multipliers of the orbits of a branch on both sides of a touch, as they come near to it.
#[derive(Debug, Clone, PartialEq)]
pub struct TouchMultipliers {
    /// Before it, in the order of the branch, shape `(2n,)`, without forcing one less, \[-\].
    pub before: Vec<Complex<f64>>,
    /// Behind it, shape `(2n,)`, without forcing one less, \[-\].
    pub after: Vec<Complex<f64>>,
}

impl TouchMultipliers {
    /// How many are real and above 1, before and after.
    pub fn n_above_1(&self) -> [usize; 2] {
        self.counted(|mu| mu > 1.0 + MARGINAL)
    }

    /// How many are real and below -1, before and after.
    pub fn n_below_minus_1(&self) -> [usize; 2] {
        self.counted(|mu| mu < -1.0 - MARGINAL)
    }

    fn counted(&self, is_there: impl Fn(f64) -> bool) -> [usize; 2] {
        [&self.before, &self.after].map(|side| {
            let real = side.iter().filter(|mu| mu.im == 0.0);
            real.filter(|mu| is_there(mu.re)).count()
        })
    }

    /// What becomes of the branch.
    pub fn outcome(&self) -> TouchOutcome {
        TouchOutcome::of_counts(self.n_above_1(), self.n_below_minus_1())
    }

    /// The traces of the maps of deviations, the sums of the multipliers, before and after.
    pub fn traces(&self) -> [f64; 2] {
        [&self.before, &self.after].map(|side| side.iter().map(|mu| mu.re).sum())
    }

    /// The same of the branch followed the other way.
    pub(super) fn reversed(self) -> Self {
        Self {
            before: self.after,
            after: self.before,
        }
    }
}
