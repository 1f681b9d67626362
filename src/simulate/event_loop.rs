//! The loop of a simulation: advance to the next event, resolve it (`hybrid/resolver.rs`), go on (theory 8, 9).

use crate::error::Result;
use crate::hybrid::clock::Clock;
use crate::hybrid::system::Present;
use crate::hybrid::{
    Arrival, ElementStates, FlowMemory, HybridFlow, HybridSystem, Pen, Resolver, RootOrders,
    Unresolved, is_one_instant,
};
use crate::observer::Observer;
use crate::simulate::options::{SimulateOptions, Stats, Status};
use crate::simulate::record::Record;
use nalgebra::DVector;
use std::ops::ControlFlow;

/// Events at one instant, without an impact, after which a run gives up: it ends with `Status::UnresolvedContact`. [work]
const MOST_EVENTS_AT_ONCE: usize = 64;

/// How a run ended.
pub(crate) struct Ending {
    pub time: f64,
    pub status: Status,
    pub message: String,
}

/// The state of the loop between two events, with its buffers; it serves one run after another.
#[derive(Default)]
pub(crate) struct EventLoop {
    resolver: Resolver,
    /// The time from which something else acts, where the present flight is to end; whether the last one ended at one.
    break_ahead: Option<f64>,
    is_at_break: bool,
    /// The time that a user sees at the last event, the impacts by then, and the events since either changed.
    events_at: (f64, usize, usize),
    n_flights: usize,
    /// Impacts of the run before this part of it.
    pub n_before: usize,
    /// Where the last flight began, of a run that ended before impacts that accumulate had been completed.
    cut: Option<(Box<Resolver>, FlowMemory)>,
}

