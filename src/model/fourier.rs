//! Periodic forces as sums of harmonics. The phase is that of the first harmonic and shifts all of them in time: the k-th turns by k times
//! it. What harmonics differ by is in their complex amplitudes. How a phase reaches the motion: `excitation.rs`.

use crate::error::{Error, Result};
use crate::quantity::{at_least_one, finite, finite_complex, finite_vector, is_finite, positive};
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::TAU;

/// Periodic force `mean + Re(sum_k amplitudes[k-1] exp(i k (frequency t + phase)))` on the coordinates, k = 1 to K.
#[derive(Debug, Clone, PartialEq)]
pub struct Fourier {
    amplitudes: Vec<DVector<Complex<f64>>>,
    mean: Option<DVector<f64>>,
    pub(super) frequency: f64,
    pub(super) phase: f64,
}

impl Fourier {
    /// A periodic force from the amplitudes of its harmonics, K of them, each of shape `(n,)`.
    ///
    /// # Errors
    /// No harmonic, amplitudes of different lengths or of none, numbers that are not finite, or a frequency that is not positive.
    ///
    /// # Examples
    /// ```
    /// use nalgebra::{Complex, dvector};
    /// use vibroimpact::Fourier;
    /// // 2 cos t + sin 2 t
    /// let amplitudes = vec![dvector![Complex::new(2.0, 0.0)], dvector![Complex::new(0.0, -1.0)]];
    /// let force = Fourier::new(amplitudes, 1.0, 0.0)?;
    /// assert_eq!(force.n_harmonics(), 2);
    /// # Ok::<(), vibroimpact::Error>(())
    /// ```
    pub fn new(amplitudes: Vec<DVector<Complex<f64>>>, frequency: f64, phase: f64) -> Result<Self> {
        let n = amplitudes.first().map_or(0, DVector::len);
        if n == 0 {
            let found = format!("({}, {n})", amplitudes.len());
            let expected = "(K, n): K harmonics, one number for each degree of freedom";
            return Err(Error::bad_shape("amplitudes", found, expected));
        }
        for (k, amplitude) in amplitudes.iter().enumerate() {
            if amplitude.len() != n {
                let found = format!("({},)", amplitude.len());
                let argument = format!("amplitudes[{k}]");
                return Err(Error::bad_shape(argument, found, format!("({n},)")));
            }
            finite_complex(&format!("amplitudes[{k}]"), amplitude)?;
        }
        Ok(Self {
            amplitudes,
            mean: None,
            frequency: positive("frequency", frequency)?,
            phase: finite("phase", phase)?,
        })
    }

    /// The same force about a constant one, shape `(n,)`.
    ///
    /// # Errors
    /// Another length, numbers that are not finite.
    pub fn with_mean(self, mean: DVector<f64>) -> Result<Self> {
        finite_vector("mean", &mean, self.n_dof())?;
        let mean = Some(mean);
        Ok(Self { mean, ..self })
    }

    /// The force whose first harmonics, and whose mean, are those of samples over one period: shape `(m, n)`, equally spaced, the first
    /// at t = 0. It goes through the samples where they have no other harmonics.
    ///
    /// # Errors
    /// No harmonic, fewer than `2 n_harmonics + 1` samples, numbers that are not finite, a frequency that is not positive.
    pub fn fit(samples: &DMatrix<f64>, frequency: f64, n_harmonics: usize) -> Result<Self> {
        let (m, n) = samples.shape();
        at_least_one("n_harmonics", n_harmonics)?;
        if m <= 2 * n_harmonics {
            let rule = format!(
                "{m} samples tell at most {} harmonics",
                m.saturating_sub(1) / 2
            );
            return Err(Error::bad_value("n_harmonics", n_harmonics, rule));
        }
        if let Some(x) = samples.iter().find(|x| !x.is_finite()) {
            return Err(Error::bad_value("samples", x, "they must be finite"));
        }
        let amplitude = |k: usize| {
            DVector::from_fn(n, |i, _| {
                let turned = |j: usize| {
                    // The turn is that of a whole number of samples: reduced, it has all its digits.
                    let angle = TAU * ((k * j) % m) as f64 / m as f64;
                    Complex::cis(-angle) * samples[(j, i)]
                };
                (0..m).map(turned).sum::<Complex<f64>>() * (2.0 / m as f64)
            })
        };
        let mean = DVector::from_fn(n, |i, _| samples.column(i).sum() / m as f64);
        Self::new((1..=n_harmonics).map(amplitude).collect(), frequency, 0.0)?.with_mean(mean)
    }

