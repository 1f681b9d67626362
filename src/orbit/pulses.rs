//! A closed motion of a linear scene whose modes all decay, by its impulses (theory 19, "Many modes"): between impacts of one stop each it
//! flies free, and is the response to the forcing and to impulses that are repeated with its period. Unknown are their sizes and times, two for
//! each whatever the number of modes; each has the gap of its stop and the law of restitution as its equations.

use crate::error::Result;
use crate::flow::ModalScene;
use crate::hybrid::joined;
use crate::linalg::plane::{Pair, plus, times};
use crate::modal::{Block, Form, ModalState, Response};
use crate::model::{Moment, Scene, contacts};
use crate::orbit::contact_mode::{ContactMode, ContactStage, Event};
use crate::orbit::flights::{Flight, OrbitData};
use crate::orbit::pattern::Pattern;
use crate::orbit::periodic_orbit::PeriodicOrbit;
use crate::orbit::shooting::closure::Units;
use nalgebra::{Complex, ComplexField, DMatrix, DVector};
use std::sync::Arc;

/// A mode of which more than this is left after a period does not decay: near the circle its pulses have no end in sight.
const DECAYS: f64 = 1.0 - 1e-6;

/// One impact of a period.
struct Hit {
    stop: usize,
    /// `1 + e`
    gain: f64,
    /// `n.b`, and the largest part of n.
    weight: f64,
    size: f64,
    /// What an impulse takes from the state that changes the speed along the stop by one, in parts of the largest part of n.
    jump: Vec<Pair>,
}

/// The equations of closed motions of a pattern in a scene.
pub(crate) struct Pulses {
    modal: Arc<ModalScene>,
    phase: f64,
    period: f64,
    hits: Vec<Hit>,
    blocks: Vec<Block>,
    /// Of each force that turns its steady response, and that to the load.
    steady: Vec<Vec<Response>>,
    rest: Vec<Pair>,
    /// How much of each mode is left after a period.
    left: Vec<f64>,
    /// `e^{A T}`, and what it lacks to one.
    once: Vec<[Pair; 2]>,
    one_minus: Vec<[Pair; 2]>,
}

/// The times of impulses, and by how much each changes the speed along its stop, in parts of the largest part of n.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PulseTrain {
    pub times: Vec<f64>,
    pub changes: Vec<f64>,
}

/// The equations of a train linearised: `rows xi = right`, impulses before times.
pub(crate) struct LinearisedPulses {
    pub rows: DMatrix<f64>,
    pub right: DVector<f64>,
    pub mismatch: f64,
}

impl Pulses {
    /// The equations in a scene, from a phase of its forcing at time zero; `None` where they do not say all: stops are held or struck
    /// together, impacts accumulate, a mode does not decay, nothing gives a period.
    pub fn new(
        scene: &Scene,
        modal: &Arc<ModalScene>,
        stages: &[ContactStage],
        period: f64,
    ) -> Option<Self> {
        let Form::Blocks(blocks) = &modal.form.form else {
            return None;
        };
        let contacts = contacts(scene);
        let mut hits = Vec::with_capacity(stages.len());
        for stage in stages {
            let Event::Strike(stops) = &stage.event else {
                return None;
            };
            let &[stop] = stops.as_slice() else {
                return None;
            };
            if !stage.held.is_empty() {
                return None;
            }
            let along = modal.velocity_rows[stop].iter().zip(&modal.jumps[stop][..]);
            let weight = along.map(|(n, b)| n[0] * b[0] + n[1] * b[1]).sum();
            let size = modal.geometry.normals.column(stop).amax();
            let jumps = modal.jumps[stop].iter();
            hits.push(Hit {
                stop,
                gain: 1.0 + contacts[stop].restitution,
                weight,
                size,
                jump: jumps.map(|z| z.map(|x| x * size / weight)).collect(),
            });
        }
        let left = blocks.iter().map(|block| {
            let each = block.roots().map(|root| (root.re * period).exp());
            each[0].max(each[1])
        });
        let left: Vec<f64> = left.collect();
        if !left.iter().all(|left| *left < DECAYS) || !modal.signals.is_empty() {
            return None;
        }
        let of = |(w, force): (f64, &[Response])| -> Vec<Response> {
            let each = blocks.iter().zip(force);
            each.map(|(block, &f)| block.steady(w, f)).collect()
        };
        let loads = blocks.iter().zip(&modal.load);
        let rest =
            loads.map(|(block, load)| block.steady(0.0, load.map(Complex::from)).map(|z| z.re));
        Some(Self {
            left,
            phase: scene.phase(),
            period,
            hits,
            steady: modal.harmonics().map(of).collect(),
            rest: rest.collect(),
            once: blocks
                .iter()
                .map(|block| block.propagator(period))
                .collect(),
            one_minus: blocks
                .iter()
                .map(|block| block.one_minus_propagator(period))
                .collect(),
            blocks: blocks.clone(),
            modal: Arc::clone(modal),
        })
    }

