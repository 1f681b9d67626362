//! Anything that drives a linear flow: any number of rotations, harmonics or not, and signals, whose derivatives are stored where the
//! phasors are (theory 10, 11).

use crate::flow::drive::{
    Alone, Drive, NOTHING, Turning, TurningRow, harmonic_inputs, real_part, turning,
};
use crate::flow::gap_row::{Derivatives, Quantity};
use crate::linalg::plane::plus;
use crate::modal::{Pair, Response};
use crate::model::{Moment, Rotations, Signal};
use nalgebra::Complex;

/// `Re sum_k f_kj e^{i w_k t} + sum_m d_mj s_m(t)` on block j.
#[derive(Debug, Clone, Default)]
pub(crate) struct ManyDrive {
    pub rotations: Rotations,
    /// By rotations, then by blocks.
    pub forces: Vec<Vec<Response>>,
    pub signals: Vec<SignalInput>,
}

/// A signal with what it does to each block.
#[derive(Debug, Clone)]
pub(crate) struct SignalInput {
    pub signal: Signal,
    /// By blocks.
    pub directions: Vec<Pair>,
}

impl SignalInput {
    /// Pairs that hold its derivatives of orders 0 to its degree.
    pub fn n_pairs(&self) -> usize {
        self.signal.degree() / 2 + 1
    }

    /// Stores its derivatives at a moment.
    pub fn store(&self, at: Moment, stored: &mut [Pair]) {
        stored.fill([0.0, 0.0]);
        let put = |m: usize, x: f64| stored[m / 2][m % 2] = x;
        self.signal.derivatives(at.since, at.time, put);
    }
}

/// Carries the derivatives of a polynomial over a span of time.
pub(super) fn shift(t: f64, stored: &mut [Pair]) {
    let stored = stored.as_flattened_mut();
    for m in 0..stored.len() {
        stored[m] = crate::model::taylor(&stored[m..], t);
    }
}

/// The pairs of a polynomial with their derivatives. The norm of the first bounds its third derivative over a step of some length, that
/// of the second its fourth.
pub(super) fn polynomial(
    stored: &[Pair],
    longest_step: f64,
) -> impl Iterator<Item = Derivatives> + '_ {
    let flat = stored.as_flattened();
    let of = |m: usize| flat.get(m).copied().unwrap_or(0.0);
    (0..stored.len()).map(move |pair| {
        let at = |order: usize| [of(2 * pair + order), of(2 * pair + order + 1)];
        Derivatives {
            z: at(0),
            d1: at(1),
            d2: at(2),
            d3: at(3),
            norm: if pair < 2 {
                let rest = flat.iter().skip(3 + pair);
                let sizes: Vec<f64> = rest.map(|x| x.abs()).collect();
                crate::model::taylor(&sizes, longest_step)
            } else {
                0.0
            },
        }
    })
}

impl ManyDrive {
    /// The pairs of each signal among those that are stored.
    fn parted<'s>(&'s self, stored: &'s [Pair]) -> impl Iterator<Item = &'s [Pair]> {
        let mut rest = &stored[self.rotations.len()..];
        self.signals.iter().map(move |signal| {
            let (own, others) = rest.split_at(signal.n_pairs());
            rest = others;
            own
        })
    }
}

impl Turning for ManyDrive {
    /// All of it.
    type Seen<'s> = &'s [Pair];
    /// What the phasors turn by, and the span.
    type Turn = (Vec<Complex<f64>>, f64);

    fn n_pairs(&self) -> usize {
        self.rotations.len() + self.signals.iter().map(SignalInput::n_pairs).sum::<usize>()
    }

    fn store(&self, at: Moment, stored: &mut [Pair]) {
        let (turned, mut rest) = stored.split_at_mut(self.rotations.len());
        for (place, u) in turned.iter_mut().zip(self.rotations.phasors(at)) {
            *place = [u.re, u.im];
        }
        for signal in &self.signals {
            let (own, others) = rest.split_at_mut(signal.n_pairs());
            signal.store(at, own);
            rest = others;
        }
    }

    fn read(stored: &[Pair]) -> &[Pair] {
        stored
    }

    fn frequencies(&self) -> impl Iterator<Item = f64> + Clone {
        self.rotations.frequencies()
    }

    fn turn(&self, t: f64) -> (Vec<Complex<f64>>, f64) {
        (self.rotations.turns(t).collect(), t)
    }

    fn carry(&self, (turns, t): &(Vec<Complex<f64>>, f64), stored: &mut [Pair]) {
        let (turned, mut rest) = stored.split_at_mut(self.rotations.len());
        for (place, turn) in turned.iter_mut().zip(turns) {
            let u = Complex::new(place[0], place[1]) * turn;
            *place = [u.re, u.im];
        }
        for signal in &self.signals {
            let (own, others) = rest.split_at_mut(signal.n_pairs());
            shift(*t, own);
            rest = others;
        }
    }

