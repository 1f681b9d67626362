//! Taylor series of a pendulum's large motions, to any order up to [`MOST_ORDER`] (theory 8).
//!
//! With `s_i = sin q_i`, `c_i = cos q_i` the equations of motion are `c_i P_i - s_i Q_i = -(C v)_i + f_i`, where
//! `P_i = sum_j I_ij s_j'' - h_i b` and `Q_i = sum_j I_ij c_j'' - h_i g`: products of series of one link alone, and linear
//! combinations of links. Coefficient k of each product is a convolution, in which the unknown acceleration appears with
//! the mass matrix at the start; `s' = c v` and `c' = -s v` give the rest.

use crate::error::Result;
use crate::flow::runge_kutta::Tolerance;
use crate::flow::shaking::{Calm, Excitation, Shaking, Two, paired};
use crate::linalg::small;
use crate::model::{Forcing, Links, singular_mass};
use nalgebra::DMatrix;

/// Highest order of a series.
pub(crate) const MOST_ORDER: usize = 24;
/// Coefficients of the positions, which have one order more than the velocities.
pub(crate) const ROWS: usize = MOST_ORDER + 2;

/// `1/k`, zero for k = 0.
const RECIPROCALS: [f64; ROWS] = {
    let mut all = [0.0; ROWS];
    let mut k = 1;
    while k < ROWS {
        all[k] = 1.0 / k as f64;
        k += 1;
    }
    all
};

/// The series of two links: coefficient k is that of `t^k`.
#[derive(Debug, Clone)]
struct Lane {
    q: [Two; ROWS],
    v: [Two; ROWS],
    sin: [Two; ROWS],
    cos: [Two; ROWS],
    /// P and Q of the equations of motion.
    across: [Two; ROWS],
    along: [Two; ROWS],
    /// The second derivatives of sine and cosine at the order in work: without the acceleration, then its part alone.
    bent: [Two; 2],
    /// What drives the acceleration of the order in work.
    rest: Two,
    acceleration: Two,
}

impl Lane {
    const EMPTY: Self = Self {
        q: [[0.0; 2]; ROWS],
        v: [[0.0; 2]; ROWS],
        sin: [[0.0; 2]; ROWS],
        cos: [[0.0; 2]; ROWS],
        across: [[0.0; 2]; ROWS],
        along: [[0.0; 2]; ROWS],
        bent: [[0.0; 2]; 2],
        rest: [0.0; 2],
        acceleration: [0.0; 2],
    };
}

/// A matrix over the links: entries of two rows in one column, block row after block row.
#[derive(Debug, Clone, Default)]
struct Blocks(Vec<Two>);

impl Blocks {
    fn new(n: usize, entry: impl Fn(usize, usize) -> f64) -> Self {
        let lanes = n.div_ceil(2);
        let at = |i: usize, j: usize| if i < n && j < n { entry(i, j) } else { 0.0 };
        let blocks = (0..lanes).flat_map(|r| (0..2 * lanes).map(move |j| (r, j)));
        Self(
            blocks
                .map(|(r, j)| [at(2 * r, j), at(2 * r + 1, j)])
                .collect(),
        )
    }

    /// Block row r of a matrix over so many lanes.
    #[inline]
    fn row(&self, r: usize, lanes: usize) -> &[Two] {
        &self.0[2 * r * lanes..2 * (r + 1) * lanes]
    }
}

/// `sum += row x`, x given by lanes.
#[inline]
fn add_product(sum: &mut Two, row: &[Two], lanes: &[Lane], of: impl Fn(&Lane) -> Two) {
    for (columns, lane) in row.chunks_exact(2).zip(lanes) {
        let x = of(lane);
        for i in 0..2 {
            sum[i] += columns[0][i] * x[0] + columns[1][i] * x[1];
        }
    }
}

/// What does not change with the state.
#[derive(Debug, Clone)]
struct Coefficients {
    order: usize,
    inertia: Blocks,
    /// Empty without damping.
    damping: Blocks,
    /// `h_i g`
    weight: Vec<Two>,
}

