//! The drive of a linear flow: a harmonic force, a constant load, both, or nothing; several harmonics and signals are in `many_drive.rs`.
//! Forces are rates of change of modal pairs. A flow without forcing or without load compiles to code without them.

use crate::flow::gap_row::{Derivatives, Quantity};
use crate::linalg::elementary::sin_cos;
use crate::linalg::plane::plus;
use crate::modal::{Block, Pair, Propagation, Response};
use crate::model::Moment;
use nalgebra::Complex;

/// A block without its drive, over a fixed time.
pub(crate) struct Alone {
    pub block: Block,
    pub propagation: Propagation,
    pub t: f64,
    /// `e^{A t}`
    pub exponential: [Pair; 2],
}

/// How forcing changes with time: its phasors and the derivatives of its signals, stored in pairs at the end of a state.
pub(crate) trait Turning {
    /// The stored pairs, in the form in which the drive reads them.
    type Stored<'s>: Copy;
    /// The map of the stored pairs over a fixed time.
    type Turn: Default;

    /// How many pairs it stores.
    fn n_pairs(&self) -> usize;
    /// Writes the stored pairs for a moment.
    fn store(&self, at: Moment, stored: &mut [Pair]);
    /// Reads the stored pairs.
    fn read(stored: &[Pair]) -> Self::Stored<'_>;
    /// The frequencies of the phasors \[rad/s\].
    fn frequencies(&self) -> impl Iterator<Item = f64> + Clone;
    /// The map of the stored pairs over a span of time.
    fn turn(&self, t: f64) -> Self::Turn;
    /// Applies that map.
    fn carry(&self, turn: &Self::Turn, stored: &mut [Pair]);
    /// The stored pairs with their derivatives.
    fn turning<'s>(&'s self, seen: Self::Stored<'s>) -> impl Iterator<Item = Derivatives> + 's;
    /// The row of a quantity on the stored pairs; `weights` are what one unit of the third derivative of each signal adds, through the
    /// blocks, to the fourth derivative of the quantity.
    fn rows(&self, quantity: &Quantity, weights: &[f64]) -> Vec<TurningRow>;
}

/// The row of a quantity on one stored pair, with bounds.
#[derive(Default)]
pub(crate) struct TurningRow {
    pub row: Pair,
    /// Bound on what one unit of the pair's norm adds to the fourth derivative.
    pub weight: f64,
    /// Bound on what the pair adds to the quantity at any later time.
    pub reach: f64,
    /// Bound on its own part of the fourth derivative.
    pub forced: f64,
}

impl TurningRow {
    /// That of a harmonic `Re(f e^{i w t})`.
    pub fn of_harmonic(f: Complex<f64>, w: f64) -> Self {
        Self {
            row: [f.re, -f.im],
            weight: 0.0,
            reach: f.norm(),
            forced: f.norm() * w.powi(4),
        }
    }
}

/// A phasor of a frequency with its derivatives.
#[inline]
pub(crate) fn turning(u: Complex<f64>, w: f64) -> Derivatives {
    let (z, d1) = ([u.re, u.im], [-w * u.im, w * u.re]);
    Derivatives {
        z,
        d1,
        d2: z.map(|x| -w * w * x),
        d3: d1.map(|x| -w * w * x),
        norm: 0.0,
    }
}

/// The forces on the blocks of a flow.
pub(crate) trait Drive: Turning {
    /// Whether it never changes.
    const IS_CONSTANT: bool = false;
    /// The response of one block from rest over a fixed time, as a function of what is stored.
    type Reply: Clone + Default;

