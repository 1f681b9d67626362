//! The phases at which a stop is reached under several harmonics (theory 10): the gap at the instant is a trigonometric polynomial of
//! the phase, of which all roots are found, by bounds on its derivatives.

use crate::error::{Error, Result};
use crate::linalg::rank::SolutionSet;
use crate::orbit::one_instant::periodic_conditions::PeriodicConditions;
use crate::orbit::one_instant::phases::PhaseSolutions;
use crate::orbit::problem::outgrown;
use crate::root::{Bracket, NewtonPoint, newton};
use crate::tolerance::{AT_FOLD, SAME_PHASE, SOLVABLE};
use nalgebra::{Complex, DMatrix, DVector};
use std::convert::Infallible;
use std::f64::consts::TAU;

/// `constant + Re sum_k a_k e^{i k x}`, k from 1.
struct TrigonometricPolynomial {
    constant: f64,
    amplitudes: Vec<Complex<f64>>,
}

/// Halvings of a range of phases beyond which the values in it are rounding. [work]
const MOST_PHASE_HALVINGS: u32 = 45;
/// Values for a root in its bracket, halvings among them. [work]
const MOST_PHASE_POLISHES: usize = 200;
/// Where the first range of phases begins [rad]: at no phase that a symmetry has. [work]
const FIRST_PHASE: f64 = 0.37;

impl TrigonometricPolynomial {
    /// The derivative of some order at x.
    fn derivative(&self, order: i32, x: f64) -> f64 {
        let term = |(k, a): (f64, &Complex<f64>)| {
            let turned = a * Complex::cis(k * x) * Complex::i().powi(order);
            k.powi(order) * turned.re
        };
        let sum: f64 = self.terms().map(term).sum();
        if order == 0 { self.constant + sum } else { sum }
    }

    /// A bound on the size of the derivative of some order.
    fn bound(&self, order: i32) -> f64 {
        self.terms().map(|(k, a)| k.powi(order) * a.norm()).sum()
    }

    fn terms(&self) -> impl Iterator<Item = (f64, &Complex<f64>)> {
        (1..).map(|k: u32| f64::from(k)).zip(&self.amplitudes)
    }

    /// The roots in [0, 2 pi), one of a higher order (a fold) once.
    ///
    /// In a cell in which a derivative has no zero, by its bound, the one before it has at most one, which parts the cell for the one
    /// before that: down to the values themselves.
    fn roots(&self) -> Vec<f64> {
        let cells = 4 * self.amplitudes.len();
        let at = |i: usize| FIRST_PHASE + TAU * i as f64 / cells as f64;
        let mut found = Vec::new();
        let mut open: Vec<(f64, f64, u32)> = (0..cells).map(|i| (at(i), at(i + 1), 0)).collect();
        while let Some((low, high, depth)) = open.pop() {
            let (middle, reach) = (0.5 * (low + high), 0.5 * (high - low));
            let is_clear =
                |&order: &i32| self.derivative(order, middle).abs() > reach * self.bound(order + 1);
            // One of so many derivatives is not zero, unless all are.
            let last = 2 * i32::try_from(self.amplitudes.len()).unwrap_or(i32::MAX);
            match (0..=last).find(is_clear) {
                Some(order) => found.extend(self.zeros(order, low, high)),
                None if depth == MOST_PHASE_HALVINGS => {}
                None => open.extend([(low, middle, depth + 1), (middle, high, depth + 1)]),
            }
        }
        let mut found: Vec<f64> = found.into_iter().map(|x| x.rem_euclid(TAU)).collect();
        found.sort_by(f64::total_cmp);
        found.dedup_by(|b, a| *b - *a <= SAME_PHASE);
        if found.len() > 1 && TAU + found[0] - found[found.len() - 1] <= SAME_PHASE {
            found.pop();
        }
        found
    }

