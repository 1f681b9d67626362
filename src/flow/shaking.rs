//! Forcing of a pendulum as a Taylor series: what shakes it enters as `Re(a e^{i(angle + w t)})`. Without forcing the series
//! compile to code that knows of none.

use crate::model::{Forcing, Links};
use nalgebra::{Complex, DVector};

/// What shakes the pendulum: the base, forces on the links, or nothing, as one factor `e^{i(angle + w t)}` whose series is
/// taken along.
pub(crate) trait Shaking {
    /// The frequency w.
    fn frequency(&self) -> f64;
    /// The factor of order zero.
    fn begin(&self, angle: f64) -> Two {
        let (sin, cos) = angle.sin_cos();
        [cos, sin]
    }
    /// The factor of the next order, k.
    #[inline]
    fn raise(&self, [re, im]: Two, k: f64) -> Two {
        let factor = self.frequency() / k;
        [-factor * im, factor * re]
    }
    /// The base's push on two links: what is taken off `P`.
    #[inline]
    fn base(&self, _factor: Two, _r: usize) -> Two {
        [0.0; 2]
    }
    /// The forces on two links.
    #[inline]
    fn force(&self, _factor: Two, _r: usize) -> Two {
        [0.0; 2]
    }
}

/// Nothing.
pub(crate) struct Calm;

impl Shaking for Calm {
    fn frequency(&self) -> f64 {
        0.0
    }
    fn begin(&self, _angle: f64) -> Two {
        [0.0; 2]
    }
    #[inline]
    fn raise(&self, factor: Two, _k: f64) -> Two {
        factor
    }
}

/// A base with an acceleration.
#[derive(Debug, Clone)]
pub(crate) struct Shaken {
    frequency: f64,
    /// `h_i A w^2` of two links each.
    push: Vec<Two>,
}

impl Shaking for Shaken {
    #[inline]
    fn frequency(&self) -> f64 {
        self.frequency
    }
    #[inline]
    fn base(&self, factor: Two, r: usize) -> Two {
        self.push[r].map(|push| push * factor[0])
    }
}

/// Forces on the links.
#[derive(Debug, Clone)]
pub(crate) struct Forced {
    frequency: f64,
    /// Amplitudes of two links each, their real parts and their imaginary ones.
    amplitude: Vec<[Two; 2]>,
}

impl Shaking for Forced {
    #[inline]
    fn frequency(&self) -> f64 {
        self.frequency
    }
    #[inline]
    fn force(&self, factor: Two, r: usize) -> Two {
        let [re, im] = self.amplitude[r];
        std::array::from_fn(|i| re[i] * factor[0] - im[i] * factor[1])
    }
}

/// What shakes a pendulum.
#[derive(Debug, Clone)]
pub(crate) enum Excitation {
    /// Nothing.
    None,
    /// The base.
    Base(Shaken),
    /// Forces on the links.
    Forces(Forced),
}

/// The numbers of two links, which processors handle as one.
pub(crate) type Two = [f64; 2];

/// Numbers of each link as pairs.
pub(crate) fn paired(values: &DVector<f64>) -> Vec<Two> {
    let values = values.as_slice().chunks(2);
    values
        .map(|v| [v[0], v.get(1).copied().unwrap_or(0.0)])
        .collect()
}

impl Excitation {
    /// The excitation by a forcing.
    pub fn new(forcing: &Forcing, links: &Links) -> Self {
        match forcing {
            Forcing::Unforced => Self::None,
            Forcing::BaseMotion(base) => Self::Base(Shaken {
                frequency: base.frequency(),
                push: paired(&(&links.hanging * (base.amplitude() * base.frequency().powi(2)))),
            }),
            Forcing::Harmonic(force) => {
                let part =
                    |of: fn(&Complex<f64>) -> f64| paired(&force.amplitude().map(|z| of(&z)));
                let (re, im) = (part(|z| z.re), part(|z| z.im));
                Self::Forces(Forced {
                    frequency: force.frequency(),
                    amplitude: re.into_iter().zip(im).map(|(re, im)| [re, im]).collect(),
                })
            }
        }
    }
}
