//! A batch of runs of one pendulum side by side: each goes its own way, in steps of its own, but their Taylor series are made together.

use crate::error::{Failure, Result};
use crate::flow::steps::State;
use crate::flow::{BatchMotion, SeriesOf};
use crate::hybrid::clock::Clock;
use crate::hybrid::recorder::Recorder;
use crate::hybrid::{AnyLoop, Arrival, HybridFlow, IntegratedFlow, Present, SeriesStep, Taylor};
use crate::model::{Dynamics, PhysicalState};
use crate::observer::Observer;
use crate::simulate::by_method::SeriesRun;
use crate::simulate::event_loop::Ending;
use crate::simulate::record::Record;
use crate::simulate::run::{Done, Run};
use std::ops::ControlFlow;

/// One of the runs.
struct LaneRun<'a, S: State, D: Dynamics> {
    run: SeriesRun<'a, S, D>,
    record: Record,
    /// The number of the run; none where there is none left to do.
    item: Option<usize>,
    flight: Option<LaneFlight>,
}

/// A free flight under way.
struct LaneFlight {
    /// Where it is to end.
    goal: Clock,
    is_new: bool,
    /// The step that it takes, once the series has been looked along; none then where it would be too short for the time.
    step: Option<SeriesStep>,
}

/// K runs side by side, with their buffers.
pub(crate) struct Batch<'a, S: State, D: Dynamics, const K: usize> {
    lanes: [LaneRun<'a, S, D>; K],
    series: SeriesOf<K>,
    t_span: (f64, f64),
}

impl<'a, S: State, D: Dynamics, const K: usize> Batch<'a, S, D, K> {
    /// Runs over a span, made one by one.
    pub fn new(make: impl Fn() -> SeriesRun<'a, S, D>, t_span: (f64, f64)) -> Self {
        let mut lanes: [LaneRun<'a, S, D>; K] = std::array::from_fn(|_| LaneRun::new(make()));
        let series = lanes[0].run.flow.free.search.pendulum().room();
        Self {
            lanes,
            series,
            t_span,
        }
    }

    /// Runs each item from its start, and puts down what it leaves behind; nothing of one that starts inside a stop.
    ///
    /// # Errors
    /// As a run by itself, with the number of the item.
    pub fn run(
        &mut self,
        mut items: impl Iterator<Item = usize>,
        start: impl Fn(usize) -> PhysicalState,
        put: &mut dyn FnMut(usize, Option<Done>) -> Result<()>,
    ) -> std::result::Result<(), Failure> {
        let (t0, t_end) = self.t_span;
        for lane in &mut self.lanes {
            (lane.item, lane.flight) = (None, None);
        }
        let work = self.lanes[0].run.flow.free.search.work();
        let mut observer = Observer::default();
        loop {
            for (m, lane) in self.lanes.iter_mut().enumerate() {
                while lane.item.is_none()
                    && let Some(item) = items.next()
                {
                    lane.item = Some(item);
                    match lane.begin(&start(item), t0) {
                        Err(error) if error.is_about("q0") => {
                            lane.item = None;
                            put(item, None).map_err(|error| (item, error))?;
                        }
                        ended => lane.put_down(ended, put)?,
                    }
                }
                if let Some(item) = lane.item {
                    observer.work(work).map_err(|error| (item, error))?;
                    let ended = lane.depart(&mut self.series, m, t_end, &mut observer);
                    lane.put_down(ended, put)?;
                }
            }
            if self.lanes.iter().all(|lane| lane.item.is_none()) {
                return Ok(());
            }
            self.step();
            for lane in &mut self.lanes {
                let ended = lane.arrive(t_end);
                lane.put_down(ended, put)?;
            }
        }
    }

    /// A step of all runs in free flight.
    fn step(&mut self) {
        let Self { lanes, series, .. } = self;
        lanes[0].run.flow.free.search.pendulum().expand(series);
        let mut spans = [0.0; K];
        for (m, (span, lane)) in spans.iter_mut().zip(lanes.iter_mut()).enumerate() {
            *span = lane.search_along(series.motion(m));
        }
        series.states(&spans, |link, m, state| {
            if spans[m] > 0.0 {
                lanes[m].run.flow.system.put_link(link, state);
            }
        });
    }
}

impl<'a, S: State, D: Dynamics> LaneRun<'a, S, D> {
    fn new(run: Run<'a, IntegratedFlow<'a, S, D, Taylor>>) -> Self {
        Self {
            record: run.new_record(),
            run,
            item: None,
            flight: None,
        }
    }

