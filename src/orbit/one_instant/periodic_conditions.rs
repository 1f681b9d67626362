//! The periodic solve at one instant, mode by mode (theory 5): after T the motion repeats, so each mode's contact state
//! follows from the impulses through `(I - e^{A T})^-1`, and what is left is a small system for the impulses p and the
//! forcing phase `u = (cos phase, sin phase)`, of which those of higher harmonics are powers. Modes for which that inverse is
//! ill-conditioned (no damping, resonance, rigid body) keep their own two unknowns. O(n k^2 + k^3) for n modes and k stops, those
//! modes aside.

use crate::error::Result;
use crate::flow::{ModalScene, along};
use crate::impact::impulse_matrix;
use crate::linalg::rank::{self, SolutionSet};
use crate::modal::{Block, Form, ModalState, Pair, times};
use crate::model::{Moment, powers};
use crate::tolerance::{DEPENDENT, RETAIN_BELOW};
use nalgebra::{Complex, DMatrix, DVector};

/// The periodic conditions of one instant as linear forms in the unknowns `(p, resonant states, u)`.
pub(crate) struct PeriodicConditions<'a> {
    pub(in crate::orbit) scene: &'a ModalScene,
    pub(in crate::orbit) stops: &'a [usize],
    /// Per eliminated block: `(I - P)^-1`; `None` for resonant ones.
    pub(in crate::orbit) resolvents: Vec<Option<[Pair; 2]>>,
    /// Blocks that keep their unknowns because `I - P` is too near to singular: in step with the period, or with nothing to rest on.
    pub(in crate::orbit) resonant: Vec<usize>,
    /// `(cos, sin)` parts of the steady response of the eliminated blocks to each harmonic, zero for resonant ones.
    pub(in crate::orbit) steady: Vec<Vec<[Pair; 2]>>,
    pub(in crate::orbit) equilibrium: ModalState,
    pub(in crate::orbit) period: f64,
}

/// Conditions on X: a matrix and its right-hand side.
pub(crate) type Rows = (DMatrix<f64>, DVector<f64>);

/// Affine form in the unknowns: coefficients of p and of u, and a constant.
struct AffineForm {
    by_impulse: DMatrix<f64>,
    by_phase: DMatrix<f64>,
    constant: DVector<f64>,
}

/// `(I - P)^-1` of a block over T, `None` where it is ill-conditioned.
fn resolvent(block: Block, period: f64) -> Option<[Pair; 2]> {
    let (det, size) = block.det_one_minus(period);
    if det.abs().is_nan() || det.abs() <= RETAIN_BELOW * size {
        return None;
    }
    let [[a, b], [c, d]] = block.one_minus_propagator(period);
    Some([[d / det, -b / det], [-c / det, a / det]])
}

impl<'a> PeriodicConditions<'a> {
    /// The conditions for the stops hit together once in the period T.
    pub fn new(scene: &'a ModalScene, stops: &'a [usize], period: f64) -> Self {
        let n = scene.form.n_dof();
        let still = vec![[[0.0; 2]; 2]; n];
        let mut instant = Self {
            scene,
            stops,
            resolvents: vec![None; n],
            resonant: Vec::new(),
            steady: vec![still; scene.n_harmonics()],
            equilibrium: vec![[0.0; 2]; n].into(),
            period,
        };
        match &scene.form.form {
            Form::Dense(_) => instant.resonant = (0..n).collect(),
            Form::Blocks(blocks) => {
                for (j, &block) in blocks.iter().enumerate() {
                    instant.resolvents[j] = resolvent(block, period);
                    if instant.resolvents[j].is_none() {
                        instant.resonant.push(j);
                        continue;
                    }
                    for (steady, (w, force)) in instant.steady.iter_mut().zip(scene.harmonics()) {
                        let y = block.steady(w, force[j]);
                        steady[j] = [[y[0].re, y[1].re], [-y[0].im, -y[1].im]];
                    }
                    instant.equilibrium[j] = block.equilibrium(scene.load[j]);
                }
            }
        }
        instant
    }

    /// Number of stops hit.
    pub fn n_impulses(&self) -> usize {
        self.stops.len()
    }

