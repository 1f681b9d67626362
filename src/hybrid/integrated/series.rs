//! Free flights of a pendulum along its Taylor series: the step is known beforehand, the gap along it is a polynomial, and a
//! contact needs no step of its own (theory 8).

use super::free::FreeFlight;
use super::pendulum::series_order;
use super::scene::{Integrated, parted};
use crate::error::Result;
use crate::event::curvature::gap_tolerance;
use crate::event::first_root::{FirstEvent, FirstRoot};
use crate::event::series::{GapSeries, GapTerms};
use crate::flow::steps::{DormandPrince, State, Stepper};
use crate::flow::{BatchMotion, PendulumSeries, SeriesOf, write_series};
use crate::hybrid::clock::Clock;
use crate::hybrid::flow::Arrival;
use crate::hybrid::recorder::{ArcMotion, ArcSpan, Recorder, Written};
use crate::hybrid::segment::{Graze, SegmentKind};
use crate::hybrid::system::Gaps;
use crate::law::{Guard, Regime};
use crate::model::{Dynamics, Links, PhysicalState, Scene, contacts};
use crate::observer::Observer;
use crate::tolerance::SINE_TURN;

/// Flights along Taylor series.
pub(crate) struct Taylor {
    pub search: SeriesSearch,
    series: SeriesOf<1>,
}

/// What makes series, and searches the gaps along them.
pub(crate) struct SeriesSearch {
    pendulum: PendulumSeries,
    gaps: Vec<GapTerms>,
    /// The step last taken, where it says how fast the motion changes.
    before: Option<f64>,
}

impl Taylor {
    /// Flights of a scene's pendulum, to a relative tolerance.
    pub fn new(links: Links, scene: &Scene, tolerance: f64) -> Self {
        let order = series_order(tolerance);
        let pendulum = PendulumSeries::new(links, &scene.excitation(), order);
        let gaps = contacts(scene);
        let gaps = gaps
            .iter()
            .filter_map(|contact| GapTerms::new(&contact.surface));
        Self {
            series: pendulum.room(),
            search: SeriesSearch {
                gaps: gaps.collect(),
                pendulum,
                before: None,
            },
        }
    }
}

impl<S: State, D: Dynamics> FreeFlight<S, D> for Taylor {
    type Steps = DormandPrince<S>;

    fn choice(&self) {}

    fn reset(&mut self) {
        self.search.before = None;
    }

    fn advance(
        &mut self,
        system: &mut Integrated<'_, S, D, Self::Steps>,
        orders: &[usize],
        (span, last): (f64, f64),
        recorder: &mut dyn Recorder,
        observer: &mut Observer,
    ) -> Result<Arrival> {
        let Self { search, series } = self;
        let end = system.clock.after(span);
        if system.contacts.is_empty() && recorder.wanted().is_nothing() {
            return search.go_through(system, series, end, observer);
        }
        let mut steps = observer.steps(search.work());
        let mut orders = Some(orders);
        loop {
            steps.begin()?;
            let arrival = search.step_on(system, series, orders.take(), (end, last), recorder)?;
            if let Some(arrival) = arrival {
                return Ok(arrival);
            }
            if recorder.is_satisfied() {
                return Ok(Arrival::End);
            }
        }
    }

    fn record_instant(
        &mut self,
        system: &mut Integrated<'_, S, D, Self::Steps>,
        last: Option<f64>,
        recorder: &mut dyn Recorder,
    ) -> Result<()> {
        self.search.expand(system, &mut self.series)?;
        system.record_series(&self.series, 0.0, last, recorder);
        Ok(())
    }
}

/// The motion on a series.
pub(crate) struct SeriesArc<'s> {
    pub series: &'s SeriesOf<1>,
    pub n: usize,
    pub span: f64,
}

impl Written for SeriesArc<'_> {
    fn write(&self, numbers: &mut Vec<f64>) {
        let unit = if self.span > 0.0 { self.span } else { 1.0 };
        let motion = self.series.motion(0);
        write_series(unit, |link| motion.angle(link), self.n, numbers);
    }
}

impl ArcMotion for SeriesArc<'_> {
    fn state(&mut self, local: f64) -> PhysicalState {
        let mut x = vec![0.0; 2 * self.n];
        self.series.state(local, &mut x);
        parted(&x)
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
    /// A step of no length leaves the state as it is.
    pub span: f64,
    arrival: Option<Arrival>,
}

