//! Derivatives by differences of which each knows whether its step is short enough: those of second and of fourth order agree there.

use crate::derivative::stencil::{Differences, Stencil};

/// Differences of second and of fourth order agree well, or say something, where they differ by no more than this part of the derivative: that of
/// fourth order is off by the square of it, or less.
const FITS: f64 = 1e-3;
const APART: f64 = 3e-2;

/// Numbers that are known together, one after the other: so many, in parts of a unit; of an infinite one they are not asked.
pub(super) type Block = (usize, f64);

/// Derivatives of blocks of numbers, each by the longest steps that are short enough for it.
pub(super) struct Settled {
    blocks: Vec<Block>,
    /// By what part each misfits, and the derivatives.
    each: Vec<Option<(f64, Vec<f64>)>>,
    /// What is unknown of the numbers, in parts of their units.
    unknown: f64,
}

impl Settled {
    pub fn new(blocks: Vec<Block>, unknown: f64) -> Self {
        Self {
            each: vec![None; blocks.len()],
            blocks,
            unknown,
        }
    }

    /// Takes what differences over the steps of a stencil say better.
    pub fn take(&mut self, stencil: &Stencil, found: &Differences) {
        let mut from = 0;
        for (&(len, unit), own) in self.blocks.iter().zip(&mut self.each) {
            let range = from..from + len;
            from += len;
            let before = own.as_ref().map_or(f64::INFINITY, |own| own.0);
            if before <= FITS {
                continue;
            }
            let unknown = self.unknown * unit / stencil.step;
            let misfit = found.misfit(range.clone(), unknown);
            if own.is_none() || misfit < before {
                *own = Some((misfit, found.derivative[range].to_vec()));
            }
        }
    }

    /// Whether no shorter steps are needed.
    pub fn is_complete(&self) -> bool {
        let misfit =
            |own: &Option<(f64, Vec<f64>)>| own.as_ref().map_or(f64::INFINITY, |own| own.0);
        self.each.iter().all(|own| misfit(own) <= FITS)
    }

    /// All of them; `None` where some are nothing, whatever the step.
    pub fn derivative(self) -> Option<Vec<f64>> {
        let known = self
            .each
            .into_iter()
            .map(|own| own.filter(|own| own.0 <= APART));
        let all: Option<Vec<Vec<f64>>> = known.map(|own| own.map(|own| own.1)).collect();
        all.map(|all| all.concat())
    }
}
