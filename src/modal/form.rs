//! The modal form of a linear system and the maps to and from it: what a state, a normal, a force and an impulse are in
//! the coordinates in which the motion uncouples. A state is a list of pairs, one for each block.

use crate::error::Result;
use crate::linalg::matrix_exponential::matrix_exponential;
use crate::linalg::plane::Pair;
use crate::modal::block::{Block, Response};
use crate::modal::complex::{ComplexModes, state_matrix};
use crate::modal::real::{RealModes, Shapes};
use crate::modal::state::ModalState;
use crate::model::{LinearSystem, PhysicalState};
use nalgebra::{Complex, DMatrix, DVector};
use std::sync::Arc;

/// How the motion uncouples.
#[derive(Debug, Clone)]
pub(crate) enum Form {
    /// Into 2 by 2 blocks.
    Blocks(Vec<Block>),
    /// Not at all: the state matrix in the interleaved order `(q_0, v_0, q_1, v_1, ...)`.
    Dense(DMatrix<f64>),
}

#[derive(Debug, Clone)]
enum Coordinates {
    Real(Shapes),
    Complex {
        to_physical: DMatrix<f64>,
        to_modal: DMatrix<f64>,
    },
    Physical,
}

/// A linear system in uncoupled coordinates.
#[derive(Debug, Clone)]
pub(crate) struct ModalForm {
    pub form: Form,
    coordinates: Coordinates,
    n: usize,
    /// Condition number of the coordinates, column by column.
    condition: f64,
}

impl ModalForm {
    /// The form of a system, made once: its copies, and every scene that has it, share it.
    pub fn of(system: &LinearSystem) -> Result<Arc<Self>> {
        system.derived().or_made(|| Self::new(system))
    }

    /// Real modes where the damping is proportional, complex modes elsewhere, the state matrix itself where those fail.
    pub fn new(system: &LinearSystem) -> Result<Self> {
        let n = system.n_dof();
        if let Some(modes) = RealModes::new(system)?.filter(|m| m.is_proportional) {
            let blocks = modes
                .w2
                .iter()
                .zip(modes.eta.iter())
                .map(|(&w2, &eta)| Block::Oscillator { w2, eta });
            let form = Form::Blocks(blocks.collect());
            return Ok(Self {
                form,
                coordinates: Coordinates::Real(modes.shapes),
                n,
                condition: 1.0,
            });
        }
        if let Some(modes) = ComplexModes::new(system)? {
            let coordinates = Coordinates::Complex {
                to_physical: modes.to_physical,
                to_modal: modes.to_modal,
            };
            return Ok(Self {
                form: Form::Blocks(modes.blocks),
                coordinates,
                n,
                condition: modes.condition,
            });
        }
        let a = state_matrix(system);
        let place = |i: usize| i / 2 + n * (i % 2);
        let interleaved = DMatrix::from_fn(2 * n, 2 * n, |i, j| a[(place(i), place(j))]);
        Ok(Self {
            form: Form::Dense(interleaved),
            coordinates: Coordinates::Physical,
            n,
            condition: 1.0,
        })
    }

    /// The form of a system without degrees of freedom.
    pub fn empty() -> Self {
        Self {
            form: Form::Blocks(Vec::new()),
            coordinates: Coordinates::Physical,
            n: 0,
            condition: 1.0,
        }
    }

    /// The fastest rate at which the free motion turns or decays \[rad/s\]: the largest modulus of an eigenvalue, or where
    /// the motion does not uncouple the root of the largest entry of the state matrix.
    pub fn fastest_rate(&self) -> f64 {
        match &self.form {
            Form::Blocks(blocks) => {
                let rates = blocks.iter().flat_map(|b| b.roots().map(Complex::norm));
                rates.fold(0.0, f64::max)
            }
            Form::Dense(matrix) => matrix.amax().sqrt(),
        }
    }

    /// The fastest rate at which the free motion grows \[1/s\], zero for one that does not; taken for zero where the motion
    /// does not uncouple.
    pub fn fastest_growth(&self) -> f64 {
        match &self.form {
            Form::Blocks(blocks) => {
                let growths = blocks.iter().flat_map(|b| b.roots().map(|root| root.re));
                growths.fold(0.0, f64::max)
            }
            Form::Dense(_) => 0.0,
        }
    }

    /// What rounding leaves unknown of a sum over the modes, relative to its terms.
    pub fn rounding(&self) -> f64 {
        f64::EPSILON * self.condition.max(4.0)
    }

