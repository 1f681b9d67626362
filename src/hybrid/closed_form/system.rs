//! Exact flights: a linear scene moved in closed form from contact to contact (theory 8), with the traits of `hybrid/system.rs`:
//! gaps and their margins, the impact of one stop, chatter completed.

use super::compliant_elements::CompliantElements;
use super::departure::Departure;
use super::flight_sampler::FlightSampler;
use super::kept_regimes::KeptRegimes;
use crate::error::Result;
use crate::event::first_root::{FirstEvent, FirstRoot};
use crate::event::next::{ContactSearch, Grazed};
use crate::event::walk::STEPS_PER_REACH_CHECK;
use crate::flow::characteristic_length::{Tolerances, part_of};
use crate::flow::steps::Tolerance;
use crate::flow::{GuardDerivatives, LinearFlow, ModalScene, RegimeMotion, TimedScene, along};
use crate::hybrid::clock::Clock;
use crate::hybrid::flow::{AnyLoop, Arrival, Counts, HybridFlow};
use crate::hybrid::memory::FlowMemory;
use crate::hybrid::recorder::Recorder;
use crate::hybrid::root_orders::RootOrders;
use crate::hybrid::system::{
    Accelerations, Contacts, GapSizes, GapState, Gaps, GivenGap, Holding, NormalMotion, Present,
};
use crate::impact::{put_onto_stops, wrapped};
use crate::law::{Guard, Law, Newton, Regime};
use crate::modal::ModalState;
use crate::modal::Pair;
use crate::model::{Moment, PhysicalState};

use crate::model::{acceleration_size, force_terms};
use crate::observer::Observer;
use crate::quantity::{difference, larger};
use crate::tolerance::{DEPENDENT, GAP_ROUNDING, PLACED_ROUNDING};
use nalgebra::{DMatrix, DVector};
use std::cell::{Cell, OnceCell};
use std::ops::Range;
use std::sync::Arc;

/// Derivatives of a load and of a harmonic force that are independent of each other: beyond these, and two for each coordinate, the
/// derivatives of a linear motion follow from the lower ones. [exact]
const ORDERS_OF_INPUT: usize = 4;

/// A linear scene in motion; one run after another, with its buffers.
pub(crate) struct ClosedForm<'a, F: LinearFlow> {
    pub(super) flow: &'a F,
    pub(super) timed: &'a TimedScene,
    pub(super) scene: &'a ModalScene,
    /// The forcing phase at time zero, which the scene's amplitude has.
    pub(super) phase: f64,
    pub(super) search: ContactSearch<'a, F>,
    /// The rows of the normal velocities on the flow's state.
    pub(super) velocity_rows: Vec<Vec<Pair>>,
    /// The gap of each stop now, once it has been asked for.
    known: Vec<Cell<Option<GapState>>>,
    /// `(1 + e)/(n.b)` of each stop, from its approach speed to its impulse, shape `(n_stops,)`, \[kg\].
    pub(super) rebounds: Vec<f64>,
    pub(super) clock: Clock,
    pub(super) state: Vec<Pair>,
    pub(super) arrived: Vec<Pair>,
    /// What the rounding of positions leaves unknown of each gap, shape `(n_stops,)`, \[m\]; empty where the state was not taken from a
    /// position.
    pub(super) placed: Vec<f64>,
    /// The place of each stop, once two of them are asked about.
    pub(super) places: OnceCell<Vec<usize>>,
    pub(super) grazed: Vec<Grazed>,
    pub(super) sampler: FlightSampler<F>,
    tolerances: Tolerances,
    /// What the tolerances allow as an absolute error of each gap, shape `(n_stops,)`, \[m\].
    pub(super) allowed: Vec<f64>,
    /// Where the last flight began; its state is what `arrived` has after it.
    pub(super) departure: Departure,
    pub(super) regimes: KeptRegimes,
    /// The one that holds now.
    pub(super) regime_motion: Option<Arc<RegimeMotion>>,
    /// What elements that give way do to the others.
    pub(super) compliant: CompliantElements,
}

