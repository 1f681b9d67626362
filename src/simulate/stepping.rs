//! Stepped flights: any scene moved by the Dormand-Prince pair, its contacts found on the quintic of each gap and reached by
//! a step of their own (theory 8).

use crate::contact::curvature::first_crossing;
use crate::contact::polynomial::{Along, Judgement, Quintic};
use crate::contact::walk::ROUNDING;
use crate::error::{Error, Result};
use crate::flow::runge_kutta::{State, Stepper, Tolerance};
use crate::flow::step_size::{Controller, first_step, trial_step};
use crate::impact::wrapped;
use crate::model::{Contact, Dynamics, GapValue, Moment, Scene, contacts};
use crate::simulate::clock::Clock;
use crate::simulate::kept::{Kept, Piece, SegmentKind};
use crate::simulate::mover::{Arrival, Blow, GapState, Mover};
use crate::simulate::record::Record;
use crate::simulate::trajectory::Graze;
use crate::simulate::{Keep, SimulateOptions};
use nalgebra::DVector;

/// Beat of the clock of a motion without forcing.
pub(crate) const STEPPED_BEAT: f64 = 1.0;
/// Steps taken again on the way to one contact.
const MOST_POLISHES: usize = 12;
/// A correction this small, in parts of the step, moves the state by its Taylor series of second order.
const TAYLOR_PART: f64 = 1e-8;
/// Halvings of a step that cannot tell contact from none, before the interpolant decides.
const MOST_HALVINGS: usize = 12;
/// Steps between two calls of the caller's check.
const STEPS_PER_CHECK: usize = 256;

/// What the gaps do along a step.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Found {
    Nothing,
    /// The earliest contact, at a part x of the step.
    Contact {
        stop: usize,
        x: f64,
    },
    /// The interpolation cannot tell contact from none.
    Undecided,
}

/// A scene moved in steps; one run after another, with its buffers.
pub(crate) struct StepMover<'a, S, D> {
    dynamics: &'a D,
    scene: &'a Scene,
    contacts: Vec<Contact>,
    frequency: f64,
    phase: f64,
    tolerance: Tolerance,
    stepper: Stepper<S>,
    controller: Controller,
    /// The step to take next; `None` before the first.
    h: Option<f64>,
    /// Whether the stepper holds the rate of the present state.
    is_begun: bool,
    x: S,
    clock: Clock,
    gaps: Vec<GapValue>,
    ahead: Vec<GapValue>,
    touches: Vec<(f64, f64)>,
    grazes: Vec<Graze>,
    kept: Option<Kept>,
    pub n_steps: usize,
    pub n_gap_evaluations: usize,
}

impl<'a, S: State, D: Dynamics> StepMover<'a, S, D> {
    /// A mover of a scene along its equations of motion.
    pub fn new(dynamics: &'a D, scene: &'a Scene, options: &SimulateOptions) -> Self {
        let n = dynamics.n_dof();
        let contacts = contacts(scene);
        let none = vec![GapValue::default(); contacts.len()];
        let frequency = scene.forcing().frequency().unwrap_or(0.0);
        Self {
            dynamics,
            scene,
            gaps: none.clone(),
            ahead: none,
            contacts,
            frequency,
            phase: scene.forcing().phase(),
            tolerance: Tolerance {
                // Below this the rounding of a step exceeds its tolerance.
                relative: options.rtol.max(4.0 * f64::EPSILON),
                absolute: options.atol.max(f64::MIN_POSITIVE),
            },
            stepper: Stepper::new(n),
            controller: Controller::default(),
            h: None,
            is_begun: false,
            x: S::zeros(2 * n),
            clock: Clock::new(0.0, frequency, STEPPED_BEAT),
            touches: Vec::new(),
            grazes: Vec::new(),
            kept: (options.keep == Keep::Motion).then(Kept::default),
            n_steps: 0,
            n_gap_evaluations: 0,
        }
    }

