//! A closed motion of a linear scene whose modes all decay, by its impulses (theory 19, "Many modes"): between impacts of one stop each it
//! flies free, and is the response to the forcing and to impulses that are repeated with its period. Unknown are their sizes and times, two for
//! each whatever the number of modes; each has the gap of its stop and the law of restitution as its equations.

use crate::error::Result;
use crate::flow::{ModalScene, along};
use crate::hybrid::ScaledUnits;
use crate::impact::wrapped;
use crate::itinerary::Itinerary;
use crate::law::Stage;
use crate::linalg::plane::{Pair, plus, times};
use crate::modal::{Block, Form, ModalForm, ModalState, Response};
use crate::model::{Moment, Scene, contacts};
use crate::orbit::orbit_data::{OrbitArc, OrbitData};
use crate::orbit::pattern::Pattern;
use crate::orbit::periodic_orbit::PeriodicOrbit;
use crate::tolerance::DECAYING_MODE;
use nalgebra::{Complex, DVector};
use std::borrow::Cow;
use std::sync::Arc;

/// One impact of a period.
pub(super) struct Hit {
    pub stop: usize,
    /// `1 + e`
    pub gain: f64,
    /// `n.b`, and the largest part of n.
    weight: f64,
    pub size: f64,
    /// The change of the modal state by an impulse that changes the speed along the stop by one, with the opposite sign, in parts of the
    /// largest component of n.
    pub jump: Vec<Pair>,
}

/// The equations of closed motions of a pattern in a scene.
pub(crate) struct Pulses {
    pub(super) modal: Arc<ModalScene>,
    phase: f64,
    period: f64,
    pub(super) hits: Vec<Hit>,
    pub(super) decay: Arc<Decay>,
    /// The steady response to each harmonic of the forcing; then that to the load.
    steady: Vec<Vec<Response>>,
    rest: Vec<Pair>,
}

/// The propagators of decaying modes over a period, shared by scenes of one system and one period.
pub(super) struct Decay {
    pub blocks: Vec<Block>,
    /// The multipliers of each mode.
    multipliers: Vec<Response>,
    /// `e^{A T}`, and what it lacks to one.
    pub once: Vec<[Pair; 2]>,
    pub one_minus: Vec<[Pair; 2]>,
}

impl Decay {
    /// That of modes that decay; none of others.
    fn new(form: &ModalForm, period: f64) -> Option<Self> {
        let Form::Blocks(blocks) = &form.form else {
            return None;
        };
        let multipliers = blocks
            .iter()
            .map(|block| block.roots().map(|root| (root * period).exp()));
        let multipliers: Vec<Response> = multipliers.collect();
        let mut each = multipliers.iter().flatten();
        let each_of = |of: &dyn Fn(&Block) -> [Pair; 2]| blocks.iter().map(of).collect();
        each.all(|mode| mode.norm() < DECAYING_MODE).then(|| Self {
            multipliers,
            once: each_of(&|block| block.propagator(period)),
            one_minus: each_of(&|block| block.one_minus_propagator(period)),
            blocks: blocks.clone(),
        })
    }
}

/// The times of impulses, and by how much each changes the speed along its stop, in parts of the largest part of n.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PulseTrain {
    /// Times of the k impulses, shape (k,), [s].
    pub times: Vec<f64>,
    /// Changes of the speeds along the stops, in parts of the largest component of each normal, shape (k,), [m/s].
    pub changes: Vec<f64>,
}

impl PulseTrain {
    /// The train with changes of its times and of its impulses.
    pub fn moved(&self, by: &Self) -> Self {
        let sum = |own: &[f64], more: &[f64]| own.iter().zip(more).map(|(a, b)| a + b).collect();
        Self {
            times: sum(&self.times, &by.times),
            changes: sum(&self.changes, &by.changes),
        }
    }
}

