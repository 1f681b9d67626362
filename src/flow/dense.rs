//! A linear flow that does not uncouple (defective state matrix): the matrix exponential of the state enlarged by 1, and by cos and
//! sin of each harmonic of the forcing (theory 4), each a pair more at the end of the state.

use crate::flow::drive::turning;
use crate::flow::gap_row::{Derivatives, GapRow, Quantity};
use crate::flow::linear::{FlowRates, FlowRows, LinearFlow, softest_rate};
use crate::linalg::francis::eigenvalues;
use crate::linalg::matrix_exponential::matrix_exponential;
use crate::modal::{ModalState, Pair, Response};
use crate::model::powers;
use nalgebra::{Complex, DMatrix};

/// A flow that does not uncouple.
#[derive(Debug, Clone)]
pub(crate) struct DenseFlow {
    /// State matrix in interleaved pairs, shape `(2n, 2n)`.
    matrix: DMatrix<f64>,
    /// The matrix enlarged by the load and K harmonics, shape `(2n + 1 + 2K, 2n + 1 + 2K)`.
    enlarged: DMatrix<f64>,
    load: Vec<f64>,
    /// By harmonics, then by entries of the state.
    forces: Vec<Vec<Complex<f64>>>,
    frequency: f64,
    /// Scales of the unknowns for the norm, and its growth over the longest step.
    unit: Vec<f64>,
    growth: f64,
    longest_step: f64,
    fastest_growth: f64,
}

impl DenseFlow {
    /// A flow with the given state matrix, load and harmonics of a force in interleaved pairs; frequency zero without forcing.
    pub fn new(
        matrix: DMatrix<f64>,
        load: &[Pair],
        forces: &[Vec<Response>],
        frequency: f64,
    ) -> Self {
        let m = matrix.nrows();
        let load: Vec<f64> = load.iter().flatten().copied().collect();
        let flat = |force: &Vec<Response>| force.iter().flatten().copied().collect();
        let forces: Vec<Vec<Complex<f64>>> = forces.iter().map(flat).collect();
        let order = m + 1 + 2 * forces.len();
        let mut enlarged = DMatrix::zeros(order, order);
        enlarged.view_mut((0, 0), (m, m)).copy_from(&matrix);
        for i in 0..m {
            enlarged[(i, m)] = load[i];
        }
        for (k, force) in forces.iter().enumerate() {
            let (cos, sin) = (m + 1 + 2 * k, m + 2 + 2 * k);
            for i in 0..m {
                enlarged[(i, cos)] = force[i].re;
                enlarged[(i, sin)] = -force[i].im;
            }
            let w = (k + 1) as f64 * frequency;
            enlarged[(cos, sin)] = -w;
            enlarged[(sin, cos)] = w;
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
        let longest_step =
            (1.0 / softest_rate([rate, frequency].into_iter())).min(0.7 / growth_rate);
        let growth = (growth_rate * longest_step).exp();
        let fastest_growth = eigenvalues(matrix.clone()).map_or(growth_rate, |roots| {
            roots.into_iter().map(|l| l.re).fold(0.0, f64::max)
        });
        Self {
            matrix,
            enlarged,
            load,
            forces,
            frequency,
            unit,
            growth,
            longest_step,
            fastest_growth,
        }
    }

    /// The frequencies of the harmonics.
    fn frequencies(&self) -> impl Iterator<Item = f64> {
        (1..=self.forces.len()).map(|k| k as f64 * self.frequency)
    }

    /// Where the harmonics are at an angle of the first.
    fn phasors(&self, angle: f64) -> impl Iterator<Item = Pair> {
        let phasors = powers(Complex::new(angle.cos(), angle.sin()));
        phasors.take(self.forces.len()).map(|u| [u.re, u.im])
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

    fn state_from_modal(&self, modal_state: &ModalState, angle: f64, state: &mut Vec<Pair>) {
        state.clear();
        state.extend_from_slice(modal_state);
        state.extend(self.phasors(angle));
    }

    fn modal_from_state(&self, state: &[Pair], modal_state: &mut ModalState) {
        modal_state.clear();
        modal_state.extend_from_slice(&state[..self.matrix.nrows() / 2]);
    }

    fn set_angle(&self, state: &mut [Pair], angle: f64) {
        let turned = &mut state[self.matrix.nrows() / 2..];
        for (place, u) in turned.iter_mut().zip(self.phasors(angle)) {
            *place = u;
        }
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
        let z: Vec<f64> = state[..m / 2].iter().flatten().copied().collect();
        let turned = state[m / 2..].iter().map(|u| Complex::new(u[0], u[1]));
        let mut phasors: Vec<Complex<f64>> = turned.clone().collect();
        let mut orders = vec![z];
        for order in 0..3 {
            let mut next = self.image(&orders[order]);
            for (i, x) in next.iter_mut().enumerate() {
                let forces = self.forces.iter().zip(&phasors);
                let input: f64 = forces.map(|(force, u)| (force[i] * u).re).sum();
                *x += input + if order == 0 { self.load[i] } else { 0.0 };
            }
            for (u, w) in phasors.iter_mut().zip(self.frequencies()) {
                *u *= Complex::new(0.0, w);
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
        derivatives.extend(turned.zip(self.frequencies()).map(|(u, w)| turning(u, w)));
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
        for ((force, w), f) in self
            .forces
            .iter()
            .zip(self.frequencies())
            .zip(quantity.harmonics())
        {
            let w3 = w.powi(3);
            let direct: Complex<f64> = flat.iter().zip(force).map(|(r, f)| f * *r).sum();
            let squares = force
                .iter()
                .zip(&self.unit)
                .map(|(f, s)| f.norm_sqr() * s * s);
            let size = squares.sum::<f64>().sqrt();
            forced += direct.norm() * w3 + f.norm() * w3 * w;
            forced_growth += weight * size * w3;
            cells.push(([f.re, -f.im], 0.0, f64::INFINITY));
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
        norms.resize(self.matrix.nrows() / 2 + self.forces.len(), f64::INFINITY);
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
        self.frequencies().fold(self.matrix.norm(), f64::max)
    }

    fn fastest_growth(&self) -> f64 {
        self.fastest_growth
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::linear::contract;

    #[test]
    fn a_defective_flow_keeps_the_contract() {
        let force = [[Complex::new(0.3, 0.1), Complex::new(-0.2, 0.4)]; 2];
        let matrix = nalgebra::dmatrix![
            0.0, 1.0, 0.0, 0.0;
            -1.0, 0.0, -1.0, 0.0;
            0.0, 0.0, 0.0, 1.0;
            0.0, 0.0, -1.0, 0.0
        ];
        contract::check(
            &DenseFlow::new(matrix, &[[0.0, 0.2], [0.0, 0.1]], &[force.to_vec()], 0.8),
            2,
            0.8,
        );
    }
}