    /// The reply of block j over a time.
    fn reply(&self, j: usize, alone: &Alone) -> Self::Reply;
    /// What the reply adds to the block's state.
    fn added(reply: &Self::Reply, seen: Self::Stored<'_>) -> Pair;
    /// The input to block j and its first two derivatives.
    fn inputs(&self, j: usize, seen: Self::Stored<'_>) -> [Pair; 3];
    /// The harmonics of the force on block j, with their frequencies.
    fn forces(&self, j: usize) -> impl Iterator<Item = (f64, Response)>;
    /// How many signals there are.
    fn n_signals(&self) -> usize {
        0
    }
    /// How each signal acts on block j.
    fn signals(&self, _j: usize) -> impl Iterator<Item = Pair> {
        std::iter::empty()
    }
    /// The lengths of the shortest and of the longest piece of its signals, beyond which no step goes.
    fn pieces(&self) -> Option<[f64; 2]> {
        None
    }
    /// The constant load on block j, zero where there is none.
    fn load(&self, j: usize) -> Pair;
}

/// No forcing.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Undriven;

/// The pair that is added where there is no forcing. Adding minus zero leaves every number as it is, the sign of a zero too, so that the
/// compiler may leave the addition out; with zero it may not.
pub(super) const MINUS_ZERO: Pair = [-0.0, -0.0];

impl Turning for Undriven {
    type Stored<'s> = ();
    type Turn = ();

    fn n_pairs(&self) -> usize {
        0
    }

    fn store(&self, _at: Moment, _stored: &mut [Pair]) {}

    fn read(_stored: &[Pair]) {}

    fn frequencies(&self) -> impl Iterator<Item = f64> + Clone {
        std::iter::empty()
    }

    fn turn(&self, _t: f64) {}

    #[inline]
    fn carry(&self, (): &(), _stored: &mut [Pair]) {}

    #[inline]
    fn turning<'s>(&'s self, (): Self::Stored<'s>) -> impl Iterator<Item = Derivatives> + 's {
        std::iter::empty()
    }

    fn rows(&self, _quantity: &Quantity, _weights: &[f64]) -> Vec<TurningRow> {
        Vec::new()
    }
}

impl Drive for Undriven {
    const IS_CONSTANT: bool = true;
    type Reply = ();

    fn reply(&self, _j: usize, _alone: &Alone) {}

    #[inline]
    fn added((): &(), (): ()) -> Pair {
        MINUS_ZERO
    }

    #[inline]
    fn inputs(&self, _j: usize, (): ()) -> [Pair; 3] {
        [MINUS_ZERO; 3]
    }

    fn forces(&self, _j: usize) -> impl Iterator<Item = (f64, Response)> {
        std::iter::empty()
    }

    fn load(&self, _j: usize) -> Pair {
        [0.0, 0.0]
    }
}

/// `Re(f_j e^{i (w t + phase)})` on block j.
#[derive(Debug, Clone)]
pub(crate) struct HarmonicDrive {
    pub frequency: f64,
    pub force: Vec<Response>,
}

/// `Re(f u)`, `u = (cos, sin)`.
#[inline]
pub(crate) fn real_part(f: Response, u: Pair) -> Pair {
    f.map(|f| f.re * u[0] - f.im * u[1])
}

/// The input of one harmonic and its first two derivatives.
#[inline]
pub(super) fn harmonic_inputs(w: f64, f: Response, u: Complex<f64>) -> [Pair; 3] {
    let value = real_part(f, [u.re, u.im]);
    let slope = real_part(f, [-w * u.im, w * u.re]);
    [value, slope, [-w * w * value[0], -w * w * value[1]]]
}

impl Turning for HarmonicDrive {
    type Stored<'s> = Complex<f64>;
    type Turn = Complex<f64>;

    fn n_pairs(&self) -> usize {
        1
    }

    #[inline]
    fn store(&self, at: Moment, stored: &mut [Pair]) {
        let (sin, cos) = sin_cos(at.angle);
        if let Some(place) = stored.first_mut() {
            *place = [cos, sin];
        }
    }

    fn frequencies(&self) -> impl Iterator<Item = f64> + Clone {
        std::iter::once(self.frequency)
    }

    #[inline]
    fn read(stored: &[Pair]) -> Complex<f64> {
        stored
            .first()
            .map_or_else(Complex::default, |u| Complex::new(u[0], u[1]))
    }

    fn turn(&self, t: f64) -> Complex<f64> {
        let (sin, cos) = sin_cos(self.frequency * t);
        Complex::new(cos, sin)
    }

    #[inline]
    fn carry(&self, turn: &Complex<f64>, stored: &mut [Pair]) {
        let u = Self::read(stored) * turn;
        if let Some(place) = stored.first_mut() {
            *place = [u.re, u.im];
        }
    }

    #[inline]
    fn turning<'s>(&'s self, u: Self::Stored<'s>) -> impl Iterator<Item = Derivatives> + 's {
        std::iter::once(turning(u, self.frequency))
    }

    fn rows(&self, quantity: &Quantity, _weights: &[f64]) -> Vec<TurningRow> {
        let f = quantity.harmonics().next().unwrap_or_default();
        vec![TurningRow::of_harmonic(f, self.frequency)]
    }
}

impl Drive for HarmonicDrive {
    type Reply = Response;

    fn reply(&self, j: usize, alone: &Alone) -> Response {
        alone.block.forced(alone.t, self.frequency, self.force[j])
    }

    #[inline]
    fn added(reply: &Response, u: Complex<f64>) -> Pair {
        real_part(*reply, [u.re, u.im])
    }

    #[inline]
    fn inputs(&self, j: usize, u: Complex<f64>) -> [Pair; 3] {
        harmonic_inputs(self.frequency, self.force[j], u)
    }

    fn forces(&self, j: usize) -> impl Iterator<Item = (f64, Response)> {
        std::iter::once((self.frequency, self.force[j]))
    }

    fn load(&self, _j: usize) -> Pair {
        [0.0, 0.0]
    }
}

/// A constant load on each block beside another drive.
#[derive(Debug, Clone)]
pub(crate) struct Loaded<D> {
    pub load: Vec<Pair>,
    pub drive: D,
}

impl<D: Drive> Turning for Loaded<D> {
    type Stored<'s> = D::Stored<'s>;
    type Turn = D::Turn;

    fn n_pairs(&self) -> usize {
        self.drive.n_pairs()
    }

    #[inline]
    fn store(&self, at: Moment, stored: &mut [Pair]) {
        self.drive.store(at, stored);
    }

    fn frequencies(&self) -> impl Iterator<Item = f64> + Clone {
        self.drive.frequencies()
    }

    #[inline]
    fn read(stored: &[Pair]) -> D::Stored<'_> {
        D::read(stored)
    }

    fn turn(&self, t: f64) -> D::Turn {
        self.drive.turn(t)
    }

    #[inline]
    fn carry(&self, turn: &D::Turn, stored: &mut [Pair]) {
        self.drive.carry(turn, stored);
    }

    #[inline]
    fn turning<'s>(&'s self, seen: Self::Stored<'s>) -> impl Iterator<Item = Derivatives> + 's {
        self.drive.turning(seen)
    }

    fn rows(&self, quantity: &Quantity, weights: &[f64]) -> Vec<TurningRow> {
        self.drive.rows(quantity, weights)
    }
}

impl<D: Drive> Drive for Loaded<D> {
    const IS_CONSTANT: bool = D::IS_CONSTANT;
    type Reply = (Pair, D::Reply);

    fn reply(&self, j: usize, alone: &Alone) -> (Pair, D::Reply) {
        let loaded = alone
            .propagation
            .loaded(alone.t, &alone.exponential, self.load[j]);
        (loaded, self.drive.reply(j, alone))
    }

    #[inline]
    fn added((loaded, reply): &(Pair, D::Reply), seen: D::Stored<'_>) -> Pair {
        plus(D::added(reply, seen), *loaded)
    }

    #[inline]
    fn inputs(&self, j: usize, seen: D::Stored<'_>) -> [Pair; 3] {
        let [value, slope, bend] = self.drive.inputs(j, seen);
        [plus(value, self.load[j]), slope, bend]
    }

    fn forces(&self, j: usize) -> impl Iterator<Item = (f64, Response)> {
        self.drive.forces(j)
    }

    fn n_signals(&self) -> usize {
        self.drive.n_signals()
    }

    fn signals(&self, j: usize) -> impl Iterator<Item = Pair> {
        self.drive.signals(j)
    }

    fn pieces(&self) -> Option<[f64; 2]> {
        self.drive.pieces()
    }

    fn load(&self, j: usize) -> Pair {
        self.load[j]
    }
}
