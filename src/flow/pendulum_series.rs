//! The motions of a pendulum about one state after another as Taylor series (theory 8).

use crate::error::Result;
use crate::flow::series_forcing::{PendulumForcing, paired};
use crate::flow::series_of::SeriesOf;
use crate::flow::taylor::{Blocks, MOST_ORDER, MotionCoefficients};
use crate::linalg::small;
use crate::model::{Excitation, Links, Moment, singular_mass};
use nalgebra::DMatrix;

/// The recurrence by which the Taylor series of a pendulum's motions are made.
#[derive(Debug, Clone)]
pub(crate) struct PendulumSeries {
    n: usize,
    inertia: DMatrix<f64>,
    coefficients: MotionCoefficients,
    shake: PendulumForcing,
}

impl PendulumSeries {
    /// Series of an order, of the velocities; the positions have one more.
    pub fn new(links: Links, excitation: &Excitation, order: usize) -> Self {
        let n = links.static_moment.len();
        let is_damped = links.damping.amax() > 0.0;
        Self {
            n,
            coefficients: MotionCoefficients {
                order: order.min(MOST_ORDER),
                inertia: Blocks::new(n, |i, j| links.inertia[(i, j)]),
                damping: if is_damped {
                    Blocks::new(n, |i, j| links.damping[(i, j)])
                } else {
                    Blocks::default()
                },
                weight: paired(&(&links.static_moment * links.gravity)),
            },
            shake: PendulumForcing::new(excitation, &links),
            inertia: links.inertia,
        }
    }

    /// Room for the series of K motions.
    pub fn room<const K: usize>(&self) -> SeriesOf<K> {
        SeriesOf::new(self.n, self.coefficients.order)
    }

    /// Operations that a series is, at the most.
    pub fn work(&self) -> usize {
        let order = self.coefficients.order;
        order * self.n * (self.n + order) + self.n.pow(3)
    }

    /// The coefficients that do not depend on the state.
    pub fn coefficients(&self) -> &MotionCoefficients {
        &self.coefficients
    }

    /// Makes the series of motions that have begun, each with the bits that it has by itself.
    pub fn expand<const K: usize>(&self, series: &mut SeriesOf<K>) {
        series.expand(&self.coefficients, &self.shake);
    }

    /// Begins the m-th series: sets its coefficients of order zero, by a state and a moment, and what else the others
    /// follow from.
    ///
    /// # Errors
    /// A mass matrix that is not positive definite in double precision.
    pub fn begin<const K: usize>(
        &self,
        series: &mut SeriesOf<K>,
        m: usize,
        (at, q, v): (Moment, &[f64], &[f64]),
    ) -> Result<()> {
        for (i, (q, v)) in q.iter().zip(v).enumerate() {
            let lane = &mut series.lanes[i / 2];
            (lane.q[0][i % 2][m], lane.v[0][i % 2][m]) = (*q, *v);
            (lane.sin[0][i % 2][m], lane.cos[0][i % 2][m]) = q.sin_cos();
        }
        series.angles[m] = at.angle;
        if let PendulumForcing::Any(forcing) = &self.shake {
            forcing.begin(&mut series.shaken, m, (at, self.coefficients.order));
        }
        self.invert_mass(series, m)
    }

