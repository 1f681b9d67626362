//! A scene that is integrated, where it is now.

use crate::error::{Error, Result};
use crate::event::certified::{SearchCost, SearchFailure, StepTouch};
use crate::event::curvature::gap_tolerance;
use crate::flow::characteristic_length::{StepLengths, Tolerances, part_of};
use crate::flow::steps::control::Controller;
use crate::flow::steps::{DenseOutput, State, StepStart, Stepper, Tolerance};
use crate::hybrid::clock::Clock;
use crate::hybrid::flow::{Arrival, Counts};
use crate::hybrid::recorder::{ArcMotion, ArcSpan, Recorder, Written};
use crate::hybrid::relaxing_places::RelaxingPlaces;
use crate::hybrid::root_orders::RootOrders;
use crate::hybrid::segment::Graze;
use crate::hybrid::system::Gaps;
use crate::law::{Guard, Regime};
use crate::model::{
    Constraint, Contact, Dynamics, Excitation, GapMotion, GapValue, Moment, PhysicalState, Scene,
    contacts, slow_time,
};
use crate::observer::Observer;
use nalgebra::DVector;
use std::cell::OnceCell;
use std::marker::PhantomData;
use std::sync::Arc;

/// Steps taken again on the way to one contact: as many as halvings alone need. [work]
pub(super) const MOST_RETAKEN_STEPS: usize = 60;

/// What is said of a motion whose steps were held down by stability.
const STIFF: &str = "; the motion is stiff: stability, not accuracy, held the steps down";

/// A scene that is integrated; one run after another, with its buffers.
pub(crate) struct Integrated<'a, S: State, D, P: Stepper<S>> {
    pub(super) dynamics: &'a D,
    pub(super) scene: &'a Scene,
    pub(super) contacts: Arc<Vec<Contact>>,
    pub(super) regime: Regime,
    /// Whether each stop stays as far away as it is in this regime: those held themselves, and those whose gaps depend on theirs.
    pub(super) is_bound: Vec<bool>,
    /// Whether no zero of what is watched of the gap of each element ends this regime.
    pub(super) is_unwatched: Vec<bool>,
    /// The forces whose zeros end this regime.
    pub(super) force_guards: Vec<Guard>,
    /// The largest of each since it began, shape `(n_guards,)`, \[N\].
    pub(super) peak_forces: Vec<f64>,
    /// The places of the elements that relax.
    pub(super) places_back: RelaxingPlaces,
    pub(super) phase: f64,
    pub(super) excitation: Excitation,
    /// The frequency of the fastest harmonic or tone, zero without any.
    pub(super) fastest_forcing: f64,
    /// The longest step along which the gap of a stop that moves is told from the ends; infinite where all rest.
    pub(super) longest_step: f64,
    /// The times at which a signal passes from one polynomial to the next, ascending, shape `(n_breaks,)`, \[s\].
    pub(super) breaks: Vec<f64>,
    pub(super) tolerance: Tolerance,
    /// Of what the absolute tolerance is a part; none where it is given.
    lengths: Option<StepLengths>,
    /// What was chosen of the method.
    choice: P::Choice,
    pub(super) stepper: P,
    pub(super) controller: Controller,
    /// The step to take next; `None` before the first.
    pub(super) h: Option<f64>,
    /// Whether the stepper holds the rate of the present state.
    pub(super) is_begun: bool,
    pub(super) x: S,
    pub(super) clock: Clock,
    /// Where the run began.
    pub(super) began: Clock,
    /// What is watched of the gap of each element at the present state.
    pub(super) gaps: Vec<GapValue>,
    pub(super) ahead: Vec<GapValue>,
    pub(super) touches: Vec<(f64, f64)>,
    /// The stops whose gaps are to be searched along the step last taken by the bound on their curvature, with the orders of their roots
    /// at its start, and the touches found.
    pub(super) sought: Vec<(usize, usize)>,
    pub(super) sought_touches: Vec<StepTouch>,
    /// What these searches have taken in the run, by stops.
    pub(super) search_costs: Vec<SearchCost>,
    /// The stop of which the search along the step last tried could not be certified, and why, if it could not.
    pub(super) doubt: Option<(usize, SearchFailure)>,
    /// The place of each stop, once two of them are asked about.
    pub(super) places: OnceCell<Vec<usize>>,
    pub(super) grazes: Vec<Graze>,
    /// The largest size of the terms of each gap on the present flight, shape `(n_stops,)`, \[m\].
    pub(super) extents: Vec<f64>,
    /// When the motion was found stiff, if it was.
    pub(super) stiff_from: Option<f64>,
    /// Why a step could not be tried, and when it began: its stages led to what is no number.
    pub(super) beyond: Option<(f64, Error)>,
    /// Accelerations that were asked beside those of steps: of series, and of a start.
    pub(super) n_series: usize,
    pub(super) n_steps: usize,
    pub(super) n_gap_evaluations: usize,
}

