//! The first contact along a Taylor series: the gap is a polynomial, and each part of the step is proved by the cubic about its
//! start, with all higher terms in the remainder (theory 8).

use crate::event::first_root::FirstRoot;
use crate::event::gap_verdict::{GapVerdict, from_contact, from_open};

use crate::event::touch::Bottom;
use crate::flow::BatchMotion;
use crate::flow::gap_model::GapModel;
use crate::flow::taylor::ROWS;
use crate::model::Surface;
use crate::root::{Bracket, NewtonPoint, newton};
use crate::tolerance::{GAP_ROUNDING, SHORTEST_SERIES_PART, TERM_ROUNDINGS};
use std::convert::Infallible;

/// Samples of a step between which the lowest gap is sought. [work]
const LOWEST_SAMPLES: usize = 32;
/// Newton steps towards one root or minimum, bisections among them. [work]
const MOST_SERIES_POLISHES: usize = 60;

/// `k (k - 1)/20`: what a term of order k adds to the bound of fifth order on the second derivative. [exact]
const BOUND_GROWTH: [f64; ROWS] = {
    let mut all = [0.0; ROWS];
    let mut k = 1;
    while k < ROWS {
        all[k] = (k * (k - 1)) as f64 * 0.05;
        k += 1;
    }
    all
};

/// `sum c_k t^k`, a gap along a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GapSeries {
    c: [f64; ROWS],
    len: usize,
    /// Size of the terms of the gap at the start.
    pub size: f64,
}

/// What a gap is made of: `constant - sum weight_i x_i` over angles of links or their sines.
#[derive(Debug, Clone)]
pub(crate) struct GapTerms {
    constant: f64,
    of: Term,
    weights: Vec<(usize, f64)>,
}

#[derive(Debug, Clone, Copy)]
enum Term {
    Angle,
    Sine,
}

impl GapTerms {
    /// The terms of a surface's gap, `None` where it has no series.
    pub fn new(surface: &Surface) -> Option<Self> {
        let weights = |weights: &mut dyn Iterator<Item = f64>| {
            let all = weights.enumerate();
            all.filter(|(_, weight)| *weight != 0.0).collect()
        };
        Some(match surface {
            Surface::Plane { normal, clearance } => Self {
                constant: *clearance,
                of: Term::Angle,
                weights: weights(&mut normal.iter().copied()),
            },
            Surface::Wall {
                lengths,
                position,
                sign,
            } => Self {
                constant: sign * position,
                of: Term::Sine,
                weights: weights(&mut lengths.iter().map(|l| sign * l)),
            },
            Surface::Nonlinear(_) => return None,
        })
    }

    /// The sum of the lengths whose sines it has, none of angles.
    pub fn reach(&self) -> Option<f64> {
        let lengths = self.weights.iter().map(|(_, weight)| weight.abs());
        matches!(self.of, Term::Sine).then(|| lengths.sum())
    }

    /// Makes a gap that along a motion.
    pub fn along<const K: usize>(&self, motion: BatchMotion<'_, K>, gap: &mut GapSeries) {
        gap.len = motion.order() + 2;
        gap.size = self.constant.abs();
        gap.c[..gap.len].fill(0.0);
        for &(link, weight) in &self.weights {
            match self.of {
                Term::Angle => gap.take_off(weight, motion.angle(link)),
                Term::Sine => gap.take_off(weight, motion.sine(link)),
            }
        }
        gap.c[0] += self.constant;
    }
}

/// A polynomial and its derivative at a time.
fn value_and_slope(c: &[f64], t: f64) -> (f64, f64) {
    c.iter().rev().fold((0.0, 0.0), |(value, slope), c| {
        (value * t + c, slope * t + value)
    })
}

/// The zero of a polynomial that falls through it between two times, near a guess; `sign` is -1 for one that rises.
fn falling_zero(c: &[f64], sign: f64, between: [f64; 2], guess: f64) -> f64 {
    let between = Bracket::new(between);
    let guess = guess.clamp(between.before, between.after);
    let Ok(step) = newton(between, guess, MOST_SERIES_POLISHES, |t| {
        let (value, slope) = value_and_slope(c, t);
        // A step that the time does not show is none.
        let is_rounding = t - value / slope == t;
        Ok::<_, Infallible>(NewtonPoint {
            value: if is_rounding { 0.0 } else { sign * value },
            slope: sign * slope,
            resolution: 2.0 * f64::EPSILON * t,
        })
    });
    step.to
}

