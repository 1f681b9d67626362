//! Derivatives by differences of which each knows whether its step is short enough, those of second and of fourth order agreeing there, and
//! long enough for what is unknown of its values.

use crate::derivative::stencil::{Differences, Stencil};

/// Differences of second and of fourth order agree well, or say something, where they differ by no more than this part of the derivative: that of
/// fourth order is off by the square of it, or less, each of its numbers by so much of the largest.
const FITS: f64 = 1e-4;
const APART: f64 = 3e-2;

/// Numbers that are known together, one after the other: so many, in parts of a unit.
pub(super) type Block = (usize, f64);

/// A derivative of one block.
#[derive(Debug, Clone)]
struct Known {
    derivative: Vec<f64>,
    /// By what part it differs from that of lower order, beyond what is unknown.
    misfit: f64,
    /// By what part it is off, by the length of its step and by what is unknown over that.
    error: f64,
}

/// Derivatives of blocks of numbers, each by the steps that are best for it.
pub(super) struct Settled {
    blocks: Vec<Block>,
    each: Vec<Option<Known>>,
    /// Whether the last steps were short enough for all.
    is_complete: bool,
    /// What is unknown of the numbers, in parts of their units.
    unknown: f64,
}

impl Settled {
    pub fn new(blocks: Vec<Block>, unknown: f64) -> Self {
        Self {
            each: vec![None; blocks.len()],
            blocks,
            is_complete: false,
            unknown,
        }
    }

    /// Takes what differences over the steps of a stencil say better.
    pub fn take(&mut self, stencil: &Stencil, found: &Differences) {
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
                *own = Some(Known {
                    derivative,
                    misfit,
                    error,
                });
            }
        }
        self.is_complete = worst <= FITS;
    }

    /// Whether no shorter steps are needed.
    pub fn is_complete(&self) -> bool {
        self.is_complete
    }

    /// All of them; `None` where some are nothing, whatever the step.
    pub fn derivative(self) -> Option<Vec<f64>> {
        let each = self.each.into_iter();
        let known = each.map(|own| own.filter(|own| own.misfit <= APART));
        let all: Option<Vec<Vec<f64>>> = known.map(|own| own.map(|own| own.derivative)).collect();
        all.map(|all| all.concat())
    }
}
