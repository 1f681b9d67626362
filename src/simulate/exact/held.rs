//! Exact flights with stops held: the motion left over has modes of its own, and its contact forces are searched as gaps
//! are (theory 9).

use super::{ExactMover, is_within};
use crate::contact::next::{Margin, Next, Search};
use crate::contact::walk::ROUNDING;
use crate::error::{Error, Result};
use crate::flow::jet::Jet;
use crate::flow::{GapRow, LinearFlow, StuckMotion};
use crate::modal::Pair;
use crate::model::along_reactions;
use crate::simulate::kept::SegmentKind;
use crate::simulate::mover::{Arrival, Mover};
use crate::simulate::record::Record;
use crate::watch::Watch;
use nalgebra::DVector;
use std::sync::Arc;

/// A contact force at zero for good: its first derivatives are this small, relative to its terms and the fastest rate.
const FLAT: f64 = 1e-12;

impl<F: LinearFlow> ExactMover<'_, F> {
    /// The present position and velocity, moved onto some stops along their reactions: what is left of an impact that comes to
    /// rest is taken as impacts take it, not along the normals.
    pub(super) fn settled(&self, stops: &[usize]) -> Result<(DVector<f64>, DVector<f64>)> {
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
    pub(super) fn motion_of(&mut self, stops: &[usize]) -> Result<Arc<StuckMotion>> {
        if let Some(known) = self.held.iter().find(|h| h.stops == stops) {
            return Ok(Arc::clone(known));
        }
        let motion = Arc::new(StuckMotion::new(self.scene, stops)?);
        self.held.push(Arc::clone(&motion));
        Ok(motion)
    }

    /// A segment in which stops are held: to a contact of another, to a release, or over the whole span.
    pub(super) fn fly_held<H: LinearFlow>(
        &mut self,
        flow: &H,
        motion: &StuckMotion,
        starts: &[usize],
        span: f64,
        last: f64,
        record: &mut Record,
        watch: &mut Watch<'_>,
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
        let (event, time) = match search.next(&state, &orders, span, &mut self.grazed, watch) {
            Next::Interrupted => return Err(Error::Interrupted),
            Next::End => (None, span),
            Next::Stalled { stop, time } => (Some(events.list[stop].0), time),
            Next::Contact { stop, time } => {
                let mut arrived = Vec::new();
                let (stop, time) = search.arrive(stop, time, &state, &mut arrived);
                if is_within(self.clock.after(time), last) {
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
