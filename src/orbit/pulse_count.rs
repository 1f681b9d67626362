//! How many multipliers of a closed motion lie outside the unit circle, by how often the determinant of its small equations winds about zero
//! along the circle (theory 19, "Many modes"): no eigenproblem of all modes.

use crate::hybrid::ScaledUnits;
use crate::orbit::pulse_kernel::Kernel;
use crate::orbit::pulses::{PulseTrain, Pulses};
use crate::root::Secant;
use crate::tolerance::{
    LONGEST_WINDING_STEP, MARGINAL, SHORTEST_WINDING_STEP, WINDING_STEP_PART, WINDING_TURN,
};
use nalgebra::Complex;
use std::f64::consts::PI;

/// The circle next to which modes matter, outside the unit circle by what decides nothing. [exact]
const MARGINAL_RADIUS: f64 = 1.0 + MARGINAL;
/// Points of half the circle at which the determinant is evaluated while multipliers are counted. [work]
const MOST_WINDING_POINTS: usize = 20_000;
/// Points of half the circle between which a multiplier on it is sought. [work]
const CIRCLE_POINTS: i32 = 400;
/// The angle between the first two places of those steps \[rad\]. [work]
const SECOND_MULTIPLIER_ANGLE: f64 = 1e-3;
/// Secant steps towards one multiplier. [work]
const MOST_MULTIPLIER_SECANTS: usize = 30;

impl Pulses {
    /// How many multipliers lie outside the unit circle by more than a margin; `None` where the determinant is too near to zero there, or turns
    /// too fast.
    pub fn n_outside(&self, train: &PulseTrain, units: &ScaledUnits, margin: f64) -> Option<usize> {
        if self.len() == 0 {
            // Those of the modes, which decay.
            return Some(0);
        }
        let (kernel, modes) = self.near_circle(train);
        let at = |angle: f64| {
            let point = Complex::from_polar(1.0 + margin, angle);
            let value = kernel.equations(self, units, point).determinant();
            let near = modes.iter().map(|mode| (point - mode).norm_sqr());
            (value, near.fold(1.0, f64::min).sqrt())
        };
        // The lower half is the image of the upper one.
        let (mut angle, mut turned) = (0.0, 0.0);
        let (mut value, mut near) = at(angle);
        let mut points = 0;
        while angle < PI {
            let mut step = (WINDING_STEP_PART * near)
                .min(LONGEST_WINDING_STEP)
                .min(PI - angle);
            loop {
                points += 1;
                let (next, there) = at(angle + step);
                let turn = (next / value).arg();
                if turn.abs() < WINDING_TURN {
                    (angle, value, near) = (angle + step, next, there);
                    turned += turn;
                    break;
                }
                step *= 0.5;
                if !(step > SHORTEST_WINDING_STEP && points < MOST_WINDING_POINTS) {
                    return None;
                }
            }
            if PI - angle < SHORTEST_WINDING_STEP {
                break;
            }
        }
        // Modes decay, so that all poles are inside: what winds is minus what is outside.
        let winds = (turned / PI).round();
        let outside = -winds;
        let most = 2.0 * self.modal_multipliers().len() as f64;
        (0.0..=most).contains(&outside).then_some(outside as usize)
    }

    /// The multiplier on the upper half of the unit circle, where one is: from points of the circle at which the determinant, without the poles
    /// that the modes give it, is less than at their neighbours, by the method of the secant; the one that is nearest to the circle.
    pub fn on_circle(&self, train: &PulseTrain, units: &ScaledUnits) -> Option<Complex<f64>> {
        let (kernel, modes) = self.near_circle(train);
        let at = |point: Complex<f64>| {
            let own = kernel.equations(self, units, point).determinant();
            modes.iter().fold(own, |left, mode| left * (point - mode))
        };
        let angle = |k: i32| PI * f64::from(k) / f64::from(CIRCLE_POINTS);
        let sizes = (0..=CIRCLE_POINTS).map(|k| at(Complex::from_polar(1.0, angle(k))).norm());
        let sizes: Vec<f64> = sizes.collect();
        let lows = (1..CIRCLE_POINTS).filter(|&k| {
            let k = k as usize;
            sizes[k] <= sizes[k - 1] && sizes[k] <= sizes[k + 1]
        });
        let found = lows.filter_map(|k| {
            let low = Complex::from_polar(1.0, angle(k));
            let mut found = low * Complex::from_polar(1.0, SECOND_MULTIPLIER_ANGLE);
            let mut secant = Secant {
                at: low,
                value: at(low),
            };
            for _ in 0..MOST_MULTIPLIER_SECANTS {
                let step = secant.step(found, at(found));
                if !step.norm().is_finite() || step.norm() <= f64::EPSILON {
                    break;
                }
                found += step;
            }
            (found.im > 0.0).then_some(found)
        });
        let off = |mu: &Complex<f64>| mu.norm().ln().abs();
        found.min_by(|a, b| off(a).total_cmp(&off(b)))
    }