    /// Number of columns for the phase: the cosine and the sine of each harmonic.
    pub(in crate::orbit) fn n_phases(&self) -> usize {
        2 * self.steady.len()
    }

    /// Number of unknowns besides the phase.
    pub(in crate::orbit) fn n_inner(&self) -> usize {
        self.n_impulses() + 2 * self.resonant.len()
    }

    /// The part of rows (positions or velocities of the stops hit) that the eliminated blocks give.
    fn sums(&self, rows: &[Vec<Pair>]) -> AffineForm {
        let k = self.n_impulses();
        let mut sums = AffineForm {
            by_impulse: DMatrix::zeros(k, k),
            by_phase: DMatrix::zeros(k, self.n_phases()),
            constant: DVector::zeros(k),
        };
        for (a, &stop) in self.stops.iter().enumerate() {
            for (b, &other) in self.stops.iter().enumerate() {
                sums.by_impulse[(a, b)] = self.pushed(&rows[stop], other);
            }
            for harmonic in 0..self.steady.len() {
                let [cos, sin] = self.driven(harmonic, &rows[stop]);
                sums.by_phase[(a, 2 * harmonic)] = cos;
                sums.by_phase[(a, 2 * harmonic + 1)] = sin;
            }
            sums.constant[a] = along(&rows[stop], &self.equilibrium);
        }
        sums
    }

    /// A row of the eliminated blocks under a unit impulse of a stop.
    pub(in crate::orbit) fn pushed(&self, row: &[Pair], stop: usize) -> f64 {
        let jumps = &self.scene.jumps[stop];
        let mut sum = 0.0;
        for ((resolvent, r), jump) in self.resolvents.iter().zip(row).zip(jumps) {
            if let Some(resolvent) = resolvent {
                let response = times(resolvent, *jump);
                sum -= r[0] * response[0] + r[1] * response[1];
            }
        }
        sum
    }

    /// A row of the steady response to a harmonic, per unit of cos and sin.
    pub(in crate::orbit) fn driven(&self, harmonic: usize, row: &[Pair]) -> Pair {
        let mut sum = [0.0, 0.0];
        for (r, [cos, sin]) in row.iter().zip(&self.steady[harmonic]) {
            sum[0] += r[0] * cos[0] + r[1] * cos[1];
            sum[1] += r[0] * sin[0] + r[1] * sin[1];
        }
        sum
    }

    /// `n_a . b_b` of the stops hit.
    pub(in crate::orbit) fn delassus(&self) -> DMatrix<f64> {
        self.scene.geometry.delassus(self.stops)
    }

    /// The clearances of the stops hit, with the means of their motions.
    pub fn clearances(&self) -> DVector<f64> {
        self.scene.mean_clearances(self.stops)
    }

    /// Rows that say "the normal velocities are reversed", and that the resonant blocks repeat: `matrix X = rhs` with X
    /// the inner unknowns and u, that of each harmonic.
    pub(in crate::orbit) fn repeat_rows(&self) -> Rows {
        let (k, inner) = (self.n_impulses(), self.n_inner());
        let mut matrix = DMatrix::zeros(inner, inner + self.n_phases());
        let mut rhs = DVector::zeros(inner);
        // n.v+ + e n.v- = 0 with v- = v+ + B p
        let velocity = self.sums(&self.scene.velocity_rows);
        let delassus = self.delassus();
        for (a, &stop) in self.stops.iter().enumerate() {
            let law = self.scene.geometry.law(stop);
            let factor = law.factor();
            for b in 0..k {
                matrix[(a, b)] = law.residual(velocity.by_impulse[(a, b)], delassus[(a, b)]);
            }
            for c in 0..self.n_phases() {
                matrix[(a, inner + c)] = factor * velocity.by_phase[(a, c)];
            }
            // Relative to a stop that moves: n.v - c'.
            for (harmonic, [_, speed]) in self.stop_amplitudes(stop) {
                matrix[(a, inner + 2 * harmonic)] -= factor * speed.re;
                matrix[(a, inner + 2 * harmonic + 1)] += factor * speed.im;
            }
            // At an equilibrium nothing moves, but what is eliminated of one may: the resonant blocks have the rest.
            if !self.resonant.is_empty() {
                rhs[a] = -factor * velocity.constant[a];
            }
            self.put_resonant(&mut matrix, a, factor, &self.scene.velocity_rows[stop]);
        }
        self.put_repetition(&mut matrix, &mut rhs);
        (matrix, rhs)
    }

