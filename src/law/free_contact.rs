//! One contact of a free body with a spring, a dashpot and a preload, nothing else acting, in closed form: how long it lasts and what speed it
//! leaves (theory 22).

use crate::law::contact_law::LinearForce;
use crate::law::contact_release::ContactRelease;
use crate::root::{Bracket, bisected};
use std::convert::Infallible;
use std::f64::consts::PI;

/// Coefficients of a motion over a short time. [work]
const SERIES_TERMS: usize = 24;
/// Doublings of a time within which something happens. [work]
const MOST_DOUBLINGS: usize = 2000;

/// The restitution of a damping ratio `c/(2 sqrt(k m))` without preload.
pub(super) fn restitution_of(ratio: f64, release: ContactRelease) -> f64 {
    let distance = ((1.0 - ratio).abs() * (1.0 + ratio)).sqrt();
    let exponent = match release {
        ContactRelease::Gap if ratio >= 1.0 => f64::INFINITY,
        ContactRelease::Gap => PI * ratio / distance,
        _ if ratio.is_infinite() => f64::INFINITY,
        _ if distance == 0.0 => 2.0,
        _ if ratio < 1.0 => 2.0 * ratio * distance.atan2(ratio) / distance,
        _ => 2.0 * ratio * distance.asinh() / distance,
    };
    (-exponent).exp()
}

/// The damping ratio of a restitution, the least that takes all speed for 0.
pub(super) fn damping_ratio(restitution: f64, release: ContactRelease) -> f64 {
    let fall = -restitution.ln();
    if release == ContactRelease::Gap {
        return if fall.is_infinite() {
            1.0
        } else {
            fall / PI.hypot(fall)
        };
    }
    // Restitution falls with the ratio, to 1/(4 ratio^2).
    let all = Bracket::new([0.0, 1.0 / restitution.sqrt()]);
    let Ok(found) = bisected(all, 0.0, |ratio| {
        Ok::<_, Infallible>(restitution_of(ratio, release) > restitution)
    });
    found.middle()
}

/// How a contact ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct FreeContactEnd {
    #[cfg_attr(not(test), expect(dead_code, reason = "asked for by tests"))]
    pub duration: f64,
    /// The speed away from the stop.
    pub departure: f64,
}

/// A free body from the beginning of its contact on: `p'' + 2 d p' + w^2 p + a = 0`, p = 0, p' = v > 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct FreeContact {
    /// d \[1/s\].
    decay: f64,
    /// w^2 \[1/s^2\].
    square: f64,
    /// a, of the preload \[m/s^2\].
    push: f64,
    speed: f64,
}

impl FreeContact {
    pub fn new(force: LinearForce, mass: f64, speed: f64) -> Self {
        Self {
            decay: 0.5 * force.damping / mass,
            square: force.stiffness / mass,
            push: force.preload / mass,
            speed,
        }
    }

    /// The end of a contact with a preload.
    pub fn end(&self, release: ContactRelease) -> FreeContactEnd {
        let natural = (self.square.sqrt() + self.decay + self.push / self.speed).recip();
        let turn = first(|t| self.at(t)[1] > 0.0, [0.0, natural]);
        // Behind the deepest place the body goes back all the way, as the preload pushes it there, and so long the force falls.
        let mut duration = first(|t| self.at(t)[0] > 0.0, [turn, 2.0 * turn]);
        if release != ContactRelease::Gap && self.at(duration)[2] < 0.0 {
            duration = first(|t| self.at(t)[2] > 0.0, [turn, duration]);
        }
        FreeContactEnd {
            duration,
            departure: -self.at(duration)[1],
        }
    }

    /// Approach, its rate, and the force over the mass after a time.
    fn at(&self, t: f64) -> [f64; 3] {
        let [rest, unit, rate] = self.responses(t);
        let p = self.speed * unit - self.push * rest;
        let v = self.speed * rate - self.push * unit;
        [p, v, self.square * p + 2.0 * self.decay * v + self.push]
    }

    /// H, G and G' after a time: the response G to a unit impulse, its integral and its rate.
    fn responses(&self, t: f64) -> [f64; 3] {
        let (d, s) = (self.decay, self.square);
        if (s.sqrt() + d) * t < 0.5 {
            return self.short_responses(t);
        }
        let under = (s.sqrt() - d) * (s.sqrt() + d);
        let [unit, rate] = if under > 0.0 {
            let (fade, (sin, cos)) = ((-d * t).exp(), (under.sqrt() * t).sin_cos());
            let unit = fade * sin / under.sqrt();
            [unit, fade * cos - d * unit]
        } else {
            // By the two real roots, the slow one without cancellation.
            let apart = (-under).sqrt();
            let (slow, fast) = (-s / (d + apart), -d - apart);
            let (fade, y) = ((slow * t).exp(), (slow - fast) * t);
            let unit = fade * if y == 0.0 { t } else { -(-y).exp_m1() / y * t };
            [unit, fade + fast * unit]
        };
        let rest = if s > 0.0 {
            (1.0 - rate - 2.0 * d * unit) / s
        } else {
            (t - unit) / (2.0 * d)
        };
        [rest, unit, rate]
    }

    /// The same by a power series, of a time short beside all of the motion.
    fn short_responses(&self, t: f64) -> [f64; 3] {
        // Terms g_n t^n of G; those of H are t g_n t^n/(n + 1), those of G' n g_n t^n/t.
        let (mut last, mut term) = (0.0, t);
        let mut sums = [0.0; 3];
        for n in 1..SERIES_TERMS {
            let order = n as f64;
            sums[0] += term * t / (order + 1.0);
            sums[1] += term;
            sums[2] += order * term;
            let next = -(2.0 * self.decay * t * order * term + self.square * t * t * last)
                / ((order + 1.0) * order);
            (last, term) = (term, next);
        }
        if t > 0.0 {
            sums[2] /= t;
        } else {
            sums[2] = 1.0;
        }
        sums
    }
}

/// The first time at which something no longer holds that holds at the first of two, beyond the second if need be.
fn first(holds: impl Fn(f64) -> bool, [from, mut to]: [f64; 2]) -> f64 {
    for _ in 0..MOST_DOUBLINGS {
        if !holds(to) {
            break;
        }
        to = from + 2.0 * (to - from);
    }
    let Ok(found) = bisected(Bracket::new([from, to]), 0.0, |t| {
        Ok::<_, Infallible>(holds(t))
    });
    found.after
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_preloaded_contact_lasts_as_long_as_the_reference_says() {
        let force = LinearForce {
            stiffness: 4.0,
            damping: 0.6,
            preload: 0.3,
        };
        let end = FreeContact::new(force, 2.0, 1.5).end(ContactRelease::Gap);
        assert!((end.duration - 2.116_387_068_268_05).abs() < 1e-13);
    }

    #[test]
    fn responses_agree_where_their_forms_meet() {
        for (decay, square) in [(0.3, 4.0), (2.0, 4.0), (5.0, 4.0), (1.0, 0.0), (0.0, 9.0)] {
            let contact = FreeContact {
                decay,
                square,
                push: 0.0,
                speed: 1.0,
            };
            let t = 0.5 / (square.sqrt() + decay);
            let [short, long] = [contact.short_responses(t), contact.responses(t)];
            for (one, other) in short.iter().zip(long) {
                assert!(
                    (one / other - 1.0).abs() < 1e-13,
                    "{decay} {short:?} {long:?}"
                );
            }
        }
    }
}
