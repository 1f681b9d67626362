//! The loop of a simulation: advance to the next event, resolve its impacts, go on; complete impacts that accumulate, hold the stops that
//! stay in contact, release those whose force would pull (theory 8, 9). Impacts are completed by `accumulates` here (one stop alone) and by
//! `are_spent` in `strike.rs` (several stops, or beside stops held).

mod at_once;
mod hold_or_release;
mod pass_break;
mod resting;
mod strike;

use crate::event::next::LATE;
use crate::law::{ElementState, Guard, Outcome, Regime};

use crate::error::{Error, Result, digits};
use crate::hybrid::clock::Clock;
use crate::hybrid::system::{Contacts, Gaps, Holding, Present};
use crate::hybrid::{Arrival, GapSizes, GapState, HybridFlow, HybridSystem};
use crate::impact::CompleteChatter;
use crate::observer::Observer;
use crate::quantity::larger;
use crate::simulate::options::{SimulateOptions, Stats, Status};
use crate::simulate::record::Record;
use crate::tolerance::{
    CHATTER_SAFETY, GAP_ROUNDING, GIVEN_ROUNDING, LOST_FLIGHT, MOST_LEFT, MOST_SUNK, TIME_ROUNDING,
};
use at_once::{AtOnce, is_one_instant};
use nalgebra::DVector;
use std::cell::Cell;
use std::ops::ControlFlow;

/// Events at one instant, without an impact, after which a run gives up: it ends with `Status::UnresolvedContact`. [work]
const MOST_EVENTS_AT_ONCE: usize = 64;

/// How a run ended.
pub(crate) struct Ending {
    pub time: f64,
    pub status: Status,
    pub message: String,
}

/// Why a contact could not be resolved.
struct Unresolved {
    reason: String,
}

type Resolved = Result<std::result::Result<(), Unresolved>>;

/// The state of the loop between two events, with its buffers; it serves one run after another.
#[derive(Default)]
pub(crate) struct EventLoop {
    /// The order of the root of each gap at the start of the flight; of a stop held that of its contact force, as far as known.
    pub root_orders: Vec<usize>,
    /// The largest size of the terms of each gap, whose rounding is that of the gap.
    sizes: Vec<f64>,
    /// The largest size of the motion at each stop, to which the tolerances are relative.
    reaches: Vec<f64>,
    /// Where the present flight began.
    departure: Option<Clock>,
    /// The time from which something else acts, where the present flight is to end; whether the last one ended at one.
    break_ahead: Option<f64>,
    is_at_break: bool,
    /// The stops in contact.
    touching: Vec<usize>,
    /// The stops held, and those that were before the contacts of this instant.
    held: Vec<usize>,
    were_held: Vec<usize>,
    /// The regime of the elements that are not rigid.
    regime: Regime,
    /// Stops in contact whose normal speed counts as exactly zero now.
    zero_speed: Vec<usize>,
    /// Sizes of the accelerations of the stops in contact before and between the impacts of this instant, zero elsewhere: after them the
    /// terms are smaller, and their rounding is not.
    prior_sizes: Vec<f64>,
    /// The impulses of the impacts of this instant, with their stops.
    impulses: Vec<(usize, f64)>,
    /// Instants at which only impacts without restitution came to an end.
    n_inelastic: usize,
    /// The stop struck last, and how fast.
    last_impact: Option<(usize, f64)>,
    /// How fast each stop was approached at its last impact, zero before.
    approaches: Vec<f64>,
    /// The stops let go at one instant.
    releases: AtOnce,
    /// The stops that opened late and were closed again at the same instant, without an impact.
    reclosings: AtOnce,
    /// The time that a user sees at the last event, the impacts by then, and the events since either changed.
    events_at: (f64, usize, usize),
    pub stats: Stats,
    /// Impacts of the run before this part of it.
    pub n_before: usize,
}

