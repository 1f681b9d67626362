//! The loop of a simulation: fly to the next contact, apply the impact, tell the recorder; for linear scenes with exact
//! flights (theory 8). Chatter, sticking and coupled simultaneous impacts end the run with a diagnosis.

use crate::contact::next::{Grazed, Margin, Next, Search};
use crate::contact::walk::ROUNDING;
use crate::error::{Error, Result};
use crate::flow::LinearFlow;
use crate::flow::jet::Jet;
use crate::flow::{ModalScene, along, with_flow};
use crate::impact::{Impact, wrapped};
use crate::modal::Pair;
use crate::model::Scene;
use crate::quantity::finite_vector;
use crate::simulate::clock::Clock;
use crate::simulate::trajectory::{Graze, Kept, KeptFlight};
use crate::simulate::{Keep, SimulateOptions, Stats, Status, Trajectory};
use nalgebra::{DMatrix, DVector};
use std::ops::ControlFlow;
use std::sync::Arc;

/// Evaluations of the motion spent on one impact time.
const MOST_POLISHES: usize = 12;
/// A time step this small, relative to the time in which the fastest motion turns by a radian, is added to the state to
/// first order.
const FIRST_ORDER: f64 = 1e-8;

/// Simulates a scene from `(q0, v0)` over a span of time.
///
/// A linear scene flies in closed form from impact to impact; each next impact is provably the first one, but for touches
/// inside the margin `10 (atol |n|_1 + rtol * size)`, which are listed as grazes.
///
/// # Errors
/// Arrays of the wrong length or not finite, a span that runs backwards, a start inside a stop, a nonlinear scene, a
/// motion that grows beyond the doubles.
///
/// # Examples
/// ```
/// use vibroimpact::{Kind, OrbitOptions, PaperOptions, Pattern, SimulateOptions, paper_scene, periodic_orbits, simulate};
/// let scene = paper_scene(Kind::Three, &PaperOptions::default())?;
/// let orbits = periodic_orbits(&scene, &Pattern::single(1), &OrbitOptions { n_periods: 2, ..Default::default() })?;
/// let orbit = &orbits[0];
/// let span = (0.0, 100.0 * orbit.period());
/// let trajectory = simulate(orbit.scene(), &orbit.q0(), &orbit.v0(), span, &SimulateOptions::default())?;
/// assert!((trajectory.last().0 - orbit.q0()).amax() < 1e-10);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn simulate(
    scene: &Scene,
    q0: &DVector<f64>,
    v0: &DVector<f64>,
    t_span: (f64, f64),
    options: &SimulateOptions,
) -> Result<Trajectory> {
    simulate_checked(scene, q0, v0, t_span, options, &mut |_| {
        ControlFlow::Continue(())
    })
}

