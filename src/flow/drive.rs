//! What drives a linear flow: a harmonic force, a constant load, both, or nothing. A flow without forcing or without load
//! compiles to code without them.

use crate::flow::gap_row::Derivatives;
use crate::linalg::plane::plus;
use crate::modal::{Block, Pair, Propagation, Response};
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
    /// The phasor as the pair of a state that it is stored in.
    fn stored(u: Self::Phasor) -> Option<Pair>;
    /// The phasor from the end of a state.
    fn read(stored: &[Pair]) -> Self::Phasor;
    /// The phasor after a time whose own phasor is `turn`.
    fn turned(u: Self::Phasor, turn: Self::Phasor) -> Self::Phasor;
    /// The phasor of a span of time: `e^{i w t}`.
    fn turn(&self, t: f64) -> Self::Phasor;
    /// The stored phasor with its derivatives, if there is one.
    fn turning(&self, u: Self::Phasor) -> Option<Derivatives>;
}

/// What acts on the blocks of a flow.
pub(crate) trait Drive: Turning {
    /// The response of one block from rest over a fixed time, as a function of the phasor.
    type Reply: Copy + Default;

    /// The reply of block j over a time.
    fn reply(&self, j: usize, alone: &Alone) -> Self::Reply;
    /// What the reply adds to the block's state.
    fn added(reply: Self::Reply, u: Self::Phasor) -> Pair;
    /// The input to block j and its first two derivatives.
    fn inputs(&self, j: usize, u: Self::Phasor) -> [Pair; 3];
    /// The force on block j, zero where there is none.
    fn force(&self, j: usize) -> Response;
    /// The constant load on block j, zero where there is none.
    fn load(&self, j: usize) -> Pair;
    /// The forcing frequency, zero without forcing.
    fn frequency(&self) -> f64;
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
    fn stored((): ()) -> Option<Pair> {
        None
    }

    fn read(_stored: &[Pair]) {}

    fn turned((): (), (): ()) {}

    fn turn(&self, _t: f64) {}

    #[inline]
    fn turning(&self, (): ()) -> Option<Derivatives> {
        None
    }
}

impl Drive for Undriven {
    type Reply = ();

    fn reply(&self, _j: usize, _alone: &Alone) {}

    #[inline]
    fn added((): (), (): ()) -> Pair {
        NOTHING
    }

    #[inline]
    fn inputs(&self, _j: usize, (): ()) -> [Pair; 3] {
        [NOTHING; 3]
    }

    fn force(&self, _j: usize) -> Response {
        [Complex::new(0.0, 0.0); 2]
    }

    fn load(&self, _j: usize) -> Pair {
        [0.0, 0.0]
    }

    fn frequency(&self) -> f64 {
        0.0
    }
}

/// `Re(f_j e^{i (w t + phase)})` on block j.
#[derive(Debug, Clone)]
pub(crate) struct HarmonicDrive {
    pub frequency: f64,
    pub force: Vec<Response>,
}

#[inline]
fn real_part(f: Response, u: Complex<f64>) -> Pair {
    [
        f[0].re * u.re - f[0].im * u.im,
        f[1].re * u.re - f[1].im * u.im,
    ]
}

impl Turning for HarmonicDrive {
    type Phasor = Complex<f64>;

    fn phasor(&self, angle: f64) -> Complex<f64> {
        let (sin, cos) = angle.sin_cos();
        Complex::new(cos, sin)
    }

    #[inline]
    fn stored(u: Complex<f64>) -> Option<Pair> {
        Some([u.re, u.im])
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

    fn turning(&self, u: Complex<f64>) -> Option<Derivatives> {
        let w = self.frequency;
        let (z, d1) = ([u.re, u.im], [-w * u.im, w * u.re]);
        Some(Derivatives {
            z,
            d1,
            d2: z.map(|x| -w * w * x),
            d3: d1.map(|x| -w * w * x),
            norm: 0.0,
        })
    }
}

impl Drive for HarmonicDrive {
    type Reply = Response;

    fn reply(&self, j: usize, alone: &Alone) -> Response {
        alone.block.forced(alone.t, self.frequency, self.force[j])
    }

    #[inline]
    fn added(reply: Response, u: Complex<f64>) -> Pair {
        real_part(reply, u)
    }

    #[inline]
    fn inputs(&self, j: usize, u: Complex<f64>) -> [Pair; 3] {
        let (w, f) = (self.frequency, self.force[j]);
        let value = real_part(f, u);
        let slope = real_part(f, Complex::new(-w * u.im, w * u.re));
        [value, slope, [-w * w * value[0], -w * w * value[1]]]
    }

    fn force(&self, j: usize) -> Response {
        self.force[j]
    }

    fn load(&self, _j: usize) -> Pair {
        [0.0, 0.0]
    }

    fn frequency(&self) -> f64 {
        self.frequency
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
    fn stored(u: D::Phasor) -> Option<Pair> {
        D::stored(u)
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
    fn turning(&self, u: D::Phasor) -> Option<Derivatives> {
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
    fn added((loaded, reply): (Pair, D::Reply), u: D::Phasor) -> Pair {
        plus(D::added(reply, u), loaded)
    }

    #[inline]
    fn inputs(&self, j: usize, u: D::Phasor) -> [Pair; 3] {
        let [value, slope, bend] = self.drive.inputs(j, u);
        [plus(value, self.load[j]), slope, bend]
    }

    fn force(&self, j: usize) -> Response {
        self.drive.force(j)
    }

    fn load(&self, j: usize) -> Pair {
        self.load[j]
    }

    fn frequency(&self) -> f64 {
        self.drive.frequency()
    }
}