    fn put_resonant(&self, matrix: &mut DMatrix<f64>, row: usize, factor: f64, stop_row: &[Pair]) {
        let k = self.n_impulses();
        for (i, &j) in self.resonant.iter().enumerate() {
            matrix[(row, k + 2 * i)] = factor * stop_row[j][0];
            matrix[(row, k + 2 * i + 1)] = factor * stop_row[j][1];
        }
    }

    /// `(I - P) z + jump p - G u = g` for the resonant blocks.
    fn put_repetition(&self, matrix: &mut DMatrix<f64>, rhs: &mut DVector<f64>) {
        let (k, inner, t) = (self.n_impulses(), self.n_inner(), self.period);
        match &self.scene.form.form {
            Form::Blocks(blocks) => {
                for (i, &j) in self.resonant.iter().enumerate() {
                    let block = blocks[j];
                    let repeat = block.one_minus_propagator(t);
                    let forced: Vec<_> = (self.scene.harmonics())
                        .map(|(w, force)| block.forced_over_periods(t, w, force[j]))
                        .collect();
                    let loaded = block.loaded(t, self.scene.load[j]);
                    for c in 0..2 {
                        let row = k + 2 * i + c;
                        matrix[(row, k + 2 * i)] = repeat[c][0];
                        matrix[(row, k + 2 * i + 1)] = repeat[c][1];
                        for (harmonic, forced) in forced.iter().enumerate() {
                            matrix[(row, inner + 2 * harmonic)] = -forced[c].re;
                            matrix[(row, inner + 2 * harmonic + 1)] = forced[c].im;
                        }
                        rhs[row] = loaded[c];
                    }
                }
            }
            Form::Dense(state) => {
                let enlarged = enlarged_exponential(state, self.scene, t);
                let m = state.nrows();
                for row in 0..m {
                    for column in 0..m {
                        matrix[(k + row, k + column)] =
                            f64::from(u8::from(row == column)) - enlarged[(row, column)];
                    }
                    rhs[k + row] = enlarged[(row, m)];
                    for c in 0..self.n_phases() {
                        matrix[(k + row, inner + c)] = -enlarged[(row, m + 1 + c)];
                    }
                }
            }
        }
        for (b, &stop) in self.stops.iter().enumerate() {
            for (i, &j) in self.resonant.iter().enumerate() {
                for c in 0..2 {
                    matrix[(k + 2 * i + c, b)] = self.scene.jumps[stop][j][c];
                }
            }
        }
    }

    /// Adds to the rows of restitution what settles the impulses of dependent stops, hit together, of which the velocities leave
    /// some combination open: it is zero, so that they are those of least norm.
    ///
    /// `U (S V^T x + ..) = 0` has no row for it; along its left null vectors, where the rows say nothing, `V^T p = 0` has room.
    fn settle_dependent(&self, matrix: &mut DMatrix<f64>) -> Result<()> {
        let k = self.n_impulses();
        if k < 2 {
            return Ok(());
        }
        let delassus = self.delassus();
        let (tolerance, none) = (DEPENDENT * delassus.amax(), DVector::zeros(k));
        let open = rank::solve(&delassus, &none, tolerance)?.null_space;
        if open.ncols() > 0 {
            // Refuses restitutions that contradict each other.
            impulse_matrix(&self.scene.geometry, self.stops)?;
            let unsaid = rank::solve(&delassus.transpose(), &none, tolerance)?.null_space;
            let mut block = matrix.view_mut((0, 0), (k, k));
            block += unsaid * open.transpose() * delassus.amax();
        }
        Ok(())
    }