impl<'a, S: State, D: Dynamics, P: Stepper<S>> Integrated<'a, S, D, P> {
    /// A scene along its equations of motion.
    pub(super) fn new(
        dynamics: &'a D,
        scene: &'a Scene,
        tolerances: Tolerances,
        choice: P::Choice,
    ) -> Self {
        let n = dynamics.n_dof();
        let contacts = Arc::new(contacts(scene));
        let excitation = scene.excitation();
        let n_stops = contacts.len();
        let none = vec![GapValue::default(); n_stops];
        let clock = Clock::new(0.0, scene.frequency().unwrap_or(0.0));
        let tolerance = Tolerance {
            // Below this the rounding of a step exceeds its tolerance.
            relative: tolerances.relative.max(4.0 * f64::EPSILON),
            absolute: tolerances.absolute.unwrap_or(0.0).max(f64::MIN_POSITIVE),
        };
        Self {
            dynamics,
            scene,
            gaps: none.clone(),
            ahead: none,
            contacts,
            regime: Regime::default(),
            is_bound: Vec::new(),
            is_unwatched: Vec::new(),
            force_guards: Vec::new(),
            peak_forces: Vec::new(),
            places_back: RelaxingPlaces::default(),
            phase: scene.turned_phase(),
            fastest_forcing: excitation.rotations.fastest(),
            longest_step: longest_step(&excitation, tolerance),
            breaks: excitation.breaks(),
            excitation,
            tolerance,
            lengths: (tolerances.absolute.is_none()).then(|| StepLengths::new(scene)),
            choice,
            stepper: P::new(n, tolerance, choice),
            controller: Controller::default(),
            h: None,
            is_begun: false,
            x: S::zeros(2 * n),
            clock,
            began: clock,
            touches: Vec::new(),
            sought: Vec::new(),
            sought_touches: Vec::new(),
            search_costs: vec![SearchCost::default(); n_stops],
            doubt: None,
            places: OnceCell::new(),
            grazes: Vec::new(),
            extents: Vec::new(),
            stiff_from: None,
            beyond: None,
            n_series: 0,
            n_steps: 0,
            n_gap_evaluations: 0,
        }
    }

    pub(super) fn moment(&self) -> Moment {
        self.clock.moment(self.phase)
    }

    /// Takes a step from the present state, whose rate is known; false where there is none.
    pub(super) fn step<E: Dynamics>(&mut self, dynamics: &E, h: f64) -> Result<bool> {
        let (at, x) = (self.moment(), &self.x);
        self.stepper.step(dynamics, StepStart { at, x }, h)
    }

    /// The same; false, too, where its stages lead to what is no number: a shorter one may not.
    #[inline]
    pub(super) fn step_within_doubles<E: Dynamics>(
        &mut self,
        dynamics: &E,
        h: f64,
    ) -> Result<bool> {
        match self.step(dynamics, h) {
            Ok(is_taken) => Ok(is_taken),
            Err(error) => self.refuse(error),
        }
    }

    /// Takes note of why a step could not be tried, if it was for want of numbers.
    #[cold]
    pub(super) fn refuse(&mut self, error: Error) -> Result<bool> {
        if !error.is_not_finite() {
            return Err(error);
        }
        self.beyond = Some((self.clock.time(), error));
        Ok(false)
    }

    /// The dense output of the step last taken.
    #[inline]
    pub(super) fn dense<E: Dynamics>(&mut self, dynamics: &E, h: f64) -> Result<P::Dense> {
        let (at, x) = (self.moment(), &self.x);
        self.stepper.dense(dynamics, StepStart { at, x }, h)
    }

