//! What is recorded of exact flights: segments of one arc each, touches to rounding.

use super::flight_sampler::FlightSampler;
use super::system::ClosedForm;
use crate::event::next::{ContactSearch, Grazed};
use crate::flow::{LinearFlow, ModalScene, RegimeMotion};
use crate::hybrid::clock::Clock;
use crate::hybrid::recorder::{ArcMotion, ArcSpan, Recorder, Written};
use crate::hybrid::segment::{Graze, SegmentKind};
use crate::law::Regime;
use crate::modal::{ModalState, Pair};
use crate::model::{Moment, PhysicalState};
use nalgebra::DVector;
use std::ops::ControlFlow;

/// A free flight.
struct FreeArc<'s, 'a, F: LinearFlow> {
    search: &'s mut ContactSearch<'a, F>,
    flow: &'a F,
    scene: &'a ModalScene,
    state: &'s [Pair],
    sampler: &'s mut FlightSampler<F>,
}

impl<F: LinearFlow> FreeArc<'_, '_, F> {
    /// Goes to a time after the start.
    fn go(&mut self, local: f64) {
        let there = &mut self.sampler.state;
        there.clear();
        there.extend_from_slice(self.state);
        self.search.forward(there, local);
    }

    /// Position and velocity where it is.
    fn look(&mut self) -> &PhysicalState {
        let FlightSampler {
            state,
            modal_state,
            physical,
            ..
        } = &mut *self.sampler;
        self.flow.modal_from_state(state, modal_state);
        let (q, v) = &mut *physical;
        let (q, v) = (q.as_mut_slice(), v.as_mut_slice());
        self.scene.form.fill_physical(modal_state, q, v);
        physical
    }
}

impl<F: LinearFlow> Written for FreeArc<'_, '_, F> {
    fn write(&self, numbers: &mut Vec<f64>) {
        let mut modal_state = ModalState::with_capacity(self.state.len());
        self.flow.modal_from_state(self.state, &mut modal_state);
        numbers.extend_from_slice(modal_state.as_flattened());
    }
}

impl<F: LinearFlow> ArcMotion for FreeArc<'_, '_, F> {
    fn state(&mut self, local: f64) -> PhysicalState {
        self.go(local);
        self.look().clone()
    }

    fn write_later(&mut self, local: f64, numbers: &mut Vec<f64>) {
        self.go(local);
        self.look();
        numbers.extend_from_slice(self.sampler.modal_state.as_flattened());
    }

    fn strobe(
        &mut self,
        [first, every]: [f64; 2],
        look: &mut dyn FnMut(&PhysicalState) -> ControlFlow<()>,
    ) {
        self.go(first);
        while look(self.look()).is_continue() {
            let FlightSampler {
                state,
                propagator_cache,
                ..
            } = &mut *self.sampler;
            propagator_cache.forward(self.flow, state, every);
        }
    }
}

/// A motion along stops, from a position and velocity.
pub(super) struct RegimeArc<'s> {
    pub motion: &'s RegimeMotion,
    pub scene: &'s ModalScene,
    pub at: Moment,
    /// Position, shape `(n_dof,)`, \[m\], and velocity, shape `(n_dof,)`, \[m/s\], at the start.
    pub start: (&'s DVector<f64>, &'s DVector<f64>),
    /// The same in modal pairs.
    pub modal_state: ModalState,
}

impl Written for RegimeArc<'_> {
    fn write(&self, numbers: &mut Vec<f64>) {
        numbers.extend_from_slice(self.modal_state.as_flattened());
    }
}

impl ArcMotion for RegimeArc<'_> {
    fn state(&mut self, local: f64) -> PhysicalState {
        self.motion
            .propagate(self.at, local, self.start.0, self.start.1)
    }

    fn write_later(&mut self, local: f64, numbers: &mut Vec<f64>) {
        let (q, v) = self.state(local);
        let modal_state = self.scene.form.to_modal(q.as_slice(), v.as_slice());
        numbers.extend_from_slice(modal_state.as_flattened());
    }
}

impl<F: LinearFlow> ClosedForm<'_, F> {
    /// Records what is wanted of a flight from the present state; `last` is the time at which the run ends with it.
    #[inline]
    pub(super) fn record(&mut self, span: f64, last: Option<f64>, recorder: &mut dyn Recorder) {
        if !recorder.wanted().is_nothing() {
            self.record_flight(span, last, recorder);
        }
    }

    fn record_flight(&mut self, span: f64, last: Option<f64>, recorder: &mut dyn Recorder) {
        let wanted = recorder.wanted();
        if wanted.events {
            for grazed in &self.grazed {
                let gap = self.search.gap(grazed.stop);
                let grazed = grazed.sharpened(self.flow, gap, &self.state, span);
                recorder.graze(reported(grazed, self.clock));
            }
        }
        if wanted.arcs {
            recorder.begin_segment(SegmentKind::Flight, Regime::free());
            let arc = ArcSpan {
                start: self.clock,
                span,
                last,
            };
            let mut motion = FreeArc {
                search: &mut self.search,
                flow: self.flow,
                scene: self.scene,
                state: &self.state,
                sampler: &mut self.sampler,
            };
            recorder.arc(&arc, &mut motion);
        }
    }

    /// Records what is left of impacts that accumulate, over a span: the motion along their stops, from a position and velocity.
    pub(super) fn record_rest(
        &self,
        motion: &RegimeMotion,
        (q, v): &PhysicalState,
        span: f64,
        recorder: &mut dyn Recorder,
    ) {
        if recorder.wanted().motion_in(&motion.regime) {
            let mut arc = RegimeArc {
                motion,
                scene: self.scene,
                at: self.moment(),
                start: (q, v),
                modal_state: self.scene.form.to_modal(q.as_slice(), v.as_slice()),
            };
            self.record_along(SegmentKind::Chatter, (span, None), &mut arc, recorder);
        }
    }

    /// Records a motion along stops from the present state; `last` as in [`record`](Self::record).
    pub(super) fn record_along(
        &self,
        kind: SegmentKind,
        (span, last): (f64, Option<f64>),
        arc: &mut RegimeArc<'_>,
        recorder: &mut dyn Recorder,
    ) {
        recorder.begin_segment(kind, &arc.motion.regime);
        let start = self.clock;
        recorder.arc(&ArcSpan { start, span, last }, arc);
    }
}

/// A touch on a flight that began at a time, as it is reported.
pub(super) fn reported(grazed: Grazed, start: Clock) -> Graze {
    Graze {
        time: start.after(grazed.time).time(),
        stop: grazed.stop,
        depth: -grazed.gap,
    }
}
