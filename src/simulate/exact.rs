//! Exact flights: a linear scene moved in closed form from contact to contact (theory 8).

use crate::contact::next::{Grazed, Margin, Next, Search};
use crate::contact::walk::ROUNDING;
use crate::error::{Error, Result};
use crate::flow::jet::Jet;
use crate::flow::{GapRow, LinearFlow, ModalScene, Quantity, StuckMotion, along, with_flow};
use crate::impact::wrapped;
use crate::modal::Pair;
use crate::model::along_reactions;
use crate::quantity::positive_part;
use crate::simulate::clock::Clock;
use crate::simulate::kept::{Kept, Piece, SegmentKind};
use crate::simulate::mover::{Arrival, Blow, GapState, Mover};
use crate::simulate::record::Record;
use crate::simulate::trajectory::Graze;
use crate::simulate::{Keep, SimulateOptions, Stats};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// A linear scene in motion; one run after another, with its buffers.
pub(crate) struct ExactMover<'a, F: LinearFlow> {
    flow: &'a F,
    scene: &'a ModalScene,
    /// The forcing phase at time zero.
    phase: f64,
    search: Search<'a, F>,
    /// The rows of the normal velocities on the flow's state.
    velocity_rows: Vec<Vec<Pair>>,
    /// `(1 + e)/(n.b)` of each stop.
    rebounds: Vec<f64>,
    clock: Clock,
    state: Vec<Pair>,
    arrived: Vec<Pair>,
    grazed: Vec<Grazed>,
    kept: Option<Kept>,
    margins: Vec<Margin>,
    /// The motions while stops are held, made when first needed.
    held: Vec<Arc<StuckMotion>>,
    /// The one that holds now.
    holding: Option<Arc<StuckMotion>>,
}

/// A contact force at zero for good: its first derivatives are this small, relative to its terms and the fastest rate.
const FLAT: f64 = 1e-12;

impl<'a, F: LinearFlow> ExactMover<'a, F> {
    /// A mover of a scene along its flow; `phase` is the forcing phase at time zero.
    pub fn new(flow: &'a F, scene: &'a ModalScene, phase: f64, options: &SimulateOptions) -> Self {
        let g = &scene.geometry;
        let stops = 0..scene.n_stops();
        let gaps = stops
            .clone()
            .map(|i| flow.gap_row(&Quantity::gap(g.clearances[i], &scene.position_rows[i])));
        let margins = stops.clone().map(|i| Margin {
            absolute: 10.0 * options.atol * g.normals.column(i).lp_norm(1),
            relative: (10.0 * options.rtol).max(10.0 * ROUNDING),
        });
        let margins: Vec<Margin> = margins.collect();
        let rebound =
            |i: usize| (1.0 + g.restitutions[i]) / g.normals.column(i).dot(&g.reactions.column(i));
        Self {
            flow,
            scene,
            phase,
            search: Search::new(flow, gaps.collect(), margins.clone()),
            margins,
            held: Vec::new(),
            holding: None,
            velocity_rows: scene
                .velocity_rows
                .iter()
                .map(|row| flow.velocity_row(row))
                .collect(),
            rebounds: stops.map(rebound).collect(),
            clock: Clock::new(0.0, scene.frequency, 8.0 * flow.longest_step()),
            state: Vec::new(),
            arrived: Vec::new(),
            grazed: Vec::new(),
            kept: (options.keep == Keep::Motion).then(Kept::default),
        }
    }

    fn angle(&self, clock: Clock) -> f64 {
        self.scene.frequency * clock.local + self.phase
    }

    /// Whether a time from now is no later than the end of the run, as the doubles that a user sees.
    fn is_within(&self, time: f64, last: f64) -> bool {
        self.clock.after(time).time() <= last
    }

    fn whole(&self, state: &[Pair]) -> Vec<Pair> {
        let mut whole = Vec::with_capacity(state.len());
        self.flow.leave(state, &mut whole);
        whole
    }

    /// Keeps what is asked for of a flight from the present state; `last` is the time at which the run ends with it.
    fn keep(&mut self, span: f64, last: Option<f64>, record: &mut Record) {
        if record.keep != Keep::Final {
            for i in 0..self.grazed.len() {
                let graze = self.sharpened(self.grazed[i]);
                record.grazes.push(graze);
            }
        }
        self.keep_piece(SegmentKind::Flight, &[], span);
        let Self {
            search,
            state,
            scene,
            flow,
            clock,
            ..
        } = self;
        let mut whole = Vec::new();
        record.sample(*clock, span, last, |local| {
            let mut there = state.clone();
            search.forward(&mut there, local);
            flow.leave(&there, &mut whole);
            scene.form.to_physical(&whole)
        });
    }