impl<'a, F: LinearFlow> ClosedForm<'a, F> {
    /// A scene by the clock along its flow; `phase` is the forcing phase at time zero.
    pub fn new(flow: &'a F, timed: &'a TimedScene, phase: f64, tolerances: Tolerances) -> Self {
        let scene = &*timed.modal;
        let g = &scene.geometry;
        let stops = 0..scene.n_stops();
        let gaps = stops
            .clone()
            .map(|i| flow.gap_row(&scene.gap(i)).known_to(scene.form.rounding()));
        let rebound = |i: usize| g.law(i).rebound(g.give(i, i));
        Self {
            flow,
            timed,
            scene,
            phase,
            search: ContactSearch::new(flow, gaps.collect()),
            tolerances,
            allowed: vec![0.0; scene.n_stops()],
            departure: Departure::default(),
            regimes: KeptRegimes::default(),
            regime_motion: None,
            compliant: CompliantElements::new(scene.n_stops()),
            velocity_rows: scene
                .velocity_rows
                .iter()
                .map(|row| flow.velocity_row(row))
                .collect(),
            known: vec![Cell::new(None); scene.n_stops()],
            rebounds: stops.map(rebound).collect(),
            clock: Clock::new(0.0, scene.frequency),
            state: Vec::new(),
            arrived: Vec::new(),
            placed: Vec::new(),
            places: OnceCell::new(),
            grazed: Vec::new(),
            sampler: FlightSampler::new(scene.form.n_dof()),
        }
    }

    pub(super) fn modal_state(&self, state: &[Pair]) -> ModalState {
        let mut modal_state = ModalState::with_capacity(state.len());
        self.flow.modal_from_state(state, &mut modal_state);
        modal_state
    }

    /// Makes a position and velocity the state at the present time.
    fn set(&mut self, q: &DVector<f64>, v: &DVector<f64>) {
        let modal_state = self.scene.form.to_modal(q.as_slice(), v.as_slice());
        let at = self.moment();
        (self.flow).state_from_modal(&modal_state, at, &mut self.state);
    }

    /// What the tolerances allow as an absolute error of a gap, of a motion from a start.
    fn absolute_tolerance(&self, stop: usize, q: &DVector<f64>, v: &DVector<f64>) -> f64 {
        let normal = self.scene.geometry.normals.column(stop);
        if let Some(given) = self.tolerances.absolute {
            return given * normal.lp_norm(1);
        }
        let size = |x: &DVector<f64>| -> f64 {
            let terms = normal.iter().zip(x.iter());
            terms.map(|(n, x)| (n * x).abs()).sum()
        };
        let (lengths, speed) = (self.timed.lengths(), size(v));
        let acceleration = || {
            let force = self.scene.excitation.force(self.moment(), q.len());
            size(&self.scene.system.acceleration(q, v, &force))
        };
        let distance = lengths.rate.distance(speed, acceleration);
        part_of(lengths.gaps[stop].max(size(q)).max(distance))
    }

    /// Puts the present state at a position and velocity, a time later.
    pub(super) fn put(&mut self, (q, v): (&DVector<f64>, &DVector<f64>), span: f64) {
        self.changed();
        self.clock = self.clock.after(span);
        self.compliant.places.relax(span);
        self.set(q, v);
        let g = &self.scene.geometry;
        let gaps = g.clearances.iter().zip(g.normals.column_iter());
        let unknown = gaps.map(|(clearance, normal)| {
            let terms = normal.iter().zip(q.iter()).map(|(n, q)| (n * q).abs());
            PLACED_ROUNDING * (clearance.abs() + terms.sum::<f64>())
        });
        self.placed.clear();
        self.placed.extend(unknown);
    }

    /// Goes to a later time of the present flight.
    pub(super) fn go(&mut self, span: f64) {
        self.changed();
        self.placed.clear();
        self.search.forward(&mut self.state, span);
        self.clock = self.clock.after(span);
        let at = self.moment();
        self.flow.set_moment(&mut self.state, at);
    }

    /// Forgets what was asked of a state that has changed.
    #[inline]
    fn changed(&mut self) {
        for gap in &mut self.known {
            gap.set(None);
        }
        self.compliant.changed();
    }

    /// `(1 + e)/(n.b)` of a stop now.
    #[inline]
    fn rebound_now(&self, stop: usize) -> f64 {
        let drifting = self.timed.drifting_law(stop, self.clock.time());
        let (kept, own) = (self.rebounds[stop], self.scene.geometry.law(stop));
        drifting.map_or(kept, |law| kept * law.factor() / own.factor())
    }

