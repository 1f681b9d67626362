//! Eight samples of a flight at once, at equidistant times, in the widest registers: a state, its derivatives and the models of gaps at
//! each of the times (theory 8).

use crate::flow::gap_model::GapModel;
use crate::linalg::plane::{longer_than, plus, times};
use crate::modal::Pair;
use crate::quantity::larger;

/// Number of samples of a flight that are taken at once. [work]
pub(crate) const SAMPLES_AT_ONCE: usize = 8;

/// A number at each sample.
pub(crate) type Eight = [f64; SAMPLES_AT_ONCE];

/// A number at each sample, from the number of the sample.
#[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
#[inline(always)]
pub(crate) fn eight(of: impl Fn(usize) -> f64) -> Eight {
    let mut all = [0.0; SAMPLES_AT_ONCE];
    for (k, x) in all.iter_mut().enumerate() {
        *x = of(k);
    }
    all
}

/// A set of samples, one bit each, the lowest for the first.
pub(crate) type SampleMask = u8;

/// The largest size of a number among the samples that count; `is_counted` is one for these, zero for the others.
#[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
#[inline(always)]
fn largest_of(numbers: &Eight, is_counted: &Eight) -> f64 {
    let mut all = eight(|k| numbers[k].abs() * is_counted[k]);
    for half in [
        SAMPLES_AT_ONCE / 2,
        SAMPLES_AT_ONCE / 4,
        SAMPLES_AT_ONCE / 8,
    ] {
        for k in 0..half {
            all[k] = larger(all[k], all[k + half]);
        }
    }
    all[0]
}

/// The maps of one pair of a state over one step, two, ..., eight: `M^k z + a_k`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stride {
    matrix: [[Eight; 2]; 2],
    added: [Eight; 2],
}

impl Stride {
    /// From the map over one step, `M z + a`.
    pub fn of(matrix: &[Pair; 2], added: Pair) -> Self {
        let mut all = Self {
            matrix: [[[0.0; SAMPLES_AT_ONCE]; 2]; 2],
            added: [[0.0; SAMPLES_AT_ONCE]; 2],
        };
        let (mut power, mut sum) = (*matrix, added);
        for k in 0..SAMPLES_AT_ONCE {
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

    /// The pair at each sample.
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

/// One pair of a state and its first three time derivatives at each sample, as [`crate::flow::Derivatives`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct SampleDerivatives {
    pub z: [Eight; 2],
    pub d1: [Eight; 2],
    pub d2: [Eight; 2],
    pub d3: [Eight; 2],
    pub norm: Eight,
}

impl SampleDerivatives {
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

    /// The pair at one sample.
    #[inline]
    pub fn pair(&self, k: usize) -> Pair {
        [self.z[0][k], self.z[1][k]]
    }
}

/// The model of a gap at each sample, as [`GapModel`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct SampleModels {
    pub c: [Eight; 4],
    pub quartic: Eight,
    pub quintic: f64,
    pub size: Eight,
    /// The largest size of the terms and the largest gap, at the samples that count.
    pub extent: [f64; 2],
}

impl SampleModels {
    /// The model at one sample.
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

    /// Sets the extent from the samples that count.
    #[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
    #[inline(always)]
    pub fn note_extent(&mut self, is_counted: &Eight) {
        self.extent = [&self.size, &self.c[0]].map(|numbers| largest_of(numbers, is_counted));
    }

    /// The samples after which the gap, counted from a floor, provably stays above a part of the size of its terms for a step.
    #[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
    #[inline(always)]
    pub fn above(&self, part: f64, floor: f64, step: f64) -> SampleMask {
        let mut above = 0;
        for k in 0..SAMPLES_AT_ONCE {
            let model = self.at(k);
            let is_above = model.above(floor).is_above(part * model.size, step);
            above |= SampleMask::from(is_above) << k;
        }
        above
    }
}
