//! Every orbit of one stop hit once, or of two instants, that a scan finds: over the phase, or over the flight time.

use crate::orbits::plant::{Plant, exponential};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Points of the scan over the phase, and over the flight time.
const PHASES: usize = 2000;
const TIMES: usize = 3000;
/// A condition beyond which the plain solve is not to be trusted.
const WORST_CONDITION: f64 = 1e8;

/// What a flight time leaves of the conditions: `l u = d` for the contacts.
struct Contacts {
    l: DMatrix<f64>,
    d: DVector<f64>,
}

/// The recovery matrix of a stop on lifted states.
fn lifted_recovery(plant: &Plant, stop: usize) -> DMatrix<f64> {
    let (n, face) = (plant.n(), &plant.faces[stop]);
    let mut r = DMatrix::identity(2 * n + 3, 2 * n + 3);
    let change = &face.reaction
        * face.normal.transpose()
        * ((1.0 + face.restitution) / face.normal.dot(&face.reaction));
    let mut block = r.view_mut((n, n), (n, n));
    block -= change;
    r
}

/// States of a fixed point of a lifted map, affine in u: the columns are the constant, cos and sin; with positions and
/// velocities in one unit. `None` where the map's equations are ill-conditioned.
fn fixed_points(plant: &Plant, map: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let m = 2 * plant.n();
    let unit = DVector::from_fn(m, |i, _| if i < plant.n() { 1.0 } else { plant.w });
    let raw = DMatrix::identity(m, m) - map.view((0, 0), (m, m));
    let matrix = DMatrix::from_fn(m, m, |i, j| raw[(i, j)] * unit[j] / unit[i]);
    let svd = matrix.clone().svd(false, false);
    let (largest, least) = (svd.singular_values.max(), svd.singular_values.min());
    if least.is_nan() || least <= largest / WORST_CONDITION {
        return None;
    }
    let rhs = DMatrix::from_fn(m, 3, |i, j| map[(i, m + j)] / unit[i]);
    let x = matrix.lu().solve(&rhs)?;
    Some(DMatrix::from_fn(m, 3, |i, j| x[(i, j)] * unit[i]))
}

/// The phases at which a stop is hit once in a period at its clearance; `None` where that cannot be told.
pub fn phases(plant: &Plant, stop: usize, n_periods: usize) -> Option<Vec<f64>> {
    let period = TAU * n_periods as f64 / plant.w;
    let flight = exponential(&(plant.enlarged() * period));
    let map = lifted_recovery(plant, stop) * flight;
    let states = fixed_points(plant, &map)?;
    let face = &plant.faces[stop];
    let seen = face.normal.transpose() * states.rows(0, plant.n());
    let gap = |phase: f64| face.clearance - seen[0] - seen[1] * phase.cos() - seen[2] * phase.sin();
    let size = face.clearance.abs() + seen.amax();
    let values: Vec<f64> = (0..PHASES)
        .map(|i| gap(TAU * i as f64 / PHASES as f64))
        .collect();
    let least = values.iter().fold(f64::INFINITY, |m, y| m.min(y.abs()));
    let mut found = Vec::new();
    for i in 0..PHASES {
        let (a, b) = (values[i], values[(i + 1) % PHASES]);
        if a * b < 0.0 {
            let (mut low, mut high) = (
                TAU * i as f64 / PHASES as f64,
                TAU * (i + 1) as f64 / PHASES as f64,
            );
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if gap(middle) * a > 0.0 {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            found.push(0.5 * (low + high));
        }
    }
    // A fold, or nearly, is for other tests.
    let is_near_fold = found.is_empty() && least < 1e-3 * size;
    let are_near = found.len() == 2 && (0.5 * (found[0] - found[1])).sin().abs() < 1e-3;
    (!is_near_fold && !are_near).then_some(found)
}

/// A search over the flight time between two impacts.
pub struct Times<'a> {
    plant: &'a Plant,
    stops: [usize; 2],
    big: DMatrix<f64>,
    recoveries: [DMatrix<f64>; 2],
    pub period: f64,
}

impl<'a> Times<'a> {
    pub fn new(plant: &'a Plant, stops: [usize; 2], n_periods: usize) -> Self {
        Self {
            plant,
            stops,
            big: plant.enlarged(),
            recoveries: stops.map(|stop| lifted_recovery(plant, stop)),
            period: TAU * n_periods as f64 / plant.w,
        }
    }

    fn contacts(&self, there: &DMatrix<f64>, back: &DMatrix<f64>) -> Option<Contacts> {
        let (plant, n) = (self.plant, self.plant.n());
        let map = &self.recoveries[0] * back * &self.recoveries[1] * there;
        let first = fixed_points(plant, &map)?;
        // The affine states at the second instant: the lifted columns of (constant, cos, sin).
        let mut lifted = DMatrix::zeros(2 * n + 3, 3);
        lifted.rows_mut(0, 2 * n).copy_from(&first);
        lifted.rows_mut(2 * n, 3).fill_with_identity();
        let second = there * lifted;
        let (mut l, mut d) = (DMatrix::zeros(2, 2), DVector::zeros(2));
        for (i, states) in [&first, &second].into_iter().enumerate() {
            let face = &plant.faces[self.stops[i]];
            let seen = face.normal.transpose() * states.rows(0, n);
            d[i] = face.clearance - seen[0];
            l[(i, 0)] = seen[1];
            l[(i, 1)] = seen[2];
        }
        Some(Contacts { l, d })
    }

    /// `(|adj(L) d|^2 - det(L)^2)`, relative: between -1 and 1.
    fn residual(&self, there: &DMatrix<f64>, back: &DMatrix<f64>) -> Option<f64> {
        let Contacts { l, d } = self.contacts(there, back)?;
        let det = l[(0, 0)] * l[(1, 1)] - l[(0, 1)] * l[(1, 0)];
        let a = [
            l[(1, 1)] * d[0] - l[(0, 1)] * d[1],
            l[(0, 0)] * d[1] - l[(1, 0)] * d[0],
        ];
        let square = a[0] * a[0] + a[1] * a[1];
        Some((square - det * det) / (square + det * det))
    }

    pub fn at(&self, dt: f64) -> Option<f64> {
        let flight = |t: f64| exponential(&(&self.big * t));
        self.residual(&flight(dt), &flight(self.period - dt))
    }

    /// The flight times at which the conditions change sign; `None` where they are ill-conditioned somewhere.
    pub fn scan(&self) -> Option<Vec<f64>> {
        let step = self.period / TIMES as f64;
        let one = exponential(&(&self.big * step));
        let mut powers = vec![DMatrix::identity(one.nrows(), one.ncols())];
        for k in 1..TIMES {
            let next = if k % 250 == 0 {
                exponential(&(&self.big * (step * k as f64)))
            } else {
                &powers[k - 1] * &one
            };
            powers.push(next);
        }
        let values: Vec<f64> = (1..TIMES)
            .map(|k| self.residual(&powers[k], &powers[TIMES - k]))
            .collect::<Option<_>>()?;
        let mut found = Vec::new();
        for (k, pair) in values.windows(2).enumerate() {
            if pair[0] * pair[1] < 0.0 {
                let (mut low, mut high) = (step * (k + 1) as f64, step * (k + 2) as f64);
                for _ in 0..45 {
                    let middle = 0.5 * (low + high);
                    if self.at(middle)? * pair[0] > 0.0 {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                found.push(0.5 * (low + high));
            }
        }
        Some(found)
    }
}
