//! Eight looks at a flight at once, at times of equal distance, in the widest registers: a state, its derivatives and the models of gaps
//! at each of the times (theory 8).

use crate::flow::gap_model::GapModel;
use crate::linalg::plane::{longer_than, plus, times};
use crate::modal::Pair;
use crate::quantity::larger;

/// How many looks at once.
pub(crate) const LOOKS: usize = 8;

/// A number at each look.
pub(crate) type Eight = [f64; LOOKS];

/// A number at each look, from the place of the look.
#[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
#[inline(always)]
pub(crate) fn eight(of: impl Fn(usize) -> f64) -> Eight {
    let mut all = [0.0; LOOKS];
    for (k, x) in all.iter_mut().enumerate() {
        *x = of(k);
    }
    all
}

/// Which looks, one bit each, the lowest for the first.
pub(crate) type WhichLooks = u8;

/// The largest of the numbers at looks, none of them negative; `is_seen` is one for the looks that count, zero for the others.
#[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
#[inline(always)]
fn largest_of(numbers: &Eight, is_seen: &Eight) -> f64 {
    let mut all = eight(|k| numbers[k].abs() * is_seen[k]);
    for half in [LOOKS / 2, LOOKS / 4, LOOKS / 8] {
        for k in 0..half {
            all[k] = larger(all[k], all[k + half]);
        }
    }
    all[0]
}

/// What carries one pair of a state over one step, two, ..., eight: `M^k z + a_k`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stride {
    matrix: [[Eight; 2]; 2],
    added: [Eight; 2],
}

impl Stride {
    /// From what carries it over one step.
    pub fn of(matrix: &[Pair; 2], added: Pair) -> Self {
        let mut all = Self {
            matrix: [[[0.0; LOOKS]; 2]; 2],
            added: [[0.0; LOOKS]; 2],
        };
        let (mut power, mut sum) = (*matrix, added);
        for k in 0..LOOKS {
            for (i, (row, added)) in all.matrix.iter_mut().zip(&mut all.added).enumerate() {
                added[k] = sum[i];
                for (entry, x) in row.iter_mut().zip(power[i]) {
                    entry[k] = x;
                }
            }
            let columns = [0, 1].map(|j| times(matrix, [power[0][j], power[1][j]]));
            power = [0, 1].map(|i| [columns[0][i], columns[1][i]]);
            sum = plus(times(matrix, sum), added);
        }
        all
    }

    /// The pair at each look.
    #[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
    #[inline(always)]
    fn carried(&self, z: Pair) -> [Eight; 2] {
        let [[a, b], [c, d]] = &self.matrix;
        [
            eight(|k| a[k] * z[0] + b[k] * z[1] + self.added[0][k]),
            eight(|k| c[k] * z[0] + d[k] * z[1] + self.added[1][k]),
        ]
    }
}

/// One pair of a state and its first three time derivatives at each look, as [`crate::flow::Derivatives`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct LookDerivatives {
    pub z: [Eight; 2],
    pub d1: [Eight; 2],
    pub d2: [Eight; 2],
    pub d3: [Eight; 2],
    pub norm: Eight,
}

impl LookDerivatives {
    /// Those of a block `z' = A z + f` whose norm has a scale for the first unknown.
    #[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
    #[inline(always)]
    pub fn of((a, f, scale): (&[Pair; 2], Pair, f64), stride: &Stride, z: Pair) -> Self {
        let image = |x: &[Eight; 2], f: Pair| {
            [
                eight(|k| a[0][0] * x[0][k] + a[0][1] * x[1][k] + f[0]),
                eight(|k| a[1][0] * x[0][k] + a[1][1] * x[1][k] + f[1]),
            ]
        };
        let z = stride.carried(z);
        let d1 = image(&z, f);
        let d2 = image(&d1, [0.0; 2]);
        let d3 = image(&d2, [0.0; 2]);
        let norm = eight(|k| longer_than(scale * d3[0][k], d3[1][k]));
        Self {
            z,
            d1,
            d2,
            d3,
            norm,
        }
    }

    /// The pair at one look.
    #[inline]
    pub fn pair(&self, k: usize) -> Pair {
        [self.z[0][k], self.z[1][k]]
    }
}

/// The model of a gap at each look, as [`GapModel`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct LookModels {
    pub c: [Eight; 4],
    pub quartic: Eight,
    pub quintic: f64,
    pub size: Eight,
    /// The largest size of the terms and the largest gap, at the looks that count.
    pub extent: [f64; 2],
}

impl LookModels {
    /// The model at one look.
    #[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
    #[inline(always)]
    pub fn at(&self, k: usize) -> GapModel {
        GapModel {
            c: [self.c[0][k], self.c[1][k], self.c[2][k], self.c[3][k]],
            quartic: self.quartic[k],
            quintic: self.quintic,
            size: self.size[k],
        }
    }

    /// Takes note of the largest size of the terms, and of the largest gap, at the looks that count.
    #[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
    #[inline(always)]
    pub fn note_extent(&mut self, is_seen: &Eight) {
        self.extent = [&self.size, &self.c[0]].map(|numbers| largest_of(numbers, is_seen));
    }

    /// At which looks the gap, counted from a floor, is provably above a part of the size of its terms for a step.
    #[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
    #[inline(always)]
    pub fn above(&self, part: f64, floor: f64, step: f64) -> WhichLooks {
        let mut above = 0;
        for k in 0..LOOKS {
            let model = self.at(k);
            let is_above = model.above(floor).is_above(part * model.size, step);
            above |= WhichLooks::from(is_above) << k;
        }
        above
    }
}
