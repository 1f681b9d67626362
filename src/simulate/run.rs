//! A run: a hybrid flow through its events over a span, and what it leaves behind. All that makes and reads runs is compiled once, for
//! flows of any kind behind a `dyn`.

use crate::error::{Error, Result, shortened};
use crate::flow::RegimeMotion;
use crate::hybrid::{AnyLoop, Counts, ElementStates, HybridFlow, HybridSystem, Present};
use crate::model::{PhysicalState, Scene};
use crate::simulate::event_loop::{Ending, EventLoop};
use crate::simulate::monitor::RunMonitor;
use crate::simulate::motion_state::Left;
use crate::simulate::options::{SimulateOptions, Stats, Status};
use crate::simulate::record::Record;
use nalgebra::DVector;
use std::sync::Arc;

/// The outcome of a run.
pub(crate) struct Done {
    pub ending: Ending,
    pub last: PhysicalState,
    pub stats: Stats,
    pub record: Record,
    /// The motions while stops were held.
    pub regimes: Vec<Arc<RegimeMotion>>,
}

/// A state with its time.
type TimedState<'s> = (&'s DVector<f64>, &'s DVector<f64>, f64);

/// A flow with the event loop along it.
pub(crate) trait EventFlow {
    /// As [`Run::begin`].
    fn begin(
        &mut self,
        events: &mut EventLoop,
        start: TimedState<'_>,
        record: &mut Record,
    ) -> Result<Option<Ending>>;
    /// As [`EventLoop::go_on`].
    fn go_on(
        &mut self,
        events: &mut EventLoop,
        to: f64,
        options: &SimulateOptions,
        record: &mut Record,
    ) -> Result<Ending>;
    /// As [`EventLoop::go_past`].
    fn go_past(
        &mut self,
        events: &mut EventLoop,
        at: f64,
        record: &mut Record,
    ) -> Result<Option<Ending>>;
    /// As [`HybridFlow::record_instant`].
    fn record_last(&mut self, last: f64, record: &mut Record) -> Result<()>;
    /// The state where it is now.
    fn state(&mut self) -> PhysicalState;
    /// The state moved onto the stops that it is behind, at a time.
    fn onto_stops(&mut self, start: TimedState<'_>) -> Result<PhysicalState>;
    /// As [`EventLoop::elements`].
    fn elements(&mut self, events: &EventLoop) -> ElementStates;
    /// As [`EventLoop::flight`].
    fn flight(&mut self, events: &mut EventLoop, status: Status) -> Option<Vec<f64>>;
    /// Puts a flow at its start and then where a flight began, as [`EventLoop::go_back`].
    fn go_back(
        &mut self,
        events: &mut EventLoop,
        start: TimedState<'_>,
        flight: &[f64],
    ) -> Result<bool>;
    /// Counts, remarks, and the motions in other regimes than the free one, since the start.
    fn told(&self) -> (Counts, String, Vec<Arc<RegimeMotion>>);
}

impl<M: AnyLoop> EventFlow for M {
    fn begin(
        &mut self,
        events: &mut EventLoop,
        start: TimedState<'_>,
        record: &mut Record,
    ) -> Result<Option<Ending>> {
        let flow = self.taken();
        flow.start(start.0, start.1, start.2);
        events.start(flow, start, record)
    }

    fn go_on(
        &mut self,
        events: &mut EventLoop,
        to: f64,
        options: &SimulateOptions,
        record: &mut Record,
    ) -> Result<Ending> {
        events.go_on(self.taken(), to, options, record)
    }

    fn go_past(
        &mut self,
        events: &mut EventLoop,
        at: f64,
        record: &mut Record,
    ) -> Result<Option<Ending>> {
        events.go_past(self.taken().system(), at, record)
    }

    fn record_last(&mut self, last: f64, record: &mut Record) -> Result<()> {
        self.record_instant(Some(last), record)
    }

    fn state(&mut self) -> PhysicalState {
        self.system().physical()
    }

    fn onto_stops(&mut self, (q, v, t): TimedState<'_>) -> Result<PhysicalState> {
        let flow = self.taken();
        flow.start(q, v, t);
        put_onto_stops(flow.system())
    }

    fn elements(&mut self, events: &EventLoop) -> ElementStates {
        events.elements(self.taken())
    }

    fn flight(&mut self, events: &mut EventLoop, status: Status) -> Option<Vec<f64>> {
        events.flight(self.taken(), status)
    }

    fn go_back(
        &mut self,
        events: &mut EventLoop,
        start: TimedState<'_>,
        flight: &[f64],
    ) -> Result<bool> {
        let flow = self.taken();
        flow.start(start.0, start.1, start.2);
        events.go_back(flow, flight)
    }

    fn told(&self) -> (Counts, String, Vec<Arc<RegimeMotion>>) {
        (self.counts(), self.remarks(), self.regime_motions())
    }
}

/// One run after another of the same scene, with their buffers.
pub(crate) struct Run<'a, M: ?Sized> {
    pub events: EventLoop,
    pub options: &'a SimulateOptions,
    pub n_dof: usize,
    /// Whether what comes before a contact counts: there are stops that give way.
    pub has_sides: bool,
    pub flow: M,
}