/// The Taylor series of a pendulum's motion about one state after another.
#[derive(Debug, Clone)]
pub(crate) struct PendulumSeries {
    n: usize,
    lanes: Vec<Lane>,
    inertia: DMatrix<f64>,
    coefficients: Coefficients,
    excitation: Excitation,
    /// The inverse of the mass matrix at the start.
    inverse: Blocks,
    mass: Vec<f64>,
    column: Vec<f64>,
}

/// Fills the series from their coefficients of order zero.
#[allow(
    clippy::inline_always,
    reason = "the loops over lanes are written out where their number is known"
)]
#[inline(always)]
fn expand<E: Shaking>(
    lanes: &mut [Lane],
    c: &Coefficients,
    inverse: &Blocks,
    excitation: &E,
    angle: f64,
) {
    let count = lanes.len();
    let mut factor = excitation.begin(angle);
    for lane in lanes.iter_mut() {
        for i in 0..2 {
            lane.sin[1][i] = lane.cos[0][i] * lane.v[0][i];
            lane.cos[1][i] = -lane.sin[0][i] * lane.v[0][i];
        }
    }
    for k in 0..c.order {
        let next = (k + 1) as f64;
        for lane in lanes.iter_mut() {
            known_part(lane, k);
        }
        for r in 0..count {
            let row = c.inertia.row(r, count);
            let (mut across, mut along) = (excitation.base(factor, r).map(|b| -b), [0.0; 2]);
            if k == 0 {
                along = c.weight[r].map(|w| -w);
            }
            add_product(&mut across, row, lanes, |lane| lane.bent[0]);
            add_product(&mut along, row, lanes, |lane| lane.bent[1]);
            let mut drag = [0.0; 2];
            if !c.damping.0.is_empty() {
                add_product(&mut drag, c.damping.row(r, count), lanes, |lane| lane.v[k]);
            }
            let force = excitation.force(factor, r);
            let lane = &mut lanes[r];
            for i in 0..2 {
                lane.rest[i] +=
                    force[i] - drag[i] - lane.cos[0][i] * across[i] + lane.sin[0][i] * along[i];
            }
            (lane.across[k], lane.along[k]) = (across, along);
        }
        for r in 0..count {
            let mut acceleration = [0.0; 2];
            add_product(&mut acceleration, inverse.row(r, count), lanes, |lane| {
                lane.rest
            });
            lanes[r].acceleration = acceleration;
        }
        let (by_next, by_both) = (RECIPROCALS[k + 1], RECIPROCALS[k + 1] * RECIPROCALS[k + 2]);
        for lane in lanes.iter_mut() {
            for i in 0..2 {
                let a = lane.acceleration[i];
                let turned = [lane.cos[0][i] * a, -lane.sin[0][i] * a];
                lane.v[k + 1][i] = a * by_next;
                lane.sin[k + 2][i] = (lane.bent[0][i] + turned[0]) * by_both;
                lane.cos[k + 2][i] = (lane.bent[1][i] + turned[1]) * by_both;
                (lane.bent[0][i], lane.bent[1][i]) = (turned[0], turned[1]);
            }
        }
        for r in 0..count {
            let row = c.inertia.row(r, count);
            let (mut across, mut along) = (lanes[r].across[k], lanes[r].along[k]);
            add_product(&mut across, row, lanes, |lane| lane.bent[0]);
            add_product(&mut along, row, lanes, |lane| lane.bent[1]);
            (lanes[r].across[k], lanes[r].along[k]) = (across, along);
        }
        factor = excitation.raise(factor, next);
    }
    for lane in lanes {
        lane.q[c.order + 1] = lane.v[c.order].map(|v| v * RECIPROCALS[c.order + 1]);
    }
}