    /// What a sum over complex modes leaves unknown of each position and velocity of a state; `None` where modes are real.
    pub fn lost(&self, state: &ModalState) -> Option<[DVector<f64>; 2]> {
        let Coordinates::Complex { to_physical, .. } = &self.coordinates else {
            return None;
        };
        let sizes = DVector::from_iterator(2 * self.n, state.iter().flatten().map(|z| z.abs()));
        let unknown = to_physical.abs() * sizes * self.rounding();
        let half = |first: usize| unknown.rows(first, self.n).into_owned();
        Some([half(0), half(self.n)])
    }

    /// Number of degrees of freedom, and of pairs in a state.
    pub fn n_dof(&self) -> usize {
        self.n
    }

    /// The real mode shapes, where the modes are real.
    pub fn shapes(&self) -> Option<&Shapes> {
        match &self.coordinates {
            Coordinates::Real(shapes) => Some(shapes),
            _ => None,
        }
    }

    /// `e^{A t}` applied to deviations in modal pairs.
    pub fn propagate(&self, t: f64, deviations: &mut DMatrix<f64>) {
        match &self.form {
            Form::Blocks(blocks) => {
                for (j, block) in blocks.iter().enumerate() {
                    let p = block.propagator(t);
                    for mut column in deviations.column_iter_mut() {
                        let z = [column[2 * j], column[2 * j + 1]];
                        column[2 * j] = p[0][0] * z[0] + p[0][1] * z[1];
                        column[2 * j + 1] = p[1][0] * z[0] + p[1][1] * z[1];
                    }
                }
            }
            Form::Dense(state) => {
                let moved = matrix_exponential(&(state * t)) * &*deviations;
                deviations.copy_from(&moved);
            }
        }
    }

    /// The state (q, v) in modal pairs.
    pub fn to_modal(&self, q: &[f64], v: &[f64]) -> ModalState {
        let pairs = match &self.coordinates {
            Coordinates::Real(shapes) => shapes.to_modal(q, v),
            Coordinates::Complex { to_modal, .. } => {
                let mut pairs = vec![[0.0; 2]; self.n];
                let columns = to_modal.as_slice().chunks_exact(2 * self.n);
                for (column, x) in columns.zip(q.iter().chain(v)) {
                    for (z, y) in pairs.as_flattened_mut().iter_mut().zip(column) {
                        *z += y * x;
                    }
                }
                pairs
            }
            Coordinates::Physical => q.iter().zip(v).map(|(&q, &v)| [q, v]).collect(),
        };
        pairs.into()
    }

    /// The same of a position and a velocity in one.
    pub fn pairs_of(&self, state: &DVector<f64>) -> ModalState {
        let (q, v) = state.as_slice().split_at(self.n);
        self.to_modal(q, v)
    }

    /// The position and velocity of a state in modal pairs.
    pub fn to_physical(&self, state: &ModalState) -> PhysicalState {
        let mut physical = (DVector::zeros(self.n), DVector::zeros(self.n));
        let (q, v) = &mut physical;
        self.fill_physical(state, q.as_mut_slice(), v.as_mut_slice());
        physical
    }

    /// The same in one.
    pub fn state_of(&self, pairs: &ModalState) -> DVector<f64> {
        let mut state = DVector::zeros(2 * self.n);
        let (q, v) = state.as_mut_slice().split_at_mut(self.n);
        self.fill_physical(pairs, q, v);
        state
    }

    /// The same into ones that are there.
    pub fn fill_physical(&self, state: &ModalState, q: &mut [f64], v: &mut [f64]) {
        match &self.coordinates {
            Coordinates::Real(shapes) => shapes.fill_physical(state, q, v),
            Coordinates::Complex { to_physical, .. } => {
                q.fill(0.0);
                v.fill(0.0);
                let columns = to_physical.as_slice().chunks_exact(2 * self.n);
                for (z, column) in state.iter().flatten().zip(columns) {
                    for (x, y) in q.iter_mut().chain(&mut *v).zip(column) {
                        *x += y * z;
                    }
                }
            }
            Coordinates::Physical => {
                for (i, &[y, dy]) in state.iter().enumerate() {
                    (q[i], v[i]) = (y, dy);
                }
            }
        }
    }

    /// Whether the modes are complex: positions and velocities together make their coordinates.
    pub fn is_complex(&self) -> bool {
        matches!(self.coordinates, Coordinates::Complex { .. })
    }