    /// Puts the mover at a state and a time, as new.
    pub fn start(&mut self, q: &DVector<f64>, v: &DVector<f64>, t: f64) {
        for (x, y) in self.x.slice_mut().iter_mut().zip(q.iter().chain(v.iter())) {
            *x = *y;
        }
        self.clock = self.clock.at(t);
        self.controller = Controller::default();
        (self.h, self.is_begun) = (None, false);
        (self.n_steps, self.n_gap_evaluations, self.stepper.n_rhs) = (0, 0, 0);
        if let Some(kept) = &mut self.kept {
            *kept = Kept::default();
        }
    }

    /// Evaluations of the right-hand side since the start.
    pub fn n_rhs(&self) -> usize {
        self.stepper.n_rhs
    }

    /// Whether stability, not accuracy, held the steps down.
    pub fn is_stiff(&self) -> bool {
        self.controller.is_stiff
    }

    /// The motion kept since the start.
    pub fn take_kept(&mut self) -> Option<Kept> {
        self.kept.as_mut().map(std::mem::take)
    }

    fn moment(&self) -> Moment {
        Moment {
            time: self.clock.time(),
            angle: self.frequency * self.clock.local + self.phase,
        }
    }

    fn n(&self) -> usize {
        self.dynamics.n_dof()
    }

    /// Takes the rate of the present state.
    fn begin(&mut self) -> Result<()> {
        if !self.is_begun {
            let at = self.moment();
            self.stepper.begin(self.dynamics, at, &self.x)?;
            self.is_begun = true;
        }
        Ok(())
    }

    /// A first step, from the sizes of the state, its rate and a second derivative, in units of the tolerance.
    fn first_step(&mut self, span: f64) -> Result<f64> {
        let size = |state: &Self, y: &[f64]| {
            let scaled = y.iter().zip(state.x.slice()).map(|(y, x)| {
                (y / (state.tolerance.absolute + state.tolerance.relative * x.abs())).powi(2)
            });
            (scaled.sum::<f64>() / y.len() as f64).sqrt()
        };
        let rate = self.stepper.start_rate().clone();
        let (d0, d1) = (size(self, self.x.slice()), size(self, rate.slice()));
        let trial = trial_step(d0, d1).min(span);
        let at = self.moment();
        self.stepper
            .step(self.dynamics, at, self.frequency, &self.x, trial)?;
        let change: Vec<f64> = self
            .stepper
            .end_rate()
            .slice()
            .iter()
            .zip(rate.slice())
            .map(|(a, b)| (a - b) / trial)
            .collect();
        Ok(first_step(trial, d1, size(self, &change)))
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
        let finite = times.into_iter().filter(|t| t.is_finite());
        self.h.or(finite.reduce(f64::max)).unwrap_or(1.0)
    }

    /// The gaps at the end of the step last taken, of length h.
    fn look_ahead(&mut self, h: f64) -> Result<()> {
        let n = self.n();
        let (q, v) = self.stepper.end.slice().split_at(n);
        let a = &self.stepper.end_rate().slice()[n..];
        for (value, contact) in self.ahead.iter_mut().zip(&self.contacts) {
            *value = contact.surface.along(q, v, a, h)?;
        }
        self.n_gap_evaluations += self.contacts.len();
        Ok(())
    }

