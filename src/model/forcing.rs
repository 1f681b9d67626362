//! What drives a scene: a harmonic or a periodic force on the coordinates, or a base displaced by `a cos(w t + phase)`.

use crate::error::{Error, Result};
use crate::model::fourier::Fourier;
use crate::quantity::{finite, finite_complex, is_finite, positive};
use nalgebra::{Complex, DVector};
use std::f64::consts::TAU;

/// Harmonic force `Re(amplitude e^{i(frequency t + phase)})` on the coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Harmonic {
    amplitude: DVector<Complex<f64>>,
    frequency: f64,
    phase: f64,
}

impl Harmonic {
    /// A harmonic force; a real `amplitude` of shape `(n,)` is a cosine.
    ///
    /// # Errors
    /// No amplitude at all, numbers that are not finite, or a frequency that is not positive.
    pub fn new(amplitude: DVector<Complex<f64>>, frequency: f64, phase: f64) -> Result<Self> {
        if amplitude.is_empty() {
            let expected = "(n,): one number for each degree of freedom";
            return Err(Error::bad_shape("amplitude", "(0,)", expected));
        }
        finite_complex("amplitude", &amplitude)?;
        Ok(Self {
            amplitude,
            frequency: positive("frequency", frequency)?,
            phase: finite("phase", phase)?,
        })
    }

    /// The force amplitude, shape `(n,)`.
    pub fn amplitude(&self) -> &DVector<Complex<f64>> {
        &self.amplitude
    }

    /// The circular frequency \[rad/s\].
    pub fn frequency(&self) -> f64 {
        self.frequency
    }

    /// The phase \[rad\].
    pub fn phase(&self) -> f64 {
        self.phase
    }
}

/// Base displacement `amplitude cos(frequency t + phase)` of a pendulum, or of a linear system with an influence vector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaseMotion {
    amplitude: f64,
    frequency: f64,
    phase: f64,
}

impl BaseMotion {
    /// A harmonic base motion.
    ///
    /// # Errors
    /// Numbers that are not finite, or a frequency that is not positive; an acceleration of the base beyond the doubles.
    pub fn new(amplitude: f64, frequency: f64, phase: f64) -> Result<Self> {
        let base = Self {
            amplitude: finite("amplitude", amplitude)?,
            frequency: positive("frequency", frequency)?,
            phase: finite("phase", phase)?,
        };
        if Forcing::from(base).is_finite() {
            return Ok(base);
        }
        let rule = "the acceleration of the base, amplitude * frequency**2, must be finite";
        Err(Error::bad_value("frequency", frequency, rule))
    }

    /// The displacement amplitude.
    pub fn amplitude(&self) -> f64 {
        self.amplitude
    }

    /// The circular frequency \[rad/s\].
    pub fn frequency(&self) -> f64 {
        self.frequency
    }

    /// The phase \[rad\].
    pub fn phase(&self) -> f64 {
        self.phase
    }
}

/// What drives a scene.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Forcing {
    /// Nothing.
    #[default]
    Unforced,
    /// A harmonic force on the coordinates.
    Harmonic(Harmonic),
    /// A harmonic displacement of the base.
    BaseMotion(BaseMotion),
    /// A periodic force on the coordinates.
    Fourier(Fourier),
}

impl From<Harmonic> for Forcing {
    fn from(forcing: Harmonic) -> Self {
        Self::Harmonic(forcing)
    }
}

impl From<BaseMotion> for Forcing {
    fn from(forcing: BaseMotion) -> Self {
        Self::BaseMotion(forcing)
    }
}

impl From<Fourier> for Forcing {
    fn from(forcing: Fourier) -> Self {
        Self::Fourier(forcing)
    }
}

impl Forcing {
    /// The fundamental frequency, `None` without forcing.
    pub fn frequency(&self) -> Option<f64> {
        match self {
            Self::Unforced => None,
            Self::Harmonic(f) => Some(f.frequency),
            Self::BaseMotion(f) => Some(f.frequency),
            Self::Fourier(f) => Some(f.frequency()),
        }
    }

    /// Number of harmonics.
    pub(crate) fn n_harmonics(&self) -> usize {
        match self {
            Self::Unforced => 0,
            Self::Harmonic(_) | Self::BaseMotion(_) => 1,
            Self::Fourier(f) => f.n_harmonics(),
        }
    }