    /// The amplitudes of the harmonics, the first that of the frequency itself, shape `(n,)` each.
    pub fn amplitudes(&self) -> &[DVector<Complex<f64>>] {
        &self.amplitudes
    }

    /// Number of harmonics.
    pub fn n_harmonics(&self) -> usize {
        self.amplitudes.len()
    }

    /// Number of coordinates it acts on.
    pub fn n_dof(&self) -> usize {
        self.amplitudes[0].len()
    }

    /// The constant part, shape `(n,)`; `None` without.
    pub fn mean(&self) -> Option<&DVector<f64>> {
        self.mean.as_ref()
    }

    /// The circular frequency of the first harmonic \[rad/s\].
    pub fn frequency(&self) -> f64 {
        self.frequency
    }

    /// The phase of the first harmonic \[rad\].
    pub fn phase(&self) -> f64 {
        self.phase
    }

    /// The harmonics with their frequencies.
    pub(super) fn harmonics(&self) -> impl Iterator<Item = (f64, &DVector<Complex<f64>>)> {
        let frequencies = (1..).map(|k: u32| f64::from(k) * self.frequency);
        frequencies.zip(&self.amplitudes)
    }

    /// Multiplies it by a number, its mean too.
    pub(super) fn scale(&mut self, factor: f64) {
        for amplitude in &mut self.amplitudes {
            *amplitude *= Complex::from(factor);
        }
        if let Some(mean) = &mut self.mean {
            *mean *= factor;
        }
    }

    pub(super) fn is_finite(&self) -> bool {
        let mut mean = self.mean.iter().flatten();
        self.amplitudes.iter().flatten().all(is_finite) && mean.all(|x| x.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{dmatrix, dvector};

    #[test]
    fn samples_of_a_sum_of_harmonics_give_it_back() {
        let force = |t: f64| 0.3 + 2.0 * (t + 0.4).cos() - 0.7 * (3.0 * t).sin();
        for m in [7, 8, 50] {
            let samples = DMatrix::from_fn(m, 1, |j, _| force(TAU * j as f64 / m as f64));
            let fitted = Fourier::fit(&samples, 1.7, 3).expect("enough samples");
            let expected = [
                Complex::from_polar(2.0, 0.4),
                0.0.into(),
                Complex::new(0.0, 0.7),
            ];
            for (a, b) in fitted.amplitudes().iter().zip(expected) {
                assert!((a[0] - b).norm() < 1e-14, "{m}: {} {b}", a[0]);
            }
            assert!((fitted.mean().expect("one")[0] - 0.3).abs() < 1e-15);
            assert_eq!((fitted.frequency(), fitted.phase()), (1.7, 0.0));
        }
        // The highest harmonic that m samples tell needs m > 2 k.
        let message = Fourier::fit(&dmatrix![1.0; 2.0; 3.0; 4.0], 1.0, 2).expect_err("too few");
        let expected = "n_harmonics is 2, but 4 samples tell at most 1 harmonics";
        assert!(message.to_string().starts_with(expected), "{message}");
    }

    #[test]
    fn what_is_no_force_is_refused() {
        let one = || dvector![Complex::new(1.0, 0.0)];
        let refused = [
            Fourier::new(vec![], 1.0, 0.0),
            Fourier::new(vec![dvector![]], 1.0, 0.0),
            Fourier::new(vec![one(), dvector![]], 1.0, 0.0),
            Fourier::new(vec![one() * Complex::from(f64::NAN)], 1.0, 0.0),
            Fourier::new(vec![one()], 0.0, 0.0),
            Fourier::new(vec![one()], 1.0, f64::INFINITY),
            Fourier::new(vec![one()], 1.0, 0.0).and_then(|f| f.with_mean(dvector![1.0, 2.0])),
            Fourier::fit(&DMatrix::zeros(9, 1), 1.0, 0),
            Fourier::fit(&DMatrix::from_element(9, 1, f64::NAN), 1.0, 2),
        ];
        for (k, force) in refused.into_iter().enumerate() {
            assert!(force.is_err(), "{k}");
        }
    }
}
