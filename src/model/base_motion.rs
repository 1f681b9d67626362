//! A base that is displaced periodically.

use crate::error::{Error, Result};
use crate::model::fourier::Fourier;
use crate::quantity::{finite, finite_complex, is_finite};
use nalgebra::{Complex, DVector};
use std::ops::Deref;

/// Periodic displacement of the base of a pendulum, or of a linear system with an influence vector. It is `Re sum_k
/// amplitudes[k-1] e^{i k (frequency t + phase)}`, each amplitude of one number; with one that is real, `amplitude cos(frequency t + phase)`.
#[derive(Debug, Clone, PartialEq)]
pub struct BaseMotion(pub(super) Fourier);

impl Deref for BaseMotion {
    type Target = Fourier;

    fn deref(&self) -> &Fourier {
        &self.0
    }
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
        let harmonics = amplitudes.iter().map(|&a| DVector::from_element(1, a));
        let base = Self(Fourier::new(harmonics.collect(), frequency, phase)?);
        base.check().map(|()| base)
    }

    /// Whether its acceleration is finite.
    ///
    /// # Errors
    /// An acceleration beyond the doubles.
    pub(super) fn check(&self) -> Result<()> {
        if self.has_finite_acceleration() {
            return Ok(());
        }
        let rule = "the acceleration of the base, amplitude * frequency**2, must be finite";
        Err(Error::bad_value("frequency", self.frequency, rule))
    }

    pub(super) fn has_finite_acceleration(&self) -> bool {
        self.harmonics().all(|(w, a)| is_finite(&(a[0] * w * w)))
    }
}
