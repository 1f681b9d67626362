//! Free flights of a pendulum along its Taylor series: the step is known beforehand, the gap along it is a polynomial, and a
//! contact needs no step of its own (theory 8).

use super::StepMover;
use super::free::FreeFlight;
use super::pendulum::series_order;
use crate::contact::series::{GapSeries, GapTerms, SeriesEnd};
use crate::error::Result;
use crate::flow::steps::{DormandPrince, State};
use crate::flow::{BatchMotion, PendulumSeries, SeriesOf};
use crate::model::{Dynamics, Links, Scene, contacts};
use crate::simulate::clock::Clock;
use crate::simulate::kept::{Piece, SegmentKind, write_series};
use crate::simulate::mover::{Arrival, Mover};
use crate::simulate::options::{Keep, SimulateOptions};
use crate::simulate::record::Record;
use crate::simulate::trajectory::Graze;
use crate::watch::Watch;

/// Flights along Taylor series.
pub(crate) struct Taylor {
    pendulum: PendulumSeries,
    series: SeriesOf<1>,
    gaps: Vec<GapTerms>,
    /// The step last taken, where it says how fast the motion changes.
    before: Option<f64>,
}

impl Taylor {
    /// Flights of a scene's pendulum.
    pub fn new(links: Links, scene: &Scene, options: &SimulateOptions) -> Self {
        let order = series_order(options.rtol);
        let pendulum = PendulumSeries::new(links, scene.forcing(), order);
        Self {
            series: pendulum.room(),
            pendulum,
            gaps: contacts(scene)
                .iter()
                .filter_map(|contact| GapTerms::new(&contact.surface))
                .collect(),
            before: None,
        }
    }
}

impl<S: State, D: Dynamics> FreeFlight<S, D> for Taylor {
    type Steps = DormandPrince<S>;

    fn reset(&mut self) {
        self.before = None;
    }

    fn fly(
        mover: &mut StepMover<'_, S, D, Self>,
        starts: &[usize],
        (span, last): (f64, f64),
        record: &mut Record,
        watch: &mut Watch<'_>,
    ) -> Result<Arrival> {
        let end = mover.clock.after(span);
        let mut starts = Some(starts);
        mover.lend_series(|mover, series| {
            if mover.contacts.is_empty() && record.keeps_nothing() {
                return mover.go_through(series, end, watch);
            }
            let mut steps = watch.steps(mover.work());
            loop {
                steps.begin()?;
                let arrival = mover.step_on(series, starts.take(), (end, last), record)?;
                if let Some(arrival) = arrival {
                    return Ok(arrival);
                }
            }
        })
    }

    fn keep_nothing(
        mover: &mut StepMover<'_, S, D, Self>,
        last: Option<f64>,
        record: &mut Record,
    ) -> Result<()> {
        mover.lend_series(|mover, series| {
            mover.expand(series)?;
            mover.keep_series(series, 0.0, last, record);
            Ok(())
        })
    }
}

/// How far a step along a series goes.
enum Reach {
    /// There is nothing left to go.
    AtEnd,
    /// It would be too short for the time, or is no number.
    TooShort,
    /// A length; the last step where it reaches the end.
    To { h: f64, is_last: bool },
}

/// A step along a series: how far, and what is at its end.
pub(crate) struct SeriesStep {
    /// A leg of no length leaves the state as it is.
    pub span: f64,
    arrival: Option<Arrival>,
}