    /// Keeps a segment of one piece from the present state.
    fn keep_piece(&mut self, kind: SegmentKind, stops: &[usize], span: f64) {
        if self.kept.is_none() {
            return;
        }
        let whole = self.whole(&self.state);
        if let Some(kept) = &mut self.kept {
            let clock = self.clock;
            kept.begin(kind, stops);
            kept.pieces.push(Piece { clock, span });
            kept.numbers.extend(whole.iter().flatten());
        }
    }

    /// Puts the present state at a position and velocity, a time later.
    fn put(&mut self, (q, v): (&DVector<f64>, &DVector<f64>), span: f64) {
        self.clock = self.clock.after(span);
        let angle = self.angle(self.clock);
        self.flow
            .enter(&self.scene.form.to_modal(q, v), angle, &mut self.state);
    }

    /// The present position and velocity, moved onto some stops along their reactions: what is left of an impact that comes to
    /// rest is taken as impacts take it, not along the normals.
    fn settled(&self, stops: &[usize]) -> Result<(DVector<f64>, DVector<f64>)> {
        let (mut q, mut v) = self.physical();
        let g = &self.scene.geometry;
        let (normals, reactions) = g.directions(stops);
        let parts = |of: &dyn Fn(usize) -> f64| DVector::from_fn(stops.len(), |i, _| of(i));
        let gaps = parts(&|i| g.clearances[stops[i]] - normals[i].dot(&q));
        let speeds = parts(&|i| normals[i].dot(&v));
        q += along_reactions(&normals, &reactions, &gaps)?;
        v -= along_reactions(&normals, &reactions, &speeds)?;
        Ok((q, v))
    }

    /// The motion while the given stops are held.
    fn motion_of(&mut self, stops: &[usize]) -> Result<Arc<StuckMotion>> {
        if let Some(known) = self.held.iter().find(|h| h.stops == stops) {
            return Ok(Arc::clone(known));
        }
        let motion = Arc::new(StuckMotion::new(self.scene, stops)?);
        self.held.push(Arc::clone(&motion));
        Ok(motion)
    }

    /// A segment in which stops are held: to a contact of another, to a release, or over the whole span.
    fn fly_held<H: LinearFlow>(
        &mut self,
        flow: &H,
        motion: &StuckMotion,
        starts: &[usize],
        span: f64,
        last: f64,
        record: &mut Record,
        check: &mut dyn FnMut() -> bool,
    ) -> Result<Arrival> {
        let (q, v) = self.physical();
        let angle = self.angle(self.clock);
        let mut state = Vec::new();
        flow.enter(&motion.reduce(&q, &v), angle, &mut state);
        let events = Events::new(flow, motion, &state);
        let rows: Vec<GapRow> = events.list.iter().map(|(_, row)| row.clone()).collect();
        let margins = events.list.iter().map(|(event, _)| match event {
            Event::Release(_) => Margin {
                absolute: 0.0,
                relative: 10.0 * ROUNDING,
            },
            Event::Contact(stop) => self.margins[*stop],
        });
        let mut search = Search::new(flow, rows, margins.collect());
        search.look(&state);
        let orders: Vec<usize> = events
            .list
            .iter()
            .zip(search.jets())
            .map(|((event, _), jet)| match event {
                Event::Release(_) => order_of_zero(jet, flow.fastest_rate()),
                Event::Contact(stop) => starts[*stop],
            })
            .collect();
        self.grazed.clear();
        let (event, time) = match search.next(&state, &orders, span, &mut self.grazed, check) {
            Next::Interrupted => return Err(Error::Interrupted),
            Next::End => (None, span),
            Next::Stalled { stop, time } => (Some(events.list[stop].0), time),
            Next::Contact { stop, time } => {
                let mut arrived = Vec::new();
                let (stop, time) = search.arrive(stop, time, &state, &mut arrived);
                if self.is_within(time, last) {
                    (Some(events.list[stop].0), time)
                } else {
                    (None, span)
                }
            }
        };
        self.search.n_gap_evaluations += search.n_gap_evaluations;
        let last = event.is_none().then_some(last);
        self.grazed.clear();
        self.keep_piece(SegmentKind::Stick, &motion.stops, time);
        let mut whole = Vec::new();
        let mut at = |local: f64| {
            let mut there = state.clone();
            search.forward(&mut there, local);
            flow.leave(&there, &mut whole);
            motion.lift(&whole)
        };
        record.sample(self.clock, time, last, &mut at);
        let (q, v) = at(time);
        self.put((&q, &v), time);
        self.look()?;
        Ok(match event {
            None => Arrival::End,
            Some(Event::Release(stop)) => Arrival::Release { stop },
            Some(Event::Contact(stop)) => Arrival::Contact { stop },
        })
    }

