//! Trajectories: impacts, grazes, flights, the motion at any time, both sides of an impact.

use crate::error::{Error, Result};
use crate::hybrid::clock::Clock;
use crate::hybrid::{Graze, SegmentKind};
use crate::impact::{Impact, wrapped};
use crate::modal::Form;
use crate::model::Scene;
use crate::quantity::room_for;
use crate::simulate::kept::{Kept, Machinery, Piece};
use crate::simulate::options::{Stats, Status};
use crate::watch::is_broken_off;
use nalgebra::{DMatrix, DVector};

/// Points drawn in one flight at the most.
const MOST_POINTS: usize = 200;
/// Points drawn in all, but for both sides of each impact, and positions at them: as many as any figure shows.
const POINTS_IN_ALL: usize = 1_000_000;
const NUMBERS_IN_ALL: usize = 100_000_000;
/// Points drawn in one step of an integrator.
const POINTS_PER_STEP: usize = 4;
/// Points drawn in one radian of the fastest motion.
const POINTS_PER_RADIAN: f64 = 8.0;

/// Which velocity is meant at an impact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ImpactSide {
    /// The one after it.
    #[default]
    After,
    /// The one before it.
    Before,
}

/// A part of a trajectory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// What it is.
    pub kind: SegmentKind,
    /// The stop it stays on or chatters against, `None` for a flight.
    pub stop: Option<usize>,
    /// Start \[s\].
    pub start: f64,
    /// End \[s\].
    pub end: f64,
}

/// A simulated motion.
#[derive(Debug, Clone)]
pub struct Trajectory {
    pub(crate) scene: Scene,
    pub(crate) machinery: Machinery,
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

/// A point of the motion that was kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Point {
    pub time: f64,
    pub piece: usize,
    pub local: f64,
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
        let forcing = self.scene.forcing();
        let frequency = forcing.frequency().unwrap_or(0.0);
        wrapped(Clock::new(t, frequency).angle() + forcing.phase())
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

    /// The parts of the trajectory; several stops in lasting contact have a row each.
    ///
    /// # Errors
    /// A trajectory that does not keep its motion.
    pub fn segments(&self) -> Result<Vec<Segment>> {
        let mut all = Vec::new();
        for (whole, stops) in self.stretches()? {
            if stops.is_empty() {
                all.push(whole);
            }
            all.extend(stops.iter().map(|&stop| Segment {
                stop: Some(stop),
                ..whole
            }));
        }
        Ok(all)
    }

