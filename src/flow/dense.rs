//! A linear flow that does not uncouple (defective state matrix): the matrix exponential of the state enlarged by 1, by cos and sin of
//! each harmonic of the forcing (theory 4), and by the derivatives of each signal, pairs at the end of the state.

use crate::flow::drive::{Drive, Turning};
use crate::flow::gap_row::{Derivatives, GapRow, Quantity};
use crate::flow::linear::{FlowRates, FlowRows, LinearFlow, fitted_step, softest_rate};
use crate::flow::many_drive::ManyDrive;
use crate::linalg::francis::eigenvalues;
use crate::linalg::matrix_exponential::matrix_exponential;
use crate::modal::{ModalState, Pair};
use crate::model::Moment;
use nalgebra::{Complex, DMatrix};

/// A flow that does not uncouple.
#[derive(Debug, Clone)]
pub(crate) struct DenseFlow {
    /// State matrix in interleaved pairs, shape `(2n, 2n)`.
    matrix: DMatrix<f64>,
    /// The matrix enlarged by the load and K pairs of what drives it, shape `(2n + 1 + 2K, 2n + 1 + 2K)`.
    enlarged: DMatrix<f64>,
    load: Vec<f64>,
    drive: ManyDrive,
    /// By rotations, then by entries of the state.
    forces: Vec<Vec<Complex<f64>>>,
    /// By signals, then by entries of the state.
    directions: Vec<Vec<f64>>,
    /// Scales of the unknowns for the norm, and its growth over the longest step.
    unit: Vec<f64>,
    growth: f64,
    longest_step: f64,
    fastest_growth: f64,
}

impl DenseFlow {
    /// A flow with the given state matrix, load and what drives it, in interleaved pairs.
    pub fn new(matrix: DMatrix<f64>, load: &[Pair], drive: ManyDrive) -> Self {
        let m = matrix.nrows();
        let load: Vec<f64> = load.iter().flatten().copied().collect();
        let forces = drive.forces.iter();
        let forces: Vec<Vec<Complex<f64>>> = forces.map(|force| force.concat()).collect();
        let directions = drive.signals.iter();
        let directions: Vec<Vec<f64>> = directions.map(|own| own.directions.concat()).collect();
        let order = m + 1 + 2 * drive.n_pairs();
        let mut enlarged = DMatrix::zeros(order, order);
        enlarged.view_mut((0, 0), (m, m)).copy_from(&matrix);
        for i in 0..m {
            enlarged[(i, m)] = load[i];
        }
        for (k, (force, w)) in forces.iter().zip(drive.frequencies()).enumerate() {
            let (cos, sin) = (m + 1 + 2 * k, m + 2 + 2 * k);
            for i in 0..m {
                enlarged[(i, cos)] = force[i].re;
                enlarged[(i, sin)] = -force[i].im;
            }
            enlarged[(cos, sin)] = -w;
            enlarged[(sin, cos)] = w;
        }
        let mut place = m + 1 + 2 * forces.len();
        for (signal, direction) in drive.signals.iter().zip(&directions) {
            for (i, d) in direction.iter().enumerate() {
                enlarged[(i, place)] = *d;
            }
            let orders = 2 * signal.n_pairs();
            for order in 1..orders {
                enlarged[(place + order - 1, place + order)] = 1.0;
            }
            place += orders;
        }
        // Positions in units of velocity over the system's own rate; the growth of the Euclidean norm is at most the
        // largest eigenvalue of the symmetric part, itself at most the norm of that part.
        let rate = {
            let stiffness = matrix.iter().fold(0.0f64, |a, &x| a.max(x.abs())).sqrt();
            if stiffness > 0.0 { stiffness } else { 1.0 }
        };
        let unit: Vec<f64> = (0..m)
            .map(|i| if i % 2 == 0 { rate } else { 1.0 })
            .collect();
        let scaled = DMatrix::from_fn(m, m, |i, j| matrix[(i, j)] * unit[i] / unit[j]);
        let growth_rate = ((&scaled + scaled.transpose()) * 0.5).norm();
        let slowest = drive.frequencies().next().unwrap_or(0.0);
        let longest_step = (1.0 / softest_rate([rate, slowest].into_iter())).min(0.7 / growth_rate);
        let longest_step = fitted_step(longest_step, drive.pieces());
        let growth = (growth_rate * longest_step).exp();
        let fastest_growth = eigenvalues(matrix.clone()).map_or(growth_rate, |roots| {
            roots.into_iter().map(|l| l.re).fold(0.0, f64::max)
        });
        Self {
            matrix,
            enlarged,
            load,
            drive,
            forces,
            directions,
            unit,
            growth,
            longest_step,
            fastest_growth,
        }
    }