    /// The zeros of the polynomial in a cell in which its derivative of some order has none.
    fn zeros(&self, clear: i32, low: f64, high: f64) -> Vec<f64> {
        let nothing = AT_FOLD * self.bound(0).max(self.constant.abs());
        let mut zeros: Vec<f64> = Vec::new();
        for order in (0..clear).rev() {
            let turning = std::mem::take(&mut zeros);
            // Where a value turns at zero it has a root of a higher order, and no other beside it.
            let is_fold = |x: f64| order == 0 && self.derivative(0, x).abs() <= nothing;
            zeros.extend(turning.iter().copied().filter(|&x| is_fold(x)));
            let ends: Vec<f64> = [low].into_iter().chain(turning).chain([high]).collect();
            for (k, pair) in ends.windows(2).enumerate() {
                let is_beside =
                    (k > 0 && is_fold(pair[0])) || (k + 2 < ends.len() && is_fold(pair[1]));
                if !is_beside {
                    zeros.extend(self.crossing(order, pair[0], pair[1]));
                }
            }
            zeros.sort_by(f64::total_cmp);
        }
        zeros
    }

    /// Where a derivative that is monotone between two places changes its sign. A zero at an end counts as above it.
    fn crossing(&self, order: i32, low: f64, high: f64) -> Option<f64> {
        let falls = self.derivative(order, low) >= 0.0;
        if falls == (self.derivative(order, high) >= 0.0) {
            return None;
        }
        let sign = if falls { 1.0 } else { -1.0 };
        let between = Bracket::new([low, high]);
        let Ok(step) = newton(between, between.middle(), MOST_PHASE_POLISHES, |x| {
            Ok::<_, Infallible>(NewtonPoint {
                value: sign * self.derivative(order, x),
                slope: sign * self.derivative(order + 1, x),
                resolution: f64::EPSILON * x,
            })
        });
        Some(step.to)
    }
}

