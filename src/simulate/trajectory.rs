//! What came out of a simulation.

use crate::hybrid::Graze;
use crate::impact::Impact;
use crate::model::{PhysicalState, Scene};
use crate::path::ContactRecord;
use crate::simulate::kept::{KeptChapter, Ramped};
use crate::simulate::motion_state::{Left, MotionState, RunEnd};
use crate::simulate::options::{Stats, Status};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// A simulated motion.
#[derive(Debug, Clone)]
pub struct Trajectory {
    pub(crate) scene: Scene,
    pub(crate) chapters: Vec<KeptChapter>,
    pub(crate) ramped: Option<Arc<Ramped>>,
    pub(crate) span: (f64, f64),
    pub(crate) impacts: Vec<Impact>,
    pub(crate) grazes: Vec<Graze>,
    /// Times, shape `(m,)`, [s], positions, shape `(m, n_dof)`, [m], and velocities, shape `(m, n_dof)`, [m/s], at `t_eval`.
    pub(crate) samples: Option<(Vec<f64>, DMatrix<f64>, DMatrix<f64>)>,
    pub(crate) last: PhysicalState,
    pub(crate) status: Status,
    pub(crate) message: String,
    pub(crate) stats: Stats,
    pub(crate) left: Left,
    /// Its contacts, of a run that was saved with them and without its motion.
    pub(crate) contacts: Option<Vec<ContactRecord>>,
}

impl Trajectory {
    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The impacts, empty with [`crate::Keep::Final`].
    pub fn impacts(&self) -> &[Impact] {
        &self.impacts
    }

    /// Touches without impact, empty with [`crate::Keep::Final`].
    pub fn grazes(&self) -> &[Graze] {
        &self.grazes
    }

    /// Position and velocity at the end of the run.
    pub fn last(&self) -> (&DVector<f64>, &DVector<f64>) {
        (&self.last.0, &self.last.1)
    }

    /// All that a run goes on from, at its end: [`simulate_from`](crate::simulate_from) goes on from it as one that was not interrupted.
    pub fn last_state(&self) -> MotionState {
        MotionState {
            scene: self.scene.clone(),
            time: self.span.1,
            q: self.last.0.clone(),
            v: self.last.1.clone(),
            left: self.left.clone(),
        }
    }

    /// Where it ended.
    pub(crate) fn run_end(&self) -> RunEnd {
        RunEnd {
            state: self.last.clone(),
            elements: self.left.elements.clone(),
        }
    }

    /// The time at which the run began and the one at which it ended.
    pub fn span(&self) -> (f64, f64) {
        self.span
    }

    /// The time at which the run ended, that of [`last`](Self::last): the run goes on from there in the same phase of the
    /// forcing.
    pub fn t_end(&self) -> f64 {
        self.span.1
    }

    /// How the run ended.
    pub fn status(&self) -> Status {
        self.status
    }

    /// The same in words.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// What was counted.
    pub fn stats(&self) -> Stats {
        self.stats
    }
}