    /// Makes ready for a run; its end, if it cannot begin.
    fn begin(&mut self, (q0, v0): &PhysicalState, t0: f64) -> Result<Option<Ending>> {
        let Run { flow, events, .. } = &mut self.run;
        flow.start(q0, v0, t0);
        events.start(flow.taken(), (q0, v0, t0), &mut self.record)
    }

    /// Begins the m-th series for the next step of a free flight; goes through one with stops held. The end of the run, if it
    /// is that.
    fn depart<const K: usize>(
        &mut self,
        series: &mut SeriesOf<K>,
        m: usize,
        t_end: f64,
        observer: &mut Observer,
    ) -> Result<Option<Ending>> {
        let Run {
            flow,
            events,
            options,
            ..
        } = &mut self.run;
        if self.flight.is_none() {
            let end = flow.system.clock().at(t_end);
            match events.depart(flow.system(), end, options) {
                ControlFlow::Break(ending) => return Ok(Some(ending)),
                ControlFlow::Continue((span, _)) if flow.system.is_free() => {
                    if self.record.wanted().arcs {
                        // Behind a contact.
                        flow.record_instant(None, &mut self.record)?;
                    }
                    self.flight = Some(LaneFlight {
                        goal: flow.system.clock().after(span),
                        is_new: true,
                        step: None,
                    });
                }
                ControlFlow::Continue((span, last)) => {
                    let record = &mut self.record;
                    let arrival =
                        flow.advance_to_event(events.root_orders(), span, last, record, observer)?;
                    return events.arrive(flow.system(), arrival, t_end, record);
                }
            }
        }
        let IntegratedFlow { free, system } = flow;
        free.search.begin_series(system, series, m)?;
        Ok(None)
    }

    /// The length of the next step along its series, zero if it is not in free flight.
    fn search_along<const K: usize>(&mut self, motion: BatchMotion<'_, K>) -> f64 {
        let Some(flight) = &mut self.flight else {
            return 0.0;
        };
        let Run { flow, events, .. } = &mut self.run;
        let IntegratedFlow { free, system } = flow;
        let orders = flight.is_new.then_some(events.root_orders().gaps());
        let (goal, record) = (flight.goal, &mut self.record);
        flight.step = free
            .search
            .search_along(system, motion, orders, goal, record);
        flight.is_new = false;
        flight.step.as_ref().map_or(0.0, |step| step.span)
    }

    /// Ends a step; the end of the run, if it is that.
    fn arrive(&mut self, t_end: f64) -> Result<Option<Ending>> {
        let Some(flight) = &mut self.flight else {
            return Ok(None);
        };
        let Run { flow, events, .. } = &mut self.run;
        let arrival = match flight.step.take() {
            Some(step) => flow.system.end_step(step)?,
            None => Some(Arrival::Underflow),
        };
        let Some(arrival) = arrival else {
            return Ok(None);
        };
        self.flight = None;
        events.arrive(flow.system(), arrival, t_end, &mut self.record)
    }

    /// Puts down what the run leaves behind, if it has ended.
    fn put_down(
        &mut self,
        ended: Result<Option<Ending>>,
        put: &mut dyn FnMut(usize, Option<Done>) -> Result<()>,
    ) -> std::result::Result<(), Failure> {
        let item = self.item.unwrap_or_default();
        let Some(ending) = ended.map_err(|error| (item, error))? else {
            return Ok(());
        };
        let record = self.run.new_record();
        let record = std::mem::replace(&mut self.record, record);
        let done = self
            .run
            .finish(ending, record)
            .map_err(|error| (item, error))?;
        self.item = None;
        put(item, Some(done)).map_err(|error| (item, error))
    }
}