/// [`simulate()`], asking `observer` from time to time, with the time reached, whether to go on.
///
/// # Errors
/// As [`simulate()`]; `Error::Interrupted` when the observer breaks off.
pub fn simulate_checked(
    scene: &Scene,
    q0: &DVector<f64>,
    v0: &DVector<f64>,
    t_span: (f64, f64),
    options: &SimulateOptions,
    observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Trajectory> {
    let modal = Arc::new(ModalScene::new(scene, "simulate")?);
    let start = t_span.0;
    finite_vector("q0", q0, scene.n_dof())?;
    finite_vector("v0", v0, scene.n_dof())?;
    options.check(t_span)?;
    let flow = Arc::new(modal.flow());
    let phase = scene.forcing().phase();
    let outcome = with_flow!(&*flow, f => {
        Run::new(f, &modal, phase, options).run(modal.form.to_modal(q0, v0), t_span, observer)
    })?;
    let last = modal.form.to_physical(&outcome.state);
    if !last.0.iter().chain(&last.1).all(|x| x.is_finite()) {
        let rule = "the motion grows beyond the largest number in it";
        return Err(Error::bad_value("t_span", format!("{t_span:?}"), rule));
    }
    Ok(Trajectory {
        scene: scene.clone(),
        last,
        modal,
        flow,
        phase,
        span: (start, outcome.end),
        kept: outcome.record.kept,
        impacts: outcome.record.impacts,
        grazes: outcome.record.grazes,
        samples: outcome.record.samples.map(Sampler::finish),
        status: outcome.status,
        message: outcome.message,
        stats: outcome.stats,
    })
}

/// The motion at the times asked for, filled in flight by flight.
struct Sampler {
    times: Vec<f64>,
    next: usize,
    q: DMatrix<f64>,
    v: DMatrix<f64>,
}

impl Sampler {
    fn new(times: &[f64], n: usize) -> Self {
        let m = times.len();
        Self {
            times: times.to_vec(),
            next: 0,
            q: DMatrix::zeros(m, n),
            v: DMatrix::zeros(m, n),
        }
    }

    /// The samples taken, fewer than asked for where the run ended early.
    fn finish(mut self) -> (Vec<f64>, DMatrix<f64>, DMatrix<f64>) {
        self.times.truncate(self.next);
        let rows = self.next;
        (
            self.times,
            self.q.resize_vertically(rows, 0.0),
            self.v.resize_vertically(rows, 0.0),
        )
    }
}

/// What is kept of a run.
struct Record {
    keep: Keep,
    kept: Option<Kept>,
    impacts: Vec<Impact>,
    grazes: Vec<Graze>,
    samples: Option<Sampler>,
}

impl Record {
    fn new(options: &SimulateOptions, n: usize) -> Self {
        Self {
            keep: options.keep,
            kept: (options.keep == Keep::Motion).then(Kept::default),
            impacts: Vec::new(),
            grazes: Vec::new(),
            samples: options.t_eval.as_ref().map(|times| Sampler::new(times, n)),
        }
    }
}

/// What a run leaves behind.
pub(crate) struct Outcome {
    record: Record,
    pub state: Vec<Pair>,
    end: f64,
    pub status: Status,
    message: String,
    pub stats: Stats,
}

/// Why a contact could not be resolved.
struct Unresolved {
    reason: String,
}

/// One run after another of the same scene, with their buffers.
pub(crate) struct Run<'a, F: LinearFlow> {
    flow: &'a F,
    scene: &'a ModalScene,
    phase: f64,
    options: &'a SimulateOptions,
    search: Search<'a, F>,
    propagator: F::Propagator,
    /// The longest time step that is added to the state to first order.
    first_order: f64,
    rate: Vec<Pair>,
    /// The order of the root of each gap at the start of the flight.
    starts: Vec<usize>,
    grazed: Vec<Grazed>,
    /// The largest size of the motion seen at each stop.
    sizes: Vec<f64>,
    max_impacts: usize,
    stats: Stats,
    record: Record,
}

impl<'a, F: LinearFlow> Run<'a, F> {
    pub fn new(
        flow: &'a F,
        scene: &'a ModalScene,
        phase: f64,
        options: &'a SimulateOptions,
    ) -> Self {
        let g = &scene.geometry;
        let rows = (0..scene.n_stops())
            .map(|i| flow.gap_row(scene.position_rows[i].clone(), g.clearances[i]))
            .collect();
        let margin = |i: usize| Margin {
            absolute: 10.0 * options.atol * g.normals.column(i).lp_norm(1),
            relative: (10.0 * options.rtol).max(10.0 * ROUNDING),
        };
        let n = scene.form.n_dof();
        Self {
            flow,
            scene,
            phase,
            options,
            search: Search::new(flow, rows, (0..scene.n_stops()).map(margin).collect()),
            propagator: F::Propagator::default(),
            first_order: FIRST_ORDER / scene.fastest_rate().max(1.0 / flow.longest_step()),
            rate: vec![[0.0; 2]; n],
            starts: vec![0; scene.n_stops()],
            grazed: Vec::new(),
            sizes: vec![0.0; scene.n_stops()],
            max_impacts: options.max_impacts.unwrap_or(usize::MAX),
            stats: Stats::default(),
            record: Record::new(options, n),
        }
    }

    /// As new, but for the buffers.
    fn restart(&mut self) {
        self.search.restart();
        self.starts.fill(0);
        self.sizes.fill(0.0);
        self.stats = Stats::default();
        self.record = Record::new(self.options, self.scene.form.n_dof());
    }

    fn phasor(&self, clock: Clock) -> F::Phasor {
        self.flow
            .phasor(self.scene.frequency * clock.local + self.phase)
    }