    /// The earliest contact along the step last taken, as a part of the step; touches before it are noted.
    fn contact_along(&mut self, starts: Option<&[usize]>, h: f64) -> Result<Found> {
        let mut earliest: Option<(usize, f64)> = None;
        let noted = self.grazes.len();
        for stop in 0..self.contacts.len() {
            let (start, end) = (self.gaps[stop], self.ahead[stop]);
            let ends = |g: GapValue| [g.gap, g.speed, g.acceleration];
            let quintic = Quintic::hermite(ends(start), ends(end), h);
            let margin = self.margin_of(start).max(self.margin_of(end));
            let order = starts.map_or(0, |orders| orders[stop]);
            // The error of the interpolation is of the size of the step's tolerance, a tenth of the margin.
            let along = if quintic.is_clear(order, 2.0 * margin) {
                Along::Clear
            } else if order > 0 {
                quintic.after_contact(order)
            } else {
                let error = self.interpolation_error(stop, &quintic, h)?;
                self.touches.clear();
                let along = quintic.when_open(Judgement { margin, error }, &mut self.touches);
                for &(x, gap) in &self.touches {
                    self.grazes.push(Graze {
                        time: self.clock.after(x * h).time(),
                        stop,
                        depth: -gap,
                    });
                }
                along
            };
            match self.proved(stop, along, margin, h)? {
                Along::Unsure => {
                    self.grazes.truncate(noted);
                    return Ok(Found::Undecided);
                }
                Along::Contact { x } if earliest.is_none_or(|(_, first)| x < first) => {
                    earliest = Some((stop, x));
                }
                Along::Clear | Along::Contact { .. } => {}
            }
        }
        if let Some((_, x)) = earliest {
            let time = self.clock.after(x * h).time();
            let kept = self.grazes.iter().skip(noted).filter(|g| g.time < time);
            let before: Vec<Graze> = kept.copied().collect();
            self.grazes.truncate(noted);
            self.grazes.extend(before);
        }
        Ok(earliest.map_or(Found::Nothing, |(stop, x)| Found::Contact { stop, x }))
    }

    /// What the quintic of a gap says of the step last taken, put right where the gap has a bound that proves it.
    fn proved(&self, stop: usize, along: Along, margin: f64, h: f64) -> Result<Along> {
        let Some((nonlinear, curvature)) = self.contacts[stop].surface.bounded() else {
            return Ok(along);
        };
        let until = match along {
            Along::Contact { x } => x,
            Along::Clear | Along::Unsure => 1.0,
        };
        let dense = self.stepper.dense(&self.x, h);
        let path: Vec<[f64; 5]> = (0..self.n()).map(|i| dense.powers(i)).collect();
        Ok(
            match first_crossing(nonlinear, curvature, &path, margin, until)? {
                Some(x) => Along::Contact { x },
                None if along == Along::Unsure => Along::Clear,
                None => along,
            },
        )
    }

    /// The difference of the quintic to the dense output half-way.
    fn interpolation_error(&mut self, stop: usize, quintic: &Quintic, h: f64) -> Result<f64> {
        let n = self.n();
        let mut x = S::zeros(2 * n);
        self.stepper.dense(&self.x, h).state(0.5 * h, x.slice_mut());
        self.n_gap_evaluations += 1;
        let there = self.contacts[stop].surface.gap(&x.slice()[..n])?;
        Ok((there - quintic.value(0.5)).abs())
    }

    /// Steps to the contact itself: the step is taken again, its length corrected until the gap vanishes. Returns the length;
    /// the stepper's end is the state there.
    fn land(&mut self, stop: usize, guess: f64, h: f64) -> Result<f64> {
        let at = self.moment();
        let n = self.n();
        let mut s = guess;
        for _ in 0..MOST_POLISHES {
            self.stepper
                .step(self.dynamics, at, self.frequency, &self.x, s)?;
            self.look_ahead(h)?;
            let GapValue {
                gap,
                speed,
                acceleration,
                ..
            } = self.ahead[stop];
            if speed >= 0.0 {
                return Ok(s);
            }
            let first = -gap / speed;
            let correction = -gap / (speed + 0.5 * acceleration * first);
            if !correction.is_finite() {
                return Ok(s);
            }
            s += correction;
            if correction.abs() <= TAYLOR_PART * h {
                let rate = self.stepper.end_rate().clone();
                let (q, v) = self.stepper.end.slice_mut().split_at_mut(n);
                for i in 0..n {
                    let a = rate.slice()[n + i];
                    q[i] += correction * (v[i] + 0.5 * correction * a);
                    v[i] += correction * a;
                }
                return Ok(s);
            }
        }
        Ok(s)
    }