impl Pulses {
    /// The equations in a scene, from a phase of its forcing at time zero; `None` where they do not say all: stops are held or struck
    /// together, impacts accumulate, a mode does not decay, nothing gives a period. What others have that the scene shares is taken from them.
    pub fn new(
        scene: &Scene,
        modal: &Arc<ModalScene>,
        (itinerary, period): (&Itinerary, f64),
        others: Option<&Self>,
    ) -> Option<Self> {
        if !modal.signals.is_empty() {
            return None;
        }
        let contacts = contacts(scene);
        let mut hits = Vec::with_capacity(itinerary.len());
        for stop in itinerary.single_impacts()? {
            let weight = along(&modal.velocity_rows[stop], &modal.jumps[stop]);
            let size = modal.geometry.normals.column(stop).amax();
            let jumps = modal.jumps[stop].iter();
            hits.push(Hit {
                stop,
                gain: contacts[stop].law().factor(),
                weight,
                size,
                jump: jumps.map(|z| z.map(|x| x * size / weight)).collect(),
            });
        }
        let is_shared =
            |own: &&Self| own.period == period && Arc::ptr_eq(&own.modal.form, &modal.form);
        let decay = match others.filter(is_shared) {
            Some(own) => Arc::clone(&own.decay),
            None => Arc::new(Decay::new(&modal.form, period)?),
        };
        let blocks = &decay.blocks;
        let of = |(w, force): (f64, &[Response])| -> Vec<Response> {
            let each = blocks.iter().zip(force);
            each.map(|(block, &f)| block.steady(w, f)).collect()
        };
        let loads = blocks.iter().zip(&modal.load);
        let rest =
            loads.map(|(block, load)| block.steady(0.0, load.map(Complex::from)).map(|z| z.re));
        Some(Self {
            phase: scene.phase(),
            period,
            hits,
            steady: modal.harmonics().map(of).collect(),
            rest: rest.collect(),
            decay,
            modal: Arc::clone(modal),
        })
    }

    /// How many impacts there are.
    pub fn len(&self) -> usize {
        self.hits.len()
    }

    /// The multipliers of each mode.
    pub fn modal_multipliers(&self) -> &[Response] {
        &self.decay.multipliers
    }

    /// Deviations of the states after the impacts of a train, each at its moved time, where deviations of the changes of speed and of the
    /// times come back multiplied after a period.
    pub fn deviations(
        &self,
        train: &PulseTrain,
        multiplier: f64,
        by: &PulseTrain,
    ) -> Vec<DVector<f64>> {
        let before = self.before(train);
        let each = before.iter().enumerate().map(|(i, state)| {
            let mut rate = state.clone();
            self.modal
                .rate(state, self.moment(train.times[i]), &mut rate);
            ModalState::from(
                rate.iter()
                    .map(|z| z.map(|x| x * by.times[i]))
                    .collect::<Vec<_>>(),
            )
        });
        let mut all: Vec<ModalState> = each.collect();
        for (j, hit) in self.hits.iter().enumerate() {
            let each = self
                .decay
                .blocks
                .iter()
                .zip(&hit.jump)
                .zip(&self.decay.one_minus);
            let left: Vec<Pair> = each
                .map(|((block, &jump), one_minus)| {
                    let slide = times(&block.matrix(), jump);
                    let source = [0, 1].map(|c| {
                        jump[c] * by.changes[j] - slide[c] * train.changes[j] * by.times[j]
                    });
                    let [[p, q], [r, s]] = *one_minus;
                    let off = multiplier - 1.0;
                    solve([[off + p, q], [r, off + s]], source)
                })
                .collect();
            for (i, state) in all.iter_mut().enumerate() {
                let factor = if j < i { multiplier } else { 1.0 };
                let flights = self.flights(&train.times, i, j);
                for ((z, flight), left) in state.iter_mut().zip(flights.iter()).zip(&left) {
                    *z = plus(*z, times(flight, *left).map(|x| -x * factor));
                }
            }
        }
        let after = all.iter().enumerate();
        after
            .map(|(i, state)| self.physical(&self.after_impact(i, state, by.changes[i])))
            .collect()
    }

    pub(super) fn moment(&self, t: f64) -> Moment {
        let w = self.modal.frequency;
        Moment::new(t, w * t + self.phase, w)
    }

