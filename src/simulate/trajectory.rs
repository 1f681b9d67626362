//! Trajectories: impacts, grazes, flights, the motion at any time, both sides of an impact.

use crate::error::{Error, Result};
use crate::flow::carry;
use crate::flow::{ModalScene, SceneFlow, with_flow};
use crate::impact::Impact;
use crate::modal::Pair;
use crate::model::Scene;
use crate::simulate::clock::Clock;
use crate::simulate::{Stats, Status};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// Points drawn in one flight at the most.
const MOST_POINTS: usize = 200;
/// Points drawn in one radian of the fastest motion.
const POINTS_PER_RADIAN: f64 = 8.0;

/// Which velocity is meant at an impact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Side {
    /// The one after it.
    #[default]
    After,
    /// The one before it.
    Before,
}

/// A touch inside the margin, without impact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Graze {
    /// Time \[s\].
    pub time: f64,
    /// The stop.
    pub stop: usize,
    /// How far the stop is passed; negative where it is not quite reached.
    pub depth: f64,
}

/// What a part of a trajectory is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SegmentKind {
    /// Free motion.
    Flight,
}

/// A part of a trajectory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// What it is.
    pub kind: SegmentKind,
    /// The stop it stays on, `None` for a flight.
    pub stop: Option<usize>,
    /// Start \[s\].
    pub start: f64,
    /// End \[s\].
    pub end: f64,
}

/// One flight as kept: its clock and span; its state stands in the list of states.
#[derive(Debug, Clone, Copy)]
pub(crate) struct KeptFlight {
    pub clock: Clock,
    pub span: f64,
}

/// The motion that `keep` asks for.
#[derive(Debug, Clone, Default)]
pub(crate) struct Kept {
    pub flights: Vec<KeptFlight>,
    /// States after the impact at the start of each flight, one after the other.
    pub states: Vec<Pair>,
}

/// A simulated motion.
#[derive(Debug, Clone)]
pub struct Trajectory {
    pub(crate) scene: Scene,
    pub(crate) modal: Arc<ModalScene>,
    pub(crate) flow: Arc<SceneFlow>,
    pub(crate) phase: f64,
    pub(crate) span: (f64, f64),
    pub(crate) kept: Option<Kept>,
    pub(crate) impacts: Vec<Impact>,
    pub(crate) grazes: Vec<Graze>,
    pub(crate) samples: Option<(Vec<f64>, DMatrix<f64>, DMatrix<f64>)>,
    pub(crate) last: (DVector<f64>, DVector<f64>),
    pub(crate) status: Status,
    pub(crate) message: String,
    pub(crate) stats: Stats,
}

/// Times, positions and velocities, shapes `(m,)`, `(m, n)`, `(m, n)`.
pub type Samples = (Vec<f64>, DMatrix<f64>, DMatrix<f64>);

impl Trajectory {
    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The impacts, empty with [`crate::Keep::Final`].
    pub fn impacts(&self) -> &[Impact] {
        &self.impacts
    }

    /// Touches inside the margin, empty with [`crate::Keep::Final`].
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

    /// The parts of the trajectory.
    ///
    /// # Errors
    /// A trajectory that does not keep its motion.
    pub fn segments(&self) -> Result<Vec<Segment>> {
        let flights = &self.motion()?.flights;
        Ok(flights
            .iter()
            .map(|f| Segment {
                kind: SegmentKind::Flight,
                stop: None,
                start: f.clock.time(),
                end: f.clock.after(f.span).time(),
            })
            .collect())
    }

    fn motion(&self) -> Result<&Kept> {
        self.kept.as_ref().ok_or_else(|| {
            Error::bad_value(
                "keep",
                "\"impacts\" or \"final\"",
                "the motion is kept with keep=\"motion\" alone",
            )
        })
    }

    /// Position and velocity at a time inside the span.
    ///
    /// # Errors
    /// A time outside the span, or a trajectory that does not keep its motion.
    pub fn state(&self, t: f64, side: Side) -> Result<(DVector<f64>, DVector<f64>)> {
        let kept = self.motion()?;
        let (start, end) = self.span;
        let slack = 4.0 * f64::EPSILON * start.abs().max(end.abs());
        if !(start - slack..=end + slack).contains(&t) {
            return Err(Error::bad_value(
                "t",
                t,
                format!("it must lie in the span [{start}, {end}] of the trajectory"),
            ));
        }
        let (first_later, at_impact) = {
            let later = kept.flights.partition_point(|f| f.clock.time() <= t);
            let starts_here = later > 1 && kept.flights[later - 1].clock.time() == t;
            (later, starts_here)
        };
        let mut index = first_later.max(1) - 1;
        if side == Side::Before && at_impact {
            // Stops hit one after the other at one instant leave flights of no length: go back to the first.
            while index > 0 && kept.flights[index].clock.time() == t {
                index -= 1;
            }
        }
        let flight = kept.flights[index];
        let local = flight
            .clock
            .until(flight.clock.at(t))
            .clamp(0.0, flight.span);
        let span = if side == Side::Before && at_impact {
            flight.span
        } else {
            local
        };
        Ok(self.state_in(index, span))
    }

    fn state_in(&self, index: usize, span: f64) -> (DVector<f64>, DVector<f64>) {
        let n = self.modal.form.n_dof();
        let kept = self
            .kept
            .as_ref()
            .expect("asked for by callers that have it");
        let mut state = kept.states[index * n..(index + 1) * n].to_vec();
        let angle = self.modal.frequency * kept.flights[index].clock.local + self.phase;
        with_flow!(&*self.flow, f => carry(f, angle, span, &mut state));
        self.modal.form.to_physical(&state)
    }

    /// The motion at `t_eval`, or, without it, at points for drawing: both sides of each impact, at most 200 a flight.
    ///
    /// # Errors
    /// A trajectory that has neither `t_eval` nor its motion.
    pub fn samples(&self) -> Result<Samples> {
        if let Some(samples) = &self.samples {
            return Ok(samples.clone());
        }
        let kept = self.motion()?;
        let rate = self.fastest_rate();
        let mut times = Vec::new();
        let mut states = Vec::new();
        for (i, flight) in kept.flights.iter().enumerate() {
            let wanted = (flight.span * rate * POINTS_PER_RADIAN).ceil() + 1.0;
            let count = wanted.clamp(2.0, MOST_POINTS as f64) as usize;
            for k in 0..count {
                let s = flight.span * k as f64 / (count - 1) as f64;
                times.push(flight.clock.after(s).time());
                states.push(self.state_in(i, s));
            }
        }
        // The ends are those asked for, whatever rounding makes of a time counted in periods.
        if let [first, .., last] = times.as_mut_slice() {
            (*first, *last) = self.span;
        }
        let n = self.modal.form.n_dof();
        let q = DMatrix::from_fn(states.len(), n, |i, j| states[i].0[j]);
        let v = DMatrix::from_fn(states.len(), n, |i, j| states[i].1[j]);
        Ok((times, q, v))
    }

    /// The fastest of the forcing and the free oscillations.
    fn fastest_rate(&self) -> f64 {
        let free = match &self.modal.form.form {
            crate::modal::Form::Blocks(blocks) => blocks
                .iter()
                .flat_map(|b| b.roots())
                .map(|l| l.im.abs())
                .fold(0.0, f64::max),
            crate::modal::Form::Dense(m) => m.norm(),
        };
        let rate = free.max(self.modal.frequency);
        if rate > 0.0 {
            rate
        } else {
            MOST_POINTS as f64 / (self.span.1 - self.span.0).max(f64::MIN_POSITIVE)
        }
    }
}