    /// The phase, zero without forcing.
    pub fn phase(&self) -> f64 {
        match self {
            Self::Unforced => 0.0,
            Self::Harmonic(f) => f.phase,
            Self::BaseMotion(f) => f.phase,
            Self::Fourier(f) => f.phase(),
        }
    }

    /// The period `2 pi / frequency`, `None` without forcing.
    pub fn period(&self) -> Option<f64> {
        self.frequency().map(|w| TAU / w)
    }

    /// The same forcing with another phase.
    pub(crate) fn with_phase(&self, phase: f64) -> Result<Self> {
        finite("phase", phase)?;
        Ok(match self.clone() {
            Self::Unforced => return Err(no_forcing("phase", phase)),
            Self::Harmonic(f) => Self::Harmonic(Harmonic { phase, ..f }),
            Self::BaseMotion(f) => Self::BaseMotion(BaseMotion { phase, ..f }),
            Self::Fourier(f) => Self::Fourier(f.with_phase(phase)),
        })
    }

    /// The same forcing at another frequency.
    pub(crate) fn with_frequency(&self, frequency: f64) -> Result<Self> {
        positive("frequency", frequency)?;
        Ok(match self.clone() {
            Self::Unforced => return Err(no_forcing("frequency", frequency)),
            Self::Harmonic(f) => Self::Harmonic(Harmonic { frequency, ..f }),
            Self::BaseMotion(f) => BaseMotion::new(f.amplitude, frequency, f.phase)?.into(),
            Self::Fourier(f) => Self::Fourier(f.with_frequency(frequency)),
        })
    }

    /// The same forcing with its amplitude multiplied by a number.
    pub(crate) fn scaled(&self, factor: f64) -> Result<Self> {
        finite("forcing_scale", factor)?;
        let scaled = match self.clone() {
            Self::Unforced => return Err(no_forcing("forcing_scale", factor)),
            Self::Harmonic(f) => Self::Harmonic(Harmonic {
                amplitude: f.amplitude * Complex::from(factor),
                ..f
            }),
            Self::BaseMotion(f) => Self::BaseMotion(BaseMotion {
                amplitude: f.amplitude * factor,
                ..f
            }),
            Self::Fourier(f) => Self::Fourier(f.scaled(factor)),
        };
        if scaled.is_finite() {
            return Ok(scaled);
        }
        let rule = "the amplitude times it, and the acceleration of a base, must be finite";
        Err(Error::bad_value("forcing_scale", factor, rule))
    }

    /// Whether the amplitude is finite, and for a base motion `a w^2`.
    fn is_finite(&self) -> bool {
        match self {
            Self::Unforced => true,
            Self::Harmonic(f) => f.amplitude.iter().all(is_finite),
            Self::BaseMotion(f) => (f.amplitude * f.frequency * f.frequency).is_finite(),
            Self::Fourier(f) => f.is_finite(),
        }
    }

    /// Whether its force grows with the square of the frequency.
    pub(crate) fn is_inertial(&self) -> bool {
        matches!(self, Self::BaseMotion(_))
    }
}

fn no_forcing(argument: &str, value: f64) -> Error {
    Error::bad_value(
        argument,
        value,
        "the scene has no forcing to change; give it one with `forcing`",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dvector;

    #[test]
    fn an_amplitude_beyond_the_doubles_is_refused() {
        let force = Harmonic::new(dvector![100.0.into(), 1.0.into()], 2.0, 0.0).expect("finite");
        let base = BaseMotion::new(1.0, 1e4, 0.0).expect("finite");
        for forcing in [Forcing::from(force), base.into()] {
            assert!(forcing.scaled(1e299).is_ok());
            let message = forcing.scaled(1e307).expect_err("beyond").to_string();
            assert!(
                message.starts_with("forcing_scale is 1e307, but the amplitude"),
                "{message}"
            );
        }
        let message = BaseMotion::new(1.0, 1e200, 0.0)
            .expect_err("beyond")
            .to_string();
        assert!(
            message.starts_with("frequency is 1e200, but the acceleration"),
            "{message}"
        );
        let fast = Forcing::from(base).with_frequency(1e200);
        assert_eq!(fast.expect_err("beyond").to_string(), message);
    }
}
