//! Periodic motions of any pattern from a guess (theory 5): Newton's method on the states after the impacts and on the
//! times of the impacts, all at once (multiple shooting). A time is an unknown with its own equation, the gap of the stop
//! hit; nothing asks which stop is met first, so the method stays regular where an impact loses its speed.
//!
//! Lasting contact needs no unknown of its own. A period runs from just after its first impact, free, on 2n unknowns; the
//! impacts that accumulate are one instant whose map (`hybrid/chatter_map.rs`) ends in a state with two dimensions less, the flow of
//! the held motion keeps them away, and at the release, an instant whose time has the equation "the stop let go does not
//! accelerate", `h'' = 0`, equivalent to a contact force of zero, the state and its rate are continuous. So `I - M` of
//! the closing equations stays regular where M has zero multipliers. Behind a chatter a flight begins later than its
//! instant: its start has corrections of its own, which follow from the others.

use crate::error::Result;
use crate::hybrid::chatter_map::Chatter;
use crate::hybrid::{GapAt, HybridMaps, ScaledUnits, Timed, condition, pass};
use crate::itinerary::{ArcEnd, Instant, Itinerary, MotionArc, arcs_of};
use crate::law::Regime;
use crate::observer::unless_broken_off;

use crate::tolerance::{FREE_DIRECTION, WEAK_DIRECTION};
use nalgebra::{DMatrix, DVector};

/// Newton steps before giving up. [work]
pub(super) const MOST_SHOOTING_STEPS: usize = 60;

/// A motion between instants, closed or nearly so: flight k goes from `starts[k]`, which is `times[k]` unless impacts
/// accumulate from there, to `times[k + 1]`, and its state is the one at its start.
#[derive(Debug, Clone, Default)]
pub(crate) struct ShootingState {
    /// The instants, one more than there are flights, shape (flights + 1,), [s].
    pub times: Vec<f64>,
    /// The starts of the flights, shape (flights,), [s].
    pub starts: Vec<f64>,
    /// The state (q, v) at the start of each flight, each of shape (2n,), [m, m/s].
    pub states: Vec<DVector<f64>>,
}

impl ShootingState {
    /// The motion with a part of a change of all its times and states.
    pub fn moved(&self, by: &Self, part: f64) -> Self {
        let sum = |x: &[f64], d: &[f64]| x.iter().zip(d).map(|(x, d)| x + part * d).collect();
        let states = self.states.iter().zip(&by.states);
        Self {
            times: sum(&self.times, &by.times),
            starts: sum(&self.starts, &by.starts),
            states: states.map(|(x, d)| x + d * part).collect(),
        }
    }

    /// The motion that some instants are, up to an end, and what happens along it.
    pub fn of_instants(instants: Vec<Instant>, end: f64) -> (Itinerary, Self) {
        let (mut stages, mut motion) = (Itinerary::default(), Self::default());
        for instant in instants {
            stages.push(instant.stage);
            motion.times.push(instant.time);
            motion.starts.push(instant.start);
            motion.states.push(instant.state);
        }
        motion.times.push(end);
        (stages, motion)
    }

    /// The instants of the motion, with what happens at them.
    pub fn instants(&self, stages: &Itinerary) -> Vec<Instant> {
        let times = self.times.iter().zip(&self.starts);
        let each = stages.iter().zip(times).zip(&self.states);
        let each = each.map(|((stage, (&time, &start)), state)| Instant {
            stage: stage.clone(),
            time,
            start,
            state: state.clone(),
        });
        each.collect()
    }

    /// Its arcs, given what happens along it and the ends of its flights.
    pub fn arcs<M: HybridMaps + ?Sized>(
        &self,
        stages: &Itinerary,
        arc_ends: &[ArcEnd],
        motion: &M,
    ) -> Result<Vec<MotionArc<DVector<f64>>>> {
        let end = self.times[self.states.len()];
        arcs_of(&self.instants(stages), end, arc_ends, motion)
    }

    /// The start of flight k, the one after the last being the first of the next period.
    pub(super) fn start(&self, k: usize) -> f64 {
        self.starts.get(k).copied().unwrap_or(self.times[k])
    }
}

