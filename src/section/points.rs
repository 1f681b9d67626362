//! The points of a section.

use crate::error::{Error, Result};
use crate::impact::wrapped;
use crate::model::{PhysicalState, Scene};
use crate::path::{ImpactSide, KeptMotion, Motion};
use crate::quantity::{finite, finite_vector, room_for};
use crate::section::events::{ImpactEvent, events_of};
use crate::section::plane::crossings;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// When a motion is looked at.
#[derive(Debug, Clone, PartialEq)]
pub enum Section {
    /// At a phase of the forcing \[rad\].
    Phase(f64),
    /// After the impacts on these stops, of those that give way where contacts begin, on any where the list is empty. Impacts that
    /// accumulate until the stop is at rest are one, at their end.
    Impacts(Vec<usize>),
    /// Where `row.(q, v)` rises through a value, by an impact too.
    Plane {
        /// The row, shape `(2n,)`.
        row: DVector<f64>,
        /// The value.
        value: f64,
    },
}

impl Section {
    /// Refuses a stop that a scene does not have, and a plane that is none of its states.
    pub(crate) fn check(&self, scene: &Scene) -> Result<()> {
        let all = scene.stops().len();
        match self {
            Self::Impacts(stops) => match stops.iter().find(|&&stop| stop >= all) {
                Some(&stop) => {
                    let rule = format!("the scene has {all} stops");
                    Err(Error::bad_value("stops", stop, rule))
                }
                None => Ok(()),
            },
            Self::Phase(_) => Ok(()),
            Self::Plane { row, value } => {
                finite_vector("plane[0]", row, 2 * scene.n_dof())?;
                finite("plane[1]", *value)?;
                if row.amax() == 0.0 {
                    let rule = "some number of it must not be zero";
                    return Err(Error::bad_value("plane", "a row of zeros", rule));
                }
                Ok(())
            }
        }
    }
}

/// A motion looked at once in a while: p points of n coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct PoincarePoints {
    /// Times \[s\], shape `(p,)`.
    pub t: Vec<f64>,
    /// The stop that was hit; `None` at a phase.
    pub stop: Vec<Option<usize>>,
    /// The speed at which it was approached, shape `(p,)`, \[m/s\]; zero after impacts that accumulate, NaN at a phase.
    pub speed_before: Vec<f64>,
    /// Phases of the forcing \[rad\], in [0, 2 pi), shape `(p,)`.
    pub phase: Vec<f64>,
    /// Positions, shape `(p, n)`, \[m\].
    pub q: DMatrix<f64>,
    /// Velocities, after impacts, shape `(p, n)`, \[m/s\].
    pub v: DMatrix<f64>,
}

impl PoincarePoints {
    /// No points yet, with room for `count` of a motion of n coordinates.
    pub(crate) fn with_room(count: usize, n: usize) -> Self {
        Self {
            t: Vec::with_capacity(count),
            stop: Vec::with_capacity(count),
            speed_before: Vec::with_capacity(count),
            phase: Vec::with_capacity(count),
            q: DMatrix::zeros(count, n),
            v: DMatrix::zeros(count, n),
        }
    }

    /// The states (q, v), one a row.
    pub(crate) fn states(&self) -> DMatrix<f64> {
        let n = self.q.ncols();
        DMatrix::from_fn(self.q.nrows(), 2 * n, |k, j| {
            if j < n {
                self.q[(k, j)]
            } else {
                self.v[(k, j - n)]
            }
        })
    }

    /// Leaves the first of them.
    pub(crate) fn truncate(&mut self, count: usize) {
        if count < self.t.len() {
            self.t.truncate(count);
            self.stop.truncate(count);
            self.speed_before.truncate(count);
            self.phase.truncate(count);
            self.q = self.q.rows(0, count).into_owned();
            self.v = self.v.rows(0, count).into_owned();
        }
    }

    /// Adds points, for which there is room.
    pub(crate) fn append(&mut self, mut others: Self) {
        let (first, count) = (self.t.len(), others.t.len());
        self.q.rows_mut(first, count).copy_from(&others.q);
        self.v.rows_mut(first, count).copy_from(&others.v);
        self.t.append(&mut others.t);
        self.stop.append(&mut others.stop);
        self.speed_before.append(&mut others.speed_before);
        self.phase.append(&mut others.phase);
    }
}

