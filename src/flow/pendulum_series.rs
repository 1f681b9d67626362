//! The motion of a pendulum about one state after another as a Taylor series: how far it reaches, the state along it
//! (theory 8).

use crate::error::Result;
use crate::flow::registers::{Arithmetic, in_widest};
use crate::flow::runge_kutta::Tolerance;
use crate::flow::series_of::SeriesOf;
use crate::flow::shaking::{Excitation, Pair, Two, paired};
use crate::flow::taylor::{Blocks, Coefficients, Lane, MOST_ORDER};
use crate::linalg::small;
use crate::model::{Forcing, Links, singular_mass};
use nalgebra::DMatrix;
use pulp::{Simd, WithSimd};

/// The Taylor series of a pendulum's motion about one state after another.
#[derive(Debug, Clone)]
pub(crate) struct PendulumSeries {
    n: usize,
    of: SeriesOf<1>,
    inertia: DMatrix<f64>,
    coefficients: Coefficients,
    excitation: Excitation,
    mass: Vec<f64>,
    column: Vec<f64>,
}

impl PendulumSeries {
    /// Series of an order, of the velocities; the positions have one more.
    pub fn new(links: Links, forcing: &Forcing, order: usize) -> Self {
        let n = links.hanging.len();
        let is_damped = links.damping.amax() > 0.0;
        Self {
            n,
            of: SeriesOf::new(n),
            coefficients: Coefficients {
                order: order.min(MOST_ORDER),
                inertia: Blocks::new(n, |i, j| links.inertia[(i, j)]),
                damping: if is_damped {
                    Blocks::new(n, |i, j| links.damping[(i, j)])
                } else {
                    Blocks::default()
                },
                weight: paired(&(&links.hanging * links.gravity)),
            },
            excitation: Excitation::new(forcing, &links),
            mass: vec![0.0; n * n],
            column: vec![0.0; n],
            inertia: links.inertia,
        }
    }

    /// Order of the velocities.
    pub fn order(&self) -> usize {
        self.coefficients.order
    }

    /// Operations that a series is, at the most.
    pub fn work(&self) -> usize {
        self.order() * self.n * (self.n + self.order()) + self.n.pow(3)
    }

    /// Makes the series from their coefficients of order zero.
    pub fn expand(&mut self) {
        self.of.expand(&self.coefficients, &self.excitation);
    }

    /// Makes the series of several motions of one pendulum together, with the bits of each by itself.
    pub fn expand_abreast<const K: usize>(together: &mut SeriesOf<K>, all: [Option<&mut Self>; K]) {
        let mut all = all;
        for (m, series) in all.iter().enumerate() {
            if let Some(series) = series {
                together.take_start(m, &series.of);
            }
        }
        if let Some(one) = all.iter().flatten().next() {
            together.expand(&one.coefficients, &one.excitation);
        }
        for (m, series) in all.iter_mut().enumerate() {
            if let Some(series) = series {
                together.hand_over(m, series.order(), &mut series.of);
            }
        }
    }

    /// Sets the coefficients of order zero, by a state and a forcing angle, and what else the others follow from.
    ///
    /// # Errors
    /// A mass matrix that is not positive definite in double precision.
    pub fn begin(&mut self, angle: f64, q: &[f64], v: &[f64]) -> Result<()> {
        for (i, (q, v)) in q.iter().zip(v).enumerate() {
            let lane = &mut self.of.lanes[i / 2];
            (lane.q[0][i % 2], lane.v[0][i % 2]) = ([*q], [*v]);
            let (sin, cos) = q.sin_cos();
            (lane.sin[0][i % 2], lane.cos[0][i % 2]) = ([sin], [cos]);
        }
        self.of.angles = [angle];
        self.invert_mass()
    }