/// The parts of order k of a lane that do not need the acceleration of order k: the position, the second derivatives of
/// sine and cosine, the products of the equations of motion.
#[allow(clippy::inline_always, reason = "the innermost loop of the series")]
#[inline(always)]
fn known_part(lane: &mut Lane, k: usize) {
    let next = (k + 1) as f64;
    let (mut sin, mut cos, mut rest) = ([0.0; 2], [0.0; 2], [0.0; 2]);
    // The coefficients found last come last: the sum does not wait for them.
    let (c, s, v) = (&lane.cos[1..][..k], &lane.sin[1..][..k], &lane.v[1..][..k]);
    let (p, q) = (&lane.across[..k], &lane.along[..k]);
    for j in 0..k {
        let back = k - 1 - j;
        for i in 0..2 {
            sin[i] += c[back][i] * v[j][i];
            cos[i] += s[back][i] * v[j][i];
            rest[i] += s[back][i] * q[j][i] - c[back][i] * p[j][i];
        }
    }
    let (c, s, v) = (lane.cos[k + 1], lane.sin[k + 1], lane.v[0]);
    for i in 0..2 {
        sin[i] = next * (sin[i] + c[i] * v[i]);
        cos[i] = -next * (cos[i] + s[i] * v[i]);
        lane.q[k + 1][i] = lane.v[k][i] * RECIPROCALS[k + 1];
    }
    lane.bent = [sin, cos];
    lane.rest = rest;
}

/// [`expand`] with the number of lanes known at compile time where it is small.
fn expand_lanes<E: Shaking>(
    lanes: &mut [Lane],
    c: &Coefficients,
    inverse: &Blocks,
    excitation: &E,
    angle: f64,
) {
    match lanes {
        [_] => expand(&mut lanes[..1], c, inverse, excitation, angle),
        [_, _] => expand(&mut lanes[..2], c, inverse, excitation, angle),
        [_, _, _] => expand(&mut lanes[..3], c, inverse, excitation, angle),
        _ => expand(lanes, c, inverse, excitation, angle),
    }
}

