//! Forcing of a pendulum as a Taylor series: one harmonic enters as `Re(a e^{i(angle + w t)})`, anything else by coefficients made
//! beforehand. Without forcing the series compile to code that knows of none.

use crate::model::{Excitation, HarmonicPart, Links, Moment};
use nalgebra::{Complex, DVector};

/// The forcing of K motions of a pendulum: of its base, of its links, or none, by a factor whose series is made along with them.
pub(crate) trait SeriesForcing<const K: usize> {
    type Factor;

    /// The factor of order zero of each motion, from the angles of the forcing.
    fn begin(&self, angles: &[f64; K]) -> Self::Factor;
    /// The factor of the next order, k.
    fn raise(&self, factor: &Self::Factor, k: f64) -> Self::Factor;
    /// The base's push on two links: what is taken off `P`.
    #[inline]
    fn base(&self, _factor: &Self::Factor, _r: usize) -> LinkPair<K> {
        [[0.0; K]; 2]
    }
    /// The forces on two links.
    #[inline]
    fn force(&self, _factor: &Self::Factor, _r: usize) -> LinkPair<K> {
        [[0.0; K]; 2]
    }
}

/// `e^{i(angle + w t)}` of order zero, its real parts and its imaginary ones.
#[inline]
fn phasors<const K: usize>(angles: &[f64; K]) -> LinkPair<K> {
    let mut factor = [[0.0; K]; 2];
    for (m, angle) in angles.iter().enumerate() {
        (factor[1][m], factor[0][m]) = angle.sin_cos();
    }
    factor
}

/// The same of the next order, k.
#[inline]
fn raised<const K: usize>([re, im]: &LinkPair<K>, frequency: f64, k: f64) -> LinkPair<K> {
    let factor = frequency / k;
    [im.map(|im| -factor * im), re.map(|re| factor * re)]
}

/// No forcing.
pub(crate) struct NoForcing;

impl<const K: usize> SeriesForcing<K> for NoForcing {
    type Factor = ();

    #[inline]
    fn begin(&self, _angles: &[f64; K]) {}
    #[inline]
    fn raise(&self, (): &(), _k: f64) {}
}

/// A base that is moved by a cosine.
#[derive(Debug, Clone)]
pub(crate) struct BaseForcing {
    frequency: f64,
    /// `h_i A w^2` of two links each.
    push: Vec<Two>,
}

impl<const K: usize> SeriesForcing<K> for BaseForcing {
    type Factor = LinkPair<K>;