/// Which times are unknown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Clocked {
    /// A forcing: every impact has its time, and the last flight ends one period [s] after the first began.
    Forced { period: f64 },
    /// None: time counts from the first impact, and the period is an unknown.
    Free,
}

/// One periodic problem.
pub(crate) struct Shooting<'a> {
    pub motion: &'a dyn HybridMaps,
    pub stages: &'a Itinerary,
    pub clocked: Clocked,
    /// The image of each stop, where a motion closes half a period later with its mirror image.
    pub images: Option<&'a [usize]>,
    /// Singular values below which a loop is not corrected along their directions: at first, and where it comes no nearer to closing.
    pub weak_directions: [f64; 2],
}

/// Flights in closed form: corrections along all directions come first. [work]
pub(crate) const WEAK_EXACT: [f64; 2] = [FREE_DIRECTION, WEAK_DIRECTION];
/// Integrated flights: corrections along the directions that their errors leave come first. [work]
pub(crate) const WEAK_INTEGRATED: [f64; 2] = [WEAK_DIRECTION, FREE_DIRECTION];

impl Shooting<'_> {
    /// The regime after instant k.
    pub(super) fn regime(&self, k: usize) -> &Regime {
        &self.stages.stage(k).regime
    }

    /// The stops hit at instant k whose gaps are conditions: they were free before it.
    pub(crate) fn closing(&self, k: usize) -> Vec<usize> {
        let (before, transition) = (self.stages.before(k), &self.stages.stage(k).transition);
        let is_first = k.is_multiple_of(self.stages.len());
        match self.images.filter(|_| is_first) {
            Some(images) => transition.closing(&before.mirrored(images)).collect(),
            None => transition.closing(before).collect(),
        }
    }

    /// Whether flight k is to close with its mirror image.
    fn is_mirrored(&self, k: usize) -> bool {
        self.images.is_some() && k + 1 == self.stages.len()
    }

    /// Replaces the end of a flight that is to close with its mirror image by the image, half a period before; leaves another flight alone.
    pub(super) fn mirror(&self, k: usize, state: &ShootingState, y: &mut Timed) {
        if self.is_mirrored(k) {
            y.state.neg_mut();
            y.deviations.neg_mut();
            y.time = state.times[0];
        }
    }

    /// The start of the flight that follows flight k, in the time of its end.
    pub(super) fn next_start(&self, k: usize, state: &ShootingState) -> f64 {
        if self.is_mirrored(k) {
            state.times[0]
        } else {
            state.start(k + 1)
        }
    }

    /// How many times are unknown.
    pub(super) fn n_times(&self) -> usize {
        if self.stages.is_uneventful() {
            0
        } else {
            self.stages.len()
        }
    }

    /// The unknown that the time of instant k is, among the times.
    pub(super) fn time_index(&self, k: usize) -> Option<usize> {
        match (self.n_times(), self.clocked) {
            (0, _) => None,
            (count, Clocked::Forced { .. }) => Some(k % count),
            (_, Clocked::Free) => k.checked_sub(1),
        }
    }

    /// Maps a state before instant k to the one after it; returns the impulses, and the accumulating impacts there.
    pub(crate) fn pass(
        &self,
        k: usize,
        units: &ScaledUnits,
        y: &mut Timed,
    ) -> Result<(Vec<f64>, Option<Chatter>)> {
        pass(self.motion, &self.stages.stage(k).transition, units, y)
    }

    /// The condition of instant k on a state before it and on its time, scaled, with what deviations make of it; a stop
    /// that is struck has its own on the state after.
    pub(crate) fn condition(
        &self,
        k: usize,
        units: &ScaledUnits,
        y: &Timed,
    ) -> Result<Option<(f64, DVector<f64>)>> {
        condition(self.motion, self.stages.stage(k), units, y)
    }

    /// Moves a state and deviations along flight k; returns the Jacobian of the flight where it was made.
    pub(super) fn fly(
        &self,
        k: usize,
        state: &ShootingState,
        (x, deviations): (&mut DVector<f64>, &mut DMatrix<f64>),
    ) -> Result<Option<DMatrix<f64>>> {
        unless_broken_off()?;
        let span = (state.starts[k], state.times[k + 1]);
        self.motion
            .flow_by_jacobian(self.regime(k), span, x, deviations)
    }

    /// The end of flight k, at instant k + 1, without deviations; of a last flight that is to close with its mirror image, the image.
    pub(super) fn end_of_flight(&self, k: usize, state: &ShootingState) -> Result<Timed> {
        let len = state.states[0].len();
        let mut y = Timed {
            time: state.times[k + 1],
            state: state.states[k].clone(),
            deviations: DMatrix::zeros(len, 0),
            delays: DVector::zeros(0),
        };
        self.fly(k, state, (&mut y.state, &mut y.deviations))?;
        self.mirror(k, state, &mut y);
        Ok(y)
    }

    pub(crate) fn units(&self, state: &ShootingState) -> Result<ScaledUnits> {
        // Behind impacts that take all speed the states may all be zero but for rounding; the ends of the flights are not.
        let end = |k: usize| Ok(self.end_of_flight(k, state)?.state);
        let ends: Vec<DVector<f64>> = (0..state.states.len()).map(end).collect::<Result<_>>()?;
        let period = match self.clocked {
            Clocked::Forced { period } => period,
            Clocked::Free => state.times[state.times.len() - 1] - state.times[0],
        };
        Ok(ScaledUnits::of(state.states.iter().chain(&ends), period))
    }

    /// The ends of all flights.
    pub(crate) fn flight_ends(
        &self,
        state: &ShootingState,
        units: &ScaledUnits,
    ) -> Result<Vec<ArcEnd>> {
        (0..state.states.len())
            .map(|k| {
                let mut y = self.end_of_flight(k, state)?;
                let before = y.state.clone();
                let (impulses, chatter) = self.pass(k + 1, units, &mut y)?;
                Ok(ArcEnd {
                    before,
                    impulses,
                    chatter,
                })
            })
            .collect()
    }

    /// The largest of all gaps at impacts and of all jumps between flights, in their units.
    pub(crate) fn mismatch(&self, state: &ShootingState, units: &ScaledUnits) -> Result<f64> {
        let mut worst = Mismatch::default();
        for k in 0..state.states.len() {
            for stop in self.closing(k) {
                let GapAt { gap, gradient, .. } =
                    self.motion.gap(stop, state.start(k), &state.states[k])?;
                worst.note(gap / (gradient.amax() * units.position));
            }
            let mut y = self.end_of_flight(k, state)?;
            if let Some((condition, _)) = self.condition(k + 1, units, &y)? {
                worst.note(condition);
            }
            if let Some(own) = self.meeting(k + 1) {
                worst.note(self.distance(&own, (state, units), &y, (&[], &[]))?.0);
            }
            self.pass(k + 1, units, &mut y)?;
            self.note_jump(k, (state, units), &y, &mut worst)?;
        }
        Ok(worst.size)
    }

    /// Takes note of how far the end of flight k, gone through its instant, is from the start of the next.
    pub(super) fn note_jump(
        &self,
        k: usize,
        (state, units): (&ShootingState, &ScaledUnits),
        y: &Timed,
        worst: &mut Mismatch,
    ) -> Result<()> {
        let n = y.state.len() / 2;
        let count = state.states.len();
        let (next, start) = (&state.states[(k + 1) % count], self.next_start(k, state));
        let mut end = &y.state - next;
        if y.time != start {
            // The end of a chatter is known to less than the state at a fixed time is.
            end += self.motion.rate(self.regime(k + 1), start, next)? * (start - y.time);
        }
        worst.note(end.rows(0, n).amax() / units.position);
        worst.note(end.rows(n, n).amax() / units.velocity);
        Ok(())
    }
}

/// The largest residual of a loop.
#[derive(Default)]
pub(super) struct Mismatch {
    pub size: f64,
}

impl Mismatch {
    /// Takes note of a residual; one that is not a number counts as infinite.
    pub fn note(&mut self, lacks: f64) {
        let size = if lacks.is_nan() {
            f64::INFINITY
        } else {
            lacks.abs()
        };
        self.size = self.size.max(size);
    }
}
