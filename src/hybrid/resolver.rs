//! The resolver: from the regime that ends where a guard fell through zero to the next one. It strikes what is reached, completes impacts
//! that accumulate, holds the stops that stay in contact, releases those whose force would pull (theory 8, 9). When impacts are completed
//! is decided in `chatter.rs`; of orbits in `hybrid/chatter_map.rs`.

mod at_once;
mod chatter;
mod compliant;
mod hold_or_release;
mod memory;
mod pass_break;
mod resting;
mod roundings;
mod strike;

use crate::error::{Error, Result, digits};
use crate::event::next::LATE;
use crate::hybrid::clock::Clock;
use crate::hybrid::flow::HybridFlow;
use crate::hybrid::recorder::Recorder;
use crate::hybrid::root_orders::RootOrders;
use crate::hybrid::system::{Contacts, GapSizes, GapState, Gaps, Holding, HybridSystem};
use crate::impact::Impact;
use crate::law::{ElementState, Guard, Outcome, Regime};
use crate::quantity::larger;
use crate::tolerance::{GAP_ROUNDING, GIVEN_ROUNDING, MOST_LEFT, MOST_SUNK, TIME_ROUNDING};
use at_once::AtOnce;
pub(crate) use at_once::is_one_instant;
use nalgebra::DVector;

/// Why a contact could not be resolved.
pub(crate) struct Unresolved {
    pub reason: String,
}

pub(crate) type Resolved = Result<std::result::Result<(), Unresolved>>;

/// What is known of contacts between two events, with its buffers; it serves one run after another.
#[derive(Clone, Default)]
pub(crate) struct Resolver {
    /// The orders of the roots of the guards at the start of the flight.
    pub root_orders: RootOrders,
    /// The largest size of the terms of each gap, whose rounding is that of the gap.
    sizes: Vec<f64>,
    /// The largest size of the motion at each stop, to which the tolerances are relative.
    reaches: Vec<f64>,
    /// Where the present flight began.
    departure: Option<Clock>,
    /// The stops in contact.
    touching: Vec<usize>,
    /// The stops held, and those that were before the contacts of this instant.
    held: Vec<usize>,
    were_held: Vec<usize>,
    /// The elements that are not rigid, and their regime.
    compliant: Vec<usize>,
    regime: Regime,
    /// Their guards that are zero at this instant whatever rounding makes of them, each with the number of derivatives that are, itself one
    /// of them, and the impacts by then.
    zeros: Vec<(Guard, usize, usize)>,
    /// Stops in contact whose normal speed counts as exactly zero now.
    zero_speed: Vec<usize>,
    /// Sizes of the accelerations of the stops in contact before and between the impacts of this instant, zero elsewhere: after them the
    /// terms are smaller, and their rounding is not.
    prior_sizes: Vec<f64>,
    /// The impulses of the impacts of this instant, with their stops.
    impulses: Vec<(usize, f64)>,
    /// Instants at which only impacts without restitution came to an end.
    pub n_inelastic: usize,
    pub n_impacts: usize,
    /// Contacts with elements that give way which began.
    pub n_contacts: usize,
    /// The stop struck last, and how fast.
    last_impact: Option<(usize, f64)>,
    /// How fast each stop was approached at its last impact, zero before.
    approaches: Vec<f64>,
    /// The stops let go at one instant.
    releases: AtOnce,
    /// The stops that opened late and were closed again at the same instant, without an impact.
    reclosings: AtOnce,
    /// The last impacts, of a run that keeps them, in debug builds.
    impacts: Vec<Impact>,
    /// The states of elements that are known where a run begins.
    pub given: ElementStates,
    /// Elements whose places the start left open: they are taken to relax from where the body is.
    pub assumed: Vec<usize>,
    /// What was known before impacts that accumulate were completed only as far as the run goes.
    pub before_cut: Option<Box<Self>>,
}

/// The states of the elements of a scene that give way, and the places of those that relax.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct ElementStates {
    pub regime: Regime,
    pub places: Vec<(usize, f64)>,
}

impl Resolver {
    /// Makes ready for a run from where a system is.
    pub fn start<M: HybridFlow + ?Sized, R: Recorder>(
        &mut self,
        flow: &mut M,
        start: (&DVector<f64>, &DVector<f64>),
        recorder: &mut R,
    ) -> Resolved {
        self.forget(flow.system());
        self.begin(flow, start, recorder)
    }

    /// Knows nothing yet of a system.
    fn forget<Y: HybridSystem + ?Sized>(&mut self, system: &Y) {
        let n_stops = system.n_stops();
        for numbers in [
            &mut self.sizes,
            &mut self.reaches,
            &mut self.prior_sizes,
            &mut self.approaches,
        ] {
            numbers.clear();
            numbers.resize(n_stops, 0.0);
        }
        self.root_orders = RootOrders::none(n_stops);
        self.compliant.clear();
        self.compliant
            .extend((0..n_stops).filter(|&i| !system.element_law(i).is_rigid()));
        self.held.clear();
        self.were_held.clear();
        self.regime = Regime::default();
        self.zeros.clear();
        self.zero_speed.clear();
        self.impulses.clear();
        (self.n_inelastic, self.n_impacts, self.n_contacts) = (0, 0, 0);
        self.last_impact = None;
        self.departure = None;
        self.releases.clear();
        self.reclosings.clear();
        self.impacts.clear();
        self.assumed.clear();
        self.before_cut = None;
    }

