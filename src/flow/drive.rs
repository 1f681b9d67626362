//! What drives a linear flow: a harmonic force, or nothing. A flow without forcing compiles to code without one.

use crate::flow::gap_row::Derivatives;
use crate::modal::{Block, Pair, Response};
use nalgebra::Complex;

/// The forcing of the blocks of a flow.
pub(crate) trait Drive {
    /// `e^{i (w t + phase)}`, or nothing.
    type Phasor: Copy + Default;
    /// The response of one block from rest over a fixed time, as a function of the phasor.
    type Reply: Copy + Default;

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
    /// The reply of block j over a time t.
    fn reply(&self, j: usize, block: Block, t: f64) -> Self::Reply;
    /// What the reply adds to the block's state.
    fn added(reply: Self::Reply, u: Self::Phasor) -> Pair;
    /// The input to block j and its first two derivatives.
    fn inputs(&self, j: usize, u: Self::Phasor) -> [Pair; 3];
    /// The stored phasor with its derivatives, if there is one.
    fn turning(&self, u: Self::Phasor) -> Option<Derivatives>;
    /// The force on block j, zero where there is none.
    fn force(&self, j: usize) -> Response;
    /// The forcing frequency, zero without forcing.
    fn frequency(&self) -> f64;
}

/// No forcing.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Undriven;

/// What is added for no forcing: minus zero leaves every number as it is, the sign of zero too, so that the compiler takes the
/// addition out, which it may not do with zero.
const NOTHING: Pair = [-0.0, -0.0];

impl Drive for Undriven {
    type Phasor = ();
    type Reply = ();

    fn phasor(&self, _angle: f64) {}
    #[inline]
    fn stored((): ()) -> Option<Pair> {
        None
    }
    fn read(_stored: &[Pair]) {}
    fn turned((): (), (): ()) {}
    fn turn(&self, _t: f64) {}
    fn reply(&self, _j: usize, _block: Block, _t: f64) {}
    #[inline]
    fn added((): (), (): ()) -> Pair {
        NOTHING
    }
    #[inline]
    fn inputs(&self, _j: usize, (): ()) -> [Pair; 3] {
        [NOTHING; 3]
    }
    #[inline]
    fn turning(&self, (): ()) -> Option<Derivatives> {
        None
    }
    fn force(&self, _j: usize) -> Response {
        [Complex::new(0.0, 0.0); 2]
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

impl Drive for HarmonicDrive {
    type Phasor = Complex<f64>;
    type Reply = Response;

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
    fn reply(&self, j: usize, block: Block, t: f64) -> Response {
        block.forced(t, self.frequency, self.force[j])
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
    fn force(&self, j: usize) -> Response {
        self.force[j]
    }
    fn frequency(&self) -> f64 {
        self.frequency
    }
}
