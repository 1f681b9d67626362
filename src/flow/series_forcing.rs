//! Forcing of a pendulum as a Taylor series: what shakes it enters as `Re(a e^{i(angle + w t)})`. Without forcing the series
//! compile to code that knows of none.

use crate::model::{Excitation, HarmonicPart, Links};
use nalgebra::{Complex, DVector};

/// What shakes the pendulum: the base, forces on the links, or nothing, as one factor `e^{i(angle + w t)}` whose series is
/// taken along.
pub(crate) trait SeriesForcing {
    /// The frequency w.
    fn frequency(&self) -> f64;
    /// The factor of order zero of each motion, its real parts and its imaginary ones.
    fn begin<const K: usize>(&self, angles: &[f64; K]) -> LinkPair<K> {
        let mut factor = [[0.0; K]; 2];
        for (m, angle) in angles.iter().enumerate() {
            (factor[1][m], factor[0][m]) = angle.sin_cos();
        }
        factor
    }
    /// The factor of the next order, k.
    #[inline]
    fn raise<const K: usize>(&self, [re, im]: &LinkPair<K>, k: f64) -> LinkPair<K> {
        let factor = self.frequency() / k;
        [im.map(|im| -factor * im), re.map(|re| factor * re)]
    }
    /// The base's push on two links: what is taken off `P`.
    #[inline]
    fn base<const K: usize>(&self, _factor: &LinkPair<K>, _r: usize) -> LinkPair<K> {
        [[0.0; K]; 2]
    }
    /// The forces on two links.
    #[inline]
    fn force<const K: usize>(&self, _factor: &LinkPair<K>, _r: usize) -> LinkPair<K> {
        [[0.0; K]; 2]
    }
}

/// Nothing.
pub(crate) struct NoForcing;

impl SeriesForcing for NoForcing {
    fn frequency(&self) -> f64 {
        0.0
    }
    fn begin<const K: usize>(&self, _angles: &[f64; K]) -> LinkPair<K> {
        [[0.0; K]; 2]
    }
    #[inline]
    fn raise<const K: usize>(&self, factor: &LinkPair<K>, _k: f64) -> LinkPair<K> {
        *factor
    }
}

/// A base with an acceleration.
#[derive(Debug, Clone)]
pub(crate) struct BaseForcing {
    frequency: f64,
    /// `h_i A w^2` of two links each.
    push: Vec<Two>,
}

impl SeriesForcing for BaseForcing {
    #[inline]
    fn frequency(&self) -> f64 {
        self.frequency
    }
    #[inline]
    fn base<const K: usize>(&self, factor: &LinkPair<K>, r: usize) -> LinkPair<K> {
        each(|i, m| self.push[r][i] * factor[0][m])
    }
}

/// Forces on the links.
#[derive(Debug, Clone)]
pub(crate) struct Forced {
    frequency: f64,
    /// Amplitudes of two links each, their real parts and their imaginary ones.
    amplitude: Vec<[Two; 2]>,
}

impl SeriesForcing for Forced {
    #[inline]
    fn frequency(&self) -> f64 {
        self.frequency
    }
    #[inline]
    fn force<const K: usize>(&self, factor: &LinkPair<K>, r: usize) -> LinkPair<K> {
        let [re, im] = self.amplitude[r];
        each(|i, m| re[i] * factor[0][m] - im[i] * factor[1][m])
    }
}

/// What shakes a pendulum.
#[derive(Debug, Clone)]
pub(crate) enum PendulumForcing {
    /// Nothing.
    None,
    /// The base.
    Base(BaseForcing),
    /// Forces on the links.
    Forces(Forced),
}

/// The numbers of two links, which processors handle as one.
pub(crate) type Two = [f64; 2];
/// The numbers of two links in each of K motions.
pub(crate) type LinkPair<const K: usize> = [[f64; K]; 2];

/// The numbers by link of the pair and motion.
#[allow(clippy::inline_always, reason = "the innermost loops are made of it")]
#[inline(always)]
pub(crate) fn each<const K: usize>(number: impl Fn(usize, usize) -> f64) -> LinkPair<K> {
    let mut all = [[0.0; K]; 2];
    for (i, link) in all.iter_mut().enumerate() {
        for (m, x) in link.iter_mut().enumerate() {
            *x = number(i, m);
        }
    }
    all
}

/// Numbers of each link as pairs.
pub(crate) fn paired(values: &DVector<f64>) -> Vec<Two> {
    let values = values.as_slice().chunks(2);
    values
        .map(|v| [v[0], v.get(1).copied().unwrap_or(0.0)])
        .collect()
}

impl PendulumForcing {
    /// What an excitation is to a pendulum.
    pub fn new(excitation: &Excitation, links: &Links) -> Self {
        let frequency = excitation.frequency;
        match excitation.harmonics.first() {
            None => Self::None,
            Some(HarmonicPart { base, force }) if force.is_empty() => Self::Base(BaseForcing {
                frequency,
                push: paired(&(&links.static_moment * *base)),
            }),
            Some(HarmonicPart { force, .. }) => {
                let part = |of: fn(&Complex<f64>) -> f64| paired(&force.map(|z| of(&z)));
                let (re, im) = (part(|z| z.re), part(|z| z.im));
                Self::Forces(Forced {
                    frequency,
                    amplitude: re.into_iter().zip(im).map(|(re, im)| [re, im]).collect(),
                })
            }
        }
    }
}