    /// The complex amplitudes of the motion of a stop and of its speed, by harmonics.
    fn stop_amplitudes(
        &self,
        stop: usize,
    ) -> impl Iterator<Item = (usize, [Complex<f64>; 2])> + '_ {
        let motion = self.scene.excitation.motion_of(stop);
        let amplitudes = motion.map_or(&[][..], |motion| &motion.amplitudes);
        let turning = amplitudes.iter().zip(self.scene.rotations.frequencies());
        let both = turning.map(|(a, w)| [*a, a * Complex::new(0.0, w)]);
        both.enumerate()
    }

    /// Rows that say where the contacts are: `matrix X + constant = n.q` at the stops hit, but for what stops that move add to their
    /// clearances.
    pub(in crate::orbit) fn contact_rows(&self) -> Rows {
        let (k, inner) = (self.n_impulses(), self.n_inner());
        let position = self.sums(&self.scene.position_rows);
        let mut matrix = DMatrix::zeros(k, inner + self.n_phases());
        matrix
            .view_mut((0, 0), (k, k))
            .copy_from(&position.by_impulse);
        matrix
            .view_mut((0, inner), (k, self.n_phases()))
            .copy_from(&position.by_phase);
        for (a, &stop) in self.stops.iter().enumerate() {
            self.put_resonant(&mut matrix, a, 1.0, &self.scene.position_rows[stop]);
            for (harmonic, [moved, _]) in self.stop_amplitudes(stop) {
                matrix[(a, inner + 2 * harmonic)] -= moved.re;
                matrix[(a, inner + 2 * harmonic + 1)] += moved.im;
            }
        }
        (matrix, position.constant)
    }

    /// The cosine and the sine of each harmonic where those of the first are u.
    pub(in crate::orbit) fn phases(&self, u: Pair) -> DVector<f64> {
        let phasors = powers(Complex::new(u[0], u[1])).take(self.steady.len());
        DVector::from_iterator(self.n_phases(), phasors.flat_map(|u| [u.re, u.im]))
    }

    /// All X for a given phase.
    pub fn at_phase(&self, u: Pair) -> Result<SolutionSet> {
        let (inner, phases) = (self.n_inner(), self.phases(u));
        let (mut matrix, rhs) = self.repeat_rows();
        self.settle_dependent(&mut matrix)?;
        let known = matrix.columns(inner, phases.len()) * &phases;
        let units = self.units(&matrix, 0);
        let floor = 1.0 / units.columns[inner];
        let set = units.solve(
            &matrix.columns(0, inner).into_owned(),
            &(rhs - known),
            floor,
        )?;
        let m = set.null_space.ncols();
        let columns = inner + phases.len();
        let mut particular = set.particular.clone().resize_vertically(columns, 0.0);
        particular.rows_mut(inner, phases.len()).copy_from(&phases);
        Ok(SolutionSet {
            particular,
            null_space: set.null_space.resize(columns, m, 0.0),
            residual: set.residual,
        })
    }

    /// The inner unknowns as what each phase adds to them, shape `(inner, 1 + n_phases)`: a constant, then per unit of the cosine and the
    /// sine of each harmonic.
    pub fn by_phases(&self) -> Result<Vec<SolutionSet>> {
        let (inner, phases) = (self.n_inner(), self.n_phases());
        let (mut matrix, rhs) = self.repeat_rows();
        self.settle_dependent(&mut matrix)?;
        let units = self.units(&matrix, 0);
        let own = matrix.columns(0, inner).into_owned();
        let solved = |rhs: DVector<f64>| units.solve(&own, &rhs, 0.0);
        let each = (0..phases).map(|c| solved(-matrix.column(inner + c)));
        std::iter::once(solved(rhs)).chain(each).collect()
    }

    /// All X, u unrestricted, for which the contacts are where the stops are: `n.q = clearance`. With `scaled`, at
    /// `n.q = scale clearance` for one more unknown, the last entry of X.
    pub fn at_clearance(&self, scaled: Option<&DVector<f64>>) -> Result<SolutionSet> {
        self.solve_contacts(&self.rows_at_clearance(scaled)?)
    }

    /// All X that satisfy the rows of [`at_clearance`](Self::at_clearance).
    pub fn solve_contacts(&self, (matrix, rhs): &Rows) -> Result<SolutionSet> {
        let units = self.units(matrix, self.n_impulses());
        units.solve(matrix, rhs, 0.0)
    }

    /// The rows of [`at_clearance`](Self::at_clearance).
    pub fn rows_at_clearance(&self, scaled: Option<&DVector<f64>>) -> Result<Rows> {
        let (k, inner) = (self.n_impulses(), self.n_inner());
        let (mut repeat, rhs) = self.repeat_rows();
        self.settle_dependent(&mut repeat)?;
        let (contact, constant) = self.contact_rows();
        let unscaled = inner + self.n_phases();
        let columns = unscaled + usize::from(scaled.is_some());
        let mut matrix = DMatrix::zeros(inner + k, columns);
        matrix
            .view_mut((0, 0), (inner, unscaled))
            .copy_from(&repeat);
        matrix
            .view_mut((inner, 0), (k, unscaled))
            .copy_from(&contact);
        let target = match scaled {
            Some(direction) => {
                matrix
                    .view_mut((inner, unscaled), (k, 1))
                    .copy_from(&-direction);
                -constant
            }
            None => self.clearances() - constant,
        };
        let rhs = DVector::from_iterator(inner + k, rhs.iter().chain(target.iter()).copied());
        Ok((matrix, rhs))
    }

    /// The phase part u of X, or of a null vector, that of the first harmonic.
    pub fn phase_part(&self, x: &DVector<f64>) -> Pair {
        [x[self.n_inner()], x[self.n_inner() + 1]]
    }

    /// The impulses in X.
    pub fn impulse_part(&self, x: &DVector<f64>) -> DVector<f64> {
        x.rows(0, self.n_impulses()).into_owned()
    }

    /// The state after the instant that X describes; `affine` is 1 for a solution and 0 for a null vector.
    pub fn state_after(&self, x: &DVector<f64>, affine: f64) -> ModalState {
        let k = self.n_impulses();
        let turned = &x.as_slice()[self.n_inner()..];
        let mut resonant = x.as_slice()[k..].chunks_exact(2);
        let mut state = ModalState::with_capacity(self.resolvents.len());
        for (j, resolvent) in self.resolvents.iter().enumerate() {
            let Some(resolvent) = resolvent else {
                state.extend(resonant.next().map(|z| [z[0], z[1]]));
                continue;
            };
            let mut push = [0.0, 0.0];
            for (b, &stop) in self.stops.iter().enumerate() {
                let jump = self.scene.jumps[stop][j];
                push = [push[0] + jump[0] * x[b], push[1] + jump[1] * x[b]];
            }
            let free = times(resolvent, push);
            state.push([0, 1].map(|c| {
                let harmonics = self.steady.iter().zip(turned.chunks_exact(2));
                let steady = harmonics.map(|(steady, u)| {
                    let [cos, sin] = steady[j];
                    cos[c] * u[0] + sin[c] * u[1]
                });
                // From minus zero, which leaves every number as it is.
                steady.fold(-0.0, |sum, x| sum + x) + affine * self.equilibrium[j][c] - free[c]
            }));
        }
        state
    }

    /// The state before the instant: the jump of every impulse taken back.
    pub fn state_before(&self, after: &ModalState, impulses: &DVector<f64>) -> ModalState {
        let mut state = after.clone();
        for (&stop, &p) in self.stops.iter().zip(impulses.iter()) {
            for (z, jump) in state.iter_mut().zip(&self.scene.jumps[stop]) {
                *z = [z[0] + jump[0] * p, z[1] + jump[1] * p];
            }
        }
        state
    }

    /// The speeds at which the stops hit recede by their own motions, at a phase.
    pub fn receding(&self, phase: f64) -> Vec<f64> {
        let at = Moment::new(0.0, phase, self.scene.frequency);
        let speed = |&stop: &usize| self.scene.stop_motion(stop, at)[1];
        self.stops.iter().map(speed).collect()
    }

    /// The contact positions `n.q` of the stops hit.
    pub fn contacts(&self, after: &[Pair]) -> Vec<f64> {
        self.stops
            .iter()
            .map(|&i| along(&self.scene.position_rows[i], after))
            .collect()
    }
}

pub(in crate::orbit) fn enlarged_exponential(
    state: &DMatrix<f64>,
    scene: &ModalScene,
    t: f64,
) -> DMatrix<f64> {
    let flow = crate::flow::DenseFlow::new(state.clone(), &scene.load, scene.drive());
    let mut enlarged = DMatrix::zeros(0, 0);
    crate::flow::LinearFlow::prepare(&flow, t, &mut enlarged);
    enlarged
}
