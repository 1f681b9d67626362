//! An orbit as plain numbers, to be stored and made again.

use crate::error::{Error, Result};
use crate::flow::ModalScene;
use crate::modal::Pair;
use crate::model::Scene;
use crate::orbit::course::Course;
use crate::orbit::motion::OrbitMotion;
use crate::orbit::periodic_orbit::{Flight, Parts};
use crate::orbit::stepped::SteppedMotion;
use crate::orbit::{Pattern, PeriodicOrbit};
use crate::simulate::SegmentKind;
use std::sync::Arc;

/// An orbit as plain numbers, from which it can be made again: spans of its flights, modal states (after, then before the
/// next instant, flight by flight), impulses.
#[derive(Debug, Clone, PartialEq)]
pub struct Saved {
    /// Forcing periods in one period.
    pub n_periods: usize,
    /// Forcing phase at the first impact.
    pub phase: f64,
    /// Spans of the flights.
    pub spans: Vec<f64>,
    /// Modal states, flattened.
    pub states: Vec<f64>,
    /// Impulses in the order of the pattern.
    pub impulses: Vec<f64>,
    /// What each flight is: its kind, the stops in contact, whether it begins with the next instant of the pattern, the
    /// stop let go at its start. Empty: all of them free, from instant to instant.
    pub courses: Vec<SavedCourse>,
}

/// One entry of [`Saved::courses`].
pub type SavedCourse = (SegmentKind, Vec<usize>, bool, Option<usize>);

impl PeriodicOrbit {
    /// The orbit as plain numbers.
    pub fn save(&self) -> Saved {
        let states = self
            .flights()
            .iter()
            .flat_map(|f| f.after.iter().chain(&f.before_next))
            .flatten();
        Saved {
            n_periods: self.n_periods(),
            phase: self.phase(),
            spans: self.flights().iter().map(|f| f.span).collect(),
            states: states.copied().collect(),
            impulses: self.impacts().iter().map(|i| i.impulse).collect(),
            courses: self.flights().iter().map(saved_course).collect(),
        }
    }

    /// The orbit that was saved; `scene` is the orbit's own.
    ///
    /// # Errors
    /// Numbers that do not fit the scene.
    pub fn restore(scene: &Scene, pattern: Pattern, saved: Saved) -> Result<Self> {
        let n = scene.n_dof();
        if saved.states.len() != 4 * n * saved.spans.len() || saved.spans.is_empty() {
            let expected = format!("({},)", 4 * n * saved.spans.len());
            return Err(Error::bad_shape(
                "states",
                format!("({},)", saved.states.len()),
                expected,
            ));
        }
        let pairs: Vec<Pair> = saved.states.chunks(2).map(|z| [z[0], z[1]]).collect();
        let mut start = 0.0;
        let mut flights = Vec::new();
        for (k, (span, states)) in saved.spans.iter().zip(pairs.chunks(2 * n)).enumerate() {
            let (after, before_next) = (states[..n].to_vec(), states[n..].to_vec());
            flights.push(Flight {
                start,
                span: *span,
                after,
                before_next,
                course: saved.courses.get(k).map_or(Course::FREE, restored_course),
            });
            start += span;
        }
        let Saved {
            n_periods,
            phase,
            impulses,
            ..
        } = saved;
        let motion = if scene.linear_system("an orbit").is_ok() {
            OrbitMotion::modal_along(Arc::new(ModalScene::new(scene, "an orbit")?), &flights)?
        } else {
            OrbitMotion::stepped(Arc::new(SteppedMotion::new(scene, phase)), &flights)?
        };
        let parts = Parts {
            pattern,
            n_periods,
            phase,
            flights,
            impulses,
        };
        Self::moved_by(motion, scene, parts)
    }
}

fn saved_course(flight: &Flight) -> SavedCourse {
    let Course {
        kind,
        stops,
        is_struck,
        released,
    } = flight.course.clone();
    (kind, stops, is_struck, released)
}

fn restored_course((kind, stops, is_struck, released): &SavedCourse) -> Course {
    Course {
        kind: *kind,
        stops: stops.clone(),
        is_struck: *is_struck,
        released: *released,
    }
}