    pub(super) fn n(&self) -> usize {
        self.dynamics.n_dof()
    }

    /// Whether a step is no time beside that since the run began.
    pub(super) fn is_too_short(&self, h: f64) -> bool {
        let elapsed = self.began.until(self.clock);
        elapsed + h == elapsed
    }

    /// Begins to note how large the gaps are on a flight.
    pub(super) fn forget_extents(&mut self) {
        self.extents.clear();
        self.extents.resize(self.contacts.len(), 0.0);
    }

    /// The gaps at the present state, whose rate is known.
    pub(super) fn take_gaps(&mut self) -> Result<()> {
        let n = self.n();
        let (q, v) = self.x.slice().split_at(n);
        let a = &self.stepper.start_rate().slice()[n..];
        let step = self.slow_time();
        for (value, contact) in self.gaps.iter_mut().zip(self.contacts.iter()) {
            *value = contact.surface.along(q, v, a, step)?;
            if let Some(motion) = &contact.motion {
                value.widen(motion, self.clock.moment(self.phase));
            }
        }
        for &(element, state) in self.regime.others() {
            self.watched(element, state)
                .turn(&mut self.gaps[element], 0.0);
        }
        self.n_gap_evaluations += self.contacts.len();
        Ok(())
    }

    /// The margin of a gap.
    pub(super) fn margin_of(&self, gap: GapValue) -> f64 {
        10.0 * gap_tolerance(self.tolerance, (gap.steepness, gap.size))
    }

    /// A time over which the motion changes little: the step, or what it takes to move by the present state.
    pub(super) fn slow_time(&self) -> f64 {
        let (q, v) = self.x.slice().split_at(self.n());
        let a = &self.stepper.start_rate().slice()[self.n()..];
        self.h.unwrap_or_else(|| slow_time(q, v, a))
    }

    /// Records a step from the present state as its dense output says.
    pub(super) fn record_dense(
        &self,
        dense: &P::Dense,
        arc: &ArcSpan,
        recorder: &mut dyn Recorder,
    ) {
        let (n, state) = (self.n(), PhantomData::<S>);
        recorder.arc(arc, &mut StepArc { dense, n, state });
    }
}

/// A step so long that the quintics of the gaps of stops that move are off by a tolerance; infinite where all rest.
fn longest_step(excitation: &Excitation, tolerance: Tolerance) -> f64 {
    let step = |motion: &GapMotion| {
        motion.quintic_step(tolerance.absolute + tolerance.relative * motion.amplitude())
    };
    let moving = excitation.stops.iter().flatten().map(step);
    moving.fold(f64::INFINITY, f64::min)
}

/// A step.
struct StepArc<'d, Q, S> {
    dense: &'d Q,
    n: usize,
    state: PhantomData<S>,
}

impl<S: State, Q: DenseOutput<S>> Written for StepArc<'_, Q, S> {
    fn write(&self, numbers: &mut Vec<f64>) {
        self.dense.write(numbers);
    }
}

impl<S: State, Q: DenseOutput<S>> ArcMotion for StepArc<'_, Q, S> {
    fn state(&mut self, local: f64) -> PhysicalState {
        let mut x = S::zeros(2 * self.n);
        self.dense.state(local, x.slice_mut());
        parted(x.slice())
    }
}

/// Position and velocity of a state.
pub(super) fn parted(x: &[f64]) -> PhysicalState {
    let (q, v) = x.split_at(x.len() / 2);
    (DVector::from_column_slice(q), DVector::from_column_slice(v))
}

