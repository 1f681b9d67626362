//! The flow of some modes with what drives them, on states with a one and a phasor behind, `(z, 1, cos, sin)`: what rows see of it, as functions
//! of its span with proved bounds (theory 5). Modes that keep their unknowns in the conditions of impacts (undamped, in resonance, rigid) are
//! followed so, and all modes along contacts that last.

use crate::flow::ModalScene;
use crate::linalg::matrix_exponential::matrix_exponential;
use crate::modal::Form;
use crate::orbit::one_instant::periodic_conditions::enlarged_exponential;
use crate::orbit::two_instants::green::TimeInterval;
use crate::orbit::two_instants::taylor_model::{TAYLOR_TERMS, UnscaledModel};
use nalgebra::{DMatrix, DVector, RowDVector};

/// Modes that move by themselves, with a norm in which their deviations grow no faster than at some rate.
struct Part {
    /// Their first place in a state.
    first: usize,
    /// What moves them, shape `(d, d)`.
    matrix: DMatrix<f64>,
    /// A row r has the norm `|r/unit|`, a state z the norm `|unit z|`.
    units: DVector<f64>,
    growth: f64,
    /// The norms of the load and of the force on them.
    load: f64,
    force: f64,
}

/// The blocks of some modes with their input: `y = (z, 1, cos, sin)`, `y' = A y`.
pub(crate) struct EnlargedFlow<'a> {
    scene: &'a ModalScene,
    indices: &'a [usize],
    matrix: DMatrix<f64>,
    /// Units of a state, in which its parts are of one kind and one size, shape (2 modes + 3,), [per unit of each].
    pub(in crate::orbit) units: DVector<f64>,
    parts: Vec<Part>,
}

