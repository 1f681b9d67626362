//! Derivatives by differences with a choice of the step for each block of numbers: short enough that differences of second and of fourth
//! order agree, long enough that the noise of the values is not felt.

use crate::derivative::stencil::{DifferenceQuotient, Stencil};
use crate::tolerance::{DIFFERENCES_AGREE, DIFFERENCES_DISAGREE};

/// A block of numbers, one after the other: how many they are, and their common unit.
pub(super) type ScaledBlock = (usize, f64);

/// The best derivative of one block so far.
#[derive(Debug, Clone)]
struct BlockDerivative {
    derivative: Vec<f64>,
    /// Relative difference to the derivative of lower order, less what noise explains [-].
    misfit: f64,
    /// Relative error, of the step and of the noise [-].
    error: f64,
}

/// Derivatives of blocks of numbers, each by the steps that are best for it.
pub(super) struct AdaptiveDifferences {
    blocks: Vec<ScaledBlock>,
    each: Vec<Option<BlockDerivative>>,
    /// Whether the last steps were short enough for all.
    is_complete: bool,
    /// Noise of the numbers, in their units [-].
    unknown: f64,
}

impl AdaptiveDifferences {
    pub fn new(blocks: Vec<ScaledBlock>, unknown: f64) -> Self {
        Self {
            each: vec![None; blocks.len()],
            blocks,
            is_complete: false,
            unknown,
        }
    }

    /// Keeps, for each block, the difference over the steps of a stencil if it is better than the one so far.
    pub fn take(&mut self, stencil: &Stencil, found: &DifferenceQuotient) {
        let (mut from, mut worst) = (0, 0.0f64);
        for (&(len, unit), own) in self.blocks.iter().zip(&mut self.each) {
            let range = from..from + len;
            from += len;
            let (size, beyond) = found.largest(range.clone());
            let unknown = self.unknown * unit / stencil.step;
            let part = |of: f64| if of > 0.0 { of / size } else { 0.0 };
            let misfit = part(beyond - unknown);
            let error = misfit * misfit + part(unknown);
            worst = worst.max(misfit);
            if own.as_ref().is_none_or(|own| error < own.error) {
                let derivative = found.derivative[range].to_vec();
                *own = Some(BlockDerivative {
                    derivative,
                    misfit,
                    error,
                });
            }
        }
        self.is_complete = worst <= DIFFERENCES_AGREE;
    }

    /// Whether no shorter steps are needed.
    pub fn is_complete(&self) -> bool {
        self.is_complete
    }

    /// All derivatives; `None` where no step was good for one of them.
    pub fn derivative(self) -> Option<Vec<f64>> {
        let each = self.each.into_iter();
        let known = each.map(|own| own.filter(|own| own.misfit <= DIFFERENCES_DISAGREE));
        let all: Option<Vec<Vec<f64>>> = known.map(|own| own.map(|own| own.derivative)).collect();
        all.map(|all| all.concat())
    }
}