    /// The moment, where the phase of the forcing is in its amplitude.
    #[inline]
    pub(super) fn moment(&self) -> Moment {
        self.clock.moment(0.0)
    }
}

/// Whether an instant is no later than the end of the run, both rounded to the doubles that a user sees.
pub(super) fn is_within(then: Clock, last: f64) -> bool {
    then.time() <= last
}

/// Whether a touch on a flight from an instant on comes before the event that ends it: one of the stop that is reached then, at what is
/// the same time to a user, is that contact.
pub(super) fn is_before(graze: &Grazed, from: Clock, (stop, time): (Option<usize>, f64)) -> bool {
    let is_apart = || from.after(graze.time).time() < from.after(time).time();
    graze.time < time && (Some(graze.stop) != stop || is_apart())
}

impl<F: LinearFlow> Gaps for ClosedForm<'_, F> {
    fn evaluate_gaps(&mut self) -> Result<()> {
        self.changed();
        self.search.evaluate(&self.state);
        Ok(())
    }

    fn guard_derivatives(&mut self, guard: Guard) -> Result<Option<GuardDerivatives>> {
        Ok(self.present_guard(guard))
    }

    #[inline]
    fn gap(&self, stop: usize) -> GapState {
        let known = &self.known[stop];
        known.get().unwrap_or_else(|| {
            let model = self.search.model(stop);
            let mut gap = GapState {
                gap: model.c[0],
                // Of the terms that an impact takes it from: those of the model are others, and larger where modes are complex.
                speed: self.stop_speed(stop) - along(&self.velocity_rows[stop], &self.state),
                acceleration: 2.0 * model.c[2],
                jerk: Some(6.0 * model.c[3]),
                size: model.size,
            };
            if let Some(pull) = self.pull(stop) {
                (gap.acceleration, gap.jerk) = (pull.acceleration, Some(pull.jerk));
            }
            known.set(Some(gap));
            gap
        })
    }

    fn given_gap(&self, stop: usize, q: &DVector<f64>, v: &DVector<f64>) -> Result<GivenGap> {
        let g = &self.scene.geometry;
        let (normal, clearance) = (g.normals.column(stop), g.clearances[stop]);
        let size = |x: &DVector<f64>| -> f64 {
            let terms = normal.iter().zip(x.iter());
            terms.map(|(n, x)| (n * x).abs()).sum()
        };
        let motion = self.scene.stop_motion(stop, self.moment());
        let [moved, speed, _] = motion;
        Ok(GivenGap {
            gap: (
                clearance + moved - normal.dot(q),
                clearance.abs() + moved.abs() + size(q),
            ),
            speed: (speed - normal.dot(v), speed.abs() + size(v)),
        }
        .at_time(self.clock.time(), motion))
    }

    fn rounding(&self, stop: usize) -> f64 {
        let placed = self.placed.get(stop).copied().unwrap_or(0.0);
        larger(self.search.rounding(stop), placed)
    }

    /// Ten times the tolerances, or ten times the usual ones where they are wider: an exact flight has errors of rounding alone, whatever
    /// the tolerances, and does not lead deeper inside a stop. A start that lies there is refused.
    fn margin(&self, stop: usize, size: f64) -> f64 {
        let usual =
            || Tolerance::USUAL.absolute * self.scene.geometry.normals.column(stop).lp_norm(1);
        let absolute = match self.tolerances.absolute {
            Some(_) => self.allowed[stop].min(usual()),
            None => self.allowed[stop],
        };
        let relative = self.tolerances.relative.min(Tolerance::USUAL.relative);
        10.0 * (absolute + relative.max(GAP_ROUNDING) * size)
    }

    fn tolerance(&self, stop: usize, size: f64) -> f64 {
        self.allowed[stop] + self.tolerances.relative.max(GAP_ROUNDING) * size
    }

    fn flight_sizes(&self, stop: usize) -> GapSizes {
        let [terms, way] = self.search.extent(stop);
        let reach = self.scene.geometry.clearances[stop].abs() + way;
        GapSizes { terms, reach }
    }

    fn speed_size(&self, stop: usize) -> f64 {
        self.search.speed_size(stop) + self.stop_speed(stop).abs()
    }
}