impl<'a> EnlargedFlow<'a> {
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
        let inputs = |first: usize, count: usize, units: &DVector<f64>| {
            let input = |column: usize| matrix.view((first, column), (count, 1));
            let [load, cos, sin] = [m, m + 1, m + 2].map(|c| input(c).component_mul(units).norm());
            (load, cos.hypot(sin))
        };
        let part = |first: usize, count: usize, growth: Option<f64>| {
            let own = units.rows(first, count).into_owned();
            let (load, force) = inputs(first, count, &own);
            let matrix = matrix.view((first, first), (count, count)).into_owned();
            let scaled = || {
                matrix
                    .map_with_location(|r, c, x| x * own[r] / own[c])
                    .norm()
            };
            let growth = growth.unwrap_or_else(scaled);
            Part {
                first,
                matrix,
                units: own,
                growth,
                load,
                force,
            }
        };
        let parts = match &scene.form.form {
            Form::Blocks(blocks) => {
                let block =
                    |(i, &j): (usize, &usize)| part(2 * i, 2, Some(blocks[j].norm(w).growth));
                indices.iter().enumerate().map(block).collect()
            }
            Form::Dense(_) => vec![part(0, m, None)],
        };
        Self {
            scene,
            indices,
            matrix,
            units,
            parts,
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

    /// The flow of a part alone.
    fn own_flow(&self, part: &Part, t: f64) -> DMatrix<f64> {
        let d = part.units.len();
        match &self.scene.form.form {
            Form::Blocks(blocks) => {
                let p = blocks[self.indices[part.first / 2]].propagator(t);
                DMatrix::from_fn(d, d, |r, c| p[r][c])
            }
            Form::Dense(_) => matrix_exponential(&(&part.matrix * t)),
        }
    }

    /// `row e^{A t}` over a cell of t: coefficients of z, of the load, and of the phase's cosine and sine.
    pub fn row(&self, row: &[f64], flow: &DMatrix<f64>, cell: &TimeInterval) -> Vec<UnscaledModel> {
        let width = self.units.len();
        let m = width - 3;
        let mut padded = RowDVector::zeros(width);
        padded.columns_mut(0, row.len()).copy_from_slice(row);
        let mut entries = vec![UnscaledModel::default(); width];
        let mut term = &padded * flow;
        for (entry, size) in entries.iter_mut().zip((padded.abs() * flow.abs()).iter()) {
            entry.size = *size;
        }
        let reached = term[m + 1].hypot(term[m + 2]);
        for k in 0..TAYLOR_TERMS + 2 {
            for (entry, x) in entries.iter_mut().zip(term.iter()) {
                entry.c[k] = *x;
            }
            term = term * &self.matrix * (cell.scale / (k + 1) as f64);
        }
        // The derivatives of each part, and what its inputs make of them.
        let (mut loaded, mut forced) = ([0.0; TAYLOR_TERMS + 3], [0.0; TAYLOR_TERMS + 3]);
        for part in &self.parts {
            let d = part.units.len();
            let mut term = padded.columns(part.first, d) * self.own_flow(part, cell.low);
            let grown = (part.growth * (cell.high - cell.low)).exp();
            for k in 0..TAYLOR_TERMS + 3 {
                let norm = grown * term.transpose().component_div(&part.units).norm();
                loaded[k] += norm * part.load;
                forced[k] += norm * part.force;
                put_bounds(
                    &mut entries[part.first..],
                    k,
                    part.units.map(|unit| norm * unit),
                );
                term = term * &part.matrix * (cell.scale / (k + 1) as f64);
            }
        }
        // The response F to the phasor has F' = i w F + what the row sees of the force.
        let w = self.scene.frequency;
        let mut response = reached + (cell.high - cell.low) * forced[0];
        for k in 1..TAYLOR_TERMS + 3 {
            let step = cell.scale / k as f64;
            response = step * (w * response + forced[k - 1]);
            let inputs = DVector::from_vec(vec![step * loaded[k - 1], response, response]);
            put_bounds(&mut entries[m..], k, inputs);
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
        let mut entries = vec![UnscaledModel::default(); column.len()];
        let mut term = flow * &padded;
        for (entry, size) in entries.iter_mut().zip((flow.abs() * padded.abs()).iter()) {
            entry.size = *size;
        }
        for k in 0..TAYLOR_TERMS + 2 {
            for (entry, x) in entries.iter_mut().zip(term.iter()) {
                entry.c[k] = *x;
            }
            term = &self.matrix * term * (-cell.scale / (k + 1) as f64);
        }
        for part in &self.parts {
            let d = part.units.len();
            let mut term = self.own_flow(part, cell.low) * padded.rows(part.first, d);
            let grown = (part.growth * (cell.high - cell.low)).exp();
            for k in 0..TAYLOR_TERMS + 3 {
                let norm = grown * term.component_mul(&part.units).norm();
                put_bounds(
                    &mut entries[part.first..],
                    k,
                    part.units.map(|unit| norm / unit),
                );
                term = &part.matrix * term * (cell.scale / (k + 1) as f64);
            }
        }
        entries
    }
}

/// Stores the bounds of order k, of the highest orders alone.
fn put_bounds(entries: &mut [UnscaledModel], k: usize, bounds: DVector<f64>) {
    if k >= TAYLOR_TERMS {
        for (entry, bound) in entries.iter_mut().zip(bounds.iter()) {
            entry.rest[k - TAYLOR_TERMS] = *bound;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Constraint, Harmonic, LinearSystem, Scene};
    use nalgebra::{dmatrix, dvector};

    fn scene(damping: DMatrix<f64>, stiffness: DMatrix<f64>) -> ModalScene {
        let system = LinearSystem::new(dmatrix![1.0, 0.2; 0.2, 1.5], damping, stiffness);
        let system = system.and_then(|own| own.with_load(dvector![0.3, -0.2]));
        let force = Harmonic::new(dvector![1.0.into(), 0.5.into()], 1.3, 0.0).expect("valid");
        let none: [Constraint; 0] = [];
        let scene = Scene::new(system.expect("valid"), force, none).expect("fits");
        ModalScene::new(&scene, "a test").expect("linear")
    }

    #[test]
    fn rows_and_columns_stay_inside_their_bounds() {
        let stiffness = dmatrix![3.0, -1.0; -1.0, 2.0];
        let scenes = [
            scene(&stiffness * 0.1, stiffness.clone()),
            scene(dmatrix![0.3, 0.0; 0.0, 0.0], stiffness.clone()),
            scene(dmatrix![400.0, 0.0; 0.0, 0.1], stiffness.clone()),
            scene(dmatrix![0.0, 0.0; 0.0, 0.0], dmatrix![1.0, -1.0; -1.0, 1.0]),
            scene(dmatrix![0.1, 2.0; 0.0, 0.1], dmatrix![1.0, 5.0; 0.0, 1.0]),
        ];
        let row = [0.7, -0.2, 0.4, 1.1, -0.3, 0.2, 0.9];
        for scene in &scenes {
            let flow = EnlargedFlow::new(scene, &[0, 1]);
            let at = |t: f64| flow.flow(t);
            for (low, high) in [(0.0, 0.1), (1.0, 1.2), (4.0, 4.05)] {
                let [origin, scale] = [0.5 * (low + high), 0.5 * (high - low)];
                let cell = TimeInterval {
                    origin,
                    scale,
                    low,
                    high,
                };
                let seen = flow.row(&row, &at(origin), &cell);
                let given = flow.column(&row[..4], &at(origin), &cell);
                for x in [-1.0, -0.35, 0.6, 1.0] {
                    let own = RowDVector::from_row_slice(&row) * at(origin + scale * x);
                    let start = DVector::from_fn(7, |i, _| if i < 4 { row[i] } else { 0.0 });
                    let moved = at(origin - scale * x) * start;
                    let all = seen
                        .iter()
                        .zip(own.iter())
                        .chain(given.iter().zip(moved.iter()));
                    for (model, exact) in all {
                        let model = model.series(1.0);
                        let miss = (model.value(x) - exact).abs();
                        let bound = model.remainder() * x.abs().powi(8);
                        assert!(
                            miss <= bound + 1e-13 * (1.0 + model.size()),
                            "{low} {x} {miss:e} {bound:e}"
                        );
                    }
                }
                // A fast decay is over after its time, and bounds know it.
                let worst = seen.iter().map(|own| own.rest[0]).fold(0.0, f64::max);
                assert!(low < 1.0 || worst < 1e-4, "{low} {worst:e}");
            }
        }
    }
}