    /// The inverse of the mass matrix at the start.
    fn invert_mass(&mut self) -> Result<()> {
        let Self {
            n,
            of: SeriesOf { lanes, inverse, .. },
            inertia,
            mass,
            column,
            ..
        } = self;
        let n = *n;
        let (sin, cos) = (
            |i: usize| lanes[i / 2].sin[0][i % 2][0],
            |i: usize| lanes[i / 2].cos[0][i % 2][0],
        );
        let entry = |i: usize, j: usize| inertia[(i, j)] * (cos(i) * cos(j) + sin(i) * sin(j));
        if n == 2 {
            let (a, b, d) = (inertia[(0, 0)], entry(0, 1), inertia[(1, 1)]);
            let det = a * d - b * b;
            if det.is_nan() || det <= 0.0 {
                return Err(singular_mass());
            }
            let scale = 1.0 / det;
            inverse.0[0] = [[d * scale], [-b * scale]];
            inverse.0[1] = [[-b * scale], [a * scale]];
            return Ok(());
        }
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
                inverse.0[i / 2 * 2 * n.div_ceil(2) + j][i % 2] = [*x];
            }
        }
        Ok(())
    }

    /// The largest of some numbers of the links; one that is not a number counts as such.
    fn largest(&self, of: impl Fn(&Lane<1>) -> Pair<1>) -> f64 {
        let all = self.of.lanes.iter().flat_map(of);
        all.flatten().fold(0.0, |most, x| {
            if x.abs() > most || x.is_nan() {
                x.abs()
            } else {
                most
            }
        })
    }

    /// The longest step whose last two terms are below the tolerance; `before` is the length of a step nearby, if one is
    /// known. Not a number where the series overflows, infinite where it has no such terms.
    pub fn longest_step(&self, tolerance: Tolerance, before: Option<f64>) -> f64 {
        let p = self.order();
        let [q, v, a] = [
            self.largest(|lane| lane.q[0]),
            self.largest(|lane| lane.v[0]),
            self.largest(|lane| lane.v[1]),
        ];
        let [early, late] = [p - 1, p].map(|k| self.largest(|lane| lane.v[k]));
        if !(early + late).is_finite() {
            return f64::NAN;
        }
        let radius = || {
            let by_term = |k: usize, term: f64| {
                (v / term)
                    .powf(1.0 / k as f64)
                    .max((a / term).powf(1.0 / (k - 1) as f64))
            };
            by_term(p - 1, early).min(by_term(p, late))
        };
        let unit = before.unwrap_or_else(radius).min(f64::MAX);
        let size = |x: f64, rate: f64| tolerance.absolute + tolerance.relative * x.max(unit * rate);
        let (of_q, of_v) = (size(q, v), size(v, a));
        let step = |k: usize, term: f64| {
            let allowed = of_v.min(of_q * (k + 1) as f64 / unit);
            (allowed / term).ln() / k as f64
        };
        step(p - 1, early).min(step(p, late)).exp()
    }

    /// The state a time s after the start.
    pub fn state(&self, s: f64, x: &mut [f64]) {
        let (q, v) = x.split_at_mut(self.n);
        let p = self.order();
        let parts = q.chunks_mut(2).zip(v.chunks_mut(2));
        for (lane, (q, v)) in self.of.lanes.iter().zip(parts) {
            let (rows, rates) = (&lane.q[..=p + 1], &lane.v[..=p]);
            let [at, rate] = in_widest(Sums { rows, rates, s });
            q.copy_from_slice(&at[..q.len()]);
            v.copy_from_slice(&rate[..v.len()]);
        }
    }

    /// The coefficients of a link's angle.
    pub fn angle(&self, link: usize) -> impl Iterator<Item = f64> {
        let rows = &self.of.lanes[link / 2].q[..self.order() + 2];
        rows.iter().map(move |row| row[link % 2][0])
    }

    /// The coefficients of the sine of a link's angle.
    pub fn sine(&self, link: usize) -> impl Iterator<Item = f64> {
        let rows = &self.of.lanes[link / 2].sin[..self.order() + 2];
        rows.iter().map(move |row| row[link % 2][0])
    }
}

/// Two polynomials of two links at a time s; the first has no fewer rows than the second.
struct Sums<'a> {
    rows: &'a [Pair<1>],
    rates: &'a [Pair<1>],
    s: f64,
}