impl<S: State, D: Dynamics, P: Stepper<S>> Integrated<'_, S, D, P> {
    /// Puts the motion at a state and a time, as new.
    pub(super) fn start(&mut self, q: &DVector<f64>, v: &DVector<f64>, t: f64) {
        for (x, y) in self.x.slice_mut().iter_mut().zip(q.iter().chain(v.iter())) {
            *x = *y;
        }
        self.clock = self.clock.at(t);
        self.began = self.clock;
        self.controller = Controller::default();
        let mut asked = 0;
        if let Some(lengths) = &self.lengths {
            let shortest = self.shortest(lengths, &mut asked);
            self.tolerance.absolute = part_of(shortest).max(f64::MIN_POSITIVE);
        }
        self.stepper = P::new(self.n(), self.tolerance, self.choice);
        (self.h, self.is_begun, self.stiff_from) = (None, false, None);
        self.regime = Regime::default();
        self.places_back.clear();
        (self.n_steps, self.n_series, self.n_gap_evaluations) = (0, asked, 0);
        self.search_costs.fill(SearchCost::default());
    }

    /// The length of which the absolute tolerance is a part: the shortest of the coordinates from where the motion is, or where it is and
    /// stays at zero of the gaps, in units of the coordinates; zero where there is none. Counts how often the acceleration is asked.
    fn shortest(&self, lengths: &StepLengths, asked: &mut usize) -> f64 {
        let (q, v) = self.x.slice().split_at(self.n());
        // Functions that report errors do so again as the run begins.
        let acceleration = || {
            *asked += 1;
            let mut a = vec![0.0; q.len()];
            let is_known = self
                .dynamics
                .acceleration(self.moment(), q, v, &mut a)
                .is_ok();
            if is_known { a } else { Vec::new() }
        };
        let of_gap = |contact: &Contact| {
            let value = contact.surface.along(q, v, v, 0.0).ok()?;
            let moved = contact.motion.as_ref().map_or(0.0, GapMotion::reach);
            let length = value.size.max(moved) / value.steepness;
            (length > 0.0).then_some(length)
        };
        let coordinates = lengths.shortest((q, v), acceleration);
        let gaps = || self.contacts.iter().filter_map(of_gap).reduce(f64::min);
        coordinates.or_else(gaps).unwrap_or(0.0)
    }

    /// Whether all elements are free.
    pub(crate) fn is_free(&self) -> bool {
        self.regime.is_free()
    }

    /// A flight in a regime that is not free.
    pub(super) fn advance_in_regime(
        &mut self,
        orders: &RootOrders,
        (span, last): (f64, f64),
        recorder: &mut dyn Recorder,
        observer: &mut Observer,
    ) -> Result<Arrival> {
        self.is_begun = false;
        let motion = self.motion_in(&self.regime);
        let orders = self.watched_orders(orders);
        let back = self.places_back.first_back().filter(|own| own.1 <= span);
        let ends = back.map_or((span, Some(last)), |own| (own.1, None));
        let arrival = self.advance_along::<_, true>(&motion, &orders, ends, recorder, observer)?;
        if let (Some((element, _)), Arrival::End) = (back, arrival) {
            self.evaluate_gaps()?;
            return Ok(Arrival::Event {
                guard: Guard::place(element),
            });
        }
        let moves = |&stop: &usize| self.contacts[stop].motion.is_some();
        if matches!(arrival, Arrival::End) && self.regime.constrained().iter().any(moves) {
            // Steps are off what a stop does that moves by their error: who goes on from here finds the contact as it is.
            self.settle()?;
        }
        Ok(arrival)
    }

    pub(super) fn counts(&self) -> Counts {
        Counts {
            rhs: self.stepper.n_rhs() + self.n_series,
            steps: self.n_steps,
            atol: self.tolerance.absolute,
            gap_evaluations: self.n_gap_evaluations,
        }
    }

    pub(super) fn remarks(&self) -> String {
        let steps = match (self.stepper.fitting(), self.stiff_from) {
            (Some(name), Some(t)) => {
                format!("; from t = {t} on, where the motion is stiff, steps of {name}")
            }
            (Some(name), None) => format!("; steps of {name}"),
            (None, Some(_)) => STIFF.to_owned(),
            (None, None) => String::new(),
        };
        steps + &uncertain(self.scene) + &self.long_searches()
    }
}

/// What is said of nonlinear stops without a curvature: their gaps are searched on an interpolant.
fn uncertain(scene: &Scene) -> String {
    let is_unbounded =
        |s: &Constraint| matches!(s, Constraint::Nonlinear(s) if s.curvature().is_none());
    let stops = scene.stops().iter().enumerate();
    let names: Vec<String> = stops
        .filter(|(_, stop)| is_unbounded(stop))
        .map(|(i, _)| format!("stop {i}"))
        .collect();
    if names.is_empty() {
        return String::new();
    }
    format!(
        "; the search for contacts with {} is not certain: give a bound `curvature`",
        names.join(" and ")
    )
}
