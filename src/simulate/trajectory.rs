//! What came out of a simulation.

use crate::error::{Error, Result};
use crate::hybrid::Graze;
use crate::hybrid::clock::Clock;
use crate::impact::{Impact, wrapped};
use crate::model::{PhysicalState, Scene};
use crate::observer::Observer;
use crate::path::{
    Energy, ImpactSide, Impulses, Path, Point, Samples, Segment, Stretch, energy_along,
};
use crate::simulate::options::{Stats, Status};
use nalgebra::{DMatrix, DVector};
use std::ops::ControlFlow;
use std::sync::OnceLock;

/// A simulated motion.
#[derive(Debug, Clone)]
pub struct Trajectory {
    pub(crate) scene: Scene,
    pub(crate) path: Option<Path>,
    /// What stops give on each segment of the path, once it has been asked for.
    pub(crate) given: OnceLock<Vec<Vec<f64>>>,
    pub(crate) span: (f64, f64),
    pub(crate) impacts: Vec<Impact>,
    pub(crate) grazes: Vec<Graze>,
    pub(crate) samples: Option<(Vec<f64>, DMatrix<f64>, DMatrix<f64>)>,
    pub(crate) last: PhysicalState,
    pub(crate) status: Status,
    pub(crate) message: String,
    pub(crate) stats: Stats,
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

    /// The time at which the run began and the one at which it ended.
    pub fn span(&self) -> (f64, f64) {
        self.span
    }

    /// The time at which the run ended, that of [`last`](Self::last): the run goes on from there in the same phase of the
    /// forcing.
    pub fn t_end(&self) -> f64 {
        self.span.1
    }

    /// The forcing phase at a time, zero without forcing.
    pub(crate) fn forcing_phase(&self, t: f64) -> f64 {
        let frequency = self.scene.frequency().unwrap_or(0.0);
        wrapped(Clock::new(t, frequency).angle() + self.scene.phase())
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

    /// The parts of the trajectory; several stops in lasting contact have a row each. What stops give on them is integrated when
    /// first asked for.
    ///
    /// # Errors
    /// A trajectory that does not keep its motion; what the functions of a nonlinear scene report.
    pub fn segments(&self) -> Result<Vec<Segment>> {
        let (parts, impulses) = (self.stretches()?, self.impulses_of_segments()?);
        let rows = parts
            .into_iter()
            .flat_map(|part| part.rows(&impulses[part.segment]));
        Ok(rows.collect())
    }

    /// The parts of the trajectory, each once, with the stops in contact.
    pub(crate) fn stretches(&self) -> Result<Vec<Stretch<'_>>> {
        Ok(self.path()?.stretches())
    }

    /// What the stops in contact on each segment of the path give.
    fn impulses_of_segments(&self) -> Result<&Vec<Vec<f64>>> {
        if let Some(known) = self.given.get() {
            return Ok(known);
        }
        let impulses = Impulses::new(self.path()?, &self.scene, &self.impacts)?.of_segments()?;
        Ok(self.given.get_or_init(|| impulses))
    }

    pub(super) fn path(&self) -> Result<&Path> {
        self.path.as_ref().ok_or_else(|| {
            Error::bad_value(
                "keep",
                "\"impacts\" or \"final\"",
                "the motion is kept with keep=\"motion\" alone",
            )
        })
    }

    /// Position and velocity at a time inside the span. What is left of impacts that accumulate (a segment `Chatter`) is given as
    /// motion with the stop held: its velocity is off the true one, which jumps without end there, by no more than the speed of
    /// the first impact left out, along the stop's reaction.
    ///
    /// # Errors
    /// A time outside the span, or a trajectory that does not keep its motion.
    pub fn state(&self, t: f64, side: ImpactSide) -> Result<PhysicalState> {
        self.path()?.state(t, side)
    }

    /// The motion at `t_eval`, or, without it, at points for drawing: both sides of each impact, at most 200 a flight, fewer where
    /// these would be more than a million.
    ///
    /// # Errors
    /// A trajectory that has neither `t_eval` nor its motion.
    pub fn samples(&self) -> Result<Samples> {
        if let Some(samples) = &self.samples {
            return Ok(samples.clone());
        }
        self.path()?.samples(&self.points()?)
    }

    /// The times of [`samples`](Self::samples).
    ///
    /// # Errors
    /// As [`samples`](Self::samples).
    pub fn sample_times(&self) -> Result<Vec<f64>> {
        if let Some((times, ..)) = &self.samples {
            return Ok(times.clone());
        }
        Ok(self.points()?.iter().map(|p| p.time).collect())
    }

    /// Where the samples are on the path.
    fn points(&self) -> Result<Vec<Point>> {
        let path = self.path()?;
        match &self.samples {
            Some((times, ..)) => Ok(path.points_at(times)),
            None => path.points(),
        }
    }

    /// The energy ledger at the times of [`Trajectory::samples`].
    ///
    /// # Errors
    /// A trajectory that does not keep its motion; a system given by functions without its mass matrix or its potential.
    pub fn energy(&self) -> Result<Energy> {
        self.energy_observed(&mut || ControlFlow::Continue(()))
    }

    /// [`energy`](Self::energy), asking `observer` from time to time whether to go on.
    ///
    /// # Errors
    /// As [`energy`](Self::energy); `Error::Interrupted` when the observer breaks off.
    pub fn energy_observed(&self, observer: &mut dyn FnMut() -> ControlFlow<()>) -> Result<Energy> {
        let (path, points) = (self.path()?, self.points()?);
        energy_along(path, &self.scene, &points, &mut Observer::new(observer))
    }
}