impl<F: LinearFlow> Contacts for ClosedForm<'_, F> {
    fn n_stops(&self) -> usize {
        self.scene.n_stops()
    }

    fn element_law(&self, element: usize) -> &Law {
        &self.scene.geometry.laws[element]
    }

    #[inline]
    fn law(&self, stop: usize) -> Newton {
        let drifting = self.timed.drifting_law(stop, self.clock.time());
        drifting.unwrap_or(self.scene.geometry.law(stop))
    }

    fn normals(&self, stops: &[usize]) -> Result<DMatrix<f64>> {
        Ok(self.scene.geometry.normals.select_columns(stops))
    }

    fn delassus(&self, stops: &[usize]) -> Result<DMatrix<f64>> {
        let g = &self.scene.geometry;
        let (normals, reactions) = g.columns(stops);
        Ok(normals.tr_mul(&reactions))
    }

    fn is_coupled(&self, one: usize, other: usize) -> bool {
        self.scene.geometry.is_coupled(one, other)
    }

    fn is_at_place_of(&self, one: usize, other: usize) -> bool {
        let made = || self.scene.geometry.places();
        let moves_alike = || {
            let excitation = &self.scene.excitation;
            excitation.motion_of(one) == excitation.motion_of(other)
        };
        one == other || {
            let places = self.places.get_or_init(made);
            places[one] == places[other] && moves_alike()
        }
    }

    fn is_bound(&self, stop: usize) -> bool {
        let bound =
            |motion: &Arc<RegimeMotion>| motion.fixes_gap(stop) && motion.regime.leaves_free(stop);
        self.regime_motion.as_ref().is_some_and(bound)
    }
}

impl<F: LinearFlow> Accelerations for ClosedForm<'_, F> {
    fn free_accelerations(&self, stops: &[usize]) -> DVector<f64> {
        let (scene, (q, v)) = (self.scene, self.physical());
        let force = scene.excitation.force(self.moment(), q.len());
        let mut acceleration = scene.system.acceleration(&q, &v, &force);
        for (element, force) in self.pushes() {
            let GapState { gap, speed, .. } = self.gap(element);
            let reaction = scene.geometry.reactions.column(element);
            acceleration.axpy(-force.at(gap, speed), &reaction, 1.0);
        }
        let pull = |i: usize| -scene.geometry.normals.column(stops[i]).dot(&acceleration);
        let own = |i: usize| scene.stop_motion(stops[i], self.moment())[2];
        DVector::from_fn(stops.len(), |i, _| own(i) + pull(i))
    }

    fn acceleration_sizes(&self, stops: &[usize]) -> Result<Vec<f64>> {
        let ModalScene {
            system,
            excitation,
            geometry,
            ..
        } = self.scene;
        let (q, v) = self.physical();
        let terms = force_terms(system, &excitation.sizes(self.moment(), q.len()), (&q, &v));
        let normal = |stop: usize| geometry.normals.column(stop).into_owned();
        // Forces that have just become zero one by one are known to the rounding of the motion.
        let size = |&stop: &usize| {
            let modal = self.search.acceleration_size(stop);
            let modal = self.pull(stop).map_or(modal, |pull| pull.size.max(modal));
            let pushed = self.pushes().map(|(element, force)| {
                let give = normal(stop).dot(&geometry.reactions.column(element));
                give.abs() * force.size_at(self.gap(element).size, self.speed_size(element))
            });
            let own = acceleration_size(system, &normal(stop), &terms);
            (own + pushed.sum::<f64>()).max(modal)
        };
        Ok(stops.iter().map(size).collect())
    }

    fn acceleration_lost(&self, stop: usize) -> f64 {
        let own = self.search.acceleration_lost(stop);
        self.pull(stop).map_or(own, |pull| own.max(pull.lost))
    }

    fn gap_derivatives(
        &mut self,
        stops: &[usize],
        regime: &Regime,
        orders: Range<usize>,
    ) -> Result<Vec<Vec<[f64; 2]>>> {
        // Beyond the order of its equations a linear motion has no derivative of its own.
        let last = 2 * self.scene.form.n_dof() + ORDERS_OF_INPUT;
        // An order that is asked for by its number may be one higher: times the rounding of a time it tells how far the one below is known
        // (`resolver/roundings.rs`).
        let end = if orders.end == usize::MAX {
            last + 1
        } else {
            orders.end.min(last + 2)
        };
        self.derivatives_beside(stops, regime, orders.start..end)
    }

    fn free_jerk(&mut self, stop: usize) -> Result<f64> {
        let own = 6.0 * self.search.model(stop).c[3];
        Ok(self.pull(stop).map_or(own, |pull| pull.jerk))
    }

    fn left_at_release(&self) -> f64 {
        10.0 * GAP_ROUNDING
    }

    fn steady(&self) -> f64 {
        DEPENDENT
    }
}