    fn turning<'s>(&'s self, stored: Self::Seen<'s>) -> impl Iterator<Item = Derivatives> + 's {
        let longest = self.longest_step();
        let phasors = stored.iter().map(|u| Complex::new(u[0], u[1]));
        let turned = phasors.zip(self.frequencies()).map(|(u, w)| turning(u, w));
        let signals = self.parted(stored);
        turned.chain(signals.flat_map(move |own| polynomial(own, longest)))
    }

    fn rows(&self, quantity: &Quantity, weights: &[f64]) -> Vec<TurningRow> {
        let harmonics = quantity.harmonics().zip(self.frequencies());
        let mut rows: Vec<_> = harmonics
            .map(|(f, w)| TurningRow::of_harmonic(f, w))
            .collect();
        let signals = self.signals.iter().zip(quantity.signals());
        for ((signal, direct), &weight) in signals.zip(weights) {
            rows.extend(signal_rows(signal.n_pairs(), direct, weight));
        }
        rows
    }

    fn longest_step(&self) -> f64 {
        longest_piece(self.signals.iter().map(|own| &own.signal))
    }
}

/// The longest piece of some signals, infinite without any.
pub(super) fn longest_piece<'s>(signals: impl Iterator<Item = &'s Signal>) -> f64 {
    let longest = signals.map(Signal::longest_piece).reduce(f64::max);
    longest.unwrap_or(f64::INFINITY)
}

/// What a quantity of which a part of a signal is taken off is on the pairs of that; `weight` is that of its third derivative through
/// the blocks.
pub(super) fn signal_rows(
    n_pairs: usize,
    direct: f64,
    weight: f64,
) -> impl Iterator<Item = TurningRow> {
    (0..n_pairs).map(move |pair| TurningRow {
        row: if pair == 0 { [direct, 0.0] } else { [0.0, 0.0] },
        weight: match pair {
            0 => weight,
            1 => direct.abs(),
            _ => 0.0,
        },
        reach: if pair == 0 && direct != 0.0 {
            f64::INFINITY
        } else {
            0.0
        },
        forced: 0.0,
    })
}

impl Drive for ManyDrive {
    /// The responses to each rotation, and to each derivative of each signal.
    type Reply = (Vec<Response>, Vec<Pair>);

    fn reply(&self, j: usize, alone: &Alone) -> (Vec<Response>, Vec<Pair>) {
        let turned = self.forces(j);
        let turned = turned.map(|(w, f)| alone.block.forced(alone.t, w, f));
        let mut signals = Vec::new();
        for signal in &self.signals {
            let orders = 2 * signal.n_pairs();
            signals.extend(alone.block.ramped(alone.t, orders, signal.directions[j]));
        }
        (turned.collect(), signals)
    }

    fn added((turned, signals): &(Vec<Response>, Vec<Pair>), stored: &[Pair]) -> Pair {
        let phasors = turned.iter().zip(stored);
        let added = phasors.map(|(&reply, &u)| real_part(reply, u));
        let added = added.fold(NOTHING, plus);
        let derivatives = stored[turned.len()..].as_flattened();
        let responses = signals.iter().zip(derivatives);
        responses.fold(added, |sum, (reply, x)| plus(sum, reply.map(|r| r * x)))
    }

    fn inputs(&self, j: usize, stored: &[Pair]) -> [Pair; 3] {
        let sum = |[a, b, c]: [Pair; 3], [x, y, z]: [Pair; 3]| [plus(a, x), plus(b, y), plus(c, z)];
        let phasors = stored.iter().map(|u| Complex::new(u[0], u[1]));
        let turned = self.forces(j).zip(phasors);
        let turned = turned.map(|((w, f), u)| harmonic_inputs(w, f, u));
        let turned = turned.fold([NOTHING; 3], sum);
        let signals = self.signals(j).zip(self.parted(stored));
        let signals = signals.map(|(d, own)| {
            let own = own.as_flattened();
            [0, 1, 2].map(|m| d.map(|d| d * own.get(m).copied().unwrap_or(0.0)))
        });
        signals.fold(turned, sum)
    }

    fn forces(&self, j: usize) -> impl Iterator<Item = (f64, Response)> {
        self.frequencies()
            .zip(self.forces.iter().map(move |force| force[j]))
    }

    fn n_signals(&self) -> usize {
        self.signals.len()
    }

    fn signals(&self, j: usize) -> impl Iterator<Item = Pair> {
        self.signals.iter().map(move |signal| signal.directions[j])
    }

    fn load(&self, _j: usize) -> Pair {
        [0.0, 0.0]
    }
}