impl EventLoop {
    /// Flight after flight to the end of the run.
    pub fn go_on<M: HybridFlow + ?Sized>(
        &mut self,
        flow: &mut M,
        t_end: f64,
        options: &SimulateOptions,
        record: &mut Record,
        observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<Ending> {
        let system = flow.system();
        let goal = system.clock().at(t_end);
        let now = Cell::new(system.clock().time());
        let mut ask = || observer(now.get());
        let mut observer = Observer::new(&mut ask);
        observer.ask()?;
        let work = system.work_of_flight();
        loop {
            observer.work(work)?;
            let (span, last) = match self.depart(flow.system(), goal, options) {
                ControlFlow::Break(ending) => return Ok(ending),
                ControlFlow::Continue(ahead) => ahead,
            };
            let arrival =
                flow.advance_to_event(&self.root_orders, span, last, record, &mut observer)?;
            let system = flow.system();
            now.set(system.clock().time());
            if let Some(ending) = self.arrive(system, arrival, t_end, record)? {
                return Ok(ending);
            }
            if record.monitor.is_done {
                return Ok(self.ended(now.get(), Status::Finished));
            }
        }
    }

    /// Makes ready for a run from where a system is, at a time; a run that cannot begin has ended.
    pub fn start<M: HybridFlow + ?Sized>(
        &mut self,
        flow: &mut M,
        (q0, v0, t0): (&DVector<f64>, &DVector<f64>, f64),
        record: &mut Record,
    ) -> Result<Option<Ending>> {
        let n_stops = flow.system().n_stops();
        self.stats = Stats::default();
        self.root_orders.clear();
        self.root_orders.resize(n_stops, 0);
        self.sizes.clear();
        self.sizes.resize(n_stops, 0.0);
        self.reaches.clear();
        self.reaches.resize(n_stops, 0.0);
        self.held.clear();
        self.were_held.clear();
        self.regime = Regime::default();
        self.zero_speed.clear();
        self.prior_sizes.clear();
        self.prior_sizes.resize(n_stops, 0.0);
        self.impulses.clear();
        self.n_inelastic = 0;
        self.last_impact = None;
        self.approaches.clear();
        self.approaches.resize(n_stops, 0.0);
        self.departure = None;
        (self.break_ahead, self.is_at_break) = (None, false);
        self.releases.clear();
        self.reclosings.clear();
        self.events_at = (t0, 0, 0);
        let begun = self.begin(flow, (q0, v0), record)?;
        Ok(begun.err().map(|unresolved| unresolved.at(t0)))
    }

    /// The span of the next flight, towards a goal, and the time at its end: that of the goal, or before it one from which on something
    /// else acts; or the end of the run, if there is to be no flight.
    pub fn depart<Y: HybridSystem + ?Sized>(
        &mut self,
        system: &Y,
        goal: Clock,
        options: &SimulateOptions,
    ) -> ControlFlow<Ending, (f64, f64)> {
        let now = system.clock().time();
        if options
            .max_impacts
            .is_some_and(|most| self.n_before + self.stats.n_impacts >= most)
        {
            return ControlFlow::Break(self.ended(now, Status::MaxImpacts));
        }
        if !std::mem::take(&mut self.is_at_break) {
            self.stats.n_flights += 1;
        }
        let clock = system.clock();
        self.departure = Some(clock);
        let left = clock.until(goal).max(0.0);
        if self.is_looping(now, left) {
            let reason = "contacts open and close without end at one instant".to_owned();
            return ControlFlow::Break(Unresolved { reason }.at(now));
        }
        self.is_at_break = false;
        self.break_ahead = None;
        let breaks = system.breaks();
        let next = breaks.get(breaks.partition_point(|at| *at <= now));
        ControlFlow::Continue(match next {
            Some(&at) if at < goal.time() => {
                self.break_ahead = Some(at);
                (clock.until(clock.at(at)).max(0.0), at)
            }
            _ => (left, goal.time()),
        })
    }

    /// Resolves the event at the end of a flight; returns the end of the run, if it is that.
    pub fn arrive<Y: HybridSystem + ?Sized>(
        &mut self,
        system: &mut Y,
        arrival: Arrival,
        t_end: f64,
        record: &mut Record,
    ) -> Result<Option<Ending>> {
        let resolved = match arrival {
            Arrival::End => match self.break_ahead {
                Some(at) => self.pass_break(system, at, record)?,
                None => return Ok(Some(self.ended(t_end, Status::Finished))),
            },
            Arrival::Underflow => {
                let time = system.clock().time();
                let message = format!("at t = {time}: the steps became too short for the time");
                let status = Status::StepUnderflow;
                return Ok(Some(Ending {
                    time,
                    status,
                    message,
                }));
            }
            Arrival::Uncertain { stop, doubt } => {
                let time = system.clock().time();
                let message = format!(
                    "at t = {time}: a contact with stop {stop} could neither be found nor excluded: {doubt}"
                );
                let status = Status::Uncertain;
                return Ok(Some(Ending {
                    time,
                    status,
                    message,
                }));
            }
            Arrival::Stalled { stop } => Err(Unresolved {
                reason: format!(
                    "the gap to stop {stop} stays within rounding of zero: sustained contact"
                ),
            }),
            Arrival::Event { guard } => self.pass(system, guard, t_end, record)?,
        };
        // A chatter that has been completed has taken time.
        let time = || system.clock().time();
        Ok(resolved.err().map(|unresolved| unresolved.at(time())))
    }

    /// Passes from the regime that ends where a guard fell through zero to the next one.
    fn pass<Y: HybridSystem + ?Sized>(
        &mut self,
        system: &mut Y,
        guard: Guard,
        t_end: f64,
        record: &mut Record,
    ) -> Resolved {
        let stop = guard.element;
        let state = if self.held.contains(&stop) {
            ElementState::Held
        } else {
            self.regime.state(stop)
        };
        let law = system.element_law(stop).by_state();
        match law.outcome(state, guard.kind) {
            Outcome::Impact => self.collide(system, stop, t_end, record),
            Outcome::Release => match self.struck_beside(system) {
                Some(struck) => self.collide(system, struck, t_end, record),
                None => self.release(system, stop),
            },
            Outcome::Enters(state) => {
                self.regime = self.regime.with(stop, state);
                self.enter(system)?;
                self.root_orders.fill(0);
                self.root_orders[stop] = 1;
                Ok(Ok(()))
            }
        }
    }

    /// The regime of all elements.
    fn regime_now(&self) -> Regime {
        self.regime.holding_instead(&self.held)
    }

    /// Enters the regime of all elements.
    fn enter<Y: HybridSystem + ?Sized>(&self, system: &mut Y) -> Result<()> {
        system.enter(&self.regime_now())
    }

    fn ended(&self, time: f64, status: Status) -> Ending {
        let count = self.n_before + self.stats.n_impacts;
        let mut message = if status == Status::MaxImpacts {
            format!("stopped after {count} impacts at t = {time}")
        } else {
            format!("reached t = {time} with {count} impacts")
        };
        if self.n_inelastic > 0 {
            message.push_str(&format!(
                "; at {} instants the stops hit together came to no end, and were taken without restitution",
                self.n_inelastic
            ));
        }
        Ending {
            time,
            status,
            message,
        }
    }

    /// The start: contacts there are judged by the sign of their velocity.
    fn begin<M: HybridFlow + ?Sized>(
        &mut self,
        flow: &mut M,
        (q0, v0): (&DVector<f64>, &DVector<f64>),
        record: &mut Record,
    ) -> Resolved {
        let system = flow.system();
        system.evaluate_gaps()?;
        self.touching.clear();
        for stop in 0..system.n_stops() {
            if !system.element_law(stop).is_rigid() {
                continue;
            }
            let GapState { gap, size, .. } = system.gap(stop);
            let margin = system.margin(stop, size);
            let given = system.given_gap(stop, q0, v0)?;
            // What is zero as it was given is zero, whatever the system's own numbers make of it.
            if gap < -margin && given.gap.0 < -margin {
                let value = format!("inside stop {stop}, its gap {}", digits(gap));
                let rule = format!(
                    "at the start no gap may lie below minus the margin, {}",
                    digits(-margin)
                );
                return Err(Error::bad_value("q0", value, rule));
            }
            // A gap that is open, however little, is flown through: a run cut just before a contact goes on as one. One that is zero as it
            // was given is none, however far the modes are off.
            let is_zero = |(value, size): (f64, f64)| value.abs() <= GIVEN_ROUNDING * size;
            if is_zero(given.gap) || gap <= margin && self.is_closed(system, stop) {
                self.touching.push(stop);
                if is_zero(given.speed) {
                    self.zero_speed.push(stop);
                }
            }
        }
        // A start inside a stop, as far as tolerances allow, is one on it.
        let inside = |&stop: &usize| system.gap(stop).gap < -system.rounding(stop);
        let inside: Vec<usize> = self.touching.iter().copied().filter(inside).collect();
        if !inside.is_empty() {
            system.put_on(&inside)?;
        }
        if self.touching.iter().any(|&stop| self.closes(system, stop)) {
            // A flight of no length has the state before the impact.
            flow.record_instant(None, record)?;
            return self.resolve_contacts(flow.system(), record);
        }
        self.settle(system)
    }

    /// Whether a stop in contact is approached, by more than rounding; one that is held is not, whatever rounding makes of
    /// its speed.
    fn closes<Y: HybridSystem + ?Sized>(&self, system: &Y, stop: usize) -> bool {
        self.closes_at(system, stop, system.gap(stop))
    }

    /// [`closes`](Self::closes) for a stop whose gap has been evaluated.
    fn closes_at<Y: HybridSystem + ?Sized>(
        &self,
        system: &Y,
        stop: usize,
        state: GapState,
    ) -> bool {
        state.speed < 0.0
            && state.speed < -least_speed(system, stop, state)
            && !self.held.contains(&stop)
            && !self.zero_speed.contains(&stop)
    }

    /// Whether so many events without an impact fell on one instant, to some roundings of its time, or to one of the time left, that
    /// there will be no end of them.
    fn is_looping(&mut self, now: f64, left: f64) -> bool {
        let (time, impacts, count) = &mut self.events_at;
        let is_near = is_one_instant(now, *time) || (now - *time).abs() <= f64::EPSILON * left;
        if is_near && *impacts == self.stats.n_impacts {
            *count += 1;
        } else {
            (*time, *impacts, *count) = (now, self.stats.n_impacts, 0);
        }
        *count > MOST_EVENTS_AT_ONCE
    }

    /// The time since the present flight began.
    fn flight_time<Y: HybridSystem + ?Sized>(&self, system: &Y) -> f64 {
        let then = self.departure;
        then.map_or(0.0, |then| then.until(system.clock()))
    }

    /// Whether a gap is closed, as far as the rounding of its terms and of the time of the flight tells.
    fn is_closed<Y: HybridSystem + ?Sized>(&self, system: &Y, stop: usize) -> bool {
        let flight = self.flight_time(system);
        is_closed_at(system.gap(stop), system.rounding(stop), flight)
    }

    /// A stop that is reached at the instant of a release, as far as that is known: what is let go may be so after its impact alone.
    fn struck_beside<Y: HybridSystem + ?Sized>(&self, system: &Y) -> Option<usize> {
        let is_struck = |&stop: &usize| {
            self.is_closed(system, stop)
                && self.closes(system, stop)
                && !self.faces_held(system, stop)
        };
        (0..system.n_stops()).find(is_struck)
    }

    /// An impact of a stop that was reached, with whatever other stops are reached at the same instant.
    fn collide<Y: HybridSystem + ?Sized>(
        &mut self,
        system: &mut Y,
        reached: usize,
        t_end: f64,
        record: &mut Record,
    ) -> Resolved {
        self.touching.clear();
        self.zero_speed.clear();
        self.impulses.clear();
        let arrived = system.gap(reached);
        // How many roundings may be left of the gap that was reached, and of others at that instant.
        let most_left = (arrived.gap / system.rounding(reached)).clamp(1.0, MOST_LEFT);
        let flight = self.flight_time(system);
        for stop in 0..system.n_stops() {
            let GapSizes { terms, reach } = system.flight_sizes(stop);
            self.sizes[stop] = larger(self.sizes[stop], terms);
            self.reaches[stop] = larger(self.reaches[stop], reach);
            if !system.element_law(stop).is_rigid() {
                continue;
            }
            let is_held = self.held.contains(&stop);
            // What those held keep closed has no speed, whatever rounding makes of it.
            let faces = self.faces_held(system, stop);
            if faces {
                self.zero_speed.push(stop);
            }
            let is_left = || {
                let (gap, rounding) = (system.gap(stop), system.rounding(stop));
                is_closed_at(gap, rounding, flight) || gap.gap / rounding <= most_left
            };
            if faces || is_held || system.is_at_place_of(stop, reached) || is_left() {
                self.touching.push(stop);
            }
        }
        // Flight after low flight the stop would be reached a rounding lower.
        let is_low = arrived.speed.powi(2) < MOST_SUNK * (arrived.acceleration * arrived.gap).abs();
        if is_low && arrived.gap < -system.rounding(reached) {
            system.raise(reached)?;
            system.evaluate_gaps()?;
        }
        if self.accumulates(system, reached)? {
            return self.accumulate(system, reached, t_end, record);
        }
        if self.are_spent(system)? {
            return self.come_to_rest(system, t_end, record);
        }
        self.note_return(system, reached);
        self.resolve_contacts(system, record)
    }

    /// Takes note of a stop that opened late and is back at once, no faster than rounding: its opening was rounding.
    fn note_return<Y: HybridSystem + ?Sized>(&mut self, system: &Y, reached: usize) {
        if self.root_orders[reached] == LATE && !self.closes(system, reached) {
            let now = system.clock().time();
            if self.departed_at(now) {
                self.reclosings.note(now, reached);
            }
        }
    }

    /// Whether the present flight began at the instant of a time.
    fn departed_at(&self, now: f64) -> bool {
        self.departure
            .is_some_and(|then| is_one_instant(then.time(), now))
    }

    /// Completes impacts that accumulate, those before the end of the run.
    #[cold]
    fn accumulate<Y: HybridSystem + ?Sized>(
        &mut self,
        system: &mut Y,
        stop: usize,
        t_end: f64,
        record: &mut Record,
    ) -> Resolved {
        system.evaluate_gaps()?;
        let now = system.clock();
        let left = now.until(now.at(t_end)).max(0.0);
        let span = chatter_at(system, stop).span().min(left);
        system.complete_chatter(&[stop], span, record)?;
        self.last_impact = None;
        self.zero_speed.clear();
        self.zero_speed.push(stop);
        self.settle(system)
    }

    /// Whether the impacts on the stop that was reached, alone, accumulate, and so soon that what is left of them is below
    /// the tolerance, or the flights between them lost in rounding (theory 9).
    fn accumulates<Y: HybridSystem + ?Sized>(
        &self,
        system: &mut Y,
        reached: usize,
    ) -> Result<bool> {
        let chatter = chatter_at(system, reached);
        let (law, speed, pull) = (chatter.law, chatter.speed, chatter.acceleration);
        let is_alone = self.touching.len() == 1;
        let regular = self
            .last_impact
            .is_some_and(|(stop, before)| stop == reached && law.is_repeated(before, -speed));
        if !(regular && is_alone && speed < 0.0 && pull < 0.0 && law.is_contracting()) {
            return Ok(false);
        }
        let residual = chatter.residual();
        let tolerance = system.tolerance(reached, self.reaches[reached]);
        // Impacts whose next flight rises by little more than rounding are not gone through one by one either.
        let is_low = chatter.height_by_acceleration()
            < LOST_FLIGHT * GAP_ROUNDING * self.sizes[reached] * -pull;
        let span = chatter.span();
        let is_due = CHATTER_SAFETY * residual < tolerance || is_low;
        if !is_due || pull + span * system.free_jerk(reached)?.abs() >= 0.0 {
            return Ok(false);
        }
        let others = (0..system.n_stops()).filter(|&stop| stop != reached);
        stay_open(system, (reached, chatter), others)
    }
}

/// The impacts on a stop that is about to be struck, if they accumulate.
fn chatter_at<Y: HybridSystem + ?Sized>(system: &Y, stop: usize) -> CompleteChatter {
    let state = system.gap(stop);
    CompleteChatter {
        law: system.law(stop),
        speed: state.speed,
        acceleration: state.acceleration,
    }
}

/// Whether other stops stay open while impacts on one accumulate, whatever their impulses, and what is left of the gap, do to them.
fn stay_open<Y: HybridSystem + ?Sized>(
    system: &Y,
    (reached, chatter): (usize, CompleteChatter),
    mut others: impl Iterator<Item = usize>,
) -> Result<bool> {
    let span = chatter.span();
    let stays = |stop: usize| -> Result<bool> {
        let other = system.gap(stop);
        let coupling = system.delassus(&[reached, stop])?;
        let share = coupling[(1, 0)].abs() / coupling[(0, 0)];
        let drift = other.speed.min(0.0) + chatter.kick(share);
        let bend =
            0.5 * span * (other.acceleration.min(0.0) - span * other.jerk.unwrap_or(0.0).abs());
        Ok(other.gap + span * (drift + bend) - CHATTER_SAFETY * share * chatter.residual() > 0.0)
    };
    others.try_fold(true, |all, stop| Ok(all && stays(stop)?))
}

/// Whether a gap of some rounding is closed at the end of a flight of some time.
fn is_closed_at(state: GapState, rounding: f64, flight: f64) -> bool {
    state.gap <= rounding + TIME_ROUNDING * flight * state.speed.abs()
}

/// Normal speeds up to this are none: the rounding of their terms, and that of the speed with which a gap as large as the motion
/// would close by its acceleration.
fn least_speed<Y: HybridSystem + ?Sized>(system: &Y, stop: usize, state: GapState) -> f64 {
    let fall = (2.0 * state.acceleration.abs() * state.size).sqrt();
    GAP_ROUNDING * larger(system.speed_size(stop), fall)
}

impl Unresolved {
    fn at(self, time: f64) -> Ending {
        Ending {
            time,
            status: Status::UnresolvedContact,
            message: format!("at t = {time}: {}", self.reason),
        }
    }
}