    /// The parts of the trajectory, each once, with the stops in contact.
    pub(crate) fn stretches(&self) -> Result<Vec<(Segment, &[usize])>> {
        let kept = self.motion()?;
        let within = |time: f64| time.clamp(self.span.0, self.span.1);
        let mut all = Vec::with_capacity(kept.segments.len());
        for (k, segment) in kept.segments.iter().enumerate() {
            let range = kept.pieces_of(k);
            let (pieces, next) = (&kept.pieces[range.clone()], kept.pieces.get(range.end));
            let (Some(first), Some(last)) = (pieces.first(), pieces.last()) else {
                continue;
            };
            // A flight of no length is a side of an impact, but where there is nothing else.
            let is_last = k + 1 == kept.segments.len() && all.is_empty();
            let is_side = pieces.iter().all(|p| p.span == 0.0) && !is_last;
            if segment.stops.is_empty() && is_side {
                continue;
            }
            // A part ends where the next one begins, to the last digit.
            let end = next.map_or_else(|| last.clock.after(last.span), |next| next.clock);
            let whole = Segment {
                kind: segment.kind,
                stop: None,
                start: within(first.clock.time()),
                end: within(end.time()),
            };
            all.push((whole, segment.stops.as_slice()));
        }
        // The last one ends with the run, of which its clock knows the time to rounding.
        if let Some((last, _)) = all.last_mut() {
            last.end = self.span.1;
        }
        Ok(all)
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

    /// Position and velocity at a time inside the span. What is left of impacts that accumulate (a segment `Chatter`) is given as
    /// motion with the stop held: its velocity is off the true one, which jumps without end there, by no more than the speed of
    /// the first impact left out, along the stop's reaction.
    ///
    /// # Errors
    /// A time outside the span, or a trajectory that does not keep its motion.
    pub fn state(&self, t: f64, side: ImpactSide) -> Result<(DVector<f64>, DVector<f64>)> {
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
        let start_of = |index: usize| kept.pieces[index].clock.time();
        let (now, mut index) = self.piece_at(kept, t);
        if side == ImpactSide::Before {
            // Stops hit one after the other at one instant leave pieces of no length: go back to the first.
            while index > 0 && start_of(index) == now {
                index -= 1;
                if start_of(index) < now {
                    return Ok(self.state_in(index, kept.pieces[index].span));
                }
            }
        }
        Ok(self.state_in(index, kept.pieces[index].local(t)))
    }

    /// The last piece that begins no later than a time, and that time on the clock of the pieces, whose ends may be off those of
    /// the span by rounding.
    fn piece_at(&self, kept: &Kept, t: f64) -> (f64, usize) {
        let ends = (kept.pieces[0], kept.pieces[kept.pieces.len() - 1]);
        let t = if t >= self.span.1 && t > self.span.0 {
            ends.1.clock.after(ends.1.span).time()
        } else if t <= self.span.0 {
            ends.0.clock.time()
        } else {
            t
        };
        let first_later = kept.pieces.partition_point(|p| p.clock.time() <= t);
        (t, first_later.max(1) - 1)
    }

    pub(crate) fn state_in(&self, index: usize, local: f64) -> (DVector<f64>, DVector<f64>) {
        let kept = self
            .kept
            .as_ref()
            .expect("asked for by callers that have it");
        let segment = kept.segment_of(index);
        let width = self.machinery.width(segment.kind, self.scene.n_dof());
        let numbers = kept.numbers_of(segment, index, width);
        self.machinery
            .state(segment, kept.pieces[index], numbers, local)
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
        let points = self.points()?;
        let (m, n) = (points.len(), self.scene.n_dof());
        room_for("the motion at its points", m, 2 * n)?;
        let (mut q, mut v) = (DMatrix::zeros(m, n), DMatrix::zeros(m, n));
        for (i, point) in points.iter().enumerate() {
            if is_broken_off() {
                return Err(Error::Interrupted);
            }
            let (position, velocity) = self.state_in(point.piece, point.local);
            q.set_row(i, &position.transpose());
            v.set_row(i, &velocity.transpose());
        }
        Ok((points.iter().map(|p| p.time).collect(), q, v))
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

    /// Where the samples are in the motion that was kept.
    pub(crate) fn points(&self) -> Result<Vec<Point>> {
        let kept = self.motion()?;
        if let Some((times, ..)) = &self.samples {
            let at = |&time: &f64| {
                let (_, piece) = self.piece_at(kept, time);
                let local = kept.pieces[piece].local(time);
                Point { time, piece, local }
            };
            return Ok(times.iter().map(at).collect());
        }
        let rate = self.fastest_rate();
        let count = kept.segments.len();
        let in_all = POINTS_IN_ALL.min(NUMBERS_IN_ALL / self.scene.n_dof());
        let drawn = (in_all / count.max(1)).clamp(2, MOST_POINTS);
        let mut points: Vec<Point> = Vec::new();
        for segment in 0..count {
            if is_broken_off() {
                return Err(Error::Interrupted);
            }
            let pieces = kept.pieces_of(segment);
            let Some(&first) = kept.pieces[pieces.clone()].first() else {
                continue;
            };
            let span: f64 = kept.pieces[pieces.clone()].iter().map(|p| p.span).sum();
            let wanted = (span * rate * POINTS_PER_RADIAN).ceil() + 1.0;
            let by_steps = (POINTS_PER_STEP * pieces.len()) as f64 + 1.0;
            let wanted = if self.is_stepped() { by_steps } else { wanted };
            // A flight of no length is a side of an impact: one point.
            let most = if span > 0.0 { drawn } else { 1 };
            let count = (wanted.max(2.0) as usize).min(most);
            let (mut piece, mut before) = (pieces.start, 0.0);
            for k in 0..count - 1 {
                let s = span * k as f64 / (count - 1) as f64;
                while piece + 1 < pieces.end && s > before + kept.pieces[piece].span {
                    before += kept.pieces[piece].span;
                    piece += 1;
                }
                points.push(Point {
                    time: first.clock.after(s).time(),
                    piece,
                    local: (s - before).clamp(0.0, kept.pieces[piece].span),
                });
            }
            // The end is the start of the next segment to the bit, which a sum of steps is not.
            let (last, Piece { clock, span }) = (pieces.end - 1, kept.pieces[pieces.end - 1]);
            points.push(Point {
                time: clock.after(span).time(),
                piece: last,
                local: span,
            });
        }
        // The ends are those asked for, whatever rounding makes of a time counted in periods.
        let ends = points.first().zip(points.last());
        if let Some((first, last)) = ends.map(|(a, b)| (a.time, b.time)) {
            for point in &mut points {
                if point.time == first {
                    point.time = self.span.0;
                } else if point.time == last {
                    point.time = self.span.1;
                }
            }
        }
        Ok(points)
    }

    /// The clock at the start of a piece of the motion that was kept.
    pub(crate) fn piece_clock(&self, piece: usize) -> Clock {
        self.piece(piece).clock
    }

    /// The span of a piece of the motion that was kept.
    pub(crate) fn piece_span(&self, piece: usize) -> f64 {
        self.piece(piece).span
    }

    fn piece(&self, piece: usize) -> Piece {
        let kept = self.kept.as_ref();
        kept.expect("asked for by callers that have it").pieces[piece]
    }

    /// The kind of the segment of a piece, and the stops in contact.
    pub(crate) fn kind_of(&self, piece: usize) -> (SegmentKind, &[usize]) {
        let segment = self.kept.as_ref().map(|kept| kept.segment_of(piece));
        segment.map_or((SegmentKind::Flight, &[]), |s| (s.kind, &s.stops))
    }

    /// What moves the pieces.
    pub(crate) fn machinery(&self) -> &Machinery {
        &self.machinery
    }

    fn is_stepped(&self) -> bool {
        !matches!(self.machinery, Machinery::Exact { .. })
    }

    /// The fastest of the forcing and the free oscillations of a linear scene.
    fn fastest_rate(&self) -> f64 {
        let Machinery::Exact { modal, .. } = &self.machinery else {
            return 0.0;
        };
        let free = match &modal.form.form {
            Form::Blocks(blocks) => blocks
                .iter()
                .flat_map(|b| b.roots())
                .map(|l| l.im.abs())
                .fold(0.0, f64::max),
            Form::Dense(m) => m.norm(),
        };
        let rate = free.max(modal.frequency);
        if rate > 0.0 {
            rate
        } else {
            MOST_POINTS as f64 / (self.span.1 - self.span.0).max(f64::MIN_POSITIVE)
        }
    }
}
