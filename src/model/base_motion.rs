//! A base that is displaced periodically.

use crate::error::{Error, Result};
use crate::quantity::{finite, finite_complex, is_finite, positive};
use nalgebra::{Complex, DVector};

/// Periodic displacement of the base of a pendulum, or of a linear system with an influence vector. It is `Re sum_k
/// amplitudes[k-1] e^{i k (frequency t + phase)}`; with one real amplitude, `amplitude cos(frequency t + phase)`.
#[derive(Debug, Clone, PartialEq)]
pub struct BaseMotion {
    amplitudes: DVector<Complex<f64>>,
    frequency: f64,
    phase: f64,
}

impl BaseMotion {
    /// A harmonic base motion.
    ///
    /// # Errors
    /// Numbers that are not finite, or a frequency that is not positive; an acceleration of the base beyond the doubles.
    pub fn new(amplitude: f64, frequency: f64, phase: f64) -> Result<Self> {
        let amplitude = Complex::from(finite("amplitude", amplitude)?);
        Self::of_harmonics(DVector::from_element(1, amplitude), frequency, phase)
    }

    /// A periodic base motion from the amplitudes of its harmonics, shape `(K,)`.
    ///
    /// # Errors
    /// No amplitude at all, numbers that are not finite, or a frequency that is not positive; an acceleration of the base beyond the
    /// doubles.
    pub fn of_harmonics(
        amplitudes: DVector<Complex<f64>>,
        frequency: f64,
        phase: f64,
    ) -> Result<Self> {
        if amplitudes.is_empty() {
            let expected = "(K,): one number for each harmonic";
            return Err(Error::bad_shape("amplitude", "(0,)", expected));
        }
        finite_complex("amplitude", &amplitudes)?;
        let base = Self {
            amplitudes,
            frequency: positive("frequency", frequency)?,
            phase: finite("phase", phase)?,
        };
        if base.is_finite() {
            return Ok(base);
        }
        let rule = "the acceleration of the base, amplitude * frequency**2, must be finite";
        Err(Error::bad_value("frequency", frequency, rule))
    }

    /// The displacement amplitudes of the harmonics, shape `(K,)`.
    pub fn amplitudes(&self) -> &DVector<Complex<f64>> {
        &self.amplitudes
    }

    /// The circular frequency \[rad/s\].
    pub fn frequency(&self) -> f64 {
        self.frequency
    }

    /// The phase \[rad\].
    pub fn phase(&self) -> f64 {
        self.phase
    }

    /// The harmonics with their frequencies.
    pub(crate) fn harmonics(&self) -> impl Iterator<Item = (f64, Complex<f64>)> {
        let frequencies = (1..).map(|k: u32| f64::from(k) * self.frequency);
        frequencies.zip(self.amplitudes.iter().copied())
    }

    /// Whether its acceleration is finite.
    pub(super) fn is_finite(&self) -> bool {
        self.harmonics().all(|(w, a)| is_finite(&(a * w * w)))
    }

    pub(super) fn with_phase(self, phase: f64) -> Self {
        Self { phase, ..self }
    }

    pub(super) fn with_frequency(self, frequency: f64) -> Result<Self> {
        Self::of_harmonics(self.amplitudes, frequency, self.phase)
    }

    pub(super) fn scaled(self, factor: f64) -> Self {
        let amplitudes = self.amplitudes * Complex::from(factor);
        Self { amplitudes, ..self }
    }
}
