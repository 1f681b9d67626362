//! What came out of a simulation.

use crate::error::Result;
use crate::hybrid::Graze;
use crate::hybrid::clock::Clock;
use crate::impact::{Impact, wrapped};
use crate::model::{PhysicalState, Scene};
use crate::observer::Observer;
use crate::path::{Energy, ImpactSide, Path, Samples, Segment, Stretch, check_time, energy_along};
use crate::simulate::kept::{KeptChapter, Ramped};
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

    /// What gives the forcing phase at a time, zero without forcing.
    pub(crate) fn forcing_phase(&self) -> impl Fn(f64) -> f64 {
        let (clock, phase) = (
            Clock::new(0.0, self.scene.frequency().unwrap_or(0.0)),
            self.scene.phase(),
        );
        move |t| match &self.ramped {
            Some(ramped) => {
                let chapter = self.chapter_at(t, ImpactSide::After);
                wrapped(ramped.schedule.chapters[chapter].angle(t))
            }
            None => wrapped(clock.at(t).angle() + phase),
        }
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
        let mut rows = Vec::new();
        for chapter in 0..self.chapters.len() {
            let parts = self.kept(chapter)?.0.stretches();
            let impulses = self.impulses_of_segments(chapter)?;
            let of_part =
                |part: Stretch<'_>| part.rows(&impulses[part.segment]).collect::<Vec<_>>();
            rows.extend(parts.into_iter().flat_map(of_part));
        }
        Ok(rows)
    }

    /// The motion, chapter after chapter.
    pub(crate) fn paths(&self) -> Result<Vec<&Path>> {
        let each = 0..self.chapters.len();
        each.map(|chapter| Ok(self.kept(chapter)?.0)).collect()
    }

    /// The parts of the trajectory, each once, with the stops in contact.
    pub(crate) fn stretches(&self) -> Result<Vec<Stretch<'_>>> {
        let mut all = Vec::new();
        for chapter in 0..self.chapters.len() {
            all.extend(self.kept(chapter)?.0.stretches());
        }
        Ok(all)
    }

    /// Position and velocity at a time inside the span. What is left of impacts that accumulate (a segment `Chatter`) is given as
    /// motion with the stop held: its velocity is off the true one, which jumps without end there, by no more than the speed of
    /// the first impact left out, along the stop's reaction.
    ///
    /// # Errors
    /// A time outside the span, or a trajectory that does not keep its motion.
    pub fn state(&self, t: f64, side: ImpactSide) -> Result<PhysicalState> {
        self.kept(0)?;
        check_time(t, self.span)?;
        self.kept(self.chapter_at(t, side))?.0.state(t, side)
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
        let places = self.places(None, ImpactSide::After)?;
        let each = places
            .iter()
            .map(|(k, points)| self.kept(*k)?.0.samples(points));
        Ok(joined(each.collect::<Result<_>>()?, self.scene.n_dof()))
    }

    /// The times of [`samples`](Self::samples).
    ///
    /// # Errors
    /// As [`samples`](Self::samples).
    pub fn sample_times(&self) -> Result<Vec<f64>> {
        if let Some((times, ..)) = &self.samples {
            return Ok(times.clone());
        }
        let places = self.places(None, ImpactSide::After)?;
        let points = places.iter().flat_map(|(_, points)| points);
        Ok(points.map(|p| p.time).collect())
    }

    /// The energy ledger at the times of [`Trajectory::samples`].
    ///
    /// # Errors
    /// A trajectory that does not keep its motion; a system given by functions without its mass matrix or its potential.
    pub fn energy(&self) -> Result<Energy> {
        let (mut all, mut observer) = (Energy::default(), Observer::default());
        let mut places = self.places(None, ImpactSide::After)?.into_iter().peekable();
        for chapter in 0..self.chapters.len() {
            let (path, scene) = self.kept(chapter)?;
            let own = places.next_if(|(k, _)| *k == chapter);
            let mut points = own.map_or_else(Vec::new, |(_, points)| points);
            if chapter + 1 < self.chapters.len() {
                // What has been brought and lost by its end is there at the start of the next.
                points.push(path.end());
            }
            all.go_on(energy_along(path, scene, &points, &mut observer)?);
        }
        Ok(all)
    }
}

/// The samples of chapters one after another.
pub(super) fn joined(mut each: Vec<Samples>, n: usize) -> Samples {
    if each.len() == 1 {
        return each.swap_remove(0);
    }
    let count = each.iter().map(|(times, ..)| times.len()).sum();
    let (mut q, mut v) = (DMatrix::zeros(count, n), DMatrix::zeros(count, n));
    let (mut all, mut row) = (Vec::with_capacity(count), 0);
    for (times, positions, velocities) in each {
        q.rows_mut(row, times.len()).copy_from(&positions);
        v.rows_mut(row, times.len()).copy_from(&velocities);
        row += times.len();
        all.extend(times);
    }
    (all, q, v)
}