impl<S: State, D: Dynamics> StepMover<'_, S, D, Taylor> {
    /// Lends the series of the mover, which takes notes of the search along it.
    fn lend_series<R>(&mut self, borrow: impl FnOnce(&mut Self, &mut SeriesOf<1>) -> R) -> R {
        let mut series = std::mem::replace(&mut self.free.series, SeriesOf::new(0, 0));
        let done = borrow(self, &mut series);
        self.free.series = series;
        done
    }

    /// A flight to the instant `end` where there is no stop, and nothing to keep of it but its end.
    fn go_through(
        &mut self,
        series: &mut SeriesOf<1>,
        end: Clock,
        watch: &mut Watch<'_>,
    ) -> Result<Arrival> {
        let mut steps = watch.steps(self.work());
        self.is_begun = false;
        loop {
            steps.begin()?;
            self.expand(series)?;
            match self.reach(series.motion(0), end) {
                Reach::To { h, is_last } => {
                    self.n_steps += 1;
                    series.state(h, self.x.slice_mut());
                    self.clock = self.clock.after(h);
                    if is_last {
                        return Ok(Arrival::End);
                    }
                }
                Reach::AtEnd => return Ok(Arrival::End),
                Reach::TooShort => return Ok(Arrival::Underflow),
            }
        }
    }

    /// A step of a free flight that is to reach the instant `end` of the clock at the time `last`; where it arrives, if it
    /// does. `starts` are the orders of the gaps' roots where the flight begins with this step.
    fn step_on(
        &mut self,
        series: &mut SeriesOf<1>,
        starts: Option<&[usize]>,
        (end, last): (Clock, f64),
        record: &mut Record,
    ) -> Result<Option<Arrival>> {
        self.expand(series)?;
        let Some(leg) = self.look_along(series.motion(0), starts, end, record) else {
            return Ok(Some(Arrival::Underflow));
        };
        let is_last = matches!(leg.arrival, Some(Arrival::End));
        self.keep_series(series, leg.span, is_last.then_some(last), record);
        if leg.span > 0.0 {
            series.state(leg.span, self.x.slice_mut());
        }
        self.end_leg(leg)
    }

    /// How far the next step along the series about the present state goes, towards the instant `end`.
    #[inline]
    fn reach<const K: usize>(&mut self, motion: BatchMotion<'_, K>, end: Clock) -> Reach {
        let left = self.clock.until(end);
        if left <= 0.0 {
            return Reach::AtEnd;
        }
        let wanted = motion.longest_step(self.tolerance, self.free.before);
        let is_last = wanted >= left;
        let h = if is_last { left } else { wanted };
        if h.is_nan() || self.is_too_short(h) {
            return Reach::TooShort;
        }
        if wanted.is_finite() {
            self.free.before = Some(wanted);
        }
        Reach::To { h, is_last }
    }

    /// The next step along the series about the present state, towards the instant `end`; none where it would be too short for
    /// the time. `starts` as in `step_on`.
    pub fn look_along<const K: usize>(
        &mut self,
        motion: BatchMotion<'_, K>,
        starts: Option<&[usize]>,
        end: Clock,
        record: &mut Record,
    ) -> Option<SeriesStep> {
        if starts.is_some() {
            self.forget_extents();
            self.keep_segment(SegmentKind::Flight);
        }
        let (h, is_last) = match self.reach(motion, end) {
            Reach::To { h, is_last } => (h, is_last),
            Reach::AtEnd => {
                let arrival = Some(Arrival::End);
                return Some(SeriesStep { span: 0.0, arrival });
            }
            Reach::TooShort => return None,
        };
        self.n_steps += 1;
        let found = self.contact_on_series(motion, starts, h);
        if record.keep != Keep::Final {
            record.grazes.append(&mut self.grazes);
        }
        let (span, arrival) = match found {
            None => (h, is_last.then_some(Arrival::End)),
            Some((stop, SeriesEnd::Stalled { at })) => (at, Some(Arrival::Stalled { stop })),
            Some((stop, SeriesEnd::Contact { at })) => {
                (at.clamp(0.0, h), Some(Arrival::Contact { stop }))
            }
        };
        Some(SeriesStep { span, arrival })
    }

    /// Makes a position and velocity of a link, if there is that link, the present ones.
    #[inline]
    pub fn put_link(&mut self, link: usize, [q, v]: [f64; 2]) {
        let n = self.n();
        if link < n {
            let x = self.x.slice_mut();
            (x[link], x[n + link]) = (q, v);
        }
    }

    /// Ends a leg at whose end the present state is; where it arrived, if it did.
    pub fn end_leg(&mut self, leg: SeriesStep) -> Result<Option<Arrival>> {
        self.clock = self.clock.after(leg.span);
        self.is_begun = false;
        if matches!(
            leg.arrival,
            Some(Arrival::Contact { .. } | Arrival::Stalled { .. })
        ) {
            self.look()?;
        }
        Ok(leg.arrival)
    }

    /// Operations that a step is, at the most.
    pub fn work(&self) -> usize {
        self.free.pendulum.work()
    }

    /// Whether the next flight, or the rest of this one, is free.
    pub fn is_free(&self) -> bool {
        self.holding.is_empty()
    }

    /// Begins the m-th of some series at the present state.
    pub fn begin_series<const K: usize>(
        &mut self,
        series: &mut SeriesOf<K>,
        m: usize,
    ) -> Result<()> {
        self.n_series += 1;
        let angle = self.moment().angle;
        let (q, v) = self.x.slice().split_at(self.dynamics.n_dof());
        self.free.pendulum.begin(series, m, (angle, q, v))
    }

    /// What makes the series of the motion.
    pub fn pendulum(&self) -> &PendulumSeries {
        &self.free.pendulum
    }

    /// Makes the series about the present state.
    fn expand(&mut self, series: &mut SeriesOf<1>) -> Result<()> {
        self.begin_series(series, 0)?;
        self.pendulum().expand(series);
        Ok(())
    }

    /// The first stop reached along a step, or where the search stalls; touches before that are noted.
    fn contact_on_series<const K: usize>(
        &mut self,
        motion: BatchMotion<'_, K>,
        starts: Option<&[usize]>,
        h: f64,
    ) -> Option<(usize, SeriesEnd)> {
        self.grazes.clear();
        let mut gap = GapSeries::EMPTY;
        let mut first = None;
        let mut until = h;
        for stop in 0..self.free.gaps.len() {
            self.free.gaps[stop].along(motion, &mut gap);
            self.extents[stop] = self.extents[stop].max(gap.size);
            let order = starts.map_or(0, |orders| orders[stop]);
            self.touches.clear();
            let course = gap.first_contact(order, until, &mut self.touches);
            for &(at, gap) in &self.touches {
                let time = self.clock.after(at).time();
                let depth = -gap;
                self.grazes.push(Graze { time, stop, depth });
            }
            if let Some(course) = course {
                // A flight of one step is farthest from its stop half-way.
                self.free.gaps[stop].along(motion, &mut gap);
                let far = gap.value(0.5 * course.at()).abs();
                self.extents[stop] = self.extents[stop].max(far);
                until = course.at();
                first = Some((stop, course));
            }
        }
        self.n_gap_evaluations += self.contacts.len();
        if let Some((stop, SeriesEnd::Contact { .. })) = first {
            // A stop that is passed when the one found is reached was reached before.
            let earlier = self
                .free
                .gaps
                .iter()
                .enumerate()
                .filter_map(|(other, terms)| {
                    let is_open = starts.is_none_or(|orders| orders[other] == 0);
                    if other == stop || !is_open {
                        return None;
                    }
                    terms.along(motion, &mut gap);
                    Some((other, gap.passed_before(until)?))
                });
            if let Some((other, at)) = earlier.min_by(|a, b| a.1.total_cmp(&b.1)) {
                until = at;
                first = Some((other, SeriesEnd::Contact { at }));
            }
        }
        if first.is_some() {
            let time = self.clock.after(until).time();
            self.grazes.retain(|graze| graze.time < time);
        }
        first
    }

    /// Keeps what is asked for of the series up to a time s; `last` is the time at which the run ends with it.
    fn keep_series(
        &mut self,
        series: &SeriesOf<1>,
        span: f64,
        last: Option<f64>,
        record: &mut Record,
    ) {
        if !record.keeps_motion() {
            return;
        }
        if let Some(kept) = &mut self.kept {
            let clock = self.clock;
            kept.pieces.push(Piece { clock, span });
            let unit = if span > 0.0 { span } else { 1.0 };
            let n = self.dynamics.n_dof();
            write_series(
                unit,
                |link| series.motion(0).angle(link),
                n,
                &mut kept.numbers,
            );
        }
        self.sample(span, last, record, |local, x| {
            series.state(local, x);
        });
    }
}