impl WithSimd for Sums<'_> {
    type Output = [Two; 2];

    #[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> [Two; 2] {
        let raise = |sum: &mut Two, row: &Pair<1>| {
            for i in 0..2 {
                sum[i] = S::add_product(sum[i], self.s, row[i][0]);
            }
        };
        let (rows, higher) = self.rows.split_at(self.rates.len());
        let (mut at, mut rate) = ([0.0; 2], [0.0; 2]);
        for row in higher.iter().rev() {
            raise(&mut at, row);
        }
        for (row, change) in rows.iter().zip(self.rates).rev() {
            raise(&mut at, row);
            raise(&mut rate, change);
        }
        [at, rate]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{
        BaseMotion, DoublePendulum, Dynamics, Harmonic, Moment, PendulumChain, Scene, SceneMotion,
        Stop, System, with_motion,
    };
    use nalgebra::DVector;

    fn chain(n: usize, damper: f64) -> PendulumChain {
        let masses = DVector::from_fn(n, |i, _| 1.0 + 0.3 * i as f64);
        let lengths = DVector::from_fn(n, |i, _| 0.9 - 0.1 * i as f64);
        let dampers = DVector::from_element(n, damper);
        PendulumChain::new(masses, lengths, &dampers, 9.81).expect("valid")
    }

    fn forcings(n: usize) -> [Forcing; 3] {
        let force = DVector::from_fn(n, |i, _| nalgebra::Complex::new(0.7 - i as f64, 0.4));
        [
            Forcing::Unforced,
            BaseMotion::new(0.2, 1.7, 0.3).expect("valid").into(),
            Harmonic::new(force, 2.3, -0.4).expect("valid").into(),
        ]
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
                let frequency = scene.forcing().frequency().unwrap_or(0.0);
                let motion = SceneMotion::new(&scene);
                let order = 14;
                let mut series = PendulumSeries::new(links.clone(), scene.forcing(), order);
                series
                    .begin(0.9, q.as_slice(), v.as_slice())
                    .expect("regular");
                series.expand();
                let residual = |s: f64| {
                    let mut x = vec![0.0; 2 * n];
                    series.state(s, &mut x);
                    let (q, v) = x.split_at(n);
                    let at = Moment {
                        time: s,
                        angle: 0.9 + frequency * s,
                    };
                    let mut a = vec![0.0; n];
                    with_motion!(&motion, m => m.acceleration(at, q, v, &mut a)).expect("regular");
                    let of_series = |i: usize| {
                        let terms = series.of.lanes[i / 2].v[..=order].iter().enumerate();
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
                        at_time(series.angle(i), 0.02),
                        at_time(series.sine(i), 0.02),
                    );
                    assert!((angle.sin() - sine).abs() < 1e-13);
                }
            }
        }
    }

    #[test]
    fn the_last_terms_of_the_longest_step_are_within_the_tolerance() {
        let mut series = PendulumSeries::new(chain(2, 0.1).links(), &Forcing::Unforced, 12);
        series
            .begin(0.0, &[0.5, -0.2], &[1.0, -2.0])
            .expect("regular");
        series.expand();
        for relative in [1e-4, 1e-8, 1e-12] {
            let tolerance = Tolerance {
                relative,
                absolute: 0.0,
            };
            let mut h = series.longest_step(tolerance, None);
            h = series.longest_step(tolerance, Some(h));
            let last = series.largest(|lane| lane.v[12]) * h.powi(12);
            let size = relative * 2.0f64.max(h * series.largest(|lane| lane.v[1]));
            assert!(last < 1.3 * size, "{relative:e} {h} {:e}", last / size);
            let early = series.largest(|lane| lane.v[11]) * h.powi(11);
            assert!(last > 0.3 * size || early > 0.3 * size);
        }
    }

    #[test]
    fn a_series_at_rest_has_no_longest_step_and_one_that_overflows_has_none_at_all() {
        let mut series = PendulumSeries::new(chain(1, 0.0).links(), &Forcing::Unforced, 12);
        let tolerance = Tolerance {
            relative: 1e-9,
            absolute: 1e-12,
        };
        series.begin(0.0, &[0.0], &[0.0]).expect("regular");
        series.expand();
        assert_eq!(series.longest_step(tolerance, None), f64::INFINITY);
        series.begin(0.0, &[0.3], &[1e40]).expect("regular");
        series.expand();
        assert!(series.longest_step(tolerance, None).is_nan());
    }
}
