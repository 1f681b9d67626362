//! The phasors of an excitation: the harmonics of a fundamental frequency, and tones of frequencies of their own.

use crate::model::moment::Moment;
use nalgebra::Complex;

/// Frequencies with the phasors `e^{i w t}` that turn at them: first those of the harmonics, then those of the tones.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Rotations {
    /// The fundamental frequency [rad/s], zero without harmonics.
    pub fundamental: f64,
    /// Number of harmonics.
    pub n_harmonics: usize,
    /// The frequencies of the tones, shape `(n_tones,)`, [rad/s]; their phases are in their amplitudes.
    pub tones: Vec<f64>,
}

/// `u`, `u^2`, `u^3` and so on: the phasors of the harmonics from that of the first.
#[inline]
pub(crate) fn powers(u: Complex<f64>) -> impl Iterator<Item = Complex<f64>> {
    std::iter::successors(Some(u), move |power| Some(power * u))
}

impl Rotations {
    /// The harmonics of a frequency, alone.
    #[cfg(test)]
    pub fn harmonics(fundamental: f64, n_harmonics: usize) -> Self {
        Self {
            fundamental,
            n_harmonics,
            tones: Vec::new(),
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.n_harmonics + self.tones.len()
    }

    /// Whether nothing turns.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The frequencies.
    pub fn frequencies(&self) -> impl Iterator<Item = f64> + Clone {
        let harmonics = (1..=self.n_harmonics).map(|k| k as f64 * self.fundamental);
        harmonics.chain(self.tones.iter().copied())
    }

    /// The fastest, zero where nothing turns.
    pub fn fastest(&self) -> f64 {
        self.frequencies().fold(0.0, f64::max)
    }

    /// The phasors at a moment.
    pub fn phasors(&self, at: Moment) -> impl Iterator<Item = Complex<f64>> {
        self.phasors_of(Complex::cis(at.angle), at)
    }

    /// The phasors at a moment, given that of the fundamental frequency.
    pub fn phasors_of(
        &self,
        first: Complex<f64>,
        at: Moment,
    ) -> impl Iterator<Item = Complex<f64>> {
        let harmonics = powers(first).take(self.n_harmonics);
        let tones = self.tones.iter().map(move |&w| at.angle_of(w));
        harmonics.chain(tones.map(Complex::cis))
    }

    /// The factors by which the phasors change over a span of time.
    pub fn turns(&self, span: f64) -> impl Iterator<Item = Complex<f64>> {
        self.frequencies().map(move |w| Complex::cis(w * span))
    }
}