    /// A flight begins.
    pub fn depart(&mut self, clock: Clock) {
        self.departure = Some(clock);
    }

    /// Passes from the regime that ends where a guard fell through zero to the next one.
    pub fn pass<Y: HybridSystem + ?Sized, R: Recorder>(
        &mut self,
        system: &mut Y,
        guard: Guard,
        t_end: f64,
        recorder: &mut R,
    ) -> Resolved {
        let stop = guard.element;
        let state = self.state_of(stop);
        let law = system.element_law(stop).by_state();
        self.zeros.clear();
        let resolved = match law.outcome(state, guard.kind) {
            Outcome::Impact => self.collide(system, stop, t_end, recorder),
            Outcome::Release => match self.struck_beside(system) {
                Some(struck) => self.collide(system, struck, t_end, recorder),
                None => self.release(system, stop),
            },
            Outcome::Enters(state) => {
                self.touching.clear();
                self.zero_speed.clear();
                self.note_zero(guard, state, true);
                let state = if self.comes_to_its_seat(system, guard)? {
                    system.record_chatter(stop, recorder)?;
                    ElementState::Held
                } else {
                    state
                };
                self.enter_state(system, (stop, state), recorder)
            }
        };
        self.settle_compliant(system, resolved?, recorder)
    }

    /// The state of an element.
    fn state_of(&self, element: usize) -> ElementState {
        if self.held.contains(&element) {
            ElementState::Held
        } else {
            self.regime.state(element)
        }
    }

    /// The regime of all elements.
    pub fn regime_now(&self) -> Regime {
        self.regime.holding_instead(&self.held)
    }

    /// Enters the regime of all elements.
    fn enter<Y: HybridSystem + ?Sized>(&self, system: &mut Y) -> Result<()> {
        system.enter(&self.regime_now())
    }

    /// The start: contacts there are judged by the sign of their velocity.
    fn begin<M: HybridFlow + ?Sized, R: Recorder>(
        &mut self,
        flow: &mut M,
        (q0, v0): (&DVector<f64>, &DVector<f64>),
        recorder: &mut R,
    ) -> Resolved {
        let system = flow.system();
        system.evaluate_gaps()?;
        self.begin_compliant(system)?;
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
            flow.record_instant(None, recorder)?;
            let system = flow.system();
            let resolved = self.resolve_contacts(system, recorder)?;
            return self.settle_compliant(system, resolved, recorder);
        }
        let resolved = self.settle(system)?;
        self.settle_compliant(system, resolved, recorder)
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

    /// Whether a gap is zero, as far as rounding tells.
    fn is_at_zero<Y: HybridSystem + ?Sized>(&self, system: &Y, stop: usize) -> bool {
        let own = system.gap(stop);
        let gap = own.gap.abs();
        is_closed_at(
            GapState { gap, ..own },
            system.rounding(stop),
            self.flight_time(system),
        )
    }

    /// A stop that is reached at the instant of a release, as far as that is known: what is let go may be so after its impact alone.
    fn struck_beside<Y: HybridSystem + ?Sized>(&self, system: &Y) -> Option<usize> {
        let is_struck = |&stop: &usize| {
            system.element_law(stop).is_rigid()
                && self.is_closed(system, stop)
                && self.closes(system, stop)
                && !self.faces_held(system, stop)
        };
        (0..system.n_stops()).find(is_struck)
    }

    /// An impact of a stop that was reached, with whatever other stops are reached at the same instant.
    fn collide<Y: HybridSystem + ?Sized, R: Recorder>(
        &mut self,
        system: &mut Y,
        reached: usize,
        t_end: f64,
        recorder: &mut R,
    ) -> Resolved {
        self.touching.clear();
        self.zero_speed.clear();
        self.impulses.clear();
        let arrived = system.gap(reached);
        // The search leaves the gap of the stop reached at some roundings from zero. Stops whose gaps are no more of their own roundings
        // from zero are reached at the same instant.
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
        // Of flights so low each begins at the depth at which the one before ended, and ends a rounding deeper: the motion is moved back onto
        // the stop.
        let is_low = arrived.speed.powi(2) < MOST_SUNK * (arrived.acceleration * arrived.gap).abs();
        if is_low && arrived.gap < -system.rounding(reached) {
            system.raise(reached)?;
            system.evaluate_gaps()?;
        }
        if self.accumulates(system, reached)? {
            return self.accumulate(system, reached, t_end, recorder);
        }
        if self.are_spent(system)? {
            return self.come_to_rest(system, t_end, recorder);
        }
        self.note_return(system, reached);
        self.resolve_contacts(system, recorder)
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
