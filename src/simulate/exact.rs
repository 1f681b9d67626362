//! Exact flights: a linear scene moved in closed form from contact to contact (theory 8).

use crate::contact::next::{Grazed, Margin, Next, Search};
use crate::contact::walk::ROUNDING;
use crate::error::{Error, Result};
use crate::flow::{LinearFlow, ModalScene, along};
use crate::impact::wrapped;
use crate::modal::Pair;
use crate::quantity::positive_part;
use crate::simulate::clock::Clock;
use crate::simulate::kept::{Kept, Piece, SegmentKind};
use crate::simulate::mover::{Arrival, Blow, GapState, Mover};
use crate::simulate::record::Record;
use crate::simulate::trajectory::Graze;
use crate::simulate::{Keep, SimulateOptions};
use nalgebra::DVector;

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
}

impl<'a, F: LinearFlow> ExactMover<'a, F> {
    /// A mover of a scene along its flow; `phase` is the forcing phase at time zero.
    pub fn new(flow: &'a F, scene: &'a ModalScene, phase: f64, options: &SimulateOptions) -> Self {
        let g = &scene.geometry;
        let stops = 0..scene.n_stops();
        let gaps = stops
            .clone()
            .map(|i| flow.gap_row(&scene.position_rows[i], g.clearances[i]));
        let margins = stops.clone().map(|i| Margin {
            absolute: 10.0 * options.atol * g.normals.column(i).lp_norm(1),
            relative: (10.0 * options.rtol).max(10.0 * ROUNDING),
        });
        let rebound =
            |i: usize| (1.0 + g.restitutions[i]) / g.normals.column(i).dot(&g.reactions.column(i));
        Self {
            flow,
            scene,
            phase,
            search: Search::new(flow, gaps.collect(), margins.collect()),
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

    /// Puts the mover at a state in modal pairs and a time, as new.
    pub fn start(&mut self, whole: &[Pair], t: f64) {
        self.search.restart();
        self.clock = self.clock.at(t);
        let angle = self.angle(self.clock);
        self.flow.enter(whole, angle, &mut self.state);
        if let Some(kept) = &mut self.kept {
            *kept = Kept::default();
        }
    }

    /// Evaluations of gaps since the start.
    pub fn n_gap_evaluations(&self) -> usize {
        self.search.n_gap_evaluations
    }

    /// The motion kept since the start.
    pub fn take_kept(&mut self) -> Option<Kept> {
        self.kept.as_mut().map(std::mem::take)
    }

    fn angle(&self, clock: Clock) -> f64 {
        self.scene.frequency * clock.local + self.phase
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
        if self.kept.is_some() {
            let whole = self.whole(&self.state);
            if let Some(kept) = &mut self.kept {
                let clock = self.clock;
                kept.begin(SegmentKind::Flight, None);
                kept.pieces.push(Piece { clock, span });
                kept.numbers.extend(whole.iter().flatten());
            }
        }
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

    fn margin(&self, stop: usize) -> f64 {
        self.search.margin(stop, &self.search.jets()[stop])
    }

    fn contact_slack(&self) -> f64 {
        10.0 * ROUNDING
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
        self.grazed.clear();
        let next = self
            .search
            .next(&self.state, starts, span, &mut self.grazed, check);
        match next {
            Next::Interrupted => return Err(Error::Interrupted),
            Next::End => {}
            Next::Stalled { stop, time } => {
                let stalled = self.clock.after(time).time();
                self.keep(time, Some(stalled), record);
                self.go(time);
                return Ok(Arrival::Stalled { stop });
            }
            Next::Contact { stop, time } => {
                let (stop, time) = self
                    .search
                    .arrive(stop, time, &self.state, &mut self.arrived);
                if time <= span {
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

    fn stay(&mut self, record: &mut Record) -> Result<()> {
        self.grazed.clear();
        self.keep(0.0, None, record);
        Ok(())
    }

    fn strike(&mut self, stop: usize) -> Result<Blow> {
        let row = &self.velocity_rows[stop];
        let approach = positive_part(along(row, &self.state));
        let impulse = self.rebounds[stop] * approach;
        for (z, jump) in self.state.iter_mut().zip(&self.scene.jumps[stop]) {
            *z = [z[0] - jump[0] * impulse, z[1] - jump[1] * impulse];
        }
        Ok(Blow {
            approach,
            departure: self.scene.geometry.restitutions[stop] * approach,
            impulse,
        })
    }

    fn phase(&self) -> f64 {
        wrapped(self.angle(self.clock))
    }

    fn physical(&self) -> (DVector<f64>, DVector<f64>) {
        self.scene.form.to_physical(&self.whole(&self.state))
    }
}
