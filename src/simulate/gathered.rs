//! A trajectory as it is put together, chapter by chapter.

use crate::error::Error;
use crate::hybrid::ElementStates;
use crate::impact::wrapped;
use crate::model::{PhysicalState, Scene};
use crate::path::{Evaluator, Path, PathParts, Samples, joined};
use crate::simulate::event_loop::Ending;
use crate::simulate::kept::{KeptChapter, Ramped};
use crate::simulate::motion_state::Left;
use crate::simulate::options::{Stats, Status};
use crate::simulate::run::Done;
use crate::simulate::trajectory::Trajectory;
use std::sync::{Arc, OnceLock};

/// What there is of a trajectory so far.
pub(super) struct Gathered {
    so_far: Trajectory,
    /// The samples of each chapter.
    samples: Vec<Samples>,
}

impl Gathered {
    /// Nothing yet of a run of a scene, under ramps or not.
    pub fn new(scene: &Scene, ramped: Option<Arc<Ramped>>) -> Self {
        Self {
            so_far: Trajectory {
                scene: scene.clone(),
                chapters: Vec::with_capacity(1),
                ramped,
                span: (f64::NAN, f64::NAN),
                impacts: Vec::new(),
                grazes: Vec::new(),
                samples: None,
                last: PhysicalState::default(),
                status: Status::Finished,
                message: String::new(),
                stats: Stats::default(),
                left: Left::default(),
                contacts: None,
            },
            samples: Vec::new(),
        }
    }

    /// Impacts so far.
    pub fn n_impacts(&self) -> usize {
        self.so_far.stats.n_impacts
    }

    /// Position and velocity at the end of what there is.
    pub fn last(&self) -> &PhysicalState {
        &self.so_far.last
    }

    /// The states of elements there.
    pub fn elements(&self) -> &ElementStates {
        &self.so_far.left.elements
    }

    /// Whether the run has come to an end of its own.
    pub fn has_ended(&self) -> bool {
        self.so_far.status != Status::Finished
    }

    /// Adds a chapter from a time on.
    pub fn add(&mut self, start: f64, (evaluator, done, left): (Evaluator, Done, Left)) {
        let all = &mut self.so_far;
        let n_dof = all.scene.n_dof();
        let Ending {
            time,
            status,
            message,
        } = done.ending;
        let recorded = done.record.finish();
        let first = all.impacts.len();
        append(&mut all.impacts, recorded.impacts);
        append(&mut all.grazes, recorded.grazes);
        let path = |parts: PathParts| Path {
            evaluator: evaluator.clone(),
            parts,
            span: (start, time),
            n_dof,
        };
        let of_contacts = recorded.contacts;
        all.chapters.push(KeptChapter {
            path: recorded.kept.map(path),
            contacts: of_contacts.map(|(parts, began)| (path(parts), began)),
            contact_impulses: OnceLock::new(),
            span: (start, time),
            impacts: first..all.impacts.len(),
        });
        all.span = (all.chapters[0].span.0, time);
        (all.last, all.status, all.message) = (done.last, status, message);
        all.left = left;
        all.stats = all.stats.and(done.stats);
        let chapter = all.chapters.len() - 1;
        let ramped = all
            .ramped
            .as_ref()
            .map(|ramped| &ramped.schedule.chapters[chapter]);
        if let Some(drifting) = ramped.filter(|chapter| chapter.has_lost_its_angle()) {
            // No system knows the angle of what has become signals.
            for impact in &mut all.impacts[first..] {
                impact.phase = wrapped(drifting.angle(impact.time));
            }
        }
        self.samples.extend(recorded.samples);
    }

    /// Ends the run where a stop has been put onto the motion.
    pub fn end_inside(&mut self, t: f64, error: &Error) {
        self.so_far.status = Status::InsideStop;
        let found = error.value();
        self.so_far.message =
            format!("at t = {t}: a ramp put a stop onto the motion, which is {found}");
    }

    /// The trajectory; none where the motion grew beyond the doubles.
    pub fn finish(mut self) -> Option<Trajectory> {
        let (q, v) = &self.so_far.last;
        if !q.iter().chain(v).all(|x| x.is_finite()) {
            return None;
        }
        if self.so_far.ramped.is_some() {
            // The flight is one of the scene of the last chapter.
            self.so_far.left.flight = None;
        }
        if !self.samples.is_empty() {
            self.so_far.samples = Some(joined(self.samples, self.so_far.scene.n_dof()));
        }
        Some(self.so_far)
    }
}

/// The trajectory of one run of a scene from a time on, from which no other is to go on.
pub(crate) fn whole_run(
    scene: &Scene,
    start: f64,
    (evaluator, done): (Evaluator, Done),
) -> Trajectory {
    let mut whole = Gathered::new(scene, None);
    whole.add(start, (evaluator, done, Left::default()));
    whole.so_far.samples = whole.samples.pop();
    whole.so_far
}

/// Appends a list to another, which becomes it where there is nothing yet.
fn append<T>(all: &mut Vec<T>, more: Vec<T>) {
    if all.is_empty() {
        *all = more;
    } else {
        all.extend(more);
    }
}
