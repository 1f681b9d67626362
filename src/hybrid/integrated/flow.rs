//! A scene that is integrated from event to event: free flights by steps or series, those with stops held by steps.

use super::free::FreeFlight;
use super::scene::Integrated;
use crate::error::Result;
use crate::flow::RegimeMotion;
use crate::flow::characteristic_length::Tolerances;
use crate::flow::steps::State;
use crate::hybrid::flow::{AnyLoop, Arrival, Counts, HybridFlow};
use crate::hybrid::recorder::Recorder;
use crate::hybrid::root_orders::RootOrders;
use crate::hybrid::segment::SegmentKind;
use crate::hybrid::system::HybridSystem;
use crate::law::Regime;
use crate::model::{Dynamics, Scene};
use crate::observer::Observer;
use nalgebra::DVector;
use std::sync::Arc;

/// A scene that is integrated from event to event.
pub(crate) struct IntegratedFlow<'a, S: State, D: Dynamics, F: FreeFlight<S, D>> {
    /// What moves it where no stop is held.
    pub free: F,
    pub system: Integrated<'a, S, D, F::Steps>,
}

impl<'a, S: State, D: Dynamics, F: FreeFlight<S, D>> IntegratedFlow<'a, S, D, F> {
    /// A scene along its equations of motion.
    pub fn new(dynamics: &'a D, scene: &'a Scene, tolerances: Tolerances, free: F) -> Self {
        let system = Integrated::new(dynamics, scene, tolerances, free.choice());
        Self { free, system }
    }
}

impl<'a, S: State, D: Dynamics, F: FreeFlight<S, D>> HybridFlow for IntegratedFlow<'a, S, D, F> {
    type System = dyn HybridSystem + 'a;

    fn system(&mut self) -> &mut (dyn HybridSystem + 'a) {
        &mut self.system
    }

    fn start(&mut self, q: &DVector<f64>, v: &DVector<f64>, t: f64) {
        self.free.reset();
        self.system.start(q, v, t);
    }

    fn advance_to_event(
        &mut self,
        orders: &RootOrders,
        span: f64,
        last: f64,
        recorder: &mut dyn Recorder,
        observer: &mut Observer,
    ) -> Result<Arrival> {
        let Self { free, system } = self;
        if system.is_free() {
            return free.advance(system, orders.gaps(), (span, last), recorder, observer);
        }
        system.advance_in_regime(orders, (span, last), recorder, observer)
    }

    fn record_instant(&mut self, last: Option<f64>, recorder: &mut dyn Recorder) -> Result<()> {
        recorder.begin_segment(SegmentKind::Flight, Regime::free());
        self.free.record_instant(&mut self.system, last, recorder)
    }

    fn counts(&self) -> Counts {
        self.system.counts()
    }

    fn remarks(&self) -> String {
        self.system.remarks()
    }

    fn regime_motions(&self) -> Vec<Arc<RegimeMotion>> {
        Vec::new()
    }

    fn places(&self) -> Vec<(usize, f64)> {
        let own = self.system.places_back.iter();
        own.map(|own| (own.element, own.place)).collect()
    }
}

impl<'a, S: State, D: Dynamics, F: FreeFlight<S, D>> AnyLoop for IntegratedFlow<'a, S, D, F> {
    type Taken<'s>
        = dyn HybridFlow<System = dyn HybridSystem + 'a> + 's
    where
        Self: 's;

    fn taken(&mut self) -> &mut Self::Taken<'_> {
        self
    }
}