    /// The equations of deviations, and the multipliers of the modes near the circle, the upper one of each conjugate pair; those farther
    /// inside are never the nearest that matters.
    fn near_circle(&self, train: &PulseTrain) -> (Kernel, Vec<Complex<f64>>) {
        let kernel = Kernel::new(self, train, &self.before(train));
        let farthest = MARGINAL_RADIUS - LONGEST_WINDING_STEP / WINDING_STEP_PART;
        let each = self.modal_multipliers().iter().flatten().copied();
        // Either root of a pair may turn to the upper half.
        let near = each.filter(|mode| mode.im >= 0.0 && mode.norm() > farthest);
        (kernel, near.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::ModalScene;
    use crate::model::{Harmonic, LinearSystem, Scene, Stop};
    use crate::orbit::{Guess, OrbitOptions, Pattern, begun, periodic_orbits};
    use nalgebra::DVector;
    use std::f64::consts::TAU;
    use std::sync::Arc;

    /// Modes of frequencies that are no multiples of each other, hit in a direction that sees all of them.
    fn scene(n: usize) -> Scene {
        let frequencies = DVector::from_fn(n, |i, _| 1.0 + 0.83 * i as f64);
        let damping = frequencies.map(|w| 0.04 * w);
        let stiffness = frequencies.map(|w| w * w);
        let system = LinearSystem::new(DVector::from_element(n, 1.0), damping, stiffness);
        let force = DVector::from_fn(n, |i, _| (1.0 / (1.0 + i as f64)).into());
        let force = Harmonic::new(force, 2.4, 0.0).expect("valid");
        let normal = DVector::from_fn(n, |i, _| 1.0 / (1.0 + 0.1 * i as f64));
        let stops = [(1.0, 0.3, 0.8), (-1.0, 0.35, 0.6)].map(|(side, clearance, restitution)| {
            Stop::new(&normal * side, clearance, restitution).expect("valid")
        });
        Scene::new(system.expect("valid"), force, stops).expect("valid")
    }

    #[test]
    fn the_small_determinant_is_that_of_the_monodromy_over_that_of_the_modes() {
        let mut compared = 0;
        for n in [1, 2, 5, 24, 60, 200] {
            let scene = scene(n);
            let two = Pattern::new(vec![vec![0], vec![1]]).expect("valid");
            for pattern in [Pattern::single(0), two] {
                let found = periodic_orbits(&scene, &pattern, &OrbitOptions::default());
                for orbit in found.expect("a search").iter() {
                    let (scene, signature, state) =
                        begun(&scene, Guess::Orbit(orbit), None).expect("a loop");
                    let modal = Arc::new(ModalScene::new(&scene, "a test").expect("linear"));
                    let period = orbit.period();
                    let pulses = Pulses::new(&scene, &modal, (&signature.stages, period), None);
                    let pulses = pulses.expect("its modes decay");
                    let train = pulses.train(&state.times, &state.states);
                    let units = ScaledUnits {
                        position: 1.0,
                        velocity: 1.0,
                        time: period / TAU,
                    };
                    let closed = pulses.linearised(&train, &units);
                    assert!(closed.mismatch < 1e-11, "{n} {:e}", closed.mismatch);
                    let stability = orbit.stability().expect("multipliers");
                    let own = &stability.orders[0].multipliers;
                    let before = pulses.before(&train);
                    let kernel = Kernel::new(&pulses, &train, &before);
                    let modes: Vec<_> = pulses.modal_multipliers().iter().flatten().collect();
                    // The multipliers pair by pair, so that no product leaves the doubles.
                    let ratio = |mu: Complex<f64>| {
                        let small = kernel.equations(&pulses, &units, mu).determinant();
                        let parts = own.iter().zip(&modes);
                        parts.fold(small, |left, (m, mode)| left * (mu - *mode) / (mu - m))
                    };
                    let first = ratio(Complex::new(-1.3, 0.2));
                    for mu in [
                        Complex::new(1.5, 0.0),
                        Complex::new(0.4, 1.2),
                        Complex::new(-0.2, -0.9),
                        Complex::from_polar(1.0, 2.0),
                    ] {
                        let off = (ratio(mu) / first - 1.0).norm();
                        assert!(off < 1e-8, "{n} {mu}: {off:e}");
                    }
                    let outside = own.iter().filter(|mu| mu.norm() > MARGINAL_RADIUS).count();
                    assert_eq!(
                        pulses.n_outside(&train, &units, MARGINAL),
                        Some(outside),
                        "{n}"
                    );
                    compared += 1;
                }
            }
        }
        assert!(compared >= 8, "{compared}");
    }
}
