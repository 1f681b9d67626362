//! Stepped flights: any scene moved by the Dormand-Prince pair, its contacts found on the quintic of each gap and reached by
//! a step of their own (theory 8).

mod chatter;
mod contact;
mod free;
mod jerk;
mod normal;
mod pendulum;
mod release;
mod runge_kutta;
mod series;

pub(crate) use free::FreeFlight;
pub(crate) use pendulum::{Pendulum, has_series, series_order};
pub(crate) use runge_kutta::InSteps;
pub(crate) use series::{SeriesStep, Taylor};

use crate::contact::walk::ROUNDING;
use crate::error::Result;
use crate::flow::steps::control::Controller;
use crate::flow::steps::{DenseOutput, Start, State, StepEnds, Stepper, Tolerance};
use crate::flow::{ConstrainedMotion, TERM_ROUNDINGS};
use crate::impact::wrapped;
use crate::model::{
    Constraint, Contact, Dynamics, GapValue, Moment, Scene, Surface, System, acceleration_size,
    are_coupled, contacts, force_terms, places,
};
use crate::quantity::positive_part;
use crate::simulate::clock::Clock;
use crate::simulate::kept::{Kept, Piece, SegmentKind};
use crate::simulate::mover::{Arrival, GapState, Looped, Mover, NormalImpact, Placed};
use crate::simulate::options::{Keep, SimulateOptions, Stats};
use crate::simulate::record::Record;
use crate::simulate::trajectory::Graze;
use crate::watch::Watch;
use nalgebra::{DMatrix, DVector};
use normal::dot;
use std::cell::OnceCell;
use std::ops::Range;
use std::sync::Arc;

/// Steps that a short flight is like, with its impact.
const FLIGHT: usize = 16;
/// Steps taken again on the way to one contact: as many as halvings alone need.
const MOST_POLISHES: usize = 60;

/// What is said of a motion whose steps were held down by stability.
const STIFF: &str = "; the motion is stiff: stability, not accuracy, held the steps down";

/// A scene moved in steps; one run after another, with its buffers.
pub(crate) struct StepMover<'a, S: State, D: Dynamics, F: FreeFlight<S, D>> {
    /// What moves it where no stop is held.
    free: F,
    dynamics: &'a D,
    scene: &'a Scene,
    contacts: Arc<Vec<Contact>>,
    /// The stops held, none in free motion.
    holding: Vec<usize>,
    /// Whether each stop stays as far away as it is while these are held: they themselves, and those whose gaps depend on theirs.
    is_bound: Vec<bool>,
    /// The largest contact force of each since it is held.
    pressed: Vec<f64>,
    phase: f64,
    tolerance: Tolerance,
    stepper: F::Steps,
    controller: Controller,
    /// The step to take next; `None` before the first.
    h: Option<f64>,
    /// Whether the stepper holds the rate of the present state.
    is_begun: bool,
    x: S,
    clock: Clock,
    /// Where the run began.
    began: Clock,
    gaps: Vec<GapValue>,
    ahead: Vec<GapValue>,
    touches: Vec<(f64, f64)>,
    /// The place of each stop, once two of them are asked about.
    places: OnceCell<Vec<usize>>,
    grazes: Vec<Graze>,
    /// The largest size of the terms of each gap seen on the present flight.
    extents: Vec<f64>,
    kept: Option<Kept>,
    /// Evaluations of the right-hand side by the stepper before the run.
    rhs_before: usize,
    /// Series made.
    n_series: usize,
    n_steps: usize,
    n_gap_evaluations: usize,
}

impl<'a, S: State, D: Dynamics, F: FreeFlight<S, D>> StepMover<'a, S, D, F> {
    /// A mover of a scene along its equations of motion.
    pub fn new(dynamics: &'a D, scene: &'a Scene, options: &SimulateOptions, free: F) -> Self {
        let n = dynamics.n_dof();
        let contacts = Arc::new(contacts(scene));
        let none = vec![GapValue::default(); contacts.len()];
        let clock = Clock::new(0.0, scene.forcing().frequency().unwrap_or(0.0));
        let tolerance = Tolerance {
            // Below this the rounding of a step exceeds its tolerance.
            relative: options.rtol.max(4.0 * f64::EPSILON),
            absolute: options.atol.max(f64::MIN_POSITIVE),
        };
        Self {
            free,
            dynamics,
            scene,
            gaps: none.clone(),
            ahead: none,
            contacts,
            holding: Vec::new(),
            is_bound: Vec::new(),
            pressed: Vec::new(),
            phase: scene.forcing().phase(),
            tolerance,
            stepper: F::Steps::new(n, tolerance),
            controller: Controller::new(F::Steps::CONTROL),
            h: None,
            is_begun: false,
            x: S::zeros(2 * n),
            clock,
            began: clock,
            touches: Vec::new(),
            places: OnceCell::new(),
            grazes: Vec::new(),
            extents: Vec::new(),
            kept: (options.keep == Keep::Motion).then(Kept::default),
            rhs_before: 0,
            n_series: 0,
            n_steps: 0,
            n_gap_evaluations: 0,
        }
    }