    /// A run from a state in modal pairs.
    pub fn run(
        &mut self,
        mut state: Vec<Pair>,
        (t0, t_end): (f64, f64),
        observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<Outcome> {
        self.restart();
        let mut clock = Clock::new(t0, self.scene.frequency, 8.0 * self.flow.longest_step());
        let end = clock.at(t_end);
        if let Err(unresolved) = self.begin(clock, &mut state)? {
            return Ok(self.finish(state, t0, Err(unresolved)));
        }
        loop {
            if self.stats.n_impacts >= self.max_impacts {
                return Ok(self.finish(state, clock.time(), Ok(Status::MaxImpacts)));
            }
            if observer(clock.time()).is_break() {
                return Err(Error::Interrupted);
            }
            let span = clock.until(end).max(0.0);
            let u = self.phasor(clock);
            self.stats.n_flights += 1;
            self.grazed.clear();
            let mut check = || observer(clock.time()).is_continue();
            let next =
                self.search
                    .next(&state, u, &self.starts, span, &mut self.grazed, &mut check);
            match next {
                Next::Interrupted => return Err(Error::Interrupted),
                Next::End => return Ok(self.arrive(clock, span, state, t_end)),
                Next::Stalled { stop, time } => {
                    let stalled = clock.after(time).time();
                    self.keep_flight(clock, time, &state, Some(stalled));
                    self.forward(&mut state, u, time);
                    let reason = format!(
                        "the gap to stop {stop} stays within rounding of zero: sustained contact"
                    );
                    return Ok(self.finish(
                        state,
                        clock.after(time).time(),
                        Err(Unresolved { reason }),
                    ));
                }
                Next::Contact { stop, time } => {
                    let mut arrived = state.clone();
                    let (stop, time) = self.first(stop, time, &state, &mut arrived, clock);
                    if time > span {
                        return Ok(self.arrive(clock, span, state, t_end));
                    }
                    self.keep_flight(clock, time, &state, None);
                    state.clone_from(&arrived);
                    clock = clock.after(time);
                    if let Err(unresolved) = self.collide(stop, clock, &mut state) {
                        return Ok(self.finish(state, clock.time(), Err(unresolved)));
                    }
                }
            }
        }
    }

    /// The last flight, to the end of the run.
    fn arrive(&mut self, clock: Clock, span: f64, mut state: Vec<Pair>, t_end: f64) -> Outcome {
        self.grazed.retain(|g| g.time <= span);
        self.keep_flight(clock, span, &state, Some(t_end));
        let u = self.phasor(clock);
        self.forward(&mut state, u, span);
        self.finish(state, t_end, Ok(Status::Finished))
    }

    fn forward(&mut self, state: &mut [Pair], mut u: F::Phasor, span: f64) {
        self.flow.prepare(span, &mut self.propagator);
        self.flow.advance(&self.propagator, state, &mut u);
    }

    /// The start: contacts there are judged by the sign of their velocity.
    fn begin(
        &mut self,
        clock: Clock,
        state: &mut [Pair],
    ) -> Result<std::result::Result<(), Unresolved>> {
        let u = self.phasor(clock);
        let jets = self.search.jets(state, u).to_vec();
        let mut touching = Vec::new();
        for (i, jet) in jets.iter().enumerate() {
            let margin = self.search.margin(i, jet);
            if jet.c[0] < -margin {
                let rule =
                    format!("it starts inside stop {i}, by more than the margin {margin:.3e}");
                return Err(Error::bad_value(
                    format!("q0 with a gap of {:.6e}", jet.c[0]),
                    "penetration",
                    rule,
                ));
            }
            // A gap that is open, however little, is flown through: a run cut just before a contact goes on as one.
            if jet.c[0] <= 10.0 * ROUNDING * jet.size {
                touching.push(i);
            }
        }
        let closing: Vec<usize> = touching
            .iter()
            .copied()
            .filter(|&i| jets[i].c[1] < 0.0)
            .collect();
        if !closing.is_empty() {
            // A flight of no length has the state before the impact.
            self.keep_flight(clock, 0.0, state, None);
            return Ok(self.collide_all(&closing, &touching, &jets, clock, state));
        }
        Ok(self.release(&touching, clock, state))
    }

    /// The impact time to rounding: the motion is taken again from the start of the flight until Newton's step vanishes.
    /// On return `arrived` is the state there, before the impact.
    fn polish(
        &mut self,
        stop: usize,
        guess: f64,
        start: &[Pair],
        arrived: &mut [Pair],
        clock: Clock,
    ) -> f64 {
        let mut time = guess.max(0.0);
        for _ in 0..MOST_POLISHES {
            arrived.copy_from_slice(start);
            let mut u = self.phasor(clock);
            self.flow.prepare(time, &mut self.propagator);
            self.flow.advance(&self.propagator, arrived, &mut u);
            let jet = self.search.jets(arrived, u)[stop];
            let step = newton_step(&jet);
            if step.abs() <= self.first_order.max(2.0 * f64::EPSILON * time) {
                self.flow.rate(arrived, u, &mut self.rate);
                for (z, r) in arrived.iter_mut().zip(&self.rate) {
                    *z = [z[0] + step * r[0], z[1] + step * r[1]];
                }
                return (time + step).max(0.0);
            }
            time = (time + step).max(0.0);
        }
        time
    }

    /// The contact that comes first and its time to rounding. The search has ordered the contacts of one step to the accuracy
    /// of a cubic: a stop that is passed at the time of the one it names was reached before.
    fn first(
        &mut self,
        mut stop: usize,
        guess: f64,
        start: &[Pair],
        arrived: &mut Vec<Pair>,
        clock: Clock,
    ) -> (usize, f64) {
        let mut time = self.polish(stop, guess, start, arrived, clock);
        for _ in 1..self.scene.n_stops() {
            let u = self.phasor(clock.after(time));
            let jets = self.search.jets(arrived, u);
            let is_passed = |jet: &Jet| jet.c[0] < -10.0 * ROUNDING * jet.size && jet.c[1] < 0.0;
            let earlier = (0..jets.len())
                .filter(|&i| i != stop && is_passed(&jets[i]))
                .map(|i| (i, time - jets[i].c[0] / jets[i].c[1]))
                .min_by(|a, b| a.1.total_cmp(&b.1));
            let Some((other, guess)) = earlier else { break };
            let mut there = start.to_vec();
            let reached = self.polish(other, guess, start, &mut there, clock);
            if reached >= time {
                break;
            }
            (stop, time) = (other, reached);
            *arrived = there;
        }
        (stop, time)
    }

    /// An impact of a stop that was reached, with whatever other stops are reached at the same instant.
    fn collide(
        &mut self,
        stop: usize,
        clock: Clock,
        state: &mut [Pair],
    ) -> std::result::Result<(), Unresolved> {
        let u = self.phasor(clock);
        let jets = self.search.jets(state, u).to_vec();
        let touches = |i: usize| i == stop || jets[i].c[0] <= 10.0 * ROUNDING * jets[i].size;
        let touching: Vec<usize> = (0..jets.len()).filter(|&i| touches(i)).collect();
        let closing: Vec<usize> = touching
            .iter()
            .copied()
            .filter(|&i| jets[i].c[1] < 0.0)
            .collect();
        self.collide_all(&closing, &touching, &jets, clock, state)
    }

    fn collide_all(
        &mut self,
        closing: &[usize],
        touching: &[usize],
        jets: &[Jet],
        clock: Clock,
        state: &mut [Pair],
    ) -> std::result::Result<(), Unresolved> {
        let g = &self.scene.geometry;
        for &i in closing {
            for &j in touching.iter().filter(|&&j| j != i) {
                if g.is_coupled(i, j) {
                    let reason = format!(
                        "stops {i} and {j} are in contact at one instant and coupled by inertia"
                    );
                    return Err(Unresolved { reason });
                }
            }
        }
        for &i in closing {
            let approach = -jets[i].c[1];
            let e = g.restitutions[i];
            let impulse = (1.0 + e) * approach / g.normals.column(i).dot(&g.reactions.column(i));
            for (z, jump) in state.iter_mut().zip(&self.scene.jumps[i]) {
                *z = [z[0] - jump[0] * impulse, z[1] - jump[1] * impulse];
            }
            self.stats.n_impacts += 1;
            if self.record.keep != Keep::Final {
                self.record.impacts.push(Impact {
                    time: clock.time(),
                    stop: i,
                    approach,
                    departure: -along(&self.scene.velocity_rows[i], state),
                    impulse,
                    phase: wrapped(self.scene.frequency * clock.local + self.phase),
                });
            }
        }
        self.release(touching, clock, state)
    }

    /// The order of each touching gap's root at the start of the flight, or why it does not open.
    fn release(
        &mut self,
        touching: &[usize],
        clock: Clock,
        state: &[Pair],
    ) -> std::result::Result<(), Unresolved> {
        self.starts.fill(0);
        if self.starts.is_empty() {
            return Ok(());
        }
        let u = self.phasor(clock);
        let jets = self.search.jets(state, u);
        for (size, jet) in self.sizes.iter_mut().zip(&*jets) {
            *size = size.max(jet.size).max(apex(jet));
        }
        if touching.is_empty() {
            return Ok(());
        }
        for &i in touching {
            let jet = jets[i];
            // An inelastic impact leaves a normal velocity of rounding size, which is none.
            let is_still = jet.c[1].abs() <= ROUNDING * speed_size(self.scene, i, state);
            self.starts[i] = match (is_still, jet.c[2], jet.c[3]) {
                (false, acceleration, _) if jet.c[1] > 0.0 => {
                    if acceleration < 0.0 && apex(&jet) < 10.0 * ROUNDING * self.sizes[i] {
                        let reason = format!("the impacts on stop {i} accumulate: chatter");
                        return Err(Unresolved { reason });
                    }
                    1
                }
                (true, acceleration, _) if acceleration > 0.0 => 2,
                (true, 0.0, jerk) if jerk > 0.0 => 3,
                _ => {
                    return Err(Unresolved {
                        reason: format!("the motion stays on stop {i}: sticking"),
                    });
                }
            };
        }
        Ok(())
    }

    /// A graze with its time and depth to rounding.
    fn sharpened(&mut self, grazed: Grazed, clock: Clock, start: &[Pair]) -> Graze {
        let Grazed {
            stop,
            mut time,
            mut gap,
        } = grazed;
        for _ in 0..2 {
            let mut there = start.to_vec();
            let mut u = self.phasor(clock);
            self.flow.prepare(time, &mut self.propagator);
            self.flow.advance(&self.propagator, &mut there, &mut u);
            let jet = self.search.jets(&there, u)[stop];
            if jet.c[2] > 0.0 {
                let step = -0.5 * jet.c[1] / jet.c[2];
                gap = jet.value(step);
                time += step;
            }
        }
        Graze {
            time: clock.after(time).time(),
            stop,
            depth: -gap,
        }
    }

    /// Keeps what is asked for of a flight; `last` is the time at which the run ends with it.
    fn keep_flight(&mut self, clock: Clock, span: f64, state: &[Pair], last: Option<f64>) {
        if self.record.keep != Keep::Final {
            for i in 0..self.grazed.len() {
                let graze = self.sharpened(self.grazed[i], clock, state);
                self.record.grazes.push(graze);
            }
        }
        if let Some(kept) = &mut self.record.kept {
            kept.flights.push(KeptFlight { clock, span });
            kept.states.extend_from_slice(state);
        }
        let Some(samples) = &mut self.record.samples else {
            return;
        };
        let end = clock.after(span).time();
        while let Some(&t) = samples
            .times
            .get(samples.next)
            .filter(|&&t| t < end || last.is_some_and(|last| t <= last))
        {
            let local = clock.until(clock.at(t)).clamp(0.0, span);
            let mut there = state.to_vec();
            let mut u = self
                .flow
                .phasor(self.scene.frequency * clock.local + self.phase);
            self.flow.prepare(local, &mut self.propagator);
            self.flow.advance(&self.propagator, &mut there, &mut u);
            let (q, v) = self.scene.form.to_physical(&there);
            samples.q.set_row(samples.next, &q.transpose());
            samples.v.set_row(samples.next, &v.transpose());
            samples.next += 1;
        }
    }

    fn finish(
        &mut self,
        state: Vec<Pair>,
        end: f64,
        ended: std::result::Result<Status, Unresolved>,
    ) -> Outcome {
        self.stats.n_gap_evaluations = self.search.n_gap_evaluations;
        let (status, message) = match ended {
            Ok(Status::MaxImpacts) => (
                Status::MaxImpacts,
                format!(
                    "stopped after {} impacts at t = {end}",
                    self.stats.n_impacts
                ),
            ),
            Ok(status) => (
                status,
                format!("reached t = {end} with {} impacts", self.stats.n_impacts),
            ),
            Err(unresolved) => (
                Status::UnresolvedContact,
                format!("at t = {end}: {}", unresolved.reason),
            ),
        };
        let record = std::mem::replace(&mut self.record, Record::new(self.options, 0));
        Outcome {
            record,
            state,
            end,
            status,
            message,
            stats: self.stats,
        }
    }
}

/// The height that a gap which opens against its acceleration reaches; zero for one that is not drawn back.
fn apex(jet: &Jet) -> f64 {
    if jet.c[1] > 0.0 && jet.c[2] < 0.0 {
        0.25 * jet.c[1] * jet.c[1] / -jet.c[2]
    } else {
        0.0
    }
}

/// Size of the terms of a normal velocity.
fn speed_size(scene: &ModalScene, stop: usize, state: &[Pair]) -> f64 {
    let row = &scene.velocity_rows[stop];
    row.iter()
        .zip(state)
        .map(|(r, z)| (r[0] * z[0]).abs() + (r[1] * z[1]).abs())
        .sum()
}

/// The step to the zero of a falling gap, by Newton's method on its cubic.
fn newton_step(jet: &Jet) -> f64 {
    let [a, b, c, d] = jet.c;
    if b >= 0.0 {
        return 0.0;
    }
    let mut r = -a / b;
    for _ in 0..3 {
        let slope = b + r * (2.0 * c + 3.0 * r * d);
        if slope < 0.0 {
            r -= jet.value(r) / slope;
        }
    }
    r
}