impl PendulumSeries {
    /// Series of an order, of the velocities; the positions have one more.
    pub fn new(links: Links, forcing: &Forcing, order: usize) -> Self {
        let n = links.hanging.len();
        let is_damped = links.damping.amax() > 0.0;
        Self {
            n,
            lanes: vec![Lane::EMPTY; n.div_ceil(2)],
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
            inverse: Blocks::new(n, |_, _| 0.0),
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

    /// Makes the series about a state, at a forcing angle.
    ///
    /// # Errors
    /// A mass matrix that is not positive definite in double precision.
    pub fn expand(&mut self, angle: f64, q: &[f64], v: &[f64]) -> Result<()> {
        for (i, (q, v)) in q.iter().zip(v).enumerate() {
            let lane = &mut self.lanes[i / 2];
            (lane.q[0][i % 2], lane.v[0][i % 2]) = (*q, *v);
            (lane.sin[0][i % 2], lane.cos[0][i % 2]) = q.sin_cos();
        }
        self.invert_mass()?;
        let Self {
            lanes,
            coefficients,
            inverse,
            excitation,
            ..
        } = self;
        match excitation {
            Excitation::None => expand_lanes(lanes, coefficients, inverse, &Calm, angle),
            Excitation::Base(base) => expand_lanes(lanes, coefficients, inverse, base, angle),
            Excitation::Forces(forces) => expand_lanes(lanes, coefficients, inverse, forces, angle),
        }
        Ok(())
    }

    /// The inverse of the mass matrix at the start.
    fn invert_mass(&mut self) -> Result<()> {
        let Self {
            n,
            lanes,
            inertia,
            mass,
            column,
            inverse,
            ..
        } = self;
        let n = *n;
        let (sin, cos) = (
            |i: usize| lanes[i / 2].sin[0][i % 2],
            |i: usize| lanes[i / 2].cos[0][i % 2],
        );
        let entry = |i: usize, j: usize| inertia[(i, j)] * (cos(i) * cos(j) + sin(i) * sin(j));
        if n == 2 {
            let (a, b, d) = (inertia[(0, 0)], entry(0, 1), inertia[(1, 1)]);
            let det = a * d - b * b;
            if det.is_nan() || det <= 0.0 {
                return Err(singular_mass());
            }
            let scale = 1.0 / det;
            inverse.0[0] = [d * scale, -b * scale];
            inverse.0[1] = [-b * scale, a * scale];
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
                inverse.0[i / 2 * 2 * n.div_ceil(2) + j][i % 2] = *x;
            }
        }
        Ok(())
    }

    /// The largest of some numbers of the links; one that is not a number counts as such.
    fn largest(&self, of: impl Fn(&Lane) -> Two) -> f64 {
        let all = self.lanes.iter().flat_map(of);
        all.fold(0.0, |most, x| {
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
            (allowed / term).powf(1.0 / k as f64)
        };
        step(p - 1, early).min(step(p, late))
    }

    /// The state a time s after the start.
    pub fn state(&self, s: f64, x: &mut [f64]) {
        let (q, v) = x.split_at_mut(self.n);
        let sum = |rows: &[Two]| {
            rows.iter().rev().fold([0.0; 2], |sum: Two, c| {
                [sum[0] * s + c[0], sum[1] * s + c[1]]
            })
        };
        let p = self.order();
        for (lane, (q, v)) in self.lanes.iter().zip(q.chunks_mut(2).zip(v.chunks_mut(2))) {
            let (at, rate) = (sum(&lane.q[..=p + 1]), sum(&lane.v[..=p]));
            q.copy_from_slice(&at[..q.len()]);
            v.copy_from_slice(&rate[..v.len()]);
        }
    }

    /// The coefficients of a link's angle.
    pub fn angle(&self, link: usize) -> impl Iterator<Item = f64> {
        let rows = &self.lanes[link / 2].q[..self.order() + 2];
        rows.iter().map(move |row| row[link % 2])
    }

    /// The coefficients of the sine of a link's angle.
    pub fn sine(&self, link: usize) -> impl Iterator<Item = f64> {
        let rows = &self.lanes[link / 2].sin[..self.order() + 2];
        rows.iter().map(move |row| row[link % 2])
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

    fn chain(n: usize, damper: f64) -> System {
        let masses = DVector::from_fn(n, |i, _| 1.0 + 0.3 * i as f64);
        let lengths = DVector::from_fn(n, |i, _| 0.9 - 0.1 * i as f64);
        let dampers = DVector::from_element(n, damper);
        PendulumChain::new(masses, lengths, &dampers, 9.81)
            .expect("valid")
            .into()
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
        let mut systems: Vec<System> = vec![pair.into(), free.into()];
        systems.extend((1..=7).map(|n| chain(n, 0.3 * (n % 2) as f64)));
        for system in systems {
            let n = system.n_dof();
            let q = DVector::from_fn(n, |i, _| 0.8 - 0.5 * i as f64);
            let v = DVector::from_fn(n, |i, _| -0.3 + 0.4 * i as f64);
            for forcing in forcings(n) {
                let scene = Scene::new(system.clone(), forcing, Vec::<Stop>::new()).expect("valid");
                let frequency = scene.forcing().frequency().unwrap_or(0.0);
                let motion = SceneMotion::new(&scene);
                let order = 14;
                let links = system.links().expect("a pendulum");
                let mut series = PendulumSeries::new(links, scene.forcing(), order);
                series
                    .expand(0.9, q.as_slice(), v.as_slice())
                    .expect("regular");
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
                        let terms = series.lanes[i / 2].v[..=order].iter().enumerate().skip(1);
                        at_time(terms.map(|(k, v)| k as f64 * v[i % 2]), s)
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
        let system = chain(2, 0.1);
        let mut series =
            PendulumSeries::new(system.links().expect("a pendulum"), &Forcing::Unforced, 12);
        series
            .expand(0.0, &[0.5, -0.2], &[1.0, -2.0])
            .expect("regular");
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
        let system = chain(1, 0.0);
        let mut series =
            PendulumSeries::new(system.links().expect("a pendulum"), &Forcing::Unforced, 12);
        let tolerance = Tolerance {
            relative: 1e-9,
            absolute: 1e-12,
        };
        series.expand(0.0, &[0.0], &[0.0]).expect("regular");
        assert_eq!(series.longest_step(tolerance, None), f64::INFINITY);
        series.expand(0.0, &[0.3], &[1e40]).expect("regular");
        assert!(series.longest_step(tolerance, None).is_nan());
    }
}