impl GapSeries {
    /// None yet.
    pub const EMPTY: Self = Self {
        c: [0.0; ROWS],
        len: 0,
        size: 0.0,
    };

    fn take_off(&mut self, weight: f64, series: impl Iterator<Item = f64>) {
        let before = self.c[0];
        for (c, x) in self.c.iter_mut().zip(series) {
            *c -= weight * x;
        }
        self.size += (self.c[0] - before).abs();
    }

    /// A gap by its coefficients.
    #[cfg(test)]
    fn of(coefficients: &[f64], size: f64) -> Self {
        let mut c = [0.0; ROWS];
        c[..coefficients.len()].copy_from_slice(coefficients);
        let len = coefficients.len().max(6);
        Self { c, len, size }
    }

    /// The cubic about the start with a bound on the rest for times up to `span`. The bound is of the form
    /// `a t^4 + b t^5`, and so are those on the first two derivatives: `k (k - 1) t^(k - 2) <= 20 t^3 (k (k - 1)/20) span^(k - 5)`.
    fn model(&self, span: f64) -> GapModel {
        let c = &self.c[..self.len];
        let (square, mut power, mut quintic) = (span * span, 1.0, 0.0);
        let terms = c.iter().zip(&BOUND_GROWTH).skip(5);
        let mut terms = terms.map(|(c, growth)| c.abs() * growth);
        // Two terms at a time: the powers wait for one another.
        while let Some(even) = terms.next() {
            quintic += (even + terms.next().unwrap_or(0.0) * span) * power;
            power *= square;
        }
        GapModel {
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

    /// Where the gap falls through zero before a time at which it is passed, near a guess, a root of the given order at the start
    /// divided out.
    fn root(&self, order: usize, guess: f64, passed: f64) -> f64 {
        falling_zero(&self.c[order..self.len], 1.0, [0.0, passed], guess)
    }

    /// The minimum of a gap that falls at the start, rises after a step and is convex between: its time and gap, and where the
    /// parabola there has the root before it, if that is below zero.
    fn bottom(&self, near: f64, step: f64) -> (f64, f64, f64) {
        let slopes = &self.slopes()[..self.len - 1];
        let at = falling_zero(slopes, -1.0, [0.0, step], near);
        let gap = self.value(at);
        let bend = value_and_slope(slopes, at).1;
        (at, gap, at - (-2.0 * gap / bend).max(0.0).sqrt())
    }

    /// The coefficients of its speed, one fewer.
    fn slopes(&self) -> [f64; ROWS] {
        let mut slopes = [0.0; ROWS];
        for (k, c) in self.c[..self.len].iter().enumerate().skip(1) {
            slopes[k - 1] = k as f64 * c;
        }
        slopes
    }

    /// The longest time up to a span whose last two terms are no more than what is allowed of the gap.
    pub fn known_within(&self, span: f64, allowed: f64) -> f64 {
        (self.len - 2..self.len).fold(span, |known, k| {
            let (order, c) = (k as f64, self.c[k].abs());
            let is_small = c * known.powf(order) <= allowed;
            if is_small {
                known
            } else {
                (allowed / c).powf(1.0 / order)
            }
        })
    }

    /// What rounding leaves unknown of the gap.
    pub fn rounding(&self) -> f64 {
        TERM_ROUNDINGS * self.size
    }

    /// The same gap where it is known to no more than a margin.
    pub fn within(&mut self, margin: f64) {
        self.size = margin / TERM_ROUNDINGS;
    }

    /// Where the gap is lowest within a span, and how low: at an end, or where its speed changes its sign between samples. `order` is that
    /// of the root at the start, of which the speed has one less: what rounding leaves there of a speed says nothing.
    pub fn lowest(&self, order: usize, span: f64) -> (f64, f64) {
        let slopes = &self.slopes()[order.saturating_sub(1)..self.len - 1];
        let time = |k: usize| span * k as f64 / LOWEST_SAMPLES as f64;
        let turns = (0..LOWEST_SAMPLES).filter_map(|k| {
            let between = [time(k), time(k + 1)];
            let [falls, rises] = between.map(|t| value_and_slope(slopes, t).0);
            (falls < 0.0 && rises > 0.0).then(|| {
                let guess = between[0] + (between[1] - between[0]) * falls / (falls - rises);
                falling_zero(slopes, -1.0, between, guess)
            })
        });
        let all = [0.0, span].into_iter().chain(turns);
        let valued = all.map(|t| (t, self.value(t)));
        valued.fold((0.0, f64::INFINITY), |least, own| {
            if own.1 < least.1 { own } else { least }
        })
    }

    /// The time at which a gap was reached that is passed and falls at a time t; `None` for one that is not.
    pub fn passed_before(&self, t: f64) -> Option<f64> {
        let (value, slope) = value_and_slope(&self.c[..self.len], t);
        let is_passed = value < -self.rounding() && slope < 0.0;
        is_passed.then(|| self.root(0, t - value / slope, t))
    }

    /// The gap at a time.
    pub fn value(&self, t: f64) -> f64 {
        value_and_slope(&self.c[..self.len], t).0
    }

    /// The first contact within a span; `order` is that of the root at the start, zero for an open gap. Touches within rounding
    /// before it are noted, as time and gap.
    ///
    /// The series is used up: it ends as that about the last part of the span looked at.
    pub fn first_contact(
        &mut self,
        order: usize,
        span: f64,
        touches: &mut Vec<(f64, f64)>,
    ) -> FirstRoot {
        let rounding = self.rounding();
        let shortest = span * SHORTEST_SERIES_PART;
        let (mut order, mut at, mut step) = (order.min(3), 0.0, span);
        loop {
            step = step.min(span - at);
            let model = self.model(step);
            let ahead = if order > 0 {
                from_contact(&model, order, step, self.rounding())
            } else {
                from_open(
                    &model,
                    step,
                    rounding.max(GAP_ROUNDING * model.size),
                    || rounding,
                )
            };
            match ahead {
                GapVerdict::Clear => {}
                GapVerdict::Dips { near } => {
                    let (bottom, gap, reached) = self.bottom(near, step);
                    match Bottom::of(gap, rounding) {
                        Bottom::Passed => {
                            let passed = at + bottom;
                            let at = at + self.root(order, reached, bottom);
                            return FirstRoot::Crossing { at, passed };
                        }
                        Bottom::Touch => touches.push((at + bottom, gap)),
                        Bottom::Open | Bottom::Undecided => {}
                    }
                }
                GapVerdict::Reached { at: guess, passed } => {
                    let start = at;
                    let at = start + self.root(order, guess, passed);
                    let passed = start + passed;
                    return FirstRoot::Crossing { at, passed };
                }
                GapVerdict::Rests => {
                    let is_noted = touches.last().is_some_and(|(t, _)| *t >= at - step);
                    if !is_noted {
                        touches.push((at, model.c[0]));
                    }
                }
                GapVerdict::Unknown if step <= shortest => return FirstRoot::Undecided { at },
                GapVerdict::Unknown => {
                    step *= 0.5;
                    continue;
                }
            }
            at += step;
            if at >= span {
                return FirstRoot::None;
            }
            self.advance(step);
            order = 0;
            step *= 2.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::root::polynomial::from_roots;

    fn search(c: &[f64], order: usize, span: f64) -> (FirstRoot, Vec<(f64, f64)>) {
        let mut touches = Vec::new();
        let root = GapSeries::of(c, 1.0).first_contact(order, span, &mut touches);
        (root, touches)
    }

    /// Random numbers in (-1, 1).
    fn random(mut seed: u64) -> impl FnMut() -> f64 {
        move || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 11) as f64 / (1u64 << 53) as f64 * 2.0 - 1.0
        }
    }

    #[test]
    fn the_first_fall_through_zero_is_found_whatever_follows() {
        for roots in [
            vec![0.5],
            vec![0.1, 0.9],
            vec![0.3, 0.300_01, 0.8],
            vec![0.2, 0.4, 0.6, 0.8],
            vec![0.01, 0.02, 0.5, 0.98, 0.99, 1.5, 2.0],
            vec![-0.5, 0.25, 1.5],
        ] {
            // Positive at the start: the first root ahead is a fall.
            let ahead = roots.iter().filter(|r| **r > 0.0).count();
            let scale = if ahead % 2 == 0 { 10.0 } else { -10.0 };
            let first = roots
                .iter()
                .copied()
                .filter(|r| *r > 0.0)
                .fold(f64::INFINITY, f64::min);
            let (root, touches) = search(&from_roots(&roots, scale), 0, 1.0);
            let FirstRoot::Crossing { at, .. } = root else {
                panic!("{roots:?} {root:?}")
            };
            assert!((at - first).abs() < 1e-9, "{roots:?} {at}");
            assert_eq!(touches, []);
        }
    }

    #[test]
    fn dips_deeper_than_rounding_are_contacts_and_others_touches() {
        for place in [0.05, 0.25, 0.5, 0.3, 1.0 - 1e-9, 1.0] {
            for depth in [1e-3, 1e-6, 1e-9, 1e-12, 1e-14, 0.0, -1e-14, -1e-9, -1e-3] {
                // (t - place)^2 (1 + t^6) - depth
                let mut c = vec![place * place - depth, -2.0 * place, 1.0];
                c.extend([0.0, 0.0, 0.0, place * place, -2.0 * place, 1.0]);
                let (root, touches) = search(&c, 0, 1.0);
                let case = format!("{place} {depth}: {root:?} {touches:?}");
                if depth > 0.0 {
                    let FirstRoot::Crossing { at, .. } = root else {
                        panic!("{case}")
                    };
                    // Near its minimum the gap is known to rounding, and its root to that over the slope.
                    let wanted = place - (depth / (1.0 + place.powi(6))).sqrt();
                    let error = 4e-15 / depth.sqrt() + 3.0 * depth;
                    assert!((at - wanted).abs() < error, "{case}");
                } else {
                    assert_eq!(root, FirstRoot::None, "{case}");
                    // A touch where the span ends belongs to what follows.
                    let is_inside = depth == 0.0 && place < 1.0;
                    assert_eq!(touches.len(), usize::from(is_inside), "{case}");
                }
            }
        }
    }

    #[test]
    fn a_gap_is_known_as_far_as_its_last_terms_are_small() {
        // The sine of five radians in one step, to order 7: x^7/7! is 1e-9 at 0.175.
        let sine = [
            0.0,
            1.0,
            0.0,
            -1.0 / 6.0,
            0.0,
            1.0 / 120.0,
            0.0,
            -1.0 / 5040.0,
        ];
        let gap = GapSeries::of(&sine, 1.0);
        let known = gap.known_within(5.0, 1e-9);
        assert!(
            (known.powi(7) / 5040.0 / 1e-9 - 1.0).abs() < 1e-9,
            "{known}"
        );
        assert_eq!(gap.known_within(0.1, 1e-9), 0.1);
    }

    #[test]
    fn a_low_flight_behind_an_impact_is_found() {
        for speed in [1.0, 1e-3, 1e-8, 1e-13] {
            // The next contact is at 2 speed, but for the quintic.
            let c = [1e-17, speed, -0.5, 0.0, 0.0, 0.3];
            let (root, _) = search(&c, 1, 1.0);
            let FirstRoot::Crossing { at, .. } = root else {
                assert!(speed > 0.4, "{speed} {root:?}");
                continue;
            };
            let root = |t: f64| speed - 0.5 * t + 0.3 * t.powi(4);
            assert!(root(at).abs() < 4.0 * f64::EPSILON * speed, "{speed} {at}");
            assert!(at < 2.2 * speed);
        }
        let (root, _) = search(&[0.0, 0.0, 1.0, -1.0], 2, 1.5);
        assert_eq!(
            root,
            FirstRoot::Crossing {
                at: 1.0,
                passed: 1.5
            }
        );
        assert_eq!(search(&[0.0, 1.0, 0.2, -0.3], 1, 1.0).0, FirstRoot::None);
    }

    #[test]
    fn random_gaps_are_judged_as_dense_samples_judge_them() {
        let mut random = random(1);
        let mut contacts = 0;
        for _ in 0..2000 {
            let mut c: Vec<f64> = (0..14).map(|k| random() * 0.4f64.powi(k) * 2.0).collect();
            c[0] = c[0].abs() * 0.3;
            let value = |t: f64| c.iter().rev().fold(0.0, |sum, c| sum * t + c);
            let (root, _) = search(&c, 0, 1.0);
            let sampled = (0..=4000)
                .map(|k| f64::from(k) / 4000.0)
                .find(|t| value(*t) < -1e-9);
            match (root, sampled) {
                (FirstRoot::Crossing { at, .. }, Some(t)) => {
                    contacts += 1;
                    assert!(at <= t && value(at).abs() < 1e-13, "{at} {t}");
                }
                (FirstRoot::Crossing { at, .. }, None) => assert!(value(at).abs() < 1e-13),
                (FirstRoot::None, None) => {}
                other => panic!("{other:?} {c:?}"),
            }
        }
        assert!(contacts > 500);
    }

    #[test]
    fn the_lowest_gap_is_below_all_samples() {
        let mut random = random(3);
        for _ in 0..500 {
            let c: Vec<f64> = (0..14).map(|k| random() * 0.6f64.powi(k) * 2.0).collect();
            let gap = GapSeries::of(&c, 1.0);
            let (at, least) = gap.lowest(0, 1.0);
            assert!((gap.value(at) - least).abs() < 1e-15);
            let sampled = (0..=4000).map(|k| gap.value(f64::from(k) / 4000.0));
            let sampled = sampled.fold(f64::INFINITY, f64::min);
            // Between two samples it falls by less than its curvature over their distance.
            assert!(least <= sampled + 1e-15 && least > sampled - 1e-4, "{c:?}");
        }
        assert_eq!(GapSeries::of(&[1.0, -1.0], 1.0).lowest(0, 3.0), (3.0, -2.0));
        // Behind an impact that takes all speed: -t^2/100 + t^3 is lowest at 1/150, whatever rounding leaves.
        for speed in [-1e-17, 0.0, 1e-17] {
            let gap = GapSeries::of(&[0.0, speed, -0.01, 1.0], 1.0);
            let (at, least) = gap.lowest(2, 1.0);
            assert!((at * 150.0 - 1.0).abs() < 1e-12, "{at}");
            assert!((least * 6.75e6 + 1.0).abs() < 1e-9, "{least}");
        }
    }

    #[test]
    fn within_a_margin_a_dip_is_a_touch() {
        for depth in [-1e-11, 0.0, 1e-11] {
            let mut gap = GapSeries::of(&[0.25 - depth, -1.0, 1.0], 1.0);
            gap.within(1e-10);
            let mut touches = Vec::new();
            assert_eq!(gap.first_contact(0, 1.0, &mut touches), FirstRoot::None);
            assert_eq!(touches.len(), 1);
            assert!((touches[0].1 + depth).abs() < 1e-15);
        }
        let mut gap = GapSeries::of(&[0.25 - 1e-9, -1.0, 1.0], 1.0);
        gap.within(1e-10);
        let found = gap.first_contact(0, 1.0, &mut Vec::new());
        assert!(matches!(found, FirstRoot::Crossing { .. }));
    }

    #[test]
    fn a_gap_that_is_passed_was_reached_before() {
        // 1 - 1e-12 - t + t^5/100 at a time behind its root, at one before it, and rising.
        let c = [1.0 - 1e-12, -1.0, 0.0, 0.0, 0.0, 0.01];
        let gap = GapSeries::of(&c, 1.0);
        let FirstRoot::Crossing { at, .. } = search(&c, 0, 2.0).0 else {
            panic!("it is reached")
        };
        let found = gap.passed_before(at + 1e-12).expect("it is passed");
        assert!((found - at).abs() < 2.0 * f64::EPSILON);
        assert_eq!(gap.passed_before(at - 1e-12), None);
        assert_eq!(GapSeries::of(&[-1.0, 1.0], 1.0).passed_before(0.5), None);
    }

    #[test]
    fn what_is_no_number_is_no_proof() {
        let (root, _) = search(&[1.0, f64::NAN, 0.0, 0.0], 0, 1.0);
        assert!(matches!(root, FirstRoot::Undecided { .. }));
    }
}