    /// The response to the forcing.
    pub fn steady_at(&self, t: f64) -> ModalState {
        let phasors: Vec<Complex<f64>> = self.modal.rotations.phasors(self.moment(t)).collect();
        let part = |b: usize, c: usize| {
            let turned = self.steady.iter().zip(&phasors);
            self.rest[b][c] + turned.map(|(all, u)| (all[b][c] * u).re).sum::<f64>()
        };
        let each = (0..self.decay.blocks.len()).map(|b| [part(b, 0), part(b, 1)]);
        ModalState::from(each.collect::<Vec<_>>())
    }

    /// The time since impact j at impact i [s].
    fn since(&self, times: &[f64], i: usize, j: usize) -> f64 {
        let since = times[i] - times[j];
        if j < i { since } else { since + self.period }
    }

    /// `e^{A tau}` of all blocks, tau the time since impact j at impact i.
    pub(super) fn flights(&self, times: &[f64], i: usize, j: usize) -> Cow<'_, [[Pair; 2]]> {
        if i == j {
            return Cow::Borrowed(&self.decay.once);
        }
        let tau = self.since(times, i, j);
        let each = self.decay.blocks.iter();
        each.map(|block| block.propagator(tau)).collect()
    }

    /// The response right after an impulse on the stop of impact j that is repeated with the period, mode by mode.
    fn repeated(&self, j: usize) -> impl Iterator<Item = Pair> {
        let jumps = self.hits[j].jump.iter();
        self.decay
            .one_minus
            .iter()
            .zip(jumps)
            .map(|(m, &jump)| solve(*m, jump))
    }

    /// The states before all impacts.
    pub fn before(&self, train: &PulseTrain) -> Vec<ModalState> {
        let count = self.len();
        let mut all: Vec<ModalState> = train.times.iter().map(|&t| self.steady_at(t)).collect();
        for j in 0..count {
            let sources: Vec<Pair> = self.repeated(j).collect();
            for (i, state) in all.iter_mut().enumerate() {
                let propagators = self.flights(&train.times, i, j);
                for ((z, flight), start) in state.iter_mut().zip(propagators.iter()).zip(&sources) {
                    let moved = times(flight, *start).map(|x| -x * train.changes[j]);
                    *z = plus(*z, moved);
                }
            }
        }
        all
    }

    /// The state after an impact, from that before it.
    fn after_impact(&self, i: usize, before: &ModalState, change: f64) -> ModalState {
        let each = before.iter().zip(&self.hits[i].jump);
        let moved = each.map(|(z, jump)| plus(*z, jump.map(|x| -x * change)));
        ModalState::from(moved.collect::<Vec<_>>())
    }

    /// The states after all impacts.
    pub fn after(&self, train: &PulseTrain) -> Vec<ModalState> {
        let before = self.before(train);
        let each = before.iter().enumerate();
        each.map(|(i, state)| self.after_impact(i, state, train.changes[i]))
            .collect()
    }

    /// The train of a motion from the states after its impacts: the change at each is the end of the flight before it less the state after
    /// it.
    pub fn train(&self, instants: &[f64], after: &[DVector<f64>]) -> PulseTrain {
        let count = self.len();
        let after = after.iter().map(|x| self.modal.form.pairs_of(x));
        let after: Vec<ModalState> = after.collect();
        let change = |i: usize| {
            let last = (i + count - 1) % count;
            let span = self.since(instants, i, last);
            let rows = &self.modal.velocity_rows[self.hits[i].stop];
            let ends = self.free_flight(&after[last], instants[i] - span, span);
            let changes = ends.iter().zip(&after[i][..]).zip(rows);
            let change =
                changes.map(|((end, to), n)| n[0] * (end[0] - to[0]) + n[1] * (end[1] - to[1]));
            change.sum::<f64>() / self.hits[i].size
        };
        PulseTrain {
            times: instants[..count].to_vec(),
            changes: (0..count).map(change).collect(),
        }
    }

    /// A state after a free flight.
    fn free_flight(&self, state: &ModalState, start: f64, span: f64) -> ModalState {
        let (from, to) = (self.steady_at(start), self.steady_at(start + span));
        let each = self
            .decay
            .blocks
            .iter()
            .zip(&state[..])
            .zip(&from[..])
            .zip(&to[..]);
        let ends = each.map(|(((block, z), from), to)| {
            let free = [z[0] - from[0], z[1] - from[1]];
            plus(times(&block.propagator(span), free), *to)
        });
        ModalState::from(ends.collect::<Vec<_>>())
    }

    /// A state in coordinates.
    pub fn physical(&self, state: &ModalState) -> DVector<f64> {
        self.modal.form.state_of(state)
    }

    /// The speeds at which the stops are approached.
    pub fn approaches(&self, train: &PulseTrain) -> Vec<f64> {
        let before = self.before(train);
        let each = self.hits.iter().zip(&before).zip(&train.times);
        each.map(|((hit, state), &t)| self.speed(hit, state, t))
            .collect()
    }

    fn speed(&self, hit: &Hit, state: &ModalState, t: f64) -> f64 {
        let [_, slope, _] = self.modal.stop_motion(hit.stop, self.moment(t));
        along(&self.modal.velocity_rows[hit.stop], state) - slope
    }

    /// The residuals of a train with the opposite sign.
    pub fn lacking(&self, train: &PulseTrain, units: &ScaledUnits) -> DVector<f64> {
        self.right(train, &self.before(train), units)
    }

    /// The same from the states before its impacts.
    pub(super) fn right(
        &self,
        train: &PulseTrain,
        before: &[ModalState],
        units: &ScaledUnits,
    ) -> DVector<f64> {
        let count = self.len();
        let mut right = DVector::zeros(2 * count);
        for (i, (hit, state)) in self.hits.iter().zip(before).enumerate() {
            let t = train.times[i];
            let [widening, ..] = self.modal.stop_motion(hit.stop, self.moment(t));
            let place = along(&self.modal.position_rows[hit.stop], state);
            let gap = self.modal.geometry.clearances[hit.stop] + widening - place;
            let lacks = hit.size * train.changes[i] - hit.gain * self.speed(hit, state, t);
            right[i] = -gap / (units.position * hit.size);
            right[count + i] = -lacks / (units.velocity * hit.size);
        }
        right
    }

    /// The orbit of a train; that of no impacts begins at a time.
    pub fn orbit(
        &self,
        scene: &Scene,
        (train, begin): (&PulseTrain, f64),
        n_periods: usize,
    ) -> Result<PeriodicOrbit> {
        let count = self.len();
        let before = self.before(train);
        let mut elapsed = 0.0;
        let flights = (0..count).map(|i| {
            let span = self.since(&train.times, (i + 1) % count, i);
            let after = self.after_impact(i, &before[i], train.changes[i]);
            let states = [after, before[(i + 1) % count].clone()];
            let stage = Stage::impact(&[self.hits[i].stop]);
            let own = OrbitArc::over(stage, [elapsed, span], states);
            elapsed += span;
            own
        });
        let mut flights: Vec<OrbitArc> = flights.collect();
        if flights.is_empty() {
            let state = self.steady_at(begin);
            let states = [state.clone(), state];
            flights.push(OrbitArc::over(
                Stage::impact(&[]),
                [0.0, self.period],
                states,
            ));
        }
        let hits = self.hits.iter().map(|hit| vec![hit.stop]);
        let parts = OrbitData {
            flights,
            pattern: Pattern::new(hits.collect())?,
            n_periods,
            phase: wrapped(self.modal.frequency * begin + self.phase),
            impulses: self
                .hits
                .iter()
                .zip(&train.changes)
                .map(|(hit, change)| change * hit.size / hit.weight)
                .collect(),
            clearances: Vec::new(),
        };
        PeriodicOrbit::new(scene, Arc::clone(&self.modal), parts)
    }
}

/// The solution of two equations.
fn solve(m: [Pair; 2], right: Pair) -> Pair {
    let det = m[0][0] * m[1][1] - m[0][1] * m[1][0];
    [
        (m[1][1] * right[0] - m[0][1] * right[1]) / det,
        (m[0][0] * right[1] - m[1][0] * right[0]) / det,
    ]
}
