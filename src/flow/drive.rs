//! What drives a linear flow: a harmonic force or several, a constant load, both, or nothing. A flow without forcing or without load
//! compiles to code without them.

use crate::flow::gap_row::Derivatives;
use crate::linalg::plane::plus;
use crate::modal::{Block, Pair, Propagation, Response};
use crate::model::powers;
use nalgebra::Complex;

/// How a block moves by itself over a fixed time.
pub(crate) struct Alone {
    pub block: Block,
    pub propagation: Propagation,
    pub t: f64,
    /// `e^{A t}`
    pub exponential: [Pair; 2],
}

/// How forcing turns with time.
pub(crate) trait Turning {
    /// `e^{i (w t + phase)}`, or nothing.
    type Phasor: Copy + Default;

    /// The phasor at an angle.
    fn phasor(&self, angle: f64) -> Self::Phasor;
    /// The phasors of all harmonics as the pairs of a state that they are stored in.
    fn stored(&self, u: Self::Phasor) -> impl Iterator<Item = Pair>;
    /// The phasor from the end of a state.
    fn read(stored: &[Pair]) -> Self::Phasor;
    /// The frequencies of the harmonics.
    fn frequencies(&self) -> impl Iterator<Item = f64> + Clone;
    /// The phasor after a time whose own phasor is `turn`.
    fn turned(u: Self::Phasor, turn: Self::Phasor) -> Self::Phasor;
    /// The phasor of a span of time: `e^{i w t}`.
    fn turn(&self, t: f64) -> Self::Phasor;
    /// The stored phasors with their derivatives.
    fn turning(&self, u: Self::Phasor) -> impl Iterator<Item = Derivatives>;
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

/// What acts on the blocks of a flow.
pub(crate) trait Drive: Turning {
    /// The response of one block from rest over a fixed time, as a function of the phasor.
    type Reply: Clone + Default;

    /// The reply of block j over a time.
    fn reply(&self, j: usize, alone: &Alone) -> Self::Reply;
    /// What the reply adds to the block's state.
    fn added(reply: &Self::Reply, u: Self::Phasor) -> Pair;
    /// The input to block j and its first two derivatives.
    fn inputs(&self, j: usize, u: Self::Phasor) -> [Pair; 3];
    /// The harmonics of the force on block j, with their frequencies.
    fn forces(&self, j: usize) -> impl Iterator<Item = (f64, Response)>;
    /// The constant load on block j, zero where there is none.
    fn load(&self, j: usize) -> Pair;
}

/// No forcing.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Undriven;

/// What is added for no forcing: minus zero leaves every number as it is, the sign of zero too, so that the compiler takes the
/// addition out, which it may not do with zero.
const NOTHING: Pair = [-0.0, -0.0];

impl Turning for Undriven {
    type Phasor = ();

    fn phasor(&self, _angle: f64) {}

    #[inline]
    fn stored(&self, (): ()) -> impl Iterator<Item = Pair> {
        std::iter::empty()
    }

    fn read(_stored: &[Pair]) {}

    fn frequencies(&self) -> impl Iterator<Item = f64> + Clone {
        std::iter::empty()
    }

    fn turned((): (), (): ()) {}

    fn turn(&self, _t: f64) {}

    #[inline]
    fn turning(&self, (): ()) -> impl Iterator<Item = Derivatives> {
        std::iter::empty()
    }
}

impl Drive for Undriven {
    type Reply = ();

    fn reply(&self, _j: usize, _alone: &Alone) {}

    #[inline]
    fn added((): &(), (): ()) -> Pair {
        NOTHING
    }