    /// A graze with its time and depth to rounding.
    fn sharpened(&mut self, grazed: Grazed) -> Graze {
        let Grazed {
            stop,
            mut time,
            mut gap,
        } = grazed;
        for _ in 0..2 {
            let mut there = self.state.clone();
            self.search.forward(&mut there, time);
            let jet = self.search.look(&there)[stop];
            if jet.c[2] > 0.0 {
                let step = -0.5 * jet.c[1] / jet.c[2];
                gap = jet.value(step);
                time += step;
            }
        }
        Graze {
            time: self.clock.after(time).time(),
            stop,
            depth: -gap,
        }
    }

    /// Goes to a later time of the present flight.
    fn go(&mut self, span: f64) {
        self.search.forward(&mut self.state, span);
        self.clock = self.clock.after(span);
        let angle = self.angle(self.clock);
        self.flow.set_angle(&mut self.state, angle);
    }
}

impl<F: LinearFlow> Mover for ExactMover<'_, F> {
    fn start(&mut self, q: &DVector<f64>, v: &DVector<f64>, t: f64) {
        self.search.restart();
        self.holding = None;
        self.clock = self.clock.at(t);
        let angle = self.angle(self.clock);
        let whole = self.scene.form.to_modal(q, v);
        self.flow.enter(&whole, angle, &mut self.state);
        if let Some(kept) = &mut self.kept {
            *kept = Kept::default();
        }
    }

    fn counted(&self, stats: Stats) -> Stats {
        Stats {
            n_gap_evaluations: self.search.n_gap_evaluations,
            ..stats
        }
    }

    fn remarks(&self) -> String {
        String::new()
    }

    fn take_kept(&mut self) -> Option<Kept> {
        self.kept.as_mut().map(std::mem::take)
    }

    fn held_motions(&self) -> Vec<Arc<StuckMotion>> {
        self.held.clone()
    }

    fn n_stops(&self) -> usize {
        self.scene.n_stops()
    }

    fn clock(&self) -> Clock {
        self.clock
    }

    fn look(&mut self) -> Result<()> {
        self.search.look(&self.state);
        Ok(())
    }

    fn gap(&self, stop: usize) -> GapState {
        let jet = self.search.jets()[stop];
        GapState {
            gap: jet.c[0],
            speed: jet.c[1],
            acceleration: 2.0 * jet.c[2],
            jerk: 6.0 * jet.c[3],
            size: jet.size,
        }
    }

    fn margin(&self, stop: usize, size: f64) -> f64 {
        self.margins[stop].absolute + self.margins[stop].relative * size
    }

    fn speed_size(&self, stop: usize) -> f64 {
        let row = &self.velocity_rows[stop];
        row.iter()
            .zip(&self.state)
            .map(|(r, z)| (r[0] * z[0]).abs() + (r[1] * z[1]).abs())
            .sum()
    }

    fn is_coupled(&self, one: usize, other: usize) -> bool {
        self.scene.geometry.is_coupled(one, other)
    }

    fn fly(
        &mut self,
        starts: &[usize],
        span: f64,
        last: f64,
        record: &mut Record,
        check: &mut dyn FnMut() -> bool,
    ) -> Result<Arrival> {
        if let Some(motion) = self.holding.clone() {
            return with_flow!(&motion.flow, f => {
                self.fly_held(f, &motion, starts, span, last, record, check)
            });
        }
        self.grazed.clear();
        let next = self
            .search
            .next(&self.state, starts, span, &mut self.grazed, check);
        match next {
            Next::Interrupted => return Err(Error::Interrupted),
            Next::End => {}
            Next::Stalled { stop, time } => {
                self.keep(time, None, record);
                self.go(time);
                return Ok(Arrival::Stalled { stop });
            }
            Next::Contact { stop, time } => {
                let (stop, time) = self
                    .search
                    .arrive(stop, time, &self.state, &mut self.arrived);
                if self.is_within(time, last) {
                    self.keep(time, None, record);
                    self.clock = self.clock.after(time);
                    std::mem::swap(&mut self.state, &mut self.arrived);
                    let angle = self.angle(self.clock);
                    self.flow.set_angle(&mut self.state, angle);
                    return Ok(Arrival::Contact { stop });
                }
            }
        }
        self.grazed.retain(|g| g.time <= span);
        self.keep(span, Some(last), record);
        self.go(span);
        Ok(Arrival::End)
    }

    fn stay(&mut self, last: Option<f64>, record: &mut Record) -> Result<()> {
        self.grazed.clear();
        self.keep(0.0, last, record);
        Ok(())
    }

    fn strike(&mut self, stop: usize) -> Result<Blow> {
        let row = &self.velocity_rows[stop];
        let approach = positive_part(along(row, &self.state));
        let impulse = self.rebounds[stop] * approach;
        self.push(stop, impulse)?;
        Ok(Blow {
            approach,
            departure: self.scene.geometry.restitutions[stop] * approach,
            impulse,
        })
    }

    fn delassus(&self, stops: &[usize]) -> Result<DMatrix<f64>> {
        let g = &self.scene.geometry;
        let normals = g.normals.select_columns(stops);
        Ok(normals.tr_mul(&g.reactions.select_columns(stops)))
    }

    fn push(&mut self, stop: usize, impulse: f64) -> Result<()> {
        for (z, jump) in self.state.iter_mut().zip(&self.scene.jumps[stop]) {
            *z = [z[0] - jump[0] * impulse, z[1] - jump[1] * impulse];
        }
        Ok(())
    }

    fn restitution(&self, stop: usize) -> f64 {
        self.scene.geometry.restitutions[stop]
    }

    fn accumulate(&mut self, stop: usize, record: &mut Record) -> Result<()> {
        self.look()?;
        let GapState {
            speed,
            acceleration,
            ..
        } = self.gap(stop);
        let e = self.restitution(stop);
        let part = speed / (1.0 - e);
        let span = 2.0 * e * part / acceleration;
        let motion = self.motion_of(&[stop])?;
        self.keep_piece(SegmentKind::Chatter, &[stop], span);
        let (q, v) = self.physical();
        let angle = self.angle(self.clock);
        record.sample(self.clock, span, None, |local| {
            motion.carry(angle, local, &q, &v)
        });
        // Y* = Y + ((2e/a) (f, 1) + (W, 0)) h'/(1 - e)
        let (drift, kick) = (2.0 * e / acceleration * part, self.rebounds[stop] * part);
        let rates = self.search.derivatives().iter().map(|d| d.d1);
        for (z, d) in self.state.iter_mut().zip(rates) {
            *z = [z[0] + drift * d[0], z[1] + drift * d[1]];
        }
        for (z, jump) in self.state.iter_mut().zip(&self.scene.jumps[stop]) {
            *z = [z[0] + kick * jump[0], z[1] + kick * jump[1]];
        }
        self.clock = self.clock.after(span);
        let angle = self.angle(self.clock);
        self.flow.set_angle(&mut self.state, angle);
        let (q, v) = self.settled(&[stop])?;
        self.put((&q, &v), 0.0);
        self.look()
    }

    fn hold(&mut self, stops: &[usize]) -> Result<()> {
        if stops.is_empty() {
            self.holding = None;
            return Ok(());
        }
        let motion = self.motion_of(stops)?;
        let (q, v) = self.settled(stops)?;
        let (q, v) = motion.lift(&motion.reduce(&q, &v));
        self.put((&q, &v), 0.0);
        self.holding = Some(motion);
        self.look()
    }

    fn phase(&self) -> f64 {
        wrapped(self.angle(self.clock))
    }

    fn physical(&self) -> (DVector<f64>, DVector<f64>) {
        self.scene.form.to_physical(&self.whole(&self.state))
    }
}