impl EventLoop {
    /// Flight after flight to the end of the run.
    pub fn go_on<M: HybridFlow + ?Sized>(
        &mut self,
        flow: &mut M,
        t_end: f64,
        options: &SimulateOptions,
        record: &mut Record,
    ) -> Result<Ending> {
        self.cut = None;
        let system = flow.system();
        let goal = system.clock().at(t_end);
        let mut observer = Observer::at(system.clock().time());
        observer.ask()?;
        let work = system.work_of_flight();
        loop {
            observer.work(work)?;
            let (span, last) = match self.depart(flow.system(), goal, options) {
                ControlFlow::Break(ending) => return Ok(ending),
                ControlFlow::Continue(ahead) => ahead,
            };
            let arrival = flow.advance_to_event(
                &self.resolver.root_orders,
                span,
                last,
                record,
                &mut observer,
            )?;
            let system = flow.system();
            let now = system.clock().time();
            observer.at = Some(now);
            if let Some(ending) = self.arrive(system, arrival, t_end, record)? {
                return Ok(ending);
            }
            if let Some(before) = self.resolver.before_cut.take() {
                self.cut = flow.departed().map(|memory| (before, memory));
            }
            if record.monitor.is_done {
                return Ok(self.ended(now, Status::Finished));
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
        self.restart(t0);
        let begun = self.resolver.start(flow, (q0, v0), record)?;
        Ok(begun.err().map(|unresolved| unresolved_at(unresolved, t0)))
    }

    /// Counts from a time on.
    fn restart(&mut self, t: f64) {
        self.n_flights = 0;
        (self.break_ahead, self.is_at_break) = (None, false);
        self.events_at = (t, 0, 0);
    }

    /// The states of elements that are known where a run begins.
    pub fn give(&mut self, elements: &ElementStates) {
        self.resolver.given.clone_from(elements);
    }

    /// The states of elements where a run has ended.
    pub fn elements<M: HybridFlow + ?Sized>(&self, flow: &M) -> ElementStates {
        ElementStates {
            regime: self.resolver.regime_now(),
            places: flow.places(),
        }
    }

    /// Where the flight began in which a run ended, as plain numbers.
    pub fn flight<M: HybridFlow + ?Sized>(&mut self, flow: &M, status: Status) -> Option<Vec<f64>> {
        let mut pen = Pen::Writes(Vec::new());
        let mut memory = match (status, self.cut.take()) {
            (Status::Finished, Some((mut resolver, memory))) => {
                resolver.carry(&mut pen);
                memory
            }
            (status, _) => {
                let memory = match status {
                    Status::Finished => flow.departed(),
                    Status::MaxImpacts => flow.present(),
                    _ => None,
                };
                self.resolver.carry(&mut pen);
                memory?
            }
        };
        memory.carry(&mut pen);
        Some(pen.written())
    }

    /// Goes where that flight began; whether the numbers are those of one.
    pub fn go_back<M: HybridFlow + ?Sized>(
        &mut self,
        flow: &mut M,
        flight: &[f64],
    ) -> Result<bool> {
        let (mut pen, mut memory) = (Pen::reading(flight.to_vec()), FlowMemory::default());
        let is_its = self.resolver.take_up(flow.system(), &mut pen);
        memory.carry(&mut pen);
        if !(is_its && pen.is_at_end() && flow.go_back(&memory, &self.resolver.regime_now())?) {
            return Ok(false);
        }
        self.restart(flow.system().clock().time());
        Ok(true)
    }

    /// The counts of the run so far.
    pub fn stats(&self) -> Stats {
        Stats {
            n_impacts: self.resolver.n_impacts,
            n_contacts: self.resolver.n_contacts,
            n_flights: self.n_flights,
            ..Stats::default()
        }
    }

    /// The impacts, and the contacts with stops that give way.
    pub fn n_met(&self) -> usize {
        self.resolver.n_impacts + self.resolver.n_contacts
    }

    /// The orders of the roots of the guards where the present flight begins.
    pub fn root_orders(&self) -> &RootOrders {
        &self.resolver.root_orders
    }

    /// Goes on behind the end of a part of a run, as at a break; the end of the run, if it cannot.
    pub fn go_past<Y: HybridSystem + ?Sized>(
        &mut self,
        system: &mut Y,
        at: f64,
        record: &mut Record,
    ) -> Result<Option<Ending>> {
        self.is_at_break = true;
        let resolved = self.resolver.pass_break(system, at, record)?;
        Ok(resolved
            .err()
            .map(|unresolved| unresolved_at(unresolved, at)))
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
            .is_some_and(|most| self.n_before + self.n_met() >= most)
        {
            return ControlFlow::Break(self.ended(now, Status::MaxImpacts));
        }
        if !std::mem::take(&mut self.is_at_break) {
            self.n_flights += 1;
        }
        let clock = system.clock();
        self.resolver.depart(clock);
        let left = clock.until(goal).max(0.0);
        if self.is_looping(now, left) {
            let reason = "contacts open and close without end at one instant".to_owned();
            return ControlFlow::Break(unresolved_at(Unresolved { reason }, now));
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
                Some(at) => {
                    self.is_at_break = true;
                    self.resolver.pass_break(system, at, record)?
                }
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
            Arrival::Event { guard } => self.resolver.pass(system, guard, t_end, record)?,
        };
        // A chatter that has been completed has taken time.
        let time = || system.clock().time();
        Ok(resolved
            .err()
            .map(|unresolved| unresolved_at(unresolved, time())))
    }

    fn ended(&self, time: f64, status: Status) -> Ending {
        let impacts = self.n_before + self.resolver.n_impacts;
        let counted = match self.resolver.n_contacts {
            0 => format!("{impacts} impacts"),
            contacts => format!("{impacts} impacts and {contacts} contacts"),
        };
        let mut message = if status == Status::MaxImpacts {
            format!("stopped after {counted} at t = {time}")
        } else {
            format!("reached t = {time} with {counted}")
        };
        for element in &self.resolver.assumed {
            message.push_str(&format!(
                "; stop {element} was taken to relax from where the body began, since position and velocity do not say its place"
            ));
        }
        if self.resolver.n_inelastic > 0 {
            message.push_str(&format!(
                "; at {} instants the stops hit together came to no end, and were taken without restitution",
                self.resolver.n_inelastic
            ));
        }
        Ending {
            time,
            status,
            message,
        }
    }

    /// Whether so many events without an impact fell on one instant, to some roundings of its time, or to one of the time left, that
    /// there will be no end of them.
    fn is_looping(&mut self, now: f64, left: f64) -> bool {
        let (time, impacts, count) = &mut self.events_at;
        let is_near = is_one_instant(now, *time) || (now - *time).abs() <= f64::EPSILON * left;
        let met = self.resolver.n_impacts + self.resolver.n_contacts;
        if is_near && *impacts == met {
            *count += 1;
        } else {
            (*time, *impacts, *count) = (now, met, 0);
        }
        *count > MOST_EVENTS_AT_ONCE
    }
}

fn unresolved_at(unresolved: Unresolved, time: f64) -> Ending {
    Ending {
        time,
        status: Status::UnresolvedContact,
        message: format!("at t = {time}: {}", unresolved.reason),
    }
}
