//! A run: a hybrid flow through its events over a span, and what it leaves behind.

use crate::error::{Result, shortened};
use crate::flow::RegimeMotion;
use crate::hybrid::{AnyLoop, HybridFlow, Present};
use crate::model::PhysicalState;
use crate::simulate::event_loop::{Ending, EventLoop};
use crate::simulate::monitor::RunMonitor;
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

/// One run after another of the same scene, with their buffers.
pub(crate) struct Run<'a, M> {
    pub flow: M,
    pub events: EventLoop,
    pub options: &'a SimulateOptions,
    pub n_dof: usize,
}

impl<'a, M: AnyLoop> Run<'a, M> {
    /// Runs along a flow.
    pub fn new(flow: M, options: &'a SimulateOptions, n_dof: usize) -> Self {
        Self {
            flow,
            events: EventLoop::default(),
            options,
            n_dof,
        }
    }

    /// Puts a run at its start; a run that cannot begin has ended.
    pub fn begin(
        &mut self,
        start: (&DVector<f64>, &DVector<f64>, f64),
        record: &mut Record,
    ) -> Result<Option<Ending>> {
        let flow = self.flow.taken();
        flow.start(start.0, start.1, start.2);
        self.events.start(flow, start, record)
    }

    /// A run over a span.
    pub fn run(
        &mut self,
        q0: &DVector<f64>,
        v0: &DVector<f64>,
        t_span: (f64, f64),
    ) -> Result<Done> {
        let mut record = Record::new(self.options, self.n_dof);
        let ending = if let Some(ending) = self.begin((q0, v0, t_span.0), &mut record)? {
            ending
        } else {
            let flow = self.flow.taken();
            self.events
                .go_on(flow, t_span.1, self.options, &mut record)?
        };
        self.finish(ending, record)
    }

    /// A run that a monitor inspects and may end. It is made in parts of a given length of time, so that no contact is sought long after the
    /// end.
    pub fn monitored(
        &mut self,
        (q0, v0): (&DVector<f64>, &DVector<f64>),
        (start, end): (f64, f64),
        (monitor, every): (Box<dyn RunMonitor>, f64),
    ) -> Result<Done> {
        let mut record = Record::new(self.options, self.n_dof);
        record.monitor.monitor = Some(monitor);
        let mut ending = self.begin((q0, v0, start), &mut record)?;
        let Self {
            flow,
            events,
            options,
            ..
        } = self;
        let flow = flow.taken();
        let mut parts = 1;
        let ending = loop {
            if let Some(ending) = ending {
                break ending;
            }
            let to = end.min(start + every * f64::from(parts));
            let ended = events.go_on(flow, to, options, &mut record)?;
            let goes_on = ended.status == Status::Finished && !record.monitor.is_done && to < end;
            ending = if goes_on {
                events.go_past(flow.system(), to, &mut record)?
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
            flow.record_instant(Some(ending.time), &mut record)?;
        }
        ending.message = shortened(ending.message + &flow.remarks());
        Ok(Done {
            ending,
            last: flow.system().physical(),
            stats: events.stats().with(flow.counts()),
            record,
            regimes: flow.regime_motions(),
        })
    }
}
