//! Free flights of a pendulum along its Taylor series: the step is known beforehand, the gap along it is a polynomial, and a
//! contact needs no step of its own (theory 8).

use super::StepMover;
use super::free::FreeFlight;
use crate::contact::series::{Course, GapTerms};
use crate::error::{Error, Result};
use crate::flow::PendulumSeries;
use crate::flow::runge_kutta::State;
use crate::flow::taylor::MOST_ORDER;
use crate::model::{
    ChainMotion, Constraint, DoublePendulumMotion, Dynamics, Links, Scene, System, contacts,
};
use crate::simulate::clock::Clock;
use crate::simulate::kept::{Piece, SegmentKind, write_series};
use crate::simulate::mover::{Arrival, Mover};
use crate::simulate::record::Record;
use crate::simulate::trajectory::Graze;
use crate::simulate::{Keep, SimulateOptions};
use crate::watch::{Watch, answer};

/// The order of a series for a tolerance. A step of order p is as long as `tolerance^(1/p)` and its work `a + b p + c p^2`, of
/// which it is least for about this order on a double pendulum; it is flat there.
pub(crate) fn series_order(rtol: f64) -> usize {
    let digits = -rtol.max(f64::EPSILON).log10();
    let order = (8.5 + 1.1 * digits).ceil().max(8.0);
    (order as usize).min(MOST_ORDER)
}

/// Whether the motion of a scene and its gaps have Taylor series: a pendulum's do, but for stops given by functions.
pub(crate) fn has_series(scene: &Scene) -> bool {
    let is_given = |stop: &Constraint| !matches!(stop, Constraint::Nonlinear(_));
    let is_pendulum = matches!(
        scene.system(),
        System::DoublePendulum(_) | System::PendulumChain(_)
    );
    is_pendulum && scene.stops().iter().all(is_given)
}

/// A pendulum that has Taylor series: its motion for everything else, the coefficients for these.
pub(crate) enum Pendulum {
    /// Two links.
    Double(DoublePendulumMotion, Links),
    /// N links.
    Chain(ChainMotion, Links),
}

impl Pendulum {
    /// The pendulum of a scene.
    ///
    /// # Errors
    /// A scene that has no Taylor series.
    pub fn new(scene: &Scene) -> Result<Self> {
        let forcing = scene.forcing();
        match scene.system() {
            System::DoublePendulum(s) if has_series(scene) => Ok(Self::Double(
                DoublePendulumMotion::new(s, forcing),
                s.links(),
            )),
            System::PendulumChain(s) if has_series(scene) => {
                Ok(Self::Chain(ChainMotion::new(s, forcing), s.links()))
            }
            _ => Err(Error::bad_value(
                "method",
                "\"taylor\"",
                "Taylor series are those of a DoublePendulum or a PendulumChain with stops and walls; use \"auto\"",
            )),
        }
    }
}

/// Flights along Taylor series.
pub(crate) struct Taylor {
    series: PendulumSeries,
    gaps: Vec<GapTerms>,
    /// The step last taken, where it says how fast the motion changes.
    before: Option<f64>,
    /// Whether the series about the present state is made already.
    is_made: bool,
}

impl Taylor {
    /// Flights of a scene's pendulum.
    pub fn new(links: Links, scene: &Scene, options: &SimulateOptions) -> Self {
        Self {
            series: PendulumSeries::new(links, scene.forcing(), series_order(options.rtol)),
            gaps: contacts(scene)
                .iter()
                .filter_map(|contact| GapTerms::new(&contact.surface))
                .collect(),
            before: None,
            is_made: false,
        }
    }
}

impl<S: State, D: Dynamics> FreeFlight<S, D> for Taylor {
    fn reset(&mut self) {
        self.before = None;
        self.is_made = false;
    }

    fn fly(
        mover: &mut StepMover<'_, S, D, Self>,
        starts: &[usize],
        (span, last): (f64, f64),
        record: &mut Record,
        check: &mut dyn FnMut() -> bool,
    ) -> Result<Arrival> {
        let end = mover.clock.after(span);
        let mut starts = Some(starts);
        let mut go_on = answer(check);
        let mut watch = Watch::new(&mut go_on);
        loop {
            watch.work(mover.work())?;
            if let Some(arrival) = mover.step_on(starts.take(), (end, last), record)? {
                return Ok(arrival);
            }
        }
    }

    fn keep_nothing(
        mover: &mut StepMover<'_, S, D, Self>,
        last: Option<f64>,
        record: &mut Record,
    ) -> Result<()> {
        mover.expand()?;
        mover.keep_series(0.0, last, record);
        Ok(())
    }
}