/// Runs along a flow of any kind.
pub(crate) type AnyRun<'a> = Run<'a, dyn EventFlow + 'a>;

impl<'a, M> Run<'a, M> {
    /// Runs along a flow.
    pub fn new(flow: M, options: &'a SimulateOptions, scene: &Scene) -> Self {
        Self {
            events: EventLoop::default(),
            options,
            n_dof: scene.n_dof(),
            has_sides: !scene.stops().iter().all(|stop| stop.contact().is_rigid()),
            flow,
        }
    }
}

impl<M: ?Sized> Run<'_, M> {
    /// An empty record.
    pub fn new_record(&self) -> Record {
        Record::new(self.options, (self.n_dof, self.has_sides))
    }
}

impl<M: EventFlow + ?Sized> Run<'_, M> {
    /// Puts a run at its start; a run that cannot begin has ended.
    pub fn begin(&mut self, start: TimedState<'_>, record: &mut Record) -> Result<Option<Ending>> {
        self.flow.begin(&mut self.events, start, record)
    }

    /// A run over a span.
    pub fn run(
        &mut self,
        q0: &DVector<f64>,
        v0: &DVector<f64>,
        t_span: (f64, f64),
    ) -> Result<Done> {
        let mut record = self.new_record();
        let ending = if let Some(ending) = self.begin((q0, v0, t_span.0), &mut record)? {
            ending
        } else {
            self.flow
                .go_on(&mut self.events, t_span.1, self.options, &mut record)?
        };
        self.finish(ending, record)
    }

    /// A run that goes on, to a time, from a state at which the flight under way is known as plain numbers.
    ///
    /// # Errors
    /// Numbers that are not those of a flight of the scene.
    pub fn go_on_from(&mut self, state: TimedState<'_>, flight: &[f64], end: f64) -> Result<Done> {
        let mut record = self.new_record();
        record.since = state.2;
        let Self {
            flow,
            events,
            options,
            ..
        } = self;
        if !flow.go_back(events, state, flight)? {
            let rule = "they must be those of a motion of the scene";
            return Err(Error::bad_value("state", "with other numbers", rule));
        }
        let ending = flow.go_on(events, end, options, &mut record)?;
        self.finish(ending, record)
    }

    /// What the run that has ended leaves behind for the next one.
    pub fn left(&mut self, status: Status) -> Left {
        let Self {
            flow,
            events,
            options,
            ..
        } = self;
        let flight = flow.flight(events, status);
        Left {
            elements: flow.elements(events),
            flight: flight.map(|numbers| (options.solver.tolerances(), numbers)),
        }
    }

    /// A run that a monitor inspects and may end. It is made in parts of a given length of time, so that no contact is sought long after the
    /// end.
    pub fn monitored(
        &mut self,
        (q0, v0): (&DVector<f64>, &DVector<f64>),
        (start, end): (f64, f64),
        (monitor, every): (Box<dyn RunMonitor>, f64),
    ) -> Result<Done> {
        let mut record = self.new_record();
        record.monitor.monitor = Some(monitor);
        let mut ending = self.begin((q0, v0, start), &mut record)?;
        let Self {
            flow,
            events,
            options,
            ..
        } = self;
        let mut parts = 1;
        let ending = loop {
            if let Some(ending) = ending {
                break ending;
            }
            let to = end.min(start + every * f64::from(parts));
            let ended = flow.go_on(events, to, options, &mut record)?;
            let goes_on = ended.status == Status::Finished && !record.monitor.is_done && to < end;
            ending = if goes_on {
                flow.go_past(events, to, &mut record)?
            } else {
                Some(ended)
            };
            parts += 1;
        };
        self.finish(ending, record)
    }

    /// The outcome of a run that has ended.
    pub fn finish(&mut self, mut ending: Ending, mut record: Record) -> Result<Done> {
        let Self { flow, events, .. } = self;
        if ending.status != Status::Finished {
            // The last event has a side after it, and the last instant its sample.
            flow.record_last(ending.time, &mut record)?;
        }
        let (counts, remarks, regimes) = flow.told();
        ending.message = shortened(ending.message + &remarks);
        Ok(Done {
            ending,
            last: flow.state(),
            stats: events.stats().with(counts),
            record,
            regimes,
        })
    }
}

/// Moves a system along the reactions of the stops that it lies behind onto them.
///
/// # Errors
/// What the gap functions of nonlinear stops report; stops that cannot be reached together.
fn put_onto_stops<Y: HybridSystem + ?Sized>(system: &mut Y) -> Result<PhysicalState> {
    // One stop may lead behind another.
    for _ in 0..=system.n_stops() {
        system.evaluate_gaps()?;
        let is_behind = |&stop: &usize| {
            system.element_law(stop).is_rigid() && system.gap(stop).gap < -system.rounding(stop)
        };
        let behind: Vec<usize> = (0..system.n_stops()).filter(is_behind).collect();
        if behind.is_empty() {
            break;
        }
        system.put_on(&behind)?;
    }
    Ok(system.physical())
}
