//! The flow of a hybrid system, from event to event.

use crate::error::Result;
use crate::event::certified::SearchFailure;
use crate::flow::RegimeMotion;
use crate::hybrid::memory::FlowMemory;
use crate::hybrid::recorder::Recorder;
use crate::hybrid::root_orders::RootOrders;
use crate::hybrid::system::HybridSystem;
use crate::law::{Guard, Regime};
use crate::observer::Observer;
use nalgebra::DVector;
use std::sync::Arc;

/// How a flight ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Arrival {
    /// At the end of the span.
    End,
    /// Where a guard fell through zero.
    Event { guard: Guard },
    /// Where no step was short enough to tell contact from none.
    Stalled { stop: usize },
    /// Where the steps of an integrator became too short for the time.
    Underflow,
    /// Where a contact could neither be found nor excluded.
    Uncertain { stop: usize, doubt: SearchFailure },
}

/// Counts of evaluations and steps, and the tolerance of the run.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Counts {
    /// Evaluations of the right-hand side.
    pub rhs: usize,
    /// Steps of an integrator.
    pub steps: usize,
    /// Evaluations of a gap with its derivatives.
    pub gap_evaluations: usize,
    /// The smallest absolute tolerance of the run.
    pub atol: f64,
}

/// The motion of a hybrid system from event to event.
pub(crate) trait HybridFlow {
    /// The system that it moves: of a type of its own where an impact takes little more time than the calls of the event loop (exact
    /// flights); behind a `dyn` where integration steps outweigh them, so that one compiled loop serves all of these.
    type System: HybridSystem + ?Sized;

    /// The system where it is now.
    fn system(&mut self) -> &mut Self::System;
    /// Puts the motion at a state and a time, as new.
    fn start(&mut self, q: &DVector<f64>, v: &DVector<f64>, t: f64);
    /// Goes to the next event or over the whole span, `last` the time at which the run ends there. The gaps must have
    /// been evaluated; `orders` are those of the roots of the guards at the start. At an event the gaps have been evaluated there.
    fn advance_to_event(
        &mut self,
        orders: &RootOrders,
        span: f64,
        last: f64,
        recorder: &mut dyn Recorder,
        observer: &mut Observer,
    ) -> Result<Arrival>;
    /// Records a flight of no length: the state before an impact at the start of the run, or that after the last event of a run
    /// that ends with it, at `last`.
    fn record_instant(&mut self, last: Option<f64>, recorder: &mut dyn Recorder) -> Result<()>;
    /// The counts since the start.
    fn counts(&self) -> Counts;
    /// Remarks on the run since the start, to be appended to the message.
    fn remarks(&self) -> String;
    /// The motions in other regimes than the free one, which arcs refer to.
    fn regime_motions(&self) -> Vec<Arc<RegimeMotion>>;
    /// Where its last flight began, from where the same flight can be gone again to the bit; `None` of one that keeps no such thing.
    fn departed(&self) -> Option<FlowMemory> {
        None
    }
    /// Where it is, likewise.
    fn present(&self) -> Option<FlowMemory> {
        None
    }
    /// Goes where a flight of the same scene began, in a regime; whether the memory is one of such a flow.
    fn go_back(&mut self, _memory: &FlowMemory, _regime: &Regime) -> Result<bool> {
        Ok(false)
    }
    /// The places of the elements that relax.
    fn places(&self) -> Vec<(usize, f64)> {
        Vec::new()
    }
}

/// A flow in the form for which the event loop is compiled: static dispatch for exact flights, dynamic for integrated ones.
pub(crate) trait AnyLoop: HybridFlow {
    /// The type for which the loop is compiled.
    type Taken<'s>: HybridFlow + ?Sized
    where
        Self: 's;

    /// The flow as that type.
    fn taken(&mut self) -> &mut Self::Taken<'_>;
}
