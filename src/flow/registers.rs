//! The widest registers that the processor has, chosen as the program runs: numbers of several motions, or of two links, are
//! handled as one.

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
        fn with_simd<S: Simd>(self, _: S) -> usize {
            S::F64_LANES
        }
    }
    in_widest(Width)
}

/// Does some work, which must be inlined as a whole, in code compiled for the widest registers.
#[inline]
pub(crate) fn in_widest<W: WithSimd>(work: W) -> W::Output {
    Arch::new().dispatch(work)
}