/// Looks at a motion at a phase of the forcing, after its impacts, or where it passes through a plane of its states. Planes are
/// passed upwards.
///
/// # Errors
/// A trajectory that does not keep its motion; a phase that is not finite; of a phase, a scene without a forcing period or a run along
/// ramps; a stop that the scene does not have; a row that is none of its states, or zero.
///
/// # Examples
/// ```
/// use vibroimpact::{Kind, OrbitOptions, PaperOptions, Pattern, Section, paper_scene, periodic_orbits, poincare_points};
/// let scene = paper_scene(Kind::Three, &PaperOptions::default())?;
/// let orbits = periodic_orbits(&scene, &Pattern::single(1), &OrbitOptions { n_periods: 2, ..Default::default() })?;
/// // Once in each of its two periods of the forcing, and after its one impact.
/// assert_eq!(poincare_points(&orbits[0], &Section::Phase(0.0))?.t.len(), 2);
/// let after = poincare_points(&orbits[0], &Section::Impacts(vec![]))?;
/// assert_eq!(after.stop, [Some(1)]);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn poincare_points(motion: &impl Motion, section: &Section) -> Result<PoincarePoints> {
    points_of(motion, section)
}

/// The points of a section of any kind of motion.
pub(crate) fn points_of(motion: &dyn KeptMotion, section: &Section) -> Result<PoincarePoints> {
    match section {
        Section::Plane { row, value } => {
            section.check(motion.scene())?;
            let found = crossings(motion, row, *value)?;
            let (times, states): (Vec<f64>, Vec<PhysicalState>) = found.into_iter().unzip();
            Ok(points(motion, times, &states))
        }
        Section::Phase(phase) => {
            let mut points = at_times(motion, &strobe_times(motion, *phase)?)?;
            points.phase.fill(wrapped(*phase));
            Ok(points)
        }
        Section::Impacts(stops) => {
            section.check(motion.scene())?;
            let mut events = events_of(motion)?;
            events.retain(|event| stops.is_empty() || stops.contains(&event.stop));
            let times: Vec<f64> = events.iter().map(|event| event.time).collect();
            let mut points = at_times(motion, &times)?;
            for (
                k,
                ImpactEvent {
                    stop, speed_before, ..
                },
            ) in events.into_iter().enumerate()
            {
                (points.stop[k], points.speed_before[k]) = (Some(stop), speed_before);
            }
            Ok(points)
        }
    }
}

/// How long it is from a phase of the forcing to another.
pub(crate) fn wait(period: f64, from: f64, to: f64) -> f64 {
    period * ((to - from) / TAU).rem_euclid(1.0)
}

/// The times of a motion at which the forcing has a phase: from its start on, up to its end; but for one that closes, which has its end
/// at its start.
pub(crate) fn strobe_times(motion: &dyn KeptMotion, phase: f64) -> Result<Vec<f64>> {
    finite("phase", phase)?;
    let refused = |reason: &str| {
        Error::bad_value(
            "phase",
            phase,
            format!("a section at a phase needs a steady forcing with a period: {reason}"),
        )
    };
    let Some(period) = motion.scene().period() else {
        return Err(refused("the scene has none"));
    };
    if !motion.has_steady_phase() {
        return Err(refused("the run goes along ramps"));
    }
    let (start, end) = motion.span();
    // A phase that is the one at the start but for rounding counts as that.
    let rounding = f64::EPSILON * (start.abs().max(end.abs()) + period);
    let wait = wait(period, motion.forcing_phase()(start), phase);
    let first = if period - wait <= 4.0 * rounding {
        0.0
    } else {
        wait
    };
    let last = if motion.is_closed() {
        end - start - 4.0 * rounding
    } else {
        end - start + 4.0 * rounding
    };
    let count = if last < first {
        0
    } else {
        1 + ((last - first) / period).floor() as usize
    };
    room_for("the points of the section", count, 1)?;
    let time = |k: usize| (start + (first + k as f64 * period)).min(end);
    Ok((0..count).map(time).collect())
}

/// The motion at some times, after what happens there.
pub(crate) fn at_times(motion: &dyn KeptMotion, times: &[f64]) -> Result<PoincarePoints> {
    let states = motion.states(times, ImpactSide::After)?;
    Ok(points(motion, times.to_vec(), &states))
}

/// Points at which nothing is hit.
fn points(motion: &dyn KeptMotion, t: Vec<f64>, states: &[PhysicalState]) -> PoincarePoints {
    let n = motion.scene().n_dof();
    let is_forced = motion.scene().period().is_some();
    let at = motion.forcing_phase();
    let phase = |&t: &f64| if is_forced { at(t) } else { f64::NAN };
    PoincarePoints {
        stop: vec![None; t.len()],
        speed_before: vec![f64::NAN; t.len()],
        phase: t.iter().map(phase).collect(),
        t,
        q: DMatrix::from_fn(states.len(), n, |k, j| states[k].0[j]),
        v: DMatrix::from_fn(states.len(), n, |k, j| states[k].1[j]),
    }
}
