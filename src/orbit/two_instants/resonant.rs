//! Modes that keep their two unknowns in the periodic conditions (undamped, in resonance, rigid): what rows see of their
//! flight from a state, a load and a forcing, as functions of its span with proved bounds (theory 5).

use crate::flow::ModalScene;
use crate::modal::Form;
use crate::orbit::one_instant::periodic_conditions::enlarged_exponential;
use crate::orbit::two_instants::green::TimeInterval;
use crate::orbit::two_instants::taylor_model::{TAYLOR_TERMS, UnscaledModel};
use nalgebra::{DMatrix, DVector, RowDVector};

/// The resonant blocks with their input: `y = (z, 1, cos, sin)`, `y' = A y`.
pub(crate) struct ResonantModes<'a> {
    scene: &'a ModalScene,
    indices: &'a [usize],
    matrix: DMatrix<f64>,
    /// Units in which the matrix is measured: a row r has the norm `|r/unit|`, a state y the norm `|unit y|`.
    units: DVector<f64>,
    /// `|e^{A t}| <= e^{rate |t|}` in these units.
    rate: f64,
}

impl<'a> ResonantModes<'a> {
    /// The blocks with the given indices, all of them where the flow is dense.
    pub fn new(scene: &'a ModalScene, indices: &'a [usize]) -> Self {
        let m = 2 * indices.len();
        let w = scene.frequency;
        let mut matrix = DMatrix::zeros(m + 3, m + 3);
        let mut units = DVector::from_element(m + 3, 1.0);
        match &scene.form.form {
            Form::Blocks(blocks) => {
                for (i, &j) in indices.iter().enumerate() {
                    let a = blocks[j].matrix();
                    for r in 0..2 {
                        for c in 0..2 {
                            matrix[(2 * i + r, 2 * i + c)] = a[r][c];
                        }
                    }
                    units[2 * i] = blocks[j].norm(w).weight.sqrt();
                }
            }
            Form::Dense(state) => {
                matrix.view_mut((0, 0), (m, m)).copy_from(state);
                let rate = state.amax().sqrt().max(w);
                units.iter_mut().take(m).step_by(2).for_each(|x| *x = rate);
            }
        }
        for (i, &j) in indices.iter().enumerate() {
            for c in 0..2 {
                matrix[(2 * i + c, m)] = scene.load[j][c];
                matrix[(2 * i + c, m + 1)] = scene.force[j][c].re;
                matrix[(2 * i + c, m + 2)] = -scene.force[j][c].im;
            }
        }
        matrix[(m + 1, m + 2)] = -w;
        matrix[(m + 2, m + 1)] = w;
        for c in m..m + 3 {
            let size = (0..m)
                .map(|i| (units[i] * matrix[(i, c)]).abs())
                .fold(0.0, f64::max)
                / w;
            units[c] = if size > 0.0 { size } else { 1.0 };
        }
        let largest = units[m + 1].max(units[m + 2]);
        (units[m + 1], units[m + 2]) = (largest, largest);
        let rate = matrix
            .map_with_location(|r, c, x| x * units[r] / units[c])
            .norm();
        Self {
            scene,
            indices,
            matrix,
            units,
            rate,
        }
    }

    /// `e^{A t}`, from the closed forms of the blocks where there are such.
    pub fn flow(&self, t: f64) -> DMatrix<f64> {
        let m = 2 * self.indices.len();
        let Form::Blocks(blocks) = &self.scene.form.form else {
            let Form::Dense(state) = &self.scene.form.form else {
                return DMatrix::zeros(m + 3, m + 3);
            };
            return enlarged_exponential(state, self.scene, t);
        };
        let mut flow = DMatrix::identity(m + 3, m + 3);
        for (i, &j) in self.indices.iter().enumerate() {
            let (block, w) = (blocks[j], self.scene.frequency);
            let (propagator, loaded) = (block.propagator(t), block.loaded(t, self.scene.load[j]));
            let forced = block.forced(t, w, self.scene.force[j]);
            for r in 0..2 {
                let row = 2 * i + r;
                flow[(row, 2 * i)] = propagator[r][0];
                flow[(row, 2 * i + 1)] = propagator[r][1];
                flow[(row, m)] = loaded[r];
                flow[(row, m + 1)] = forced[r].re;
                flow[(row, m + 2)] = -forced[r].im;
            }
        }
        let (s, c) = (self.scene.frequency * t).sin_cos();
        flow.view_mut((m + 1, m + 1), (2, 2))
            .copy_from(&nalgebra::matrix![c, -s; s, c]);
        flow
    }

    /// `row e^{A t}` over a cell of t: coefficients of z, of the load, and of the phase's cosine and sine.
    pub fn row(&self, row: &[f64], flow: &DMatrix<f64>, cell: &TimeInterval) -> Vec<UnscaledModel> {
        let width = self.units.len();
        let mut padded = RowDVector::zeros(width);
        padded.columns_mut(0, row.len()).copy_from_slice(row);
        let growth = (self.rate * cell.scale).exp();
        let mut entries = vec![UnscaledModel::default(); width];
        let mut term = padded * flow;
        for k in 0..TAYLOR_TERMS + 3 {
            let norm = term.transpose().component_div(&self.units).norm() * growth;
            put(&mut entries, k, term.iter().copied(), |i| {
                norm * self.units[i]
            });
            term = term * &self.matrix * (cell.scale / (k + 1) as f64);
        }
        entries
    }

    /// `e^{A tau} column` over a cell of tau, x counting against tau, z only.
    pub fn column(
        &self,
        column: &[f64],
        flow: &DMatrix<f64>,
        cell: &TimeInterval,
    ) -> Vec<UnscaledModel> {
        let mut padded = DVector::zeros(self.units.len());
        padded.rows_mut(0, column.len()).copy_from_slice(column);
        let growth = (self.rate * cell.scale).exp();
        let mut entries = vec![UnscaledModel::default(); column.len()];
        let mut term = flow * padded;
        for k in 0..TAYLOR_TERMS + 3 {
            let norm = term.component_mul(&self.units).norm() * growth;
            put(&mut entries, k, term.iter().copied(), |i| {
                norm / self.units[i]
            });
            term = &self.matrix * term * (-cell.scale / (k + 1) as f64);
        }
        entries
    }
}

/// Stores the coefficients of order k, or their bounds.
fn put(
    entries: &mut [UnscaledModel],
    k: usize,
    term: impl Iterator<Item = f64>,
    bound: impl Fn(usize) -> f64,
) {
    for (i, (entry, x)) in entries.iter_mut().zip(term).enumerate() {
        if k < TAYLOR_TERMS + 2 {
            entry.c[k] = x;
        }
        if k == 0 {
            entry.size = bound(i);
        }
        if k >= TAYLOR_TERMS {
            entry.rest[k - TAYLOR_TERMS] = bound(i);
        }
    }
}