    fn image(&self, z: &[f64]) -> Vec<f64> {
        let m = z.len();
        (0..m)
            .map(|i| (0..m).map(|j| self.matrix[(i, j)] * z[j]).sum())
            .collect()
    }
}

impl LinearFlow for DenseFlow {
    type Propagator = DMatrix<f64>;

    fn state_from_modal(&self, modal_state: &ModalState, at: Moment, state: &mut Vec<Pair>) {
        let n = modal_state.len();
        state.clear();
        state.extend_from_slice(modal_state);
        state.resize(n + self.drive.n_pairs(), [0.0, 0.0]);
        self.drive.store(at, &mut state[n..]);
    }

    fn modal_from_state(&self, state: &[Pair], modal_state: &mut ModalState) {
        modal_state.clear();
        modal_state.extend_from_slice(&state[..self.matrix.nrows() / 2]);
    }

    fn set_moment(&self, state: &mut [Pair], at: Moment) {
        self.drive.store(at, &mut state[self.matrix.nrows() / 2..]);
    }

    fn prepare(&self, t: f64, propagator: &mut DMatrix<f64>) {
        *propagator = matrix_exponential(&(&self.enlarged * t));
    }

    fn advance(&self, propagator: &DMatrix<f64>, state: &mut [Pair]) {
        let m = self.matrix.nrows();
        let mut z: Vec<f64> = state.iter().flatten().copied().collect();
        z.insert(m, 1.0);
        let row = |i: usize| (0..z.len()).map(|j| propagator[(i, j)] * z[j]).sum::<f64>();
        for (i, pair) in state.iter_mut().enumerate() {
            let first = if i < m / 2 { 2 * i } else { 2 * i + 1 };
            *pair = [row(first), row(first + 1)];
        }
    }
}

impl FlowRows for DenseFlow {
    fn derivatives(&self, state: &[Pair], derivatives: &mut Vec<Derivatives>) {
        let m = self.matrix.nrows();
        let (own, stored) = state.split_at(m / 2);
        let z = own.concat();
        let turned = stored.iter().zip(self.drive.frequencies());
        let mut phasors: Vec<(Complex<f64>, f64)> =
            turned.map(|(u, w)| (Complex::new(u[0], u[1]), w)).collect();
        let signals: Vec<Derivatives> = self.drive.turning(stored).skip(phasors.len()).collect();
        let mut orders = vec![z];
        for order in 0..3 {
            let mut next = self.image(&orders[order]);
            for (i, x) in next.iter_mut().enumerate() {
                let forces = self.forces.iter().zip(&phasors);
                let input: f64 = forces.map(|(force, (u, _))| (force[i] * u).re).sum();
                *x += input + if order == 0 { self.load[i] } else { 0.0 };
                let mut first = 0;
                for (signal, direction) in self.drive.signals.iter().zip(&self.directions) {
                    let Derivatives { z, d1, d2, .. } = signals[first];
                    *x += direction[i] * [z, d1, d2][order][0];
                    first += signal.n_pairs();
                }
            }
            for (u, w) in &mut phasors {
                *u *= Complex::new(0.0, *w);
            }
            orders.push(next);
        }
        let norm = orders[3]
            .iter()
            .zip(&self.unit)
            .map(|(d, s)| (d * s).powi(2))
            .sum::<f64>()
            .sqrt();
        let pair = |order: usize, j: usize| [orders[order][2 * j], orders[order][2 * j + 1]];
        derivatives.clear();
        derivatives.extend((0..m / 2).map(|j| Derivatives {
            z: pair(0, j),
            d1: pair(1, j),
            d2: pair(2, j),
            d3: pair(3, j),
            // One norm for all, counted once.
            norm: if j == 0 { norm } else { 0.0 },
        }));
        derivatives.extend(self.drive.turning(stored));
    }

