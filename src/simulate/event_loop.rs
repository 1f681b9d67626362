//! The loop of a simulation: fly to the next contact, strike, go on (theory 8). Chatter, sticking and coupled
//! simultaneous impacts end the run with a diagnosis.

use crate::contact::walk::ROUNDING;
use crate::error::{Error, Result, digits};
use crate::impact::Impact;
use crate::simulate::mover::{Arrival, Mover};
use crate::simulate::record::Record;
use crate::simulate::{Keep, SimulateOptions, Stats, Status};
use std::ops::ControlFlow;

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

/// What the loop carries from contact to contact; one run after another, with its buffers.
#[derive(Default)]
pub(crate) struct EventLoop {
    /// The order of the root of each gap at the start of the flight.
    starts: Vec<usize>,
    /// The largest size of the motion seen at each stop.
    sizes: Vec<f64>,
    /// The stops in contact.
    touching: Vec<usize>,
    pub stats: Stats,
}

impl EventLoop {
    /// Runs a mover from where it is to the end of the span.
    pub fn run<M: Mover>(
        &mut self,
        mover: &mut M,
        (t0, t_end): (f64, f64),
        options: &SimulateOptions,
        record: &mut Record,
        observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<Ending> {
        self.stats = Stats::default();
        self.starts.clear();
        self.starts.resize(mover.n_stops(), 0);
        self.sizes.clear();
        self.sizes.resize(mover.n_stops(), 0.0);
        let end = mover.clock().at(t_end);
        if let Err(unresolved) = self.begin(mover, record)? {
            return Ok(unresolved.at(t0));
        }
        let most = options.max_impacts.unwrap_or(usize::MAX);
        loop {
            if self.stats.n_impacts >= most {
                return Ok(self.ended(mover.clock().time(), Status::MaxImpacts));
            }
            let now = mover.clock().time();
            if observer(now).is_break() {
                return Err(Error::Interrupted);
            }
            let span = mover.clock().until(end).max(0.0);
            self.stats.n_flights += 1;
            let mut check = || observer(now).is_continue();
            match mover.fly(&self.starts, span, t_end, record, &mut check)? {
                Arrival::End => return Ok(self.ended(t_end, Status::Finished)),
                Arrival::Stalled { stop } => {
                    let reason = format!(
                        "the gap to stop {stop} stays within rounding of zero: sustained contact"
                    );
                    return Ok(Unresolved { reason }.at(mover.clock().time()));
                }
                Arrival::Underflow => {
                    let time = mover.clock().time();
                    return Ok(Ending {
                        time,
                        status: Status::StepUnderflow,
                        message: format!("at t = {time}: the steps became too short for the time"),
                    });
                }
                Arrival::Contact { stop } => {
                    if let Err(unresolved) = self.collide(mover, stop, record)? {
                        return Ok(unresolved.at(mover.clock().time()));
                    }
                }
            }
        }
    }

    fn ended(&self, time: f64, status: Status) -> Ending {
        let count = self.stats.n_impacts;
        let message = if status == Status::MaxImpacts {
            format!("stopped after {count} impacts at t = {time}")
        } else {
            format!("reached t = {time} with {count} impacts")
        };
        Ending {
            time,
            status,
            message,
        }
    }

    /// The start: contacts there are judged by the sign of their velocity.
    fn begin<M: Mover>(&mut self, mover: &mut M, record: &mut Record) -> Resolved {
        mover.look()?;
        self.touching.clear();
        for stop in 0..mover.n_stops() {
            let (gap, margin) = (mover.gap(stop).gap, mover.margin(stop));
            if gap < -margin {
                let value = format!("inside stop {stop}, its gap {}", digits(gap));
                let rule = format!(
                    "at the start no gap may lie below minus the margin, {}",
                    digits(-margin)
                );
                return Err(Error::bad_value("q0", value, rule));
            }
            // A gap that is open, however little, is flown through: a run cut just before a contact goes on as one.
            if gap <= mover.contact_slack() * mover.gap(stop).size {
                self.touching.push(stop);
            }
        }
        if self
            .touching
            .iter()
            .any(|&stop| mover.gap(stop).speed < 0.0)
        {
            // A flight of no length has the state before the impact.
            mover.stay(record)?;
            return self.strike_all(mover, record);
        }
        Ok(self.release(mover))
    }

    /// An impact of a stop that was reached, with whatever other stops are reached at the same instant.
    fn collide<M: Mover>(
        &mut self,
        mover: &mut M,
        reached: usize,
        record: &mut Record,
    ) -> Resolved {
        self.touching.clear();
        for stop in 0..mover.n_stops() {
            let state = mover.gap(stop);
            if stop == reached || state.gap <= mover.contact_slack() * state.size {
                self.touching.push(stop);
            }
        }
        self.strike_all(mover, record)
    }

    /// The impacts of those stops in contact that are approached.
    fn strike_all<M: Mover>(&mut self, mover: &mut M, record: &mut Record) -> Resolved {
        for (k, &stop) in self.touching.iter().enumerate() {
            if mover.gap(stop).speed >= 0.0 {
                continue;
            }
            let mut others = self.touching.iter().enumerate();
            if let Some((_, other)) = others.find(|&(j, &o)| j != k && mover.is_coupled(stop, o)) {
                let reason = format!(
                    "stops {stop} and {other} are in contact at one instant and coupled by inertia"
                );
                return Ok(Err(Unresolved { reason }));
            }
        }
        for &stop in &self.touching {
            if mover.gap(stop).speed >= 0.0 {
                continue;
            }
            let blow = mover.strike(stop)?;
            self.stats.n_impacts += 1;
            if record.keep != Keep::Final {
                record.impacts.push(Impact {
                    time: mover.clock().time(),
                    stop,
                    approach: blow.approach,
                    departure: blow.departure,
                    impulse: blow.impulse,
                    phase: mover.phase(),
                });
            }
        }
        mover.look()?;
        Ok(self.release(mover))
    }

    /// The order of each touching gap's root at the start of the flight, or why it does not open.
    fn release<M: Mover>(&mut self, mover: &M) -> std::result::Result<(), Unresolved> {
        self.starts.fill(0);
        for (stop, size) in self.sizes.iter_mut().enumerate() {
            let state = mover.gap(stop);
            *size = size.max(state.size).max(0.5 * state.apex());
        }
        for &stop in &self.touching {
            let state = mover.gap(stop);
            // An inelastic impact leaves a normal velocity of rounding size, which is none.
            let is_still = state.speed.abs() <= ROUNDING * mover.speed_size(stop);
            self.starts[stop] = match (is_still, state.acceleration, state.jerk) {
                (false, acceleration, _) if state.speed > 0.0 => {
                    if acceleration < 0.0 && 0.5 * state.apex() < 10.0 * ROUNDING * self.sizes[stop]
                    {
                        let reason = format!("the impacts on stop {stop} accumulate: chatter");
                        return Err(Unresolved { reason });
                    }
                    1
                }
                (true, acceleration, _) if acceleration > 0.0 => 2,
                (true, 0.0, jerk) if jerk > 0.0 => 3,
                _ => {
                    return Err(Unresolved {
                        reason: format!("the motion stays on stop {stop}: sticking"),
                    });
                }
            };
        }
        Ok(())
    }
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