impl<F: LinearFlow> NormalMotion for ClosedForm<'_, F> {
    type Directions = usize;

    fn directions(&self, stop: usize) -> Result<usize> {
        Ok(stop)
    }

    #[inline]
    fn stop_speed(&self, stop: usize) -> f64 {
        self.scene.stop_motion(stop, self.moment())[1]
    }

    fn speed_along(&self, &stop: &usize) -> f64 {
        along(&self.velocity_rows[stop], &self.state)
    }

    fn impulse_of(&self, &stop: &usize, law: Newton, change: f64) -> f64 {
        law.approach_by(change * self.rebound_now(stop))
    }

    fn rebound(&self, &stop: &usize, _law: Newton, approach: f64) -> f64 {
        self.rebound_now(stop) * approach
    }

    fn push_along(&mut self, &stop: &usize, impulse: f64) {
        self.changed();
        for (z, jump) in self.state.iter_mut().zip(&self.scene.jumps[stop]) {
            *z = [0, 1].map(|c| difference(z[c], jump[c] * impulse));
        }
    }
}

impl<F: LinearFlow> Holding for ClosedForm<'_, F> {
    fn put_on(&mut self, stops: &[usize]) -> Result<()> {
        let (mut q, v) = self.physical();
        put_onto_stops(&mut q, |q| Ok(self.stops_at(stops, q)))?;
        self.put((&q, &v), 0.0);
        self.evaluate_gaps()
    }

    fn raise(&mut self, stop: usize) -> Result<()> {
        self.changed();
        let g = &self.scene.geometry;
        let shift = g.reactions.column(stop) * (self.gap(stop).gap / g.give(stop, stop));
        let still = vec![0.0; shift.len()];
        let moved = self.scene.form.to_modal(shift.as_slice(), &still);
        for (z, step) in self.state.iter_mut().zip(&moved) {
            *z = [z[0] + step[0], z[1] + step[1]];
        }
        Ok(())
    }

    fn set_places(&mut self, places: &[(usize, f64)]) {
        self.put_places(places.iter().copied());
    }

    fn enter(&mut self, regime: &Regime) -> Result<()> {
        self.enter_compliant(regime)?;
        if regime.is_free() {
            self.regime_motion = None;
            return Ok(());
        }
        let motion = self.motion_in(regime)?;
        if !regime.constrained().is_empty() {
            let (q, v) = self.settled(regime)?;
            let at = self.moment();
            let (q, v) = motion.lift(&motion.reduce(&q, &v, at), at);
            self.put((&q, &v), 0.0);
        }
        self.regime_motion = Some(motion);
        self.evaluate_gaps()
    }

    fn complete_chatter(
        &mut self,
        stops: &[usize],
        span: f64,
        recorder: &mut dyn Recorder,
    ) -> Result<()> {
        let (motion, start) = self.held_on(stops)?;
        self.record_rest(&motion, &start, span, recorder);
        let (q, v) = motion.propagate(self.moment(), span, &start.0, &start.1);
        self.put((&q, &v), span);
        self.evaluate_gaps()
    }

    fn record_chatter(&mut self, stop: usize, recorder: &mut dyn Recorder) -> Result<()> {
        let (motion, start) = self.held_on(&[stop])?;
        self.record_rest(&motion, &start, 0.0, recorder);
        Ok(())
    }
}