    /// Keeps what is asked for of the step last taken, of length s; `last` is the time at which the run ends with it.
    fn keep(&mut self, s: f64, last: Option<f64>, record: &mut Record) {
        let clock = self.clock;
        let wants_samples = record.wants_samples(clock.after(s).time(), last);
        if self.kept.is_none() && !wants_samples {
            return;
        }
        let dense = self.stepper.dense(&self.x, s);
        if let Some(kept) = &mut self.kept {
            kept.pieces.push(Piece { clock, span: s });
            dense.write(&mut kept.numbers);
        }
        let n = self.n();
        let mut x = S::zeros(2 * n);
        record.sample(clock, s, last, |local| {
            dense.state(local, x.slice_mut());
            let (q, v) = x.slice().split_at(n);
            (DVector::from_column_slice(q), DVector::from_column_slice(v))
        });
    }

    /// Makes the end of the step last taken the present state.
    fn arrive(&mut self, s: f64) {
        self.x.clone_from(&self.stepper.end);
        self.clock = self.clock.after(s);
    }
}

impl<S: State, D: Dynamics> Mover for StepMover<'_, S, D> {
    fn n_stops(&self) -> usize {
        self.contacts.len()
    }

    fn clock(&self) -> Clock {
        self.clock
    }

    fn look(&mut self) -> Result<()> {
        self.begin()?;
        let n = self.n();
        let (q, v) = self.x.slice().split_at(n);
        let a = &self.stepper.start_rate().slice()[n..];
        let step = self.slow_time();
        for (value, contact) in self.gaps.iter_mut().zip(&self.contacts) {
            *value = contact.surface.along(q, v, a, step)?;
        }
        self.n_gap_evaluations += self.contacts.len();
        Ok(())
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

    fn margin(&self, stop: usize) -> f64 {
        self.margin_of(self.gaps[stop])
    }

    fn contact_slack(&self) -> f64 {
        10.0 * ROUNDING
    }

    fn speed_size(&self, stop: usize) -> f64 {
        let (q, v) = self.x.slice().split_at(self.n());
        // The look before has had this normal: an error would have ended the run there.
        let normal = self.contacts[stop].surface.normal(q);
        normal.map_or(0.0, |n| n.iter().zip(v).map(|(n, v)| (n * v).abs()).sum())
    }

    fn is_coupled(&self, one: usize, other: usize) -> bool {
        let (q, _) = self.x.slice().split_at(self.n());
        let system = self.scene.system();
        // Where a function fails the stops count as coupled, which ends the run there.
        let sees = |a: &Contact, b: &Contact| match (a.surface.normal(q), b.reaction(system, q)) {
            (Ok(normal), Ok(Some(b))) => normal.dot(&b).abs() > 1e-12 * normal.norm() * b.norm(),
            _ => true,
        };
        let (a, b) = (&self.contacts[one], &self.contacts[other]);
        sees(a, b) || sees(b, a)
    }

    fn fly(
        &mut self,
        starts: &[usize],
        span: f64,
        last: f64,
        record: &mut Record,
        check: &mut dyn FnMut() -> bool,
    ) -> Result<Arrival> {
        self.grazes.clear();
        if let Some(kept) = &mut self.kept {
            kept.begin(SegmentKind::Flight, None);
        }
        let end = self.clock.after(span);
        let mut starts = Some(starts);
        let (mut halvings, mut tries) = (0, 0usize);
        let arrival = loop {
            self.begin()?;
            let left = self.clock.until(end);
            if left <= 0.0 {
                self.keep_nothing(span, last, record);
                break Arrival::End;
            }
            tries += 1;
            if tries.is_multiple_of(STEPS_PER_CHECK) && !check() {
                return Err(Error::Interrupted);
            }
            let wanted = match self.h {
                Some(h) => h,
                None => self.first_step(left)?,
            };
            // A step that would leave a crumb takes it along.
            let is_last = wanted >= 0.999 * left;
            let h = if is_last { left } else { wanted };
            if self.clock.local + h == self.clock.local {
                break Arrival::Underflow;
            }
            let at = self.moment();
            self.stepper
                .step(self.dynamics, at, self.frequency, &self.x, h)?;
            let error = self.stepper.error(&self.x, h, self.tolerance);
            let verdict = self.controller.judge(h, error);
            if !verdict.is_accepted {
                self.h = Some(verdict.next);
                continue;
            }
            self.look_ahead(h)?;
            let undecided = halvings < MOST_HALVINGS;
            let found = match self.contact_along(starts, h)? {
                Found::Undecided if undecided => {
                    halvings += 1;
                    self.h = Some(0.5 * h);
                    continue;
                }
                Found::Undecided | Found::Nothing => None,
                Found::Contact { stop, x } => Some((stop, x)),
            };
            halvings = 0;
            // A step cut short by the end says nothing about the next one.
            self.h = Some(if is_last {
                verdict.next.max(wanted)
            } else {
                verdict.next
            });
            self.controller.note_stiffness(self.stepper.stiffness(h));
            self.n_steps += 1;
            if let Some((stop, x)) = found {
                let s = self.land(stop, x * h, h)?;
                self.keep(s.max(0.0), None, record);
                self.arrive(s);
                self.is_begun = false;
                self.look()?;
                break Arrival::Contact { stop };
            }
            self.keep(h, is_last.then_some(last), record);
            self.arrive(h);
            self.stepper.go_on();
            std::mem::swap(&mut self.gaps, &mut self.ahead);
            starts = None;
            if is_last {
                break Arrival::End;
            }
        };
        if record.keep != Keep::Final {
            record.grazes.append(&mut self.grazes);
        }
        Ok(arrival)
    }

    fn stay(&mut self, record: &mut Record) -> Result<()> {
        self.begin()?;
        if let Some(kept) = &mut self.kept {
            kept.begin(SegmentKind::Flight, None);
        }
        self.keep_nothing(0.0, f64::NEG_INFINITY, record);
        Ok(())
    }

    fn strike(&mut self, stop: usize) -> Result<Blow> {
        let n = self.n();
        let contact = &self.contacts[stop];
        let (q, v) = self.x.slice_mut().split_at_mut(n);
        let normal = contact.surface.normal(q)?;
        let reaction = contact.reaction(self.scene.system(), q)?;
        let reaction = reaction.filter(|b| normal.dot(b) > 0.0);
        let Some(reaction) = reaction else {
            return Err(Error::bad_value(
                format!("stops[{stop}]"),
                "a stop without a normal",
                "at an impact its gap must change with the coordinates and its reaction must push",
            ));
        };
        let along = |v: &[f64]| normal.iter().zip(v).map(|(n, v)| n * v).sum::<f64>();
        let approach = along(v);
        let impulse = (1.0 + contact.restitution) * approach / normal.dot(&reaction);
        for (v, b) in v.iter_mut().zip(reaction.iter()) {
            *v -= b * impulse;
        }
        let departure = -along(v);
        self.is_begun = false;
        Ok(Blow {
            approach,
            departure,
            impulse,
        })
    }

    fn phase(&self) -> f64 {
        wrapped(self.frequency * self.clock.local + self.phase)
    }

    fn physical(&self) -> (DVector<f64>, DVector<f64>) {
        let (q, v) = self.x.slice().split_at(self.n());
        (DVector::from_column_slice(q), DVector::from_column_slice(v))
    }
}

impl<S: State, D: Dynamics> StepMover<'_, S, D> {
    /// Keeps a piece of no length at the present state.
    fn keep_nothing(&mut self, span: f64, last: f64, record: &mut Record) {
        self.stepper.end.clone_from(&self.x);
        let last = (span == 0.0 && last.is_finite()).then_some(last);
        self.keep(0.0, last, record);
    }
}