    fn moment(&self) -> Moment {
        self.clock.moment(self.phase)
    }

    /// Takes a step from the present state, whose rate is known; false where there is none.
    fn step<E: Dynamics>(&mut self, dynamics: &E, h: f64) -> Result<bool> {
        let (at, x) = (self.moment(), &self.x);
        self.stepper.step(dynamics, Start { at, x }, h)
    }

    /// The dense output of the step last taken.
    fn dense<E: Dynamics>(
        &mut self,
        dynamics: &E,
        h: f64,
    ) -> Result<<F::Steps as Stepper<S>>::Dense> {
        let (at, x) = (self.moment(), &self.x);
        self.stepper.dense(dynamics, Start { at, x }, h)
    }

    fn n(&self) -> usize {
        self.dynamics.n_dof()
    }

    /// Whether a step is no time beside that since the run began.
    fn is_too_short(&self, h: f64) -> bool {
        let elapsed = self.began.until(self.clock);
        elapsed + h == elapsed
    }

    /// Begins to note how large the gaps are on a flight.
    fn forget_extents(&mut self) {
        self.extents.clear();
        self.extents.resize(self.contacts.len(), 0.0);
    }

    /// The gaps at the present state, whose rate is known.
    fn take_gaps(&mut self) -> Result<()> {
        let n = self.n();
        let (q, v) = self.x.slice().split_at(n);
        let a = &self.stepper.start_rate().slice()[n..];
        let step = self.slow_time();
        for (value, contact) in self.gaps.iter_mut().zip(self.contacts.iter()) {
            *value = contact.surface.along(q, v, a, step)?;
        }
        self.n_gap_evaluations += self.contacts.len();
        Ok(())
    }

    /// The margin of a gap.
    fn margin_of(&self, gap: GapValue) -> f64 {
        let absolute = self.tolerance.absolute * gap.steepness;
        10.0 * (absolute + self.tolerance.relative.max(ROUNDING) * gap.size)
    }

    /// A time over which the motion changes little: the step, or what it takes to move by the present state.
    fn slow_time(&self) -> f64 {
        let n = self.n();
        let size = |x: &[f64]| x.iter().fold(0.0f64, |size, x| size.max(x.abs()));
        let (q, v) = self.x.slice().split_at(n);
        let (speed, acceleration) = (size(v), size(&self.stepper.start_rate().slice()[n..]));
        let times = [size(q) / speed, speed / acceleration];
        let finite = times.into_iter().filter(|t| *t > 0.0 && t.is_finite());
        self.h.or(finite.reduce(f64::max)).unwrap_or(1.0)
    }

    /// Keeps a step from the present state as its dense output says.
    fn keep_dense(
        &mut self,
        dense: &impl DenseOutput<S>,
        span: f64,
        last: Option<f64>,
        record: &mut Record,
    ) {
        if let Some(kept) = &mut self.kept {
            let clock = self.clock;
            kept.pieces.push(Piece { clock, span });
            dense.write(&mut kept.numbers);
        }
        self.sample(span, last, record, |local, x| dense.state(local, x));
    }

    /// Hands the record what it asks for of a step from the present state; `state` writes that at a time along the step.
    fn sample(
        &self,
        span: f64,
        last: Option<f64>,
        record: &mut Record,
        state: impl Fn(f64, &mut [f64]),
    ) {
        let n = self.n();
        let mut x = S::zeros(2 * n);
        record.sample(self.clock, span, last, |local| {
            state(local, x.slice_mut());
            let (q, v) = x.slice().split_at(n);
            (DVector::from_column_slice(q), DVector::from_column_slice(v))
        });
    }
}

impl<S: State, D: Dynamics, F: FreeFlight<S, D>> Looped for StepMover<'_, S, D, F> {
    type Taken<'s>
        = dyn Mover + 's
    where
        Self: 's;

    fn taken(&mut self) -> &mut (dyn Mover + '_) {
        self
    }
}