impl<F: LinearFlow> Present for ClosedForm<'_, F> {
    fn clock(&self) -> Clock {
        self.clock
    }

    fn set_time(&mut self, t: f64) {
        self.changed();
        self.clock = self.clock.at(t);
        let at = self.moment();
        self.flow.set_moment(&mut self.state, at);
    }

    fn phase(&self) -> f64 {
        wrapped(self.clock.angle() + self.phase)
    }

    fn breaks(&self) -> &[f64] {
        &self.timed.breaks
    }

    fn physical(&self) -> PhysicalState {
        self.scene.form.to_physical(&self.modal_state(&self.state))
    }

    fn work_of_flight(&self) -> usize {
        2 * STEPS_PER_REACH_CHECK * self.scene.form.n_dof()
    }
}

impl<F: LinearFlow> HybridFlow for ClosedForm<'_, F> {
    type System = Self;

    fn system(&mut self) -> &mut Self {
        self
    }

    fn start(&mut self, q: &DVector<f64>, v: &DVector<f64>, t: f64) {
        self.changed();
        self.search.restart();
        self.regime_motion = None;
        self.compliant.forget();
        self.placed.clear();
        self.clock = self.clock.at(t);
        self.set(q, v);
        for stop in 0..self.allowed.len() {
            self.allowed[stop] = self.absolute_tolerance(stop, q, v);
        }
    }

    fn advance_to_event(
        &mut self,
        orders: &RootOrders,
        span: f64,
        last: f64,
        recorder: &mut dyn Recorder,
        observer: &mut Observer,
    ) -> Result<Arrival> {
        if let Some(motion) = &self.regime_motion {
            let motion = Arc::clone(motion);
            return self.advance_in_regime(&motion, orders, (span, last), recorder, observer);
        }
        self.depart();
        self.grazed.clear();
        let FirstEvent { stop, root } =
            self.search
                .next(&self.state, orders.gaps(), span, &mut self.grazed, observer)?;
        match root {
            FirstRoot::None => {}
            FirstRoot::Undecided { at: time } => {
                self.record(time, None, recorder);
                self.go(time);
                return Ok(Arrival::Stalled { stop });
            }
            FirstRoot::Crossing { at, .. } => {
                let (stop, time) = self.search.arrive(stop, at, &self.state, &mut self.arrived);
                let from = self.clock;
                self.grazed
                    .retain(|graze| is_before(graze, from, (Some(stop), time)));
                let then = self.clock.after(time);
                if is_within(then, last) {
                    self.record(time, None, recorder);
                    self.changed();
                    self.clock = then;
                    self.placed.clear();
                    std::mem::swap(&mut self.state, &mut self.arrived);
                    let at = self.moment();
                    self.flow.set_moment(&mut self.state, at);
                    return Ok(Arrival::Event {
                        guard: Guard::gap(stop),
                    });
                }
            }
        }
        self.grazed.retain(|g| g.time <= span);
        self.record(span, Some(last), recorder);
        self.arrived.clone_from(&self.state);
        self.go(span);
        Ok(Arrival::End)
    }

    fn record_instant(&mut self, last: Option<f64>, recorder: &mut dyn Recorder) -> Result<()> {
        self.grazed.clear();
        self.record(0.0, last, recorder);
        Ok(())
    }

    fn counts(&self) -> Counts {
        Counts {
            gap_evaluations: self.search.n_gap_evaluations,
            atol: self.allowed.iter().copied().reduce(f64::min).unwrap_or(0.0),
            ..Counts::default()
        }
    }

    fn remarks(&self) -> String {
        String::new()
    }

    fn regime_motions(&self) -> Vec<Arc<RegimeMotion>> {
        self.regimes.motions()
    }

    fn departed(&self) -> Option<FlowMemory> {
        self.departed_memory()
    }

    fn present(&self) -> Option<FlowMemory> {
        self.present_memory()
    }

    fn go_back(&mut self, memory: &FlowMemory, regime: &Regime) -> Result<bool> {
        self.go_back_to(memory, regime)
    }

    fn places(&self) -> Vec<(usize, f64)> {
        let own = self.compliant.places.iter();
        own.map(|own| (own.element, own.place)).collect()
    }
}

impl<F: LinearFlow> AnyLoop for ClosedForm<'_, F> {
    type Taken<'s>
        = Self
    where
        Self: 's;

    fn taken(&mut self) -> &mut Self {
        self
    }
}
