//! The first contact along a Taylor series: the gap is a polynomial, and each part of the step is proved by the cubic about its
//! start, with all higher terms in the remainder (theory 8).

use crate::contact::ahead::{Ahead, from_contact, from_open};
use crate::contact::walk::{DEEPEST, ROUNDING};
use crate::flow::jet::Jet;
use crate::flow::taylor::{PendulumSeries, ROWS};
use crate::model::Surface;

/// A gap that moves by less than this part of its margin is at rest.
const AT_REST: f64 = 0.1;
/// Newton steps on one root.
const MOST_POLISHES: usize = 20;

/// `sum c_k t^k`, a gap along a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GapSeries {
    c: [f64; ROWS],
    len: usize,
    /// Size of the terms of the gap at the start.
    pub size: f64,
}

/// What ended a search along one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Course {
    /// The stop is reached at a time, to rounding; before the start, if the gap began within its margin below zero.
    Contact { at: f64 },
    /// No part of the step was short enough to tell contact from none.
    Stalled { at: f64 },
}

impl Course {
    /// The time of the end.
    pub fn at(self) -> f64 {
        match self {
            Self::Contact { at } | Self::Stalled { at } => at,
        }
    }
}

impl GapSeries {
    /// The gap of a surface along a series, `None` for one that has no series.
    pub fn new(surface: &Surface, series: &PendulumSeries) -> Option<Self> {
        let len = series.order() + 2;
        let mut c = [0.0; ROWS];
        let size = match surface {
            Surface::Plane { normal, clearance } => {
                for (i, n) in normal.iter().enumerate().filter(|(_, n)| **n != 0.0) {
                    for (k, c) in c[..len].iter_mut().enumerate() {
                        *c -= n * series.angle(i, k);
                    }
                }
                let terms = normal.iter().enumerate();
                let size = terms.map(|(i, n)| (n * series.angle(i, 0)).abs());
                c[0] += clearance;
                size.sum::<f64>() + clearance.abs()
            }
            Surface::Wall {
                lengths,
                position,
                sign,
            } => {
                for (i, l) in lengths.iter().enumerate() {
                    for (k, c) in c[..len].iter_mut().enumerate() {
                        *c -= sign * l * series.sine(i, k);
                    }
                }
                let terms = lengths.iter().enumerate();
                let size = terms.map(|(i, l)| (l * series.sine(i, 0)).abs());
                c[0] += sign * position;
                size.sum::<f64>() + position.abs()
            }
            Surface::Nonlinear(_) => return None,
        };
        Some(Self { c, len, size })
    }

    /// A gap by its coefficients.
    #[cfg(test)]
    fn of(coefficients: &[f64], size: f64) -> Self {
        let mut c = [0.0; ROWS];
        c[..coefficients.len()].copy_from_slice(coefficients);
        let len = coefficients.len();
        Self { c, len, size }
    }

    /// The cubic about the start with a bound on the rest for times up to `span`. The bound is of the form
    /// `a t^4 + b t^5`, and so are those on the first two derivatives: `k (k - 1) t^(k - 2) <= 20 t^3 (k (k - 1)/20) span^(k - 5)`.
    fn jet(&self, span: f64) -> Jet {
        let c = &self.c[..self.len];
        let mut power = 1.0;
        let mut quintic = 0.0;
        for (k, c) in c.iter().enumerate().skip(5) {
            quintic += c.abs() * power * (k * (k - 1)) as f64 * 0.05;
            power *= span;
        }
        Jet {
            c: [c[0], c[1], c[2], c[3]],
            quartic: c.get(4).map_or(0.0, |c| c.abs()),
            quintic,
            size: self.size,
        }
    }

    /// Makes a later time the start.
    fn advance(&mut self, t: f64) {
        for first in 0..self.len - 1 {
            for k in (first..self.len - 1).rev() {
                self.c[k] += t * self.c[k + 1];
            }
        }
    }

    /// The root near a time at which the gap falls, a root of the given order at the start divided out.
    fn root(&self, order: usize, guess: f64) -> f64 {
        let c = &self.c[order..self.len];
        let mut t = guess;
        for _ in 0..MOST_POLISHES {
            let (value, slope) = c.iter().rev().fold((0.0, 0.0), |(value, slope), c| {
                (value * t + c, slope * t + value)
            });
            let step = -value / slope;
            if !step.is_finite() {
                break;
            }
            t += step;
            if step.abs() <= 2.0 * f64::EPSILON * t.abs() {
                break;
            }
        }
        t
    }

    /// The first contact within a span; `order` is that of the root at the start, zero for an open gap. Touches within the
    /// margin before it are noted, as time and gap.
    pub fn first_contact(
        mut self,
        order: usize,
        span: f64,
        margin: f64,
        touches: &mut Vec<(f64, f64)>,
    ) -> Option<Course> {
        let shortest = span * 0.5f64.powi(DEEPEST as i32);
        let (mut order, mut at, mut step) = (order.min(3), 0.0, span);
        loop {
            step = step.min(span - at);
            let jet = self.jet(step);
            let ahead = if order > 0 {
                from_contact(&jet, order, step)
            } else {
                from_open(&jet, step, margin)
            };
            match ahead {
                Ahead::Clear => {}
                Ahead::Touch { at: inside, gap } => touches.push((at + inside, gap)),
                Ahead::Reached { at: guess } => {
                    let at = at + self.root(order, guess);
                    return Some(Course::Contact { at });
                }
                Ahead::Unknown
                    if order == 0
                        && jet.spread(step) <= AT_REST * margin.max(ROUNDING * jet.size) =>
                {
                    let is_noted = touches.last().is_some_and(|(t, _)| *t >= at - step);
                    if jet.c[0] <= margin && !is_noted {
                        touches.push((at, jet.c[0]));
                    }
                }
                Ahead::Unknown if step <= shortest => return Some(Course::Stalled { at }),
                Ahead::Unknown => {
                    step *= 0.5;
                    continue;
                }
            }
            at += step;
            if at >= span {
                return None;
            }
            self.advance(step);
            order = 0;
            step *= 2.0;
        }
    }
}
