//! The change of a gap [m] by the stop's own motion, with its time derivatives (theory 12).

use crate::model::moment::Moment;
use crate::model::rotations::Rotations;
use crate::model::signal::Signal;
use nalgebra::Complex;

/// Divisor of the remainder of a quintic through value, slope and curvature at both ends of a step h: half-way it is at most
/// `h^6 |c^(6)|/46080`. [exact]
const QUINTIC_REMAINDER: f64 = 46080.0;

/// The longest step along which the quintic through value, slope and curvature at both ends of what has a sixth derivative of a size is off by
/// no more than an error.
pub(crate) fn quintic_step(allowed: f64, sixth: f64) -> f64 {
    (QUINTIC_REMAINDER * allowed / sixth).powf(1.0 / 6.0)
}

/// `c(t) = mean + Re sum_k c_k u_k(t) + sum_j s_j(t)`, by the phasors of an excitation.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct GapMotion {
    pub mean: f64,
    pub rotations: Rotations,
    /// By rotations, zero from where none follow.
    pub amplitudes: Vec<Complex<f64>>,
    /// The signal that it follows with its number in the excitation, if any, and the factor on it.
    pub signal: Option<(usize, Signal)>,
}

impl GapMotion {
    /// The derivative of an order, 0 that of the motion itself without its mean, and the size of its terms.
    pub fn derivative(&self, at: Moment, order: usize) -> (f64, f64) {
        let [found] = self.derivatives(at, order);
        found
    }

    /// The derivatives of N orders from `first` on, from one evaluation of the phasors.
    fn derivatives<const N: usize>(&self, at: Moment, first: usize) -> [(f64, f64); N] {
        let mut all = [(0.0, 0.0); N];
        let turning = self.rotations.phasors(at).zip(self.rotations.frequencies());
        for (a, (u, w)) in self.amplitudes.iter().zip(turning) {
            if *a == Complex::default() {
                continue;
            }
            let mut power: f64 = std::iter::repeat_n(w, first).product();
            for (order, (sum, size)) in (first..).zip(&mut all) {
                let turned = match order % 4 {
                    0 => u,
                    1 => Complex::new(-u.im, u.re),
                    2 => -u,
                    _ => Complex::new(u.im, -u.re),
                };
                *sum += (a * turned).re * power;
                *size += a.norm() * power;
                power *= w;
            }
        }
        if let Some((_, signal)) = &self.signal {
            signal.derivatives(at.since, at.time, |m, x| {
                let place = m.checked_sub(first).and_then(|place| all.get_mut(place));
                if let Some((sum, size)) = place {
                    *sum += x;
                    *size += x.abs();
                }
            });
        }
        all
    }

    /// Value, with the mean, speed and acceleration.
    pub fn along(&self, at: Moment) -> [f64; 3] {
        self.along_with_size(at).0
    }

    /// The same, and the size of the terms of the value, at most.
    pub fn along_with_size(&self, at: Moment) -> ([f64; 3], f64) {
        let [(value, size), (speed, _), (acceleration, _)] = self.derivatives(at, 0);
        (
            [self.mean + value, speed, acceleration],
            self.mean.abs() + size,
        )
    }

    /// The value at a time by itself, with the mean: where a signal ends, that of its last piece.
    pub fn value_at(&self, at: Moment) -> f64 {
        let end = self.signal.as_ref().map(|(_, signal)| signal.span().1);
        let since = if end == Some(at.time) {
            at.time.next_down()
        } else {
            at.since
        };
        self.along(Moment { since, ..at })[0]
    }

    /// The longest step along which the quintic through value, slope and curvature at both ends is off by no more than an error; infinite
    /// where it does not turn.
    pub fn quintic_step(&self, allowed: f64) -> f64 {
        let turning = self.amplitudes.iter().zip(self.rotations.frequencies());
        let sixth: f64 = turning.map(|(a, w)| a.norm() * w.powi(6)).sum();
        quintic_step(allowed, sixth)
    }

    /// The largest that it adds by turning.
    pub fn amplitude(&self) -> f64 {
        self.amplitudes.iter().map(|a| a.norm()).sum()
    }

    /// The largest that the motion is, at most.
    pub fn reach(&self) -> f64 {
        let signal = self.signal.as_ref();
        let followed = signal.map_or(0.0, |(_, signal)| signal.largest()[0]);
        self.mean.abs() + self.amplitude() + followed
    }

    /// A bound on the size of its acceleration in a time after a moment.
    pub fn bend_bound(&self, at: Moment, span: f64) -> f64 {
        let turning = self.amplitudes.iter().zip(self.rotations.frequencies());
        let turning: f64 = turning.map(|(a, w)| a.norm() * w * w).sum();
        let mut derivatives = Vec::new();
        if let Some((_, signal)) = &self.signal {
            signal.derivatives(at.since, at.time, |m, x| {
                if m >= 2 {
                    derivatives.push(x.abs());
                }
            });
        }
        turning + crate::model::signal::taylor(&derivatives, span)
    }
}