/// The solutions for given clearances under several harmonics.
///
/// # Errors
/// Families of orbits, which an undamped mode in step with the period has.
pub(crate) fn clearance_given(conditions: &PeriodicConditions<'_>) -> Result<PhaseSolutions> {
    let inner = conditions.n_inner();
    let by_phases = conditions.by_phases()?;
    let mut phases = PhaseSolutions {
        points: Vec::new(),
        margin: None,
        basis: DMatrix::zeros(inner + conditions.n_phases(), 0),
        is_any_phase: false,
    };
    let is_open = |set: &SolutionSet| set.null_space.ncols() > 0 || set.residual > SOLVABLE;
    if by_phases.iter().any(is_open) {
        let found = format!("of {} harmonics", conditions.n_phases() / 2);
        let rule = "a mode that repeats by itself may leave families of orbits, or none: such scenes are solved under one harmonic alone; use find_orbit";
        return Err(Error::bad_value("forcing", found, rule));
    }
    let columns: Vec<_> = by_phases.into_iter().map(|set| set.particular).collect();
    let steady = DMatrix::from_columns(&columns);
    let (contact, constant) = conditions.contact_rows();
    let target = conditions.clearances() - constant;
    // The gap of each stop hit, by columns: constant, then cosine and sine of each harmonic.
    let seen = contact.columns(0, inner) * &steady;
    let gap = |stop: usize| {
        let part = |c: usize| -(seen[(stop, 1 + c)] + contact[(stop, inner + c)]);
        let amplitude = |k: usize| Complex::new(part(2 * k), -part(2 * k + 1));
        TrigonometricPolynomial {
            constant: target[stop] - seen[(stop, 0)],
            amplitudes: (0..conditions.n_phases() / 2).map(amplitude).collect(),
        }
    };
    let gaps: Vec<_> = (0..conditions.n_impulses()).map(gap).collect();
    // Of numbers beyond the doubles no bound would ever decide.
    if !gaps
        .iter()
        .all(|gap| gap.constant.is_finite() && gap.bound(2).is_finite())
    {
        return Err(outgrown());
    }
    let is_seen = gaps[0].bound(0) > AT_FOLD * gaps[0].constant.abs();
    // Where no stop sees the forcing, no phase stands for all, or any one.
    phases.is_any_phase = !is_seen && gaps[0].constant == 0.0;
    let roots = if is_seen {
        gaps[0].roots()
    } else {
        Vec::from_iter(phases.is_any_phase.then_some(0.0))
    };
    let is_met = |x: f64| {
        let meets = |gap: &TrigonometricPolynomial| {
            gap.derivative(0, x).abs() <= SOLVABLE * gap.bound(0).max(gap.constant.abs())
        };
        gaps[1..].iter().all(meets)
    };
    for x in roots.into_iter().filter(|&x| is_met(x)) {
        let turned = conditions.phases([x.cos(), x.sin()]);
        let own = steady.column(0) + steady.columns(1, turned.len()) * &turned;
        let both = own.iter().chain(turned.iter()).copied();
        phases
            .points
            .push(DVector::from_iterator(inner + turned.len(), both));
    }
    Ok(phases)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polynomial(constant: f64, amplitudes: &[(f64, f64)]) -> TrigonometricPolynomial {
        let complex = |&(re, im): &(f64, f64)| Complex::new(re, im);
        TrigonometricPolynomial {
            constant,
            amplitudes: amplitudes.iter().map(complex).collect(),
        }
    }

    #[test]
    fn one_harmonic_has_the_roots_of_its_cosine() {
        for i in -30..=30 {
            let level = f64::from(i) / 20.0;
            let roots = polynomial(-level, &[(0.6, 0.8)]).roots();
            // cos(x + shift) = level
            let shift = 0.8_f64.atan2(0.6);
            let mut expected: Vec<f64> = if level.abs() > 1.0 {
                Vec::new()
            } else {
                let angle = level.acos();
                vec![angle, -angle]
                    .into_iter()
                    .map(|x| (x - shift).rem_euclid(TAU))
                    .collect()
            };
            expected.sort_by(f64::total_cmp);
            if level.abs() == 1.0 {
                expected.truncate(1);
            }
            assert_eq!(roots.len(), expected.len(), "{level}");
            for (a, b) in roots.iter().zip(&expected) {
                let allowed = if level.abs() == 1.0 { 1e-7 } else { 1e-13 };
                assert!((a - b).abs() < allowed, "{level}: {a} {b}");
            }
        }
    }

    #[test]
    fn double_and_triple_roots_are_one() {
        // (1 - cos x)^2 = 3/2 - 2 cos x + cos(2x)/2: of order four at zero.
        let roots = polynomial(1.5, &[(-2.0, 0.0), (0.5, 0.0)]).roots();
        assert!(
            roots.len() == 1 && roots[0].min(TAU - roots[0]) < 1e-3,
            "{roots:?}"
        );
        // (1 - cos x) (1.5 + cos x): a fold at zero and no other.
        let roots = polynomial(1.0, &[(-0.5, 0.0), (-0.5, 0.0)]).roots();
        assert!(
            roots.len() == 1 && roots[0].min(TAU - roots[0]) < 1e-7,
            "{roots:?}"
        );
        // cos x - cos 3x = 2 sin x sin 2x: at 0 and pi of order two, at the other quarters simple.
        let roots = polynomial(0.0, &[(1.0, 0.0), (0.0, 0.0), (-1.0, 0.0)]).roots();
        assert_eq!(roots.len(), 4, "{roots:?}");
    }

    #[test]
    fn random_ones_have_the_roots_that_many_values_show() {
        let mut state = 0.5_f64;
        // Weyl's sequence of the golden ratio.
        let mut number = || {
            state = (state + 0.618_033_988_749_895).fract();
            2.0 * state - 1.0
        };
        for round in 0..500 {
            let order = 1 + round % 5;
            let amplitudes: Vec<_> = (0..order).map(|_| (number(), number())).collect();
            let g = polynomial(number(), &amplitudes);
            let many = 20_000;
            let at = |i: usize| TAU * i as f64 / many as f64;
            let signs: Vec<bool> = (0..many).map(|i| g.derivative(0, at(i)) >= 0.0).collect();
            let changes = (0..many)
                .filter(|&i| signs[i] != signs[(i + 1) % many])
                .count();
            let roots = g.roots();
            assert!(
                roots.len() >= changes && roots.len() <= 2 * order,
                "{round}: {roots:?} {changes}"
            );
            // Those beyond are pairs that lie between two of the values.
            let spacing = TAU / many as f64;
            let near = roots
                .windows(2)
                .filter(|pair| pair[1] - pair[0] < spacing)
                .count();
            assert!(
                roots.len() <= changes + 2 * near,
                "{round}: {roots:?} {changes}"
            );
            for &x in &roots {
                assert!(
                    g.derivative(0, x).abs() < 1e-14 * (1.0 + g.bound(1)),
                    "{round} {x}"
                );
            }
        }
    }
}