impl<S: State, D: Dynamics> StepMover<'_, S, D, Taylor> {
    /// A step of a free flight that is to reach the instant `end` of the clock at the time `last`; where it arrives, if it
    /// does. `starts` are the orders of the gaps' roots where the flight begins with this step.
    pub fn step_on(
        &mut self,
        starts: Option<&[usize]>,
        (end, last): (Clock, f64),
        record: &mut Record,
    ) -> Result<Option<Arrival>> {
        if starts.is_some() {
            self.keep_segment(SegmentKind::Flight);
        }
        let left = self.clock.until(end);
        if left <= 0.0 {
            Taylor::keep_nothing(self, Some(last), record)?;
            return Ok(Some(Arrival::End));
        }
        self.expand()?;
        let Taylor { series, before, .. } = &mut self.free;
        let wanted = series.longest_step(self.tolerance, *before);
        let is_last = wanted >= left;
        let h = if is_last { left } else { wanted };
        if h.is_nan() || self.clock.local + h == self.clock.local {
            return Ok(Some(Arrival::Underflow));
        }
        if wanted.is_finite() {
            *before = Some(wanted);
        }
        self.n_steps += 1;
        let found = self.contact_on_series(starts, h);
        if record.keep != Keep::Final {
            record.grazes.append(&mut self.grazes);
        }
        if let Some((stop, course)) = found {
            let (at, arrival) = match course {
                Course::Stalled { at } => (at, Arrival::Stalled { stop }),
                // Time does not go back for a stop that was passed by less than its margin when the step began.
                Course::Contact { at } => (at.clamp(0.0, h), Arrival::Contact { stop }),
            };
            self.keep_series(at, None, record);
            self.arrive_on_series(at);
            self.look()?;
            return Ok(Some(arrival));
        }
        self.keep_series(h, is_last.then_some(last), record);
        self.arrive_on_series(h);
        Ok(is_last.then_some(Arrival::End))
    }

    /// Operations that a step is, at the most.
    pub fn work(&self) -> usize {
        self.free.series.work()
    }

    /// Whether the next flight, or the rest of this one, is free.
    pub fn is_free(&self) -> bool {
        self.holding.is_empty()
    }

    /// The series about the present state, for the next step, which finds it made: all but the work of making it is done.
    pub fn begin_series(&mut self) -> Result<&mut PendulumSeries> {
        let angle = self.moment().angle;
        let (q, v) = self.x.slice().split_at(self.dynamics.n_dof());
        self.free.is_made = true;
        self.free.series.begin(angle, q, v)?;
        Ok(&mut self.free.series)
    }

    /// Makes the series about the present state, where it is not made yet.
    fn expand(&mut self) -> Result<()> {
        self.stepper.n_rhs += 1;
        if !self.free.is_made {
            self.begin_series()?.expand();
        }
        self.free.is_made = false;
        Ok(())
    }

    /// The first stop reached along a step, or where the search stalls; touches before that are noted.
    fn contact_on_series(&mut self, starts: Option<&[usize]>, h: f64) -> Option<(usize, Course)> {
        self.grazes.clear();
        let mut first = None;
        let mut until = h;
        for stop in 0..self.free.gaps.len() {
            let mut gap = self.free.gaps[stop].along(&self.free.series);
            let margin = self.margin(stop, gap.size);
            let order = starts.map_or(0, |orders| orders[stop]);
            self.touches.clear();
            let course = gap.first_contact(order, until, margin, &mut self.touches);
            for &(at, gap) in &self.touches {
                let time = self.clock.after(at).time();
                let depth = -gap;
                self.grazes.push(Graze { time, stop, depth });
            }
            if let Some(course) = course {
                until = course.at();
                first = Some((stop, course));
            }
        }
        self.n_gap_evaluations += self.contacts.len();
        if let Some((stop, Course::Contact { .. })) = first {
            // A stop passed by less than its margin when the one found is reached was reached before.
            let earlier = self
                .free
                .gaps
                .iter()
                .enumerate()
                .filter_map(|(other, gap)| {
                    let is_open = starts.is_none_or(|orders| orders[other] == 0);
                    let gap = (other != stop && is_open).then(|| gap.along(&self.free.series))?;
                    Some((other, gap.passed_before(until)?))
                });
            if let Some((other, at)) = earlier.min_by(|a, b| a.1.total_cmp(&b.1)) {
                until = at;
                first = Some((other, Course::Contact { at }));
            }
        }
        if first.is_some() {
            let time = self.clock.after(until).time();
            self.grazes.retain(|graze| graze.time < time);
        }
        first
    }

    /// Keeps what is asked for of the series up to a time s; `last` is the time at which the run ends with it.
    fn keep_series(&mut self, span: f64, last: Option<f64>, record: &mut Record) {
        if record.keeps_nothing() {
            return;
        }
        let series = &self.free.series;
        if let Some(kept) = &mut self.kept {
            let clock = self.clock;
            kept.pieces.push(Piece { clock, span });
            let unit = if span > 0.0 { span } else { 1.0 };
            let n = self.dynamics.n_dof();
            write_series(unit, |link| series.angle(link), n, &mut kept.numbers);
        }
        self.sample(span, last, record, |local, x| {
            self.free.series.state(local, x);
        });
    }

    /// Makes the state a time s along the series the present one.
    fn arrive_on_series(&mut self, s: f64) {
        self.free.series.state(s, self.x.slice_mut());
        self.clock = self.clock.after(s);
        self.is_begun = false;
    }
}
