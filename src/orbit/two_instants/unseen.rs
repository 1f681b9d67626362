//! Modes that the stops of a pattern neither see nor push (a body that nothing couples to the one that is hit): they have no part
//! in the conditions of the impacts, where what they leave open would hide what is not, and repeat by themselves or not at all.

use crate::error::Result;
use crate::flow::ModalScene;
use crate::linalg::rank::{self, SolutionSet};
use crate::modal::{Block, Form, ModalState, Pair};
use crate::orbit::one_instant::periodic_conditions::PeriodicConditions;
use crate::tolerance::{CONDITIONS_RANK, SOLVABLE, UNCOUPLED_MODE};
use nalgebra::{DMatrix, DVector};

/// Such modes of a pattern.
pub(crate) struct Unseen<'a> {
    scene: &'a ModalScene,
    period: f64,
    modes: Vec<(usize, Block)>,
}

/// Whether a row has nothing to do with a mode.
fn is_blind(row: &[Pair], mode: usize) -> bool {
    let largest = row.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
    row[mode]
        .iter()
        .all(|x| x.abs() <= UNCOUPLED_MODE * largest)
}

impl<'a> Unseen<'a> {
    /// Takes the resonant modes that no stop of an instant sees or pushes out of its conditions.
    pub fn set_aside(instant: &mut PeriodicConditions<'a>) -> Self {
        let (scene, stops) = (instant.scene, instant.stops);
        let mut modes = Vec::new();
        if let Form::Blocks(blocks) = &scene.form.form {
            instant.resonant.retain(|&j| {
                let rows = [&scene.position_rows, &scene.velocity_rows, &scene.jumps];
                let mut all = rows.iter().flat_map(|rows| stops.iter().map(|&i| &rows[i]));
                let is_seen = !all.all(|row| is_blind(row, j));
                if !is_seen {
                    modes.push((j, blocks[j]));
                }
                is_seen
            });
        }
        Self {
            scene,
            period: instant.period,
            modes,
        }
    }

    /// The response of a mode over a time, from rest, to its load and to the forcing at `u = (cos phase, sin phase)`.
    fn driven(&self, (j, block): (usize, Block), t: f64, u: Pair) -> Pair {
        let forced = block.forced(t, self.scene.frequency, self.scene.force[j]);
        let loaded = block.loaded(t, self.scene.load[j]);
        [0, 1].map(|c| loaded[c] + forced[c].re * u[0] - forced[c].im * u[1])
    }

    /// The states of a mode that repeat after the period, with positions in units of the forcing's time.
    fn repeating(&self, mode: (usize, Block), u: Pair) -> Result<SolutionSet> {
        let w = self.scene.frequency;
        let [[a, b], [c, d]] = mode.1.one_minus_propagator(self.period);
        let matrix = DMatrix::from_row_slice(2, 2, &[a, b * w, c / w, d]);
        let driven = self.driven(mode, self.period, u);
        let rhs = DVector::from_row_slice(&[driven[0] * w, driven[1]]);
        let mut set = rank::solve(&matrix, &rhs, CONDITIONS_RANK * matrix.amax().max(1.0))?;
        let force = self.scene.force[mode.0][1].norm() * self.period;
        let scale = set.particular.norm() + rhs.norm() + force;
        set.residual = if scale > 0.0 {
            set.residual / scale
        } else {
            0.0
        };
        Ok(set)
    }

    /// Fills the states of these modes after both instants, a flight time apart; false where a mode does not repeat.
    pub fn fill(&self, u: Pair, dt: f64, states: &mut [ModalState; 2]) -> Result<bool> {
        let w = self.scene.frequency;
        for &(j, block) in &self.modes {
            let set = self.repeating((j, block), u)?;
            if set.residual > SOLVABLE {
                return Ok(false);
            }
            let z = [set.particular[0] / w, set.particular[1]];
            let (p, driven) = (block.propagator(dt), self.driven((j, block), dt, u));
            states[0][j] = z;
            states[1][j] = [0, 1].map(|c| p[c][0] * z[0] + p[c][1] * z[1] + driven[c]);
        }
        Ok(true)
    }

    /// The directions of the contact state, as (q, v), in which these modes leave it open, shape `(2n, dimension)`.
    pub fn basis(&self) -> Result<DMatrix<f64>> {
        let (n, w) = (self.scene.form.n_dof(), self.scene.frequency);
        let mut columns = Vec::new();
        for &mode in &self.modes {
            for x in self.repeating(mode, [1.0, 0.0])?.null_space.column_iter() {
                let mut state = ModalState::from(vec![[0.0; 2]; n]);
                state[mode.0] = [x[0] / w, x[1]];
                let (q, v) = self.scene.form.to_physical(&state);
                let both = q.iter().chain(v.iter()).copied();
                columns.push(DVector::from_iterator(2 * n, both));
            }
        }
        Ok(if columns.is_empty() {
            DMatrix::zeros(2 * n, 0)
        } else {
            DMatrix::from_columns(&columns)
        })
    }
}