    /// The inverse of the m-th mass matrix at the start.
    fn invert_mass<const K: usize>(&self, series: &mut SeriesOf<K>, m: usize) -> Result<()> {
        let (n, inertia) = (self.n, &self.inertia);
        let SeriesOf {
            lanes,
            inverse,
            scratch,
            ..
        } = series;
        let (sin, cos) = (
            |i: usize| lanes[i / 2].sin[0][i % 2][m],
            |i: usize| lanes[i / 2].cos[0][i % 2][m],
        );
        let entry = |i: usize, j: usize| inertia[(i, j)] * (cos(i) * cos(j) + sin(i) * sin(j));
        if n == 2 {
            let (a, b, d) = (inertia[(0, 0)], entry(0, 1), inertia[(1, 1)]);
            let det = a * d - b * b;
            if det.is_nan() || det <= 0.0 {
                return Err(singular_mass());
            }
            let scale = 1.0 / det;
            (inverse.0[0][0][m], inverse.0[0][1][m]) = (d * scale, -b * scale);
            (inverse.0[1][0][m], inverse.0[1][1][m]) = (-b * scale, a * scale);
            return Ok(());
        }
        let (mass, column) = scratch.split_at_mut(n * n);
        for i in 0..n {
            for j in 0..n {
                mass[i * n + j] = entry(i, j);
            }
        }
        if !small::factor_positive(mass, n) {
            return Err(singular_mass());
        }
        for j in 0..n {
            column.fill(0.0);
            column[j] = 1.0;
            small::solve_factored(mass, column);
            for (i, x) in column.iter().enumerate() {
                inverse.0[i / 2 * 2 * n.div_ceil(2) + j][i % 2][m] = *x;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::steps::Tolerance;
    use crate::model::{
        BaseAcceleration, BaseMotion, DoublePendulum, Dynamics, Forcing, Fourier, Harmonic, Load,
        PendulumChain, Scene, SceneMotion, Signal, Stop, System,
    };
    use nalgebra::{Complex, DVector};

    fn chain(n: usize, damper: f64) -> PendulumChain {
        let masses = DVector::from_fn(n, |i, _| 1.0 + 0.3 * i as f64);
        let lengths = DVector::from_fn(n, |i, _| 0.9 - 0.1 * i as f64);
        let dampers = DVector::from_element(n, damper);
        PendulumChain::new(masses, lengths, &dampers, 9.81).expect("valid")
    }

    fn calm(n: usize, damper: f64) -> Excitation {
        Excitation::new(&chain(n, damper).into(), &Forcing::Unforced)
    }

    fn forcings(n: usize) -> Vec<Forcing> {
        let force = DVector::from_fn(n, |i, _| Complex::new(0.7 - i as f64, 0.4));
        let harmonic =
            |w: f64| Forcing::from(Harmonic::new(force.clone(), w, -0.4).expect("valid"));
        let base = |amplitudes: [f64; 2]| {
            let turned = amplitudes.map(|a| Complex::from_polar(a, 0.7));
            let amplitudes = DVector::from_row_slice(&turned);
            BaseMotion::of_harmonics(amplitudes, 1.7, 0.3).expect("valid")
        };
        let several = Fourier::new(vec![force.clone(), force.clone() * Complex::i()], 1.1, 0.2)
            .and_then(|f| f.with_mean(DVector::from_fn(n, |i, _| 0.3 - 0.2 * i as f64)));
        let cubic = nalgebra::dmatrix![0.3, 1.0; -0.7, 0.2; 0.4, -0.5; 1.1, 0.3];
        let signal = Signal::pieces(&[-1.0, 0.0, 2.0], &cubic).expect("valid");
        vec![
            Forcing::Unforced,
            BaseMotion::new(0.2, 1.7, 0.3).expect("valid").into(),
            harmonic(2.3),
            several.expect("valid").into(),
            base([0.1, 0.05]).into(),
            vec![harmonic(2.3), harmonic(1.6), base([0.1, 0.02]).into()].into(),
            Load::new(n - 1, signal.clone()).expect("valid").into(),
            vec![BaseAcceleration::new(signal).into(), harmonic(0.6)].into(),
        ]
    }

    /// The series about a moment and a state.
    fn made(of: PendulumSeries, start: (Moment, &[f64], &[f64])) -> SeriesOf<1> {
        let mut series = of.room();
        of.begin(&mut series, 0, start).expect("regular");
        of.expand(&mut series);
        series
    }

    /// A series at a time.
    fn at_time(coefficients: impl Iterator<Item = f64>, t: f64) -> f64 {
        let all: Vec<f64> = coefficients.collect();
        all.iter().rev().fold(0.0, |sum, c| sum * t + c)
    }

    /// The acceleration on the series against that of the equations of motion there: what the series leaves out goes with
    /// the power of its order.
    #[test]
    fn the_series_solve_the_equations_of_motion() {
        let pair = DoublePendulum::new(0.6, 1.4, (0.05, 0.02)).expect("valid");
        let free = DoublePendulum::new(0.6, 1.4, (0.0, 0.0)).expect("valid");
        let pairs = [pair, free].map(|s| (s.links(), System::from(s)));
        let chains = (1..=7).map(|n| chain(n, 0.3 * (n % 2) as f64));
        let chains = chains.map(|s| (s.links(), System::from(s)));
        for (links, system) in pairs.into_iter().chain(chains) {
            let n = system.n_dof();
            let q = DVector::from_fn(n, |i, _| 0.8 - 0.5 * i as f64);
            let v = DVector::from_fn(n, |i, _| -0.3 + 0.4 * i as f64);
            for forcing in forcings(n) {
                let scene = Scene::new(system.clone(), forcing, Vec::<Stop>::new()).expect("valid");
                let frequency = scene.frequency().unwrap_or(0.0);
                let motion = SceneMotion::new(&scene);
                let order = 14;
                let begun = Moment::new(0.0, 0.9, frequency);
                let series = made(
                    PendulumSeries::new(links.clone(), &scene.excitation(), order),
                    (begun, q.as_slice(), v.as_slice()),
                );
                let residual = |s: f64| {
                    let mut x = vec![0.0; 2 * n];
                    series.states(&[s], |i, _, [q, v]| {
                        if i < n {
                            (x[i], x[n + i]) = (q, v);
                        }
                    });
                    let (q, v) = x.split_at(n);
                    let at = begun.after(s);
                    let mut a = vec![0.0; n];
                    motion.acceleration(at, q, v, &mut a).expect("regular");
                    let of_series = |i: usize| {
                        let terms = series.lanes[i / 2].v[..=order].iter().enumerate();
                        at_time(terms.skip(1).map(|(k, v)| k as f64 * v[i % 2][0]), s)
                    };
                    (0..n)
                        .map(|i| (a[i] - of_series(i)).abs())
                        .fold(0.0, f64::max)
                };
                let scale = v.amax().max(1.0);
                assert!(residual(0.0) < 1e-12 * scale);
                // The radius of convergence of the longest chain is about 0.2.
                let (coarse, fine) = (residual(0.04), residual(0.02));
                assert!(fine < 1e-9 * scale, "{n} {fine:e}");
                assert!(fine < 2e-4 * coarse + 1e-12, "{n} {coarse:e} {fine:e}");
                for i in 0..n {
                    let (angle, sine) = (
                        at_time(series.motion(0).angle(i), 0.02),
                        at_time(series.motion(0).sine(i), 0.02),
                    );
                    assert!((angle.sin() - sine).abs() < 1e-13);
                }
            }
        }
    }

    #[test]
    fn the_last_terms_of_the_longest_step_are_within_the_tolerance() {
        let of = PendulumSeries::new(chain(2, 0.1).links(), &calm(2, 0.1), 12);
        let series = made(of, (Moment::of_angle(0.0), &[0.5, -0.2], &[1.0, -2.0]));
        let series = series.motion(0);
        for relative in [1e-4, 1e-8, 1e-12] {
            let tolerance = Tolerance {
                relative,
                absolute: 0.0,
            };
            let mut h = series.longest_step(tolerance, None);
            h = series.longest_step(tolerance, Some(h));
            let last = series.largest(|lane| &lane.v[12]) * h.powi(12);
            let size = relative * 2.0f64.max(h * series.largest(|lane| &lane.v[1]));
            assert!(last < 1.3 * size, "{relative:e} {h} {:e}", last / size);
            let early = series.largest(|lane| &lane.v[11]) * h.powi(11);
            assert!(last > 0.3 * size || early > 0.3 * size);
        }
    }

    #[test]
    fn a_series_at_rest_has_no_longest_step_and_one_that_overflows_has_none_at_all() {
        let of = PendulumSeries::new(chain(1, 0.0).links(), &calm(1, 0.0), 12);
        let tolerance = Tolerance {
            relative: 1e-9,
            absolute: 1e-12,
        };
        let longest = |q: f64, v: f64| {
            let series = made(of.clone(), (Moment::of_angle(0.0), &[q], &[v]));
            series.motion(0).longest_step(tolerance, None)
        };
        assert_eq!(longest(0.0, 0.0), f64::INFINITY);
        assert!(longest(0.3, 1e40).is_nan());
    }
}