impl<S: State, D: Dynamics, F: FreeFlight<S, D>> Mover for StepMover<'_, S, D, F> {
    fn start(&mut self, q: &DVector<f64>, v: &DVector<f64>, t: f64) {
        for (x, y) in self.x.slice_mut().iter_mut().zip(q.iter().chain(v.iter())) {
            *x = *y;
        }
        self.clock = self.clock.at(t);
        self.began = self.clock;
        self.controller = Controller::new(F::Steps::CONTROL);
        (self.h, self.is_begun) = (None, false);
        self.free.reset();
        self.holding.clear();
        (self.n_steps, self.n_series, self.n_gap_evaluations) = (0, 0, 0);
        self.rhs_before = self.stepper.n_rhs();
        if let Some(kept) = &mut self.kept {
            *kept = Kept::default();
        }
    }

    fn counted(&self, stats: Stats) -> Stats {
        Stats {
            n_rhs: self.stepper.n_rhs() - self.rhs_before + self.n_series,
            n_steps: self.n_steps,
            n_gap_evaluations: self.n_gap_evaluations,
            ..stats
        }
    }

    fn remarks(&self) -> String {
        let stiff = if self.controller.is_stiff { STIFF } else { "" };
        format!("{stiff}{}", uncertain(self.scene))
    }

    fn take_kept(&mut self) -> Option<Kept> {
        self.kept.as_mut().map(std::mem::take)
    }

    fn held_motions(&self) -> Vec<Arc<ConstrainedMotion>> {
        Vec::new()
    }

    fn n_stops(&self) -> usize {
        self.contacts.len()
    }

    fn clock(&self) -> Clock {
        self.clock
    }

    fn look(&mut self) -> Result<()> {
        self.is_begun = false;
        self.begin(self.dynamics)
    }

    fn gap(&self, stop: usize) -> GapState {
        let value = self.gaps[stop];
        GapState {
            gap: value.gap,
            speed: value.speed,
            acceleration: value.acceleration,
            jerk: 0.0,
            size: value.size,
        }
    }

    fn margin(&self, stop: usize, size: f64) -> f64 {
        let gap = self.gaps[stop];
        self.margin_of(GapValue { size, ..gap })
    }

    fn rounding(&self, stop: usize) -> f64 {
        TERM_ROUNDINGS * self.gaps[stop].size
    }

    fn extent(&self, stop: usize) -> f64 {
        self.extents.get(stop).copied().unwrap_or(0.0)
    }

    fn speed_size(&self, stop: usize) -> f64 {
        let (q, v) = self.x.slice().split_at(self.n());
        // The look before has had this normal: an error would have ended the run there.
        let size = self.contacts[stop].surface.speed_size(q, v);
        size.unwrap_or(0.0)
    }

    fn gap_derivatives(
        &mut self,
        stops: &[usize],
        held: &[usize],
        orders: Range<usize>,
    ) -> Result<Vec<Vec<[f64; 2]>>> {
        let mut of_order = |order: usize| -> Result<Vec<[f64; 2]>> {
            let stops = stops.iter();
            if order == 2 {
                stops.map(|&stop| self.drawn(stop, held)).collect()
            } else {
                stops.map(|&stop| self.jerk(stop, held)).collect()
            }
        };
        (orders.start..orders.end.min(4))
            .map(&mut of_order)
            .collect()
    }

    fn free_jerk(&mut self, stop: usize) -> Result<f64> {
        self.jerk(stop, &[]).map(|[jerk, _]| jerk)
    }

    fn placed(&self, stop: usize, q: &DVector<f64>, v: &DVector<f64>) -> Result<Placed> {
        let (surface, q, v) = (&self.contacts[stop].surface, q.as_slice(), v.as_slice());
        let value = surface.along(q, v, v, 0.0)?;
        Ok(Placed {
            gap: (value.gap, value.size),
            speed: (value.speed, surface.speed_size(q, v)?),
        })
    }

    fn is_bound(&self, stop: usize) -> bool {
        !self.holding.is_empty() && self.is_bound[stop] && !self.holding.contains(&stop)
    }

    fn acceleration_sizes(&self, stops: &[usize]) -> Result<Vec<f64>> {
        let (q, v) = self.physical();
        let normals = stops
            .iter()
            .map(|&stop| self.contacts[stop].surface.normal(q.as_slice()));
        if let System::Linear(system) = self.scene.system() {
            let amplitude = self.scene.forcing().force_on(system);
            let terms = force_terms(system, &amplitude, (&q, &v));
            return normals
                .map(|normal| Ok(acceleration_size(system, &normal?, &terms)))
                .collect();
        }
        // Of the terms of an acceleration given by a function nobody knows: they are as large as those of other coordinates.
        let (_, a) = self.stepper.start_rate().slice().split_at(self.n());
        let largest = a.iter().fold(0.0f64, |most, a| most.max(a.abs()));
        normals
            .map(|normal| Ok(largest * normal?.lp_norm(1)))
            .collect()
    }

    fn work_of_flight(&self) -> usize {
        FLIGHT * self.n().pow(2)
    }

    fn is_at(&self, one: usize, other: usize) -> bool {
        let plane = |contact: &Contact| match &contact.surface {
            Surface::Plane { normal, clearance } => Some((normal.clone(), *clearance)),
            _ => None,
        };
        let made = || places(&self.contacts.iter().map(plane).collect::<Vec<_>>());
        one == other || {
            let places = self.places.get_or_init(made);
            places[one] == places[other]
        }
    }

    fn is_coupled(&self, one: usize, other: usize) -> bool {
        let (q, _) = self.x.slice().split_at(self.n());
        let (a, b) = (&self.contacts[one], &self.contacts[other]);
        are_coupled(a, b, self.scene.system(), q)
    }

    fn fly(
        &mut self,
        starts: &[usize],
        span: f64,
        last: f64,
        record: &mut Record,
        watch: &mut Watch<'_>,
    ) -> Result<Arrival> {
        if self.holding.is_empty() {
            return F::fly(self, starts, (span, last), record, watch);
        }
        self.is_begun = false;
        let held = self.held_motion();
        self.fly_along::<_, true>(&held, starts, (span, last), record, watch)
    }

    fn stay(&mut self, last: Option<f64>, record: &mut Record) -> Result<()> {
        if let Some(kept) = &mut self.kept {
            kept.begin(SegmentKind::Flight, &[]);
        }
        F::keep_nothing(self, last, record)
    }

    fn strike(&mut self, stop: usize) -> Result<NormalImpact> {
        let directions = self.directions(stop)?;
        let (normal, reaction) = directions.both();
        let approach = positive_part(self.along(normal));
        let restitution = self.contacts[stop].restitution;
        let give = dot(normal, reaction);
        let (impulse, departure) = (
            (1.0 + restitution) * approach / give,
            restitution * approach,
        );
        self.push_along(reaction, impulse);
        // A small departure is what is left of two large speeds: its rounding is taken off.
        let left = self.along(normal) + departure;
        self.push_along(reaction, left / give);
        Ok(NormalImpact {
            approach,
            departure,
            impulse,
        })
    }

    fn normals(&self, stops: &[usize]) -> Result<DMatrix<f64>> {
        let q = self.x.slice().split_at(self.n()).0;
        let normal = |&stop: &usize| self.contacts[stop].surface.normal(q);
        let normals: Vec<_> = stops.iter().map(normal).collect::<Result<_>>()?;
        Ok(DMatrix::from_columns(&normals))
    }

    fn delassus(&self, stops: &[usize]) -> Result<DMatrix<f64>> {
        let all = stops.iter().map(|&stop| self.directions(stop));
        let all: Vec<_> = all.collect::<Result<_>>()?;
        let product = |i: usize, j: usize| dot(all[i].both().0, all[j].both().1);
        Ok(DMatrix::from_fn(stops.len(), stops.len(), product))
    }

    fn push(&mut self, stop: usize, impulse: f64) -> Result<()> {
        let directions = self.directions(stop)?;
        self.push_along(directions.both().1, impulse);
        Ok(())
    }

    fn restitution(&self, stop: usize) -> f64 {
        self.contacts[stop].restitution
    }

    fn accumulate(&mut self, stop: usize, left: f64, record: &mut Record) -> Result<()> {
        self.complete(stop, left, record)
    }

    fn note_chatter(&mut self, stop: usize, record: &mut Record) -> Result<()> {
        if let Some(kept) = &mut self.kept {
            kept.begin(SegmentKind::Chatter, &[stop]);
        }
        self.keep_no_step(None, record);
        Ok(())
    }

    fn touch(&mut self, stops: &[usize]) -> Result<()> {
        self.put_on(stops)?;
        self.look()
    }

    fn hold(&mut self, stops: &[usize]) -> Result<()> {
        let is_new = self.holding != stops;
        self.holding.clear();
        self.holding.extend_from_slice(stops);
        self.pressed.clear();
        self.pressed.resize(stops.len(), 0.0);
        if !stops.is_empty() {
            self.settle(stops)?;
        }
        if is_new {
            let held: Vec<&Surface> = stops.iter().map(|&i| &self.contacts[i].surface).collect();
            let is_bound = (0..self.contacts.len()).map(|stop| {
                Ok(stops.contains(&stop) || self.contacts[stop].surface.is_bound_by(&held)?)
            });
            self.is_bound = is_bound.collect::<Result<_>>()?;
        }
        self.look()
    }

    fn phase(&self) -> f64 {
        wrapped(self.clock.angle() + self.phase)
    }

    fn physical(&self) -> (DVector<f64>, DVector<f64>) {
        let (q, v) = self.x.slice().split_at(self.n());
        (DVector::from_column_slice(q), DVector::from_column_slice(v))
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