    /// The pairs r with `n.q = sum r.z`.
    pub fn position_row(&self, normal: &DVector<f64>) -> Vec<Pair> {
        match &self.coordinates {
            Coordinates::Real(shapes) => shapes.project(normal).iter().map(|&x| [x, 0.0]).collect(),
            Coordinates::Complex { to_physical, .. } => {
                pairs(&to_physical.rows(0, self.n).tr_mul(normal))
            }
            Coordinates::Physical => normal.iter().map(|&x| [x, 0.0]).collect(),
        }
    }

    /// The pairs r with `n.v = sum r.z`.
    pub fn velocity_row(&self, normal: &DVector<f64>) -> Vec<Pair> {
        match &self.coordinates {
            Coordinates::Real(shapes) => shapes.project(normal).iter().map(|&x| [0.0, x]).collect(),
            Coordinates::Complex { to_physical, .. } => {
                pairs(&to_physical.rows(self.n, self.n).tr_mul(normal))
            }
            Coordinates::Physical => normal.iter().map(|&x| [0.0, x]).collect(),
        }
    }

    /// The jump of the state when the velocity jumps by `b`.
    pub fn velocity_jump(&self, b: &DVector<f64>) -> Vec<Pair> {
        self.to_modal(&vec![0.0; self.n], b.as_slice()).to_vec()
    }

    /// The rate of change of the state under the constant force `f0`.
    pub fn load(&self, system: &LinearSystem, f0: &DVector<f64>) -> Vec<Pair> {
        match &self.coordinates {
            Coordinates::Real(shapes) => shapes.project(f0).iter().map(|&x| [0.0, x]).collect(),
            _ => self.velocity_jump(&system.solve_mass(f0)),
        }
    }

    /// The rate of change of the state under the force amplitude `f`.
    pub fn force(&self, system: &LinearSystem, f: &DVector<Complex<f64>>) -> Vec<Response> {
        let real = self.load(system, &f.map(|z| z.re));
        let imaginary = self.load(system, &f.map(|z| z.im));
        real.iter()
            .zip(&imaginary)
            .map(|(a, b)| [Complex::new(a[0], b[0]), Complex::new(a[1], b[1])])
            .collect()
    }

    /// The matrix that takes modal pairs, flattened, to (q, v), and its inverse; shape `(2n, 2n)` each.
    pub fn transformation(&self) -> (DMatrix<f64>, DMatrix<f64>) {
        let n = self.n;
        let (shapes, inverse) = match &self.coordinates {
            Coordinates::Complex {
                to_physical,
                to_modal,
            } => return (to_physical.clone(), to_modal.clone()),
            Coordinates::Real(shapes) => (shapes.to_dense(), shapes.inverse()),
            Coordinates::Physical => (DMatrix::identity(n, n), DMatrix::identity(n, n)),
        };
        // Positions see the first of each pair, velocities the second.
        let forward = DMatrix::from_fn(2 * n, 2 * n, |row, column| {
            if row / n == column % 2 {
                shapes[(row % n, column / 2)]
            } else {
                0.0
            }
        });
        let backward = DMatrix::from_fn(2 * n, 2 * n, |row, column| {
            if row % 2 == column / n {
                inverse[(row / 2, column % n)]
            } else {
                0.0
            }
        });
        (forward, backward)
    }
}

/// The pairs of a state, from its numbers in a row.
pub(crate) fn pairs(z: &DVector<f64>) -> Vec<Pair> {
    z.as_slice().chunks(2).map(|z| [z[0], z[1]]).collect()
}

