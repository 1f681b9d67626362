//! Anything that drives a linear flow: any number of rotations, harmonics or not, and signals, whose derivatives are stored where the
//! phasors are (theory 10, 11).

use crate::flow::drive::{
    Alone, Drive, MINUS_ZERO, Turning, TurningRow, harmonic_inputs, real_part, turning,
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

/// Highest degree of a polynomial whose derivatives at one time bound its third and fourth derivatives on all of its piece. [exact]
const EASILY_BOUNDED_DEGREE: usize = 3;

impl SignalInput {
    /// Pairs that hold its derivatives of orders 0 to its degree.
    pub fn n_pairs(&self) -> usize {
        self.signal.degree() / 2 + 1
    }

    /// Whether a pair of its own holds bounds on its third and fourth derivatives.
    fn has_bounds(&self) -> bool {
        self.signal.degree() > EASILY_BOUNDED_DEGREE
    }

    /// Bounds on the third and the fourth derivatives, from a moment on to the end of the piece; `stored` are those of that moment.
    fn bounds(&self, at: Moment, stored: &[Pair]) -> Pair {
        let sizes: Vec<f64> = stored.as_flattened().iter().map(|x| x.abs()).collect();
        let rest = self.signal.rest_of_piece(at.since, at.time);
        [3, 4].map(|order| crate::model::taylor(&sizes[order..], rest))
    }

    /// Stores its derivatives at a moment.
    pub fn store(&self, at: Moment, stored: &mut [Pair]) {
        stored.fill([0.0, 0.0]);
        let put = |m: usize, x: f64| stored[m / 2][m % 2] = x;
        self.signal.derivatives(at.since, at.time, put);
    }
}

/// Carries the derivatives of a polynomial over a span of time.
fn shift(t: f64, stored: &mut [Pair]) {
    let stored = stored.as_flattened_mut();
    for m in 0..stored.len() {
        stored[m] = crate::model::taylor(&stored[m..], t);
    }
}

/// The pairs of a polynomial with their derivatives. The norm of the first bounds its third derivative to the end of the piece, that
/// of the second its fourth: `bounds`, where they are not those of a polynomial of degree 3.
fn polynomial(stored: &[Pair], bounds: Option<Pair>) -> impl Iterator<Item = Derivatives> + '_ {
    let flat = stored.as_flattened();
    let of = move |m: usize| flat.get(m).copied().unwrap_or(0.0);
    let bounds = bounds.unwrap_or_else(|| [of(3).abs(), 0.0]);
    (0..stored.len()).map(move |pair| {
        let at = |order: usize| [of(2 * pair + order), of(2 * pair + order + 1)];
        Derivatives {
            z: at(0),
            d1: at(1),
            d2: at(2),
            d3: at(3),
            norm: bounds.get(pair).copied().unwrap_or(0.0),
        }
    })
}

impl ManyDrive {
    /// Pairs before those of bounds.
    fn n_input_pairs(&self) -> usize {
        self.rotations.len() + self.signals.iter().map(SignalInput::n_pairs).sum::<usize>()
    }

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
    type Stored<'s> = &'s [Pair];
    /// What the phasors turn by, and the span.
    type Turn = (Vec<Complex<f64>>, f64);

    /// Those of bounds come last.
    fn n_pairs(&self) -> usize {
        self.n_input_pairs() + self.signals.iter().filter(|own| own.has_bounds()).count()
    }

    fn store(&self, at: Moment, stored: &mut [Pair]) {
        let (moving, bounds) = stored.split_at_mut(self.n_input_pairs());
        let (turned, mut rest) = moving.split_at_mut(self.rotations.len());
        for (place, u) in turned.iter_mut().zip(self.rotations.phasors(at)) {
            *place = [u.re, u.im];
        }
        let mut bounds = bounds.iter_mut();
        for signal in &self.signals {
            let (own, others) = rest.split_at_mut(signal.n_pairs());
            signal.store(at, own);
            if let Some(place) = signal.has_bounds().then(|| bounds.next()).flatten() {
                *place = signal.bounds(at, own);
            }
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

    fn turning<'s>(&'s self, stored: Self::Stored<'s>) -> impl Iterator<Item = Derivatives> + 's {
        let phasors = stored.iter().map(|u| Complex::new(u[0], u[1]));
        let turned = phasors.zip(self.frequencies()).map(|(u, w)| turning(u, w));
        let mut bounds = stored[self.n_input_pairs()..].iter().copied();
        let resting = bounds.clone().map(|_| Derivatives::default());
        let signals = self.signals.iter().zip(self.parted(stored));
        let signals = signals.flat_map(move |(signal, own)| {
            polynomial(own, signal.has_bounds().then(|| bounds.next()).flatten())
        });
        turned.chain(signals).chain(resting)
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
        rows.resize_with(self.n_pairs(), TurningRow::default);
        rows
    }
}

/// What a quantity of which a part of a signal is taken off is on the pairs of that; `weight` is that of its third derivative through
/// the blocks.
fn signal_rows(n_pairs: usize, direct: f64, weight: f64) -> impl Iterator<Item = TurningRow> {
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
        let added = added.fold(MINUS_ZERO, plus);
        let derivatives = stored[turned.len()..].as_flattened();
        let responses = signals.iter().zip(derivatives);
        responses.fold(added, |sum, (reply, x)| plus(sum, reply.map(|r| r * x)))
    }

    fn inputs(&self, j: usize, stored: &[Pair]) -> [Pair; 3] {
        let sum = |[a, b, c]: [Pair; 3], [x, y, z]: [Pair; 3]| [plus(a, x), plus(b, y), plus(c, z)];
        let phasors = stored.iter().map(|u| Complex::new(u[0], u[1]));
        let turned = self.forces(j).zip(phasors);
        let turned = turned.map(|((w, f), u)| harmonic_inputs(w, f, u));
        let turned = turned.fold([MINUS_ZERO; 3], sum);
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

    fn pieces(&self) -> Option<[f64; 2]> {
        let lengths = self.signals.iter().map(|own| own.signal.piece_lengths());
        lengths.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
    }

    fn load(&self, _j: usize) -> Pair {
        [0.0, 0.0]
    }
}
