//! The widest registers that the processor has, chosen as the program runs: numbers of several motions, or of two links, are
//! handled as one.

use crate::linalg::elementary::{exponentials, sines_and_cosines};
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use pulp::Scalar;
use pulp::{Arch, Simd, WithSimd};

/// Arithmetic in registers of some kind.
pub(crate) trait Arithmetic {
    /// `a b + c`, rounded once where the processor does that in one instruction.
    fn add_product(a: f64, b: f64, c: f64) -> f64;
}

impl<S: Simd> Arithmetic for S {
    #[allow(clippy::inline_always, reason = "one instruction")]
    #[inline(always)]
    fn add_product(a: f64, b: f64, c: f64) -> f64 {
        if S::IS_SCALAR {
            a * b + c
        } else {
            a.mul_add(b, c)
        }
    }
}

/// How many numbers the widest registers hold.
pub(crate) fn width() -> usize {
    struct Width;
    impl WithSimd for Width {
        type Output = usize;
        #[inline]
        fn with_simd<S: Simd>(self, _: S) -> usize {
            S::F64_LANES
        }
    }
    Arch::new().dispatch(Width)
}

/// Does some work on K numbers at a time, which must be inlined as a whole, in code compiled for the widest registers that K
/// numbers fill. There is none for four in registers of eight, nor for eight in narrower ones.
///
/// # Panics
/// For K above 4 on a processor without registers of eight ([`width`] says).
#[inline]
pub(crate) fn in_registers_of<const K: usize, W: WithSimd>(work: W) -> W::Output {
    match Arch::new() {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Arch::V4(simd) if const { K > 4 } => Simd::vectorize(simd, work),
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Arch::V4(simd) if const { K <= 4 } => Simd::vectorize(*simd, work),
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Arch::V3(simd) if const { K <= 4 } => Simd::vectorize(simd, work),
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Arch::Scalar if const { K <= 4 } => work.with_simd(Scalar),
        #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
        arch if const { K <= 4 } => arch.dispatch(work),
        _ => unreachable!("{K} numbers at a time ask for registers of eight"),
    }
}

/// What angles and exponents are the arguments of.
pub(crate) struct Turned<const K: usize> {
    pub sines: [f64; K],
    pub cosines: [f64; K],
    pub powers: [f64; K],
}

/// Sines and cosines of K angles, and `e^x` of K exponents, with the bits of each by itself.
pub(crate) fn turned<const K: usize>(angles: &[f64; K], exponents: &[f64; K]) -> Turned<K> {
    struct Work<'a, const K: usize>(&'a [f64; K], &'a [f64; K]);
    impl<const K: usize> WithSimd for Work<'_, K> {
        type Output = Turned<K>;
        #[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
        #[inline(always)]
        fn with_simd<S: Simd>(self, _: S) -> Turned<K> {
            let [sines, cosines] = sines_and_cosines(self.0);
            Turned {
                sines,
                cosines,
                powers: exponentials(self.1),
            }
        }
    }
    in_registers_of::<K, _>(Work(angles, exponents))
}
