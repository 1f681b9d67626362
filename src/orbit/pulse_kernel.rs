//! The linearised equations of closed motions in their impulses: the response of gaps and speeds at the impacts to changes of the impulses
//! and of their times, where deviations come back multiplied by any number after a period (theory 19, "Many modes").

use crate::flow::along;
use crate::hybrid::ScaledUnits;
use crate::linalg::plane::{Pair, times};
use crate::modal::ModalState;
use crate::orbit::pulses::{Hit, PulseTrain, Pulses};
use crate::tolerance::{QUIET_MODE, QUIET_POWERS};
use nalgebra::{ComplexField, DMatrix, DVector};

/// The equations of a train linearised: `rows xi = right`, impulses before times.
pub(crate) struct LinearisedPulses {
    /// Derivatives of the gaps and of the restitution laws of k impacts by impulses and times, shape (2k, 2k), [-] in `ScaledUnits`.
    pub rows: DMatrix<f64>,
    /// The residuals with the opposite sign, gaps before restitution laws, shape (2k,), [-] in `ScaledUnits`.
    pub right: DVector<f64>,
    pub mismatch: f64,
}

impl Pulses {
    /// The equations about a train, changes of speeds in the unit of speeds.
    pub fn linearised(&self, train: &PulseTrain, units: &ScaledUnits) -> LinearisedPulses {
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
}

/// The response of gaps and speeds at the impacts to impulses, for deviations that come back multiplied by any number.
pub(crate) struct Kernel {
    /// The modes of which more than `QUIET_MODE` is left after a period.
    loud: Vec<usize>,
    /// `n.q` and `n.v` at impact i of a state right after impact j, by these modes; number i count + j.
    rows: Vec<Vec<[Pair; 2]>>,
    /// The state right after impact j of an impulse there, and of the loss where it comes later, by these modes.
    sources: Vec<Vec<[Pair; 2]>>,
    /// The response of all other modes, for each power of the multiplier.
    quiet: Vec<[[Pair; 2]; QUIET_POWERS]>,
    /// The rates of `n.q` and `n.v` less the stop's own before impact i.
    rates: Vec<Pair>,
}

impl Kernel {
    pub fn new(pulses: &Pulses, train: &PulseTrain, before: &[ModalState]) -> Self {
        let (modal, count) = (&pulses.modal, pulses.len());
        let source = |(hit, change): (&Hit, &f64)| -> Vec<[Pair; 2]> {
            let each = pulses.decay.blocks.iter().zip(&hit.jump);
            let both = each.map(|(block, &jump)| {
                let slide = times(&block.matrix(), jump);
                [jump, slide.map(|x| x * change)]
            });
            both.collect()
        };
        let sources = pulses.hits.iter().zip(&train.changes).map(source);
        let sources: Vec<Vec<[Pair; 2]>> = sources.collect();
        let is_loud = |b: &usize| {
            let modes = pulses.modal_multipliers()[*b];
            modes.iter().any(|mode| mode.norm() > QUIET_MODE)
        };
        let (loud, silent): (Vec<usize>, Vec<usize>) =
            (0..pulses.decay.blocks.len()).partition(is_loud);
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
                let mut sums = [[[0.0; 2]; 2]; QUIET_POWERS];
                for &b in &silent {
                    let rows = seen(b);
                    let mut left = sources[b];
                    for sum in &mut sums {
                        for (c, row) in rows.iter().enumerate() {
                            for (k, z) in left.iter().enumerate() {
                                sum[c][k] += row[0] * z[0] + row[1] * z[1];
                            }
                        }
                        left = left.map(|z| times(&pulses.decay.once[b], z));
                    }
                }
                quiet.push(sums);
            }
            let at = pulses.moment(train.times[i]);
            let mut rate = before[i].clone();
            modal.rate(&before[i], at, &mut rate);
            let [_, slope, bend] = modal.stop_motion(hit.stop, at);
            rates.push([along(n, &rate) - slope, along(m, &rate) - bend]);
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
        units: &ScaledUnits,
        multiplier: T,
    ) -> DMatrix<T> {
        let count = pulses.len();
        let mut all = DMatrix::<T>::zeros(2 * count, 2 * count);
        let off = multiplier.clone() - T::one();
        for j in 0..count {
            // The response to one impulse, and to its delay.
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
                let [[p, q], [r, s]] = pulses.decay.one_minus[self.loud[b]];
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