/// A bound on the rates at which a motion turns or decays that does not uncouple \[rad/s\]: the norm of its matrix with positions in units
/// of velocities, no less than the modulus of any eigenvalue.
pub(crate) fn rate_bound(matrix: &DMatrix<f64>) -> f64 {
    let n = matrix.nrows() / 2;
    let largest = |column: usize| {
        let entries = (0..n * n).map(|k| matrix[(2 * (k / n) + 1, 2 * (k % n) + column)].abs());
        entries.fold(0.0, f64::max)
    };
    let (stiffness, damping) = (largest(0), largest(1));
    let rate = if stiffness > 0.0 {
        stiffness.sqrt()
    } else {
        damping
    };
    if rate == 0.0 {
        return 0.0;
    }
    let unit = |i: usize| [rate, 1.0][i % 2];
    DMatrix::from_fn(2 * n, 2 * n, |i, j| matrix[(i, j)] * unit(i) / unit(j)).norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{dmatrix, dvector};

    #[test]
    fn copies_of_a_system_share_its_form_and_another_damping_has_its_own() {
        let (mass, k) = (dvector![1.0, 2.0], dmatrix![3.0, -1.0; -1.0, 2.0]);
        let system = LinearSystem::new(mass, &k * 0.1, k).expect("valid");
        let of = |system: &LinearSystem| ModalForm::of(system).expect("converges");
        let form = of(&system);
        assert!(Arc::ptr_eq(&form, &of(&system.clone())));
        let loaded = system.clone().with_load(dvector![1.0, 0.0]);
        assert!(Arc::ptr_eq(&form, &of(&loaded.expect("valid"))));
        let from_threads = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..2).map(|_| scope.spawn(|| of(&system))).collect();
            let joined = threads.into_iter().map(|t| t.join().expect("no panic"));
            joined.collect::<Vec<_>>()
        });
        assert!(from_threads.iter().all(|other| Arc::ptr_eq(&form, other)));
        let damped = system.with_damping_scaled(2.0).expect("finite");
        let (Form::Blocks(one), Form::Blocks(twice)) = (&form.form, &of(&damped).form) else {
            panic!("proportional damping uncouples");
        };
        for (one, twice) in one.iter().zip(twice) {
            let [[_, _], [_, a]] = one.matrix();
            let [[_, _], [_, b]] = twice.matrix();
            assert!(a < 0.0 && (b / a - 2.0).abs() < 1e-14);
        }
    }

    #[test]
    fn rates_are_bounded_in_any_units() {
        for (k, c) in [
            (1.2e6, 0.0),
            (1.2e6, 20.0),
            (1e-4, 0.0),
            (1.0, 1e6),
            (0.0, 3.0),
        ] {
            let matrix = dmatrix![0.0, 1.0; -k, -c];
            let roots = crate::linalg::eigen::eigenvalues(&matrix).expect("converges");
            let fastest = roots.iter().map(|root| root.norm()).fold(0.0, f64::max);
            let bound = rate_bound(&matrix);
            assert!(fastest <= bound * (1.0 + 1e-14) && bound < 2.0 * fastest);
        }
        assert_eq!(rate_bound(&DMatrix::zeros(2, 2)), 0.0);
    }

    #[test]
    fn every_form_maps_states_rows_and_jumps_consistently() {
        let mass = dmatrix![2.0, 0.3; 0.3, 1.0];
        for (c, k) in [
            (
                dmatrix![0.2, 0.03; 0.03, 0.1],
                dmatrix![3.0, -1.0; -1.0, 2.0],
            ),
            (
                dmatrix![0.3, -0.1; 0.2, 0.1],
                dmatrix![3.0, -1.0; -1.0, 2.0],
            ),
            (dmatrix![0.0, 0.0; 0.0, 0.0], dmatrix![2.0, 3.3; 0.3, 1.0]),
        ] {
            let system = LinearSystem::new(mass.clone(), c, k).expect("valid");
            let form = ModalForm::new(&system).expect("converges");
            let (q, v, n) = (dvector![0.3, -0.7], dvector![1.1, 0.4], dvector![0.6, -0.8]);
            let state = form.to_modal(q.as_slice(), v.as_slice());
            let (q2, v2) = form.to_physical(&state);
            assert!((&q2 - &q).amax() < 1e-14 && (&v2 - &v).amax() < 1e-14);
            let dot = |row: Vec<Pair>| {
                row.iter()
                    .zip(&state)
                    .map(|(r, z)| r[0] * z[0] + r[1] * z[1])
                    .sum::<f64>()
            };
            assert!((dot(form.position_row(&n)) - n.dot(&q)).abs() < 1e-14);
            assert!((dot(form.velocity_row(&n)) - n.dot(&v)).abs() < 1e-14);
            let jumped: ModalState = state
                .iter()
                .zip(form.velocity_jump(&n))
                .map(|(z, d)| [z[0] + d[0], z[1] + d[1]])
                .collect();
            let (q3, v3) = form.to_physical(&jumped);
            assert!((&q3 - &q).amax() < 1e-14 && (&v3 - &v - &n).amax() < 1e-14);
            let (forward, backward) = form.transformation();
            assert!((forward * backward - DMatrix::identity(4, 4)).amax() < 1e-13);
        }
    }
}