/// What can end a segment in which stops are held.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Event {
    Release(usize),
    Contact(usize),
}

/// What is watched while stops are held.
struct Events {
    list: Vec<(Event, GapRow)>,
}

impl Events {
    /// The contact forces and the gaps that can change, but for forces that are zero for good.
    fn new<H: LinearFlow>(flow: &H, motion: &StuckMotion, state: &[Pair]) -> Self {
        let forces = motion.stops.iter().zip(&motion.forces);
        let forces = forces.map(|(&stop, force)| (Event::Release(stop), flow.gap_row(force)));
        let gaps = motion.gaps.iter().enumerate().filter_map(|(stop, gap)| {
            let gap = gap.as_ref()?;
            Some((Event::Contact(stop), flow.gap_row(gap)))
        });
        let mut derivatives = Vec::new();
        flow.derivatives(state, &mut derivatives);
        let rate = flow.fastest_rate();
        let is_flat = |jet: &Jet| order_of_zero(jet, rate) > 3;
        let list = forces.chain(gaps).filter(|(event, row)| {
            !(matches!(event, Event::Release(_)) && is_flat(&row.jet(&derivatives)))
        });
        Self {
            list: list.collect(),
        }
    }
}

/// The number of leading derivatives of a contact force that are zero.
fn order_of_zero(jet: &Jet, rate: f64) -> usize {
    let mut scale = FLAT * jet.size;
    for (k, c) in jet.c.iter().enumerate() {
        if c.abs() > scale {
            return k;
        }
        scale *= rate;
    }
    4
}