    fn gap_row(&self, quantity: &Quantity) -> GapRow {
        let Quantity {
            constant,
            size: known_size,
            row,
            ..
        } = quantity;
        let m = self.matrix.nrows();
        let flat: Vec<f64> = row.iter().flatten().copied().collect();
        let norm = (0..m)
            .map(|j| {
                let image: f64 = (0..m).map(|i| flat[i] * self.matrix[(i, j)]).sum();
                (image / self.unit[j]).powi(2)
            })
            .sum::<f64>()
            .sqrt();
        let weight = norm * self.growth;
        let mut cells: Vec<_> = row.iter().map(|&r| (r, weight, f64::INFINITY)).collect();
        let (mut forced, mut forced_growth) = (0.0, 0.0);
        for (force, w) in self.forces.iter().zip(self.drive.frequencies()) {
            let w3 = w.powi(3);
            let direct: Complex<f64> = flat.iter().zip(force).map(|(r, f)| f * *r).sum();
            let squares = force
                .iter()
                .zip(&self.unit)
                .map(|(f, s)| f.norm_sqr() * s * s);
            let size = squares.sum::<f64>().sqrt();
            forced += direct.norm() * w3;
            forced_growth += weight * size * w3;
        }
        let most = (self.drive.pieces()).map_or(0.0, |[_, longest]| longest.min(self.longest_step));
        let signal_weight = |direction: &Vec<f64>| {
            let direct: f64 = flat.iter().zip(direction).map(|(r, d)| r * d).sum();
            let squares = direction
                .iter()
                .zip(&self.unit)
                .map(|(d, s)| (d * s).powi(2));
            direct.abs() + weight * squares.sum::<f64>().sqrt() * most
        };
        let signal_weights: Vec<f64> = self.directions.iter().map(signal_weight).collect();
        for stored in self.drive.rows(quantity, &signal_weights) {
            cells.push((stored.row, stored.weight, f64::INFINITY));
            forced += stored.forced;
        }
        let terms = (*constant, *known_size + quantity.amplitude());
        GapRow::new(cells.into_iter(), terms, terms, (forced, forced_growth))
    }

    fn velocity_row(&self, row: &[Pair]) -> Vec<Pair> {
        row.to_vec()
    }

    /// Nothing is known of all times to come.
    fn norms(&self, _state: &[Pair], norms: &mut Vec<f64>) {
        norms.clear();
        norms.resize(
            self.matrix.nrows() / 2 + self.drive.n_pairs(),
            f64::INFINITY,
        );
    }
}

impl FlowRates for DenseFlow {
    fn longest_step(&self) -> f64 {
        self.longest_step
    }

    fn holds_for_ever(&self) -> bool {
        false
    }

    fn fastest_rate(&self) -> f64 {
        let of_pieces = (self.drive.pieces()).map_or(0.0, |[shortest, _]| 1.0 / shortest);
        let own = self.matrix.norm().max(of_pieces);
        self.drive.frequencies().fold(own, f64::max)
    }

    fn fastest_growth(&self) -> f64 {
        self.fastest_growth
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::linear::contract;
    use crate::model::Rotations;

    #[test]
    fn a_defective_flow_keeps_the_contract() {
        let force = [[Complex::new(0.3, 0.1), Complex::new(-0.2, 0.4)]; 2];
        let matrix = nalgebra::dmatrix![
            0.0, 1.0, 0.0, 0.0;
            -1.0, 0.0, -1.0, 0.0;
            0.0, 0.0, 0.0, 1.0;
            0.0, 0.0, -1.0, 0.0
        ];
        let drive = ManyDrive {
            rotations: Rotations::harmonics(0.8, 1),
            forces: vec![force.to_vec()],
            signals: Vec::new(),
        };
        let flow = DenseFlow::new(matrix, &[[0.0, 0.2], [0.0, 0.1]], drive);
        contract::check(&flow, 2, 0.8);
    }
}