    /// How many impacts there are.
    pub fn len(&self) -> usize {
        self.hits.len()
    }

    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    pub fn period(&self) -> f64 {
        self.period
    }

    /// What deviations of a train that come back multiplied make of the states behind its impacts, each at its moved time: deviations of changes
    /// of speeds and of times.
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
            let each = self.blocks.iter().zip(&hit.jump).zip(&self.one_minus);
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
                for ((z, flight), left) in state.iter_mut().zip(&flights).zip(&left) {
                    *z = plus(*z, times(flight, *left).map(|x| -x * factor));
                }
            }
        }
        let behind = all.iter().enumerate();
        behind
            .map(|(i, state)| self.physical(&self.behind(i, state, by.changes[i])))
            .collect()
    }

    fn moment(&self, t: f64) -> Moment {
        let w = self.modal.frequency;
        Moment::new(t, w * t + self.phase, w)
    }

    /// The response to the forcing.
    fn steady_at(&self, t: f64) -> ModalState {
        let phasors: Vec<Complex<f64>> = self.modal.rotations.phasors(self.moment(t)).collect();
        let part = |b: usize, c: usize| {
            let turned = self.steady.iter().zip(&phasors);
            self.rest[b][c] + turned.map(|(all, u)| (all[b][c] * u).re).sum::<f64>()
        };
        let each = (0..self.blocks.len()).map(|b| [part(b, 0), part(b, 1)]);
        ModalState::from(each.collect::<Vec<_>>())
    }

    /// How long before impact i impact j was last.
    fn since(&self, times: &[f64], i: usize, j: usize) -> f64 {
        let since = times[i] - times[j];
        if j < i { since } else { since + self.period }
    }

    /// `e^{A tau}` of all blocks, tau the time since impact j at impact i.
    fn flights(&self, times: &[f64], i: usize, j: usize) -> Vec<[Pair; 2]> {
        if i == j {
            return self.once.clone();
        }
        let tau = self.since(times, i, j);
        self.blocks
            .iter()
            .map(|block| block.propagator(tau))
            .collect()
    }

    /// What is left of an impulse on the stop of impact j that is repeated each period, right behind it.
    fn repeated(&self, j: usize) -> impl Iterator<Item = Pair> {
        let jumps = self.hits[j].jump.iter();
        self.one_minus
            .iter()
            .zip(jumps)
            .map(|(m, &jump)| solve(*m, jump))
    }

    /// The states before all impacts.
    pub fn before(&self, train: &PulseTrain) -> Vec<ModalState> {
        let count = self.len();
        let mut all: Vec<ModalState> = train.times.iter().map(|&t| self.steady_at(t)).collect();
        for j in 0..count {
            let behind: Vec<Pair> = self.repeated(j).collect();
            for (i, state) in all.iter_mut().enumerate() {
                let flown = self.flights(&train.times, i, j);
                for ((z, flight), start) in state.iter_mut().zip(&flown).zip(&behind) {
                    let moved = times(flight, *start).map(|x| -x * train.changes[j]);
                    *z = plus(*z, moved);
                }
            }
        }
        all
    }

    /// The state behind an impact, from that before it.
    fn behind(&self, i: usize, before: &ModalState, change: f64) -> ModalState {
        let each = before.iter().zip(&self.hits[i].jump);
        let moved = each.map(|(z, jump)| plus(*z, jump.map(|x| -x * change)));
        ModalState::from(moved.collect::<Vec<_>>())
    }

    /// The states behind all impacts.
    pub fn after(&self, train: &PulseTrain) -> Vec<ModalState> {
        let before = self.before(train);
        let each = before.iter().enumerate();
        each.map(|(i, state)| self.behind(i, state, train.changes[i]))
            .collect()
    }

    /// The train of a motion from the states behind its impacts: what each flight ends with is turned by the next impulse.
    pub fn train(&self, instants: &[f64], after: &[DVector<f64>]) -> PulseTrain {
        let count = self.len();
        let n = self.blocks.len();
        let after = after.iter().map(|x| {
            let (q, v) = (x.rows(0, n).into_owned(), x.rows(n, n).into_owned());
            self.modal.form.to_modal(&q, &v)
        });
        let after: Vec<ModalState> = after.collect();
        let change = |i: usize| {
            let last = (i + count - 1) % count;
            let span = self.since(instants, i, last);
            let rows = &self.modal.velocity_rows[self.hits[i].stop];
            let ends = self.flown(&after[last], instants[i] - span, span);
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
    fn flown(&self, state: &ModalState, start: f64, span: f64) -> ModalState {
        let (from, to) = (self.steady_at(start), self.steady_at(start + span));
        let each = self
            .blocks
            .iter()
            .zip(&state[..])
            .zip(&from[..])
            .zip(&to[..]);
        let flown = each.map(|(((block, z), from), to)| {
            let free = [z[0] - from[0], z[1] - from[1]];
            plus(times(&block.propagator(span), free), *to)
        });
        ModalState::from(flown.collect::<Vec<_>>())
    }

    /// A state in coordinates.
    pub fn physical(&self, state: &ModalState) -> DVector<f64> {
        joined(&self.modal.form.to_physical(state))
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
        dot(&self.modal.velocity_rows[hit.stop], state) - slope
    }

    /// The equations about a train, changes of speeds in the unit of speeds.
    pub fn linearised(&self, train: &PulseTrain, units: &Units) -> LinearisedPulses {
        let before = self.before(train);
        let right = self.right(train, &before, units);
        let mismatch = right.iter().fold(0.0f64, |worst, lacks| {
            if lacks.is_nan() {
                f64::INFINITY
            } else {
                worst.max(lacks.abs())
            }
        });
        let kernel = Kernel::new(self, train, &before);
        LinearisedPulses {
            rows: kernel.equations(self, units, 1.0),
            right,
            mismatch,
        }
    }

    /// What a train lacks, negative.
    pub fn lacking(&self, train: &PulseTrain, units: &Units) -> DVector<f64> {
        self.right(train, &self.before(train), units)
    }

    fn right(&self, train: &PulseTrain, before: &[ModalState], units: &Units) -> DVector<f64> {
        let count = self.len();
        let mut right = DVector::zeros(2 * count);
        for (i, (hit, state)) in self.hits.iter().zip(before).enumerate() {
            let t = train.times[i];
            let [widening, ..] = self.modal.stop_motion(hit.stop, self.moment(t));
            let place = dot(&self.modal.position_rows[hit.stop], state);
            let gap = self.modal.geometry.clearances[hit.stop] + widening - place;
            let lacks = hit.size * train.changes[i] - hit.gain * self.speed(hit, state, t);
            right[i] = -gap / (units.position * hit.size);
            right[count + i] = -lacks / (units.velocity * hit.size);
        }
        right
    }

    /// The orbit of a train.
    pub fn orbit(
        &self,
        scene: &Scene,
        train: &PulseTrain,
        n_periods: usize,
    ) -> Result<PeriodicOrbit> {
        let count = self.len();
        let before = self.before(train);
        let mut elapsed = 0.0;
        let flights = (0..count).map(|i| {
            let span = self.since(&train.times, (i + 1) % count, i);
            let flight = Flight {
                start: elapsed,
                span,
                after: self.behind(i, &before[i], train.changes[i]),
                before_next: before[(i + 1) % count].clone(),
                mode: ContactMode::FREE,
            };
            elapsed += span;
            flight
        });
        let parts = OrbitData {
            flights: flights.collect(),
            pattern: Pattern::new(self.hits.iter().map(|hit| vec![hit.stop]).collect())?,
            n_periods,
            phase: crate::impact::wrapped(self.modal.frequency * train.times[0] + self.phase),
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

/// What the stops of impacts see of impulses, for deviations that come back multiplied by any number.
pub(crate) struct Kernel {
    /// The modes of which something is left after a period.
    loud: Vec<usize>,
    /// `n.q` and `n.v` at impact i of what is there behind impact j, of these modes; at i count + j.
    rows: Vec<Vec<[Pair; 2]>>,
    /// What an impulse is behind impact j, and what it is less when it comes later, of these modes.
    sources: Vec<Vec<[Pair; 2]>>,
    /// What is seen of all others, for each power of a deviation's number in which it comes in.
    quiet: Vec<[[Pair; 2]; POWERS]>,
    /// The rates of `n.q` and `n.v` less the stop's own before impact i.
    rates: Vec<Pair>,
}

/// Modes of which less than this is left after a period are seen by so many powers of it: to 1e-13.
const QUIET: f64 = 0.02;
const POWERS: usize = 8;

impl Kernel {
    pub fn new(pulses: &Pulses, train: &PulseTrain, before: &[ModalState]) -> Self {
        let (modal, count) = (&pulses.modal, pulses.len());
        let source = |(hit, change): (&Hit, &f64)| -> Vec<[Pair; 2]> {
            let each = pulses.blocks.iter().zip(&hit.jump);
            let both = each.map(|(block, &jump)| {
                let slide = times(&block.matrix(), jump);
                [jump, slide.map(|x| x * change)]
            });
            both.collect()
        };
        let sources = pulses.hits.iter().zip(&train.changes).map(source);
        let sources: Vec<Vec<[Pair; 2]>> = sources.collect();
        let is_loud = |b: &usize| pulses.left[*b] > QUIET;
        let (loud, silent): (Vec<usize>, Vec<usize>) = (0..pulses.blocks.len()).partition(is_loud);
        let mut rows = Vec::with_capacity(count * count);
        let mut quiet = Vec::with_capacity(count * count);
        let mut rates = Vec::with_capacity(count);
        for (i, hit) in pulses.hits.iter().enumerate() {
            let (n, m) = (
                &modal.position_rows[hit.stop],
                &modal.velocity_rows[hit.stop],
            );
            for (j, sources) in sources.iter().enumerate() {
                let flights = pulses.flights(&train.times, i, j);
                let seen = |b: usize| [row(n[b], &flights[b]), row(m[b], &flights[b])];
                rows.push(loud.iter().map(|&b| seen(b)).collect());
                let mut sums = [[[0.0; 2]; 2]; POWERS];
                for &b in &silent {
                    let rows = seen(b);
                    let mut left = sources[b];
                    for sum in &mut sums {
                        for (c, row) in rows.iter().enumerate() {
                            for (k, z) in left.iter().enumerate() {
                                sum[c][k] += row[0] * z[0] + row[1] * z[1];
                            }
                        }
                        left = left.map(|z| times(&pulses.once[b], z));
                    }
                }
                quiet.push(sums);
            }
            let at = pulses.moment(train.times[i]);
            let mut rate = before[i].clone();
            modal.rate(&before[i], at, &mut rate);
            let [_, slope, bend] = modal.stop_motion(hit.stop, at);
            rates.push([dot(n, &rate) - slope, dot(m, &rate) - bend]);
        }
        let of_loud = |own: &Vec<[Pair; 2]>| loud.iter().map(|&b| own[b]).collect();
        Self {
            rows,
            sources: sources.iter().map(of_loud).collect(),
            loud,
            quiet,
            rates,
        }
    }

    /// The equations of a deviation that comes back multiplied.
    pub fn equations<T: ComplexField<RealField = f64>>(
        &self,
        pulses: &Pulses,
        units: &Units,
        multiplier: T,
    ) -> DMatrix<T> {
        let count = pulses.len();
        let mut all = DMatrix::<T>::zeros(2 * count, 2 * count);
        let off = multiplier.clone() - T::one();
        for j in 0..count {
            // What is left of one impulse, and of one that comes later.
            let seen_of_quiet = |i: usize| {
                // 1/mu + e^{AT}/mu^2 + ...
                [0, 1].map(|c| {
                    [0, 1].map(|k| {
                        let sums = self.quiet[i * count + j].iter().rev();
                        sums.fold(T::zero(), |sum, own| {
                            (sum + T::from_real(own[c][k])) / multiplier.clone()
                        })
                    })
                })
            };
            let mut seen: Vec<[[T; 2]; 2]> = (0..count).map(seen_of_quiet).collect();
            for (b, sources) in self.sources[j].iter().enumerate() {
                let [[p, q], [r, s]] = pulses.one_minus[self.loud[b]];
                let (p, s) = (off.clone() + T::from_real(p), off.clone() + T::from_real(s));
                let det = p.clone() * s.clone() - T::from_real(q * r);
                for (k, source) in sources.iter().enumerate() {
                    let left = [
                        (s.clone().scale(source[0]) - T::from_real(q * source[1])) / det.clone(),
                        (p.clone().scale(source[1]) - T::from_real(r * source[0])) / det.clone(),
                    ];
                    for (i, seen) in seen.iter_mut().enumerate() {
                        for (c, row) in self.rows[i * count + j][b].iter().enumerate() {
                            seen[c][k] +=
                                left[0].clone().scale(row[0]) + left[1].clone().scale(row[1]);
                        }
                    }
                }
            }
            for (i, seen) in seen.into_iter().enumerate() {
                // An impulse of this round is multiplied by the time it comes again.
                let factor = if j < i { multiplier.clone() } else { T::one() };
                let hit = &pulses.hits[i];
                let [place, speed] = seen.map(|pair| pair.map(|x| x * factor.clone()));
                let (near, fast) = (units.position * hit.size, units.velocity * hit.size);
                let (change, time) = (units.velocity, units.time);
                all[(i, j)] = place[0].clone().scale(change / near);
                all[(i, count + j)] = place[1].clone().scale(-time / near);
                all[(count + i, j)] = speed[0].clone().scale(hit.gain * change / fast);
                all[(count + i, count + j)] = speed[1].clone().scale(-hit.gain * time / fast);
                if i == j {
                    let [rise, gain] = self.rates[i];
                    all[(i, count + i)] += T::from_real(-rise * time / near);
                    all[(count + i, i)] += T::from_real(hit.size * change / fast);
                    all[(count + i, count + i)] += T::from_real(-hit.gain * gain * time / fast);
                }
            }
        }
        all
    }
}

/// `n e^{A tau}`
fn row(n: Pair, flight: &[Pair; 2]) -> Pair {
    [
        n[0] * flight[0][0] + n[1] * flight[1][0],
        n[0] * flight[0][1] + n[1] * flight[1][1],
    ]
}

/// The solution of two equations.
fn solve(m: [Pair; 2], right: Pair) -> Pair {
    let det = m[0][0] * m[1][1] - m[0][1] * m[1][0];
    [
        (m[1][1] * right[0] - m[0][1] * right[1]) / det,
        (m[0][0] * right[1] - m[1][0] * right[0]) / det,
    ]
}

fn dot(row: &[Pair], state: &ModalState) -> f64 {
    let each = row.iter().zip(state.iter());
    each.map(|(n, z)| n[0] * z[0] + n[1] * z[1]).sum()
}