    #[inline]
    fn begin(&self, angles: &[f64; K]) -> LinkPair<K> {
        phasors(angles)
    }
    #[inline]
    fn raise(&self, factor: &LinkPair<K>, k: f64) -> LinkPair<K> {
        raised(factor, self.frequency, k)
    }
    #[inline]
    fn base(&self, factor: &LinkPair<K>, r: usize) -> LinkPair<K> {
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

impl<const K: usize> SeriesForcing<K> for Forced {
    type Factor = LinkPair<K>;

    #[inline]
    fn begin(&self, angles: &[f64; K]) -> LinkPair<K> {
        phasors(angles)
    }
    #[inline]
    fn raise(&self, factor: &LinkPair<K>, k: f64) -> LinkPair<K> {
        raised(factor, self.frequency, k)
    }
    #[inline]
    fn force(&self, factor: &LinkPair<K>, r: usize) -> LinkPair<K> {
        let [re, im] = self.amplitude[r];
        each(|i, m| re[i] * factor[0][m] - im[i] * factor[1][m])
    }
}

/// Anything: several harmonics, tones, signals, of the base and of forces, by series that are made where those of the motion begin.
#[derive(Debug, Clone)]
pub(crate) struct AnyForcing {
    excitation: Excitation,
    /// `h_i` of two links each.
    push: Vec<Two>,
    has_forces: bool,
}

/// The Taylor coefficients of the forcing of K motions.
#[derive(Debug, Clone, Default)]
pub(crate) struct ShakenSeries<const K: usize> {
    /// Of the acceleration of the base, by orders.
    base: Vec<[f64; K]>,
    /// Of the forces by orders, for each by pairs of links; empty without any.
    forces: Vec<Vec<LinkPair<K>>>,
}

impl AnyForcing {
    /// Makes the coefficients of the m-th motion up to an order.
    pub fn begin<const K: usize>(
        &self,
        series: &mut ShakenSeries<K>,
        m: usize,
        (at, order): (Moment, usize),
    ) {
        let Excitation {
            harmonics,
            rotations,
            signals,
            ..
        } = &self.excitation;
        let n_forced = if self.has_forces { self.push.len() } else { 0 };
        series.base.resize(order + 1, [0.0; K]);
        (series.forces).resize(order + 1, vec![[[0.0; K]; 2]; n_forced]);
        for (base, forces) in series.base.iter_mut().zip(&mut series.forces) {
            base[m] = 0.0;
            for pair in forces {
                (pair[0][m], pair[1][m]) = (0.0, 0.0);
            }
        }
        for (i, f) in self.excitation.load.iter().enumerate() {
            series.forces[0][i / 2][i % 2][m] = *f;
        }
        let mut add = |k: usize, base: f64, force: &mut dyn Iterator<Item = f64>| {
            series.base[k][m] += base;
            for (i, f) in force.enumerate() {
                series.forces[k][i / 2][i % 2][m] += f;
            }
        };
        let turning = rotations.frequencies().zip(rotations.phasors(at));
        for (part, (w, u)) in harmonics.iter().zip(turning) {
            let mut factor = u;
            for k in 0..=order {
                let mut force = part.force.iter().map(|f| (f * factor).re);
                add(k, (part.base * factor).re, &mut force);
                factor *= Complex::new(0.0, w / (k + 1) as f64);
            }
        }
        for part in signals {
            let mut factorial = 1.0;
            part.signal.derivatives(at.since, at.time, |k, x| {
                factorial *= k.max(1) as f64;
                if k <= order {
                    let x = x / factorial;
                    add(k, part.base * x, &mut part.force.iter().map(|f| f * x));
                }
            });
        }
    }
}

/// Any forcing of K motions, by its Taylor coefficients.
pub(crate) struct Shaken<'s, const K: usize> {
    pub forcing: &'s AnyForcing,
    pub series: &'s ShakenSeries<K>,
}

impl<const K: usize> SeriesForcing<K> for Shaken<'_, K> {
    /// The order.
    type Factor = usize;

    fn begin(&self, _angles: &[f64; K]) -> usize {
        0
    }
    fn raise(&self, order: &usize, _k: f64) -> usize {
        order + 1
    }
    fn base(&self, order: &usize, r: usize) -> LinkPair<K> {
        each(|i, m| self.forcing.push[r][i] * self.series.base[*order][m])
    }
    fn force(&self, order: &usize, r: usize) -> LinkPair<K> {
        let none = [[0.0; K]; 2];
        self.series.forces[*order].get(r).copied().unwrap_or(none)
    }
}

/// The forcing of a pendulum.
#[derive(Debug, Clone)]
pub(crate) enum PendulumForcing {
    /// Nothing.
    None,
    /// The base, by a cosine.
    Base(BaseForcing),
    /// Harmonic forces on the links.
    Forces(Forced),
    /// Anything else.
    Any(Box<AnyForcing>),
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
    /// The simplest form of an excitation of a pendulum.
    pub fn new(excitation: &Excitation, links: &Links) -> Self {
        let Excitation {
            harmonics,
            rotations,
            signals,
            load,
            ..
        } = excitation;
        let frequency = rotations.fundamental;
        let is_simple = signals.is_empty() && load.is_empty() && rotations.tones.is_empty();
        match &harmonics[..] {
            [] if is_simple => Self::None,
            [HarmonicPart { base, force }] if is_simple && force.is_empty() && base.im == 0.0 => {
                Self::Base(BaseForcing {
                    frequency,
                    push: paired(&(&links.static_moment * base.re)),
                })
            }
            [HarmonicPart { base, force }] if is_simple && *base == Complex::default() => {
                let part = |of: fn(&Complex<f64>) -> f64| paired(&force.map(|z| of(&z)));
                let (re, im) = (part(|z| z.re), part(|z| z.im));
                Self::Forces(Forced {
                    frequency,
                    amplitude: re.into_iter().zip(im).map(|(re, im)| [re, im]).collect(),
                })
            }
            _ => {
                let mut forces = harmonics.iter().map(HarmonicPart::is_force);
                let has_forces = forces.any(|acts| acts)
                    || !load.is_empty()
                    || signals.iter().any(|part| !part.force.is_empty());
                Self::Any(Box::new(AnyForcing {
                    excitation: excitation.clone(),
                    push: paired(&links.static_moment),
                    has_forces,
                }))
            }
        }
    }
}