    #[inline]
    fn inputs(&self, _j: usize, (): ()) -> [Pair; 3] {
        [NOTHING; 3]
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
fn harmonic_inputs(w: f64, f: Response, u: Complex<f64>) -> [Pair; 3] {
    let value = real_part(f, [u.re, u.im]);
    let slope = real_part(f, [-w * u.im, w * u.re]);
    [value, slope, [-w * w * value[0], -w * w * value[1]]]
}

impl Turning for HarmonicDrive {
    type Phasor = Complex<f64>;

    fn phasor(&self, angle: f64) -> Complex<f64> {
        let (sin, cos) = angle.sin_cos();
        Complex::new(cos, sin)
    }

    #[inline]
    fn stored(&self, u: Complex<f64>) -> impl Iterator<Item = Pair> {
        std::iter::once([u.re, u.im])
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

    #[inline]
    fn turned(u: Complex<f64>, turn: Complex<f64>) -> Complex<f64> {
        u * turn
    }

    fn turn(&self, t: f64) -> Complex<f64> {
        self.phasor(self.frequency * t)
    }

    #[inline]
    fn turning(&self, u: Complex<f64>) -> impl Iterator<Item = Derivatives> {
        std::iter::once(turning(u, self.frequency))
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

/// `Re sum_k f_kj e^{i k (w t + phase)}` on block j.
#[derive(Debug, Clone)]
pub(crate) struct FourierDrive {
    pub frequency: f64,
    /// By harmonics, then by blocks.
    pub forces: Vec<Vec<Response>>,
}

impl Turning for FourierDrive {
    /// That of the first harmonic, of which the others are powers.
    type Phasor = Complex<f64>;

    fn phasor(&self, angle: f64) -> Complex<f64> {
        Complex::cis(angle)
    }

    fn stored(&self, u: Complex<f64>) -> impl Iterator<Item = Pair> {
        powers(u).take(self.forces.len()).map(|u| [u.re, u.im])
    }

    fn read(stored: &[Pair]) -> Complex<f64> {
        HarmonicDrive::read(stored)
    }

    fn frequencies(&self) -> impl Iterator<Item = f64> + Clone {
        (1..=self.forces.len()).map(|k| k as f64 * self.frequency)
    }

    fn turned(u: Complex<f64>, turn: Complex<f64>) -> Complex<f64> {
        u * turn
    }

    fn turn(&self, t: f64) -> Complex<f64> {
        Complex::cis(self.frequency * t)
    }

    fn turning(&self, u: Complex<f64>) -> impl Iterator<Item = Derivatives> {
        powers(u)
            .zip(self.frequencies())
            .map(|(u, w)| turning(u, w))
    }
}

impl Drive for FourierDrive {
    type Reply = Vec<Response>;

    fn reply(&self, j: usize, alone: &Alone) -> Vec<Response> {
        let each = self
            .forces(j)
            .map(|(w, f)| alone.block.forced(alone.t, w, f));
        each.collect()
    }

    fn added(reply: &Vec<Response>, u: Complex<f64>) -> Pair {
        let each = reply
            .iter()
            .zip(powers(u))
            .map(|(&reply, u)| real_part(reply, [u.re, u.im]));
        each.fold(NOTHING, plus)
    }

    fn inputs(&self, j: usize, u: Complex<f64>) -> [Pair; 3] {
        let each = self
            .forces(j)
            .zip(powers(u))
            .map(|((w, f), u)| harmonic_inputs(w, f, u));
        each.fold([NOTHING; 3], |[a, b, c], [x, y, z]| {
            [plus(a, x), plus(b, y), plus(c, z)]
        })
    }

    fn forces(&self, j: usize) -> impl Iterator<Item = (f64, Response)> {
        self.frequencies()
            .zip(self.forces.iter().map(move |force| force[j]))
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
    type Phasor = D::Phasor;

    fn phasor(&self, angle: f64) -> D::Phasor {
        self.drive.phasor(angle)
    }

    #[inline]
    fn stored(&self, u: D::Phasor) -> impl Iterator<Item = Pair> {
        self.drive.stored(u)
    }

    fn frequencies(&self) -> impl Iterator<Item = f64> + Clone {
        self.drive.frequencies()
    }

    #[inline]
    fn read(stored: &[Pair]) -> D::Phasor {
        D::read(stored)
    }

    #[inline]
    fn turned(u: D::Phasor, turn: D::Phasor) -> D::Phasor {
        D::turned(u, turn)
    }

    fn turn(&self, t: f64) -> D::Phasor {
        self.drive.turn(t)
    }

    #[inline]
    fn turning(&self, u: D::Phasor) -> impl Iterator<Item = Derivatives> {
        self.drive.turning(u)
    }
}

impl<D: Drive> Drive for Loaded<D> {
    type Reply = (Pair, D::Reply);

    fn reply(&self, j: usize, alone: &Alone) -> (Pair, D::Reply) {
        let loaded = alone
            .propagation
            .loaded(alone.t, &alone.exponential, self.load[j]);
        (loaded, self.drive.reply(j, alone))
    }

    #[inline]
    fn added((loaded, reply): &(Pair, D::Reply), u: D::Phasor) -> Pair {
        plus(D::added(reply, u), *loaded)
    }

    #[inline]
    fn inputs(&self, j: usize, u: D::Phasor) -> [Pair; 3] {
        let [value, slope, bend] = self.drive.inputs(j, u);
        [plus(value, self.load[j]), slope, bend]
    }

    fn forces(&self, j: usize) -> impl Iterator<Item = (f64, Response)> {
        self.drive.forces(j)
    }

    fn load(&self, j: usize) -> Pair {
        self.load[j]
    }
}