impl SeriesSearch {
    /// A flight to the instant `end` where there is no stop, and nothing to record of it but its end.
    fn go_through<S: State, D: Dynamics, P: Stepper<S>>(
        &mut self,
        system: &mut Integrated<'_, S, D, P>,
        series: &mut SeriesOf<1>,
        end: Clock,
        observer: &mut Observer,
    ) -> Result<Arrival> {
        let mut steps = observer.steps(self.work());
        system.is_begun = false;
        loop {
            steps.begin()?;
            self.expand(system, series)?;
            match self.reach(system, series.motion(0), end) {
                Reach::To { h, is_last } => {
                    system.n_steps += 1;
                    series.state(h, system.x.slice_mut());
                    system.clock = system.clock.after(h);
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
    /// does. `orders` are those of the gaps' roots where the flight begins with this step.
    fn step_on<S: State, D: Dynamics, P: Stepper<S>>(
        &mut self,
        system: &mut Integrated<'_, S, D, P>,
        series: &mut SeriesOf<1>,
        orders: Option<&[usize]>,
        (end, last): (Clock, f64),
        recorder: &mut dyn Recorder,
    ) -> Result<Option<Arrival>> {
        self.expand(system, series)?;
        let Some(step) = self.search_along(system, series.motion(0), orders, end, recorder) else {
            return Ok(Some(Arrival::Underflow));
        };
        let is_last = matches!(step.arrival, Some(Arrival::End));
        system.record_series(series, step.span, is_last.then_some(last), recorder);
        if step.span > 0.0 {
            series.state(step.span, system.x.slice_mut());
        }
        system.end_step(step)
    }

    /// How far the next step along the series about the present state goes, towards the instant `end`.
    #[inline]
    fn reach<S: State, D: Dynamics, P: Stepper<S>, const K: usize>(
        &mut self,
        system: &Integrated<'_, S, D, P>,
        motion: BatchMotion<'_, K>,
        end: Clock,
    ) -> Reach {
        let left = system.clock.until(end);
        if left <= 0.0 {
            return Reach::AtEnd;
        }
        let wanted = motion.longest_step(system.tolerance, self.before);
        let is_last = wanted >= left;
        let h = if is_last { left } else { wanted };
        if h.is_nan() || system.is_too_short(h) {
            return Reach::TooShort;
        }
        if wanted.is_finite() {
            self.before = Some(wanted);
        }
        Reach::To { h, is_last }
    }

    /// The next step along the series about the present state, towards the instant `end`; none where it would be too short for
    /// the time. `orders` as in `step_on`.
    pub fn search_along<S: State, D: Dynamics, P: Stepper<S>, const K: usize>(
        &mut self,
        system: &mut Integrated<'_, S, D, P>,
        motion: BatchMotion<'_, K>,
        orders: Option<&[usize]>,
        end: Clock,
        recorder: &mut dyn Recorder,
    ) -> Option<SeriesStep> {
        if orders.is_some() {
            system.forget_extents();
            recorder.begin_segment(SegmentKind::Flight, Regime::free());
        }
        let (h, is_last) = match self.reach(system, motion, end) {
            Reach::To { h, is_last } => self.known(system, motion, (h, is_last)),
            Reach::AtEnd => {
                let arrival = Some(Arrival::End);
                return Some(SeriesStep { span: 0.0, arrival });
            }
            Reach::TooShort => return None,
        };
        system.n_steps += 1;
        let FirstEvent { stop, root } = self.contact_along(system, motion, orders, h);
        if recorder.wanted().events {
            for graze in system.grazes.drain(..) {
                recorder.graze(graze);
            }
        }
        let (span, arrival) = match root {
            FirstRoot::None => (h, is_last.then_some(Arrival::End)),
            FirstRoot::Undecided { at } => (at, Some(Arrival::Stalled { stop })),
            FirstRoot::Crossing { at, .. } => (
                at.clamp(0.0, h),
                Some(Arrival::Event {
                    guard: Guard::gap(stop),
                }),
            ),
        };
        Some(SeriesStep { span, arrival })
    }

    /// The same step, shorter where links turn so far in it that the sines in a gap are not known to the tolerance, though the angles
    /// are; and whether it is the last.
    #[inline]
    fn known<S: State, D: Dynamics, P: Stepper<S>, const K: usize>(
        &self,
        system: &Integrated<'_, S, D, P>,
        motion: BatchMotion<'_, K>,
        (h, is_last): (f64, bool),
    ) -> (f64, bool) {
        if h * motion.largest(|lane| &lane.v[0]) <= SINE_TURN {
            return (h, is_last);
        }
        let mut gap = GapSeries::EMPTY;
        let known = self.gaps.iter().fold(h, |known, terms| {
            let Some(reach) = terms.reach() else {
                return known;
            };
            terms.along(motion, &mut gap);
            gap.known_within(known, gap_tolerance(system.tolerance, (reach, reach)))
        });
        (known, is_last && known >= h)
    }

    /// Operations that a step is, at the most.
    pub fn work(&self) -> usize {
        self.pendulum.work()
    }

    /// Begins the m-th of some series at the present state.
    pub fn begin_series<S: State, D: Dynamics, P: Stepper<S>, const K: usize>(
        &mut self,
        system: &mut Integrated<'_, S, D, P>,
        series: &mut SeriesOf<K>,
        m: usize,
    ) -> Result<()> {
        system.n_series += 1;
        let at = system.moment();
        let (q, v) = system.x.slice().split_at(system.n());
        self.pendulum.begin(series, m, (at, q, v))
    }

    /// What makes the series of the motion.
    pub fn pendulum(&mut self) -> &mut PendulumSeries {
        &mut self.pendulum
    }

    /// Makes the series about the present state.
    fn expand<S: State, D: Dynamics, P: Stepper<S>>(
        &mut self,
        system: &mut Integrated<'_, S, D, P>,
        series: &mut SeriesOf<1>,
    ) -> Result<()> {
        self.begin_series(system, series, 0)?;
        self.pendulum.expand(series);
        Ok(())
    }

    /// The first stop reached along a step, or where the search stalls; touches before that are noted.
    fn contact_along<S: State, D: Dynamics, P: Stepper<S>, const K: usize>(
        &self,
        system: &mut Integrated<'_, S, D, P>,
        motion: BatchMotion<'_, K>,
        orders: Option<&[usize]>,
        h: f64,
    ) -> FirstEvent {
        system.grazes.clear();
        let mut gap = GapSeries::EMPTY;
        let mut first = FirstEvent::NONE;
        let mut until = h;
        for stop in 0..self.gaps.len() {
            self.gaps[stop].along(motion, &mut gap);
            system.extents[stop] = system.extents[stop].max(gap.size);
            let order = orders.map_or(0, |orders| orders[stop]);
            system.touches.clear();
            let root = gap.first_contact(order, until, &mut system.touches);
            for &(at, gap) in &system.touches {
                let time = system.clock.after(at).time();
                let depth = -gap;
                system.grazes.push(Graze { time, stop, depth });
            }
            if root != FirstRoot::None {
                // A flight of one step is farthest from its stop half-way.
                self.gaps[stop].along(motion, &mut gap);
                let far = gap.value(0.5 * root.at()).abs();
                system.extents[stop] = system.extents[stop].max(far);
                until = root.at();
                first = FirstEvent { stop, root };
            }
        }
        system.n_gap_evaluations += system.contacts.len();
        if let FirstRoot::Crossing { passed, .. } = first.root {
            // A stop that is passed when the one found is reached was reached before.
            let earlier = self.gaps.iter().enumerate().filter_map(|(other, terms)| {
                let is_open = orders.is_none_or(|orders| orders[other] == 0);
                if other == first.stop || !is_open {
                    return None;
                }
                terms.along(motion, &mut gap);
                Some((other, gap.passed_before(until)?))
            });
            if let Some((other, at)) = earlier.min_by(|a, b| a.1.total_cmp(&b.1)) {
                until = at;
                let root = FirstRoot::Crossing { at, passed };
                first = FirstEvent { stop: other, root };
            }
        }
        if first.root != FirstRoot::None {
            let time = system.clock.after(until).time();
            system.grazes.retain(|graze| graze.time < time);
        }
        first
    }
}

impl<S: State, D: Dynamics, P: Stepper<S>> Integrated<'_, S, D, P> {
    /// Makes a position and velocity of a link, if there is that link, the present ones.
    #[inline]
    pub fn put_link(&mut self, link: usize, [q, v]: [f64; 2]) {
        let n = self.n();
        if link < n {
            let x = self.x.slice_mut();
            (x[link], x[n + link]) = (q, v);
        }
    }

    /// Ends a step at whose end the present state is; where it arrived, if it did.
    pub fn end_step(&mut self, step: SeriesStep) -> Result<Option<Arrival>> {
        self.clock = self.clock.after(step.span);
        self.is_begun = false;
        if matches!(
            step.arrival,
            Some(Arrival::Event { .. } | Arrival::Stalled { .. })
        ) {
            self.evaluate_gaps()?;
        }
        Ok(step.arrival)
    }

    /// Records what is wanted of the series up to a time s; `last` is the time at which the run ends with it.
    fn record_series(
        &self,
        series: &SeriesOf<1>,
        span: f64,
        last: Option<f64>,
        recorder: &mut dyn Recorder,
    ) {
        if recorder.wanted().arcs {
            let (start, n) = (self.clock, self.n());
            let mut motion = SeriesArc { series, n, span };
            recorder.arc(&ArcSpan { start, span, last }, &mut motion);
        }
    }
}
