//! Steps along a flight that are halves and doubles of one step, so that their propagators are made once and kept (theory 8).

use crate::flow::LinearFlow;
use crate::flow::samples::Stride;
use crate::modal::Pair;
use std::cell::OnceCell;

/// Halvings from the longest step to the shortest that the fastest motion asks for, at the most: with the others they keep the exponent of
/// a step within that of a double. [exact]
const MOST_LEVELS_BETWEEN: f64 = 900.0;
/// Doublings of a flow's longest step, where its bounds hold for ever: a slow body crosses a wide room in few steps. [work]
const LEVEL_DOUBLINGS: usize = 60;
/// Halvings of a step over which the fastest motion changes as a whole: the digits of a double. [exact]
const LEVEL_HALVINGS: usize = 52;
/// Levels for which there is room from the start. [work]
const USUAL_LEVELS: usize = 24;

/// Propagators for steps of a level, each half the one before, made when first asked for.
pub(crate) struct PropagatorLevels<F: LinearFlow> {
    /// The flow's longest step.
    pub(super) longest: f64,
    /// The first level whose step the flow's bounds allow.
    top: usize,
    /// The last level, where a search gives up proving.
    pub deepest: usize,
    /// Those that were asked for, each at its place.
    made: Vec<Option<Level<F>>>,
}

/// What moves a state forward by one step.
struct Level<F: LinearFlow> {
    propagator: F::Propagator,
    /// The same for eight looks at once, made when first asked for.
    strides: OnceCell<Option<Vec<Stride>>>,
}

impl<F: LinearFlow> PropagatorLevels<F> {
    /// No levels yet for a flow.
    pub fn new(flow: &F) -> Self {
        let longest = flow.longest_step();
        // The longest step is as long as the slowest motion allows; the fastest needs short ones.
        let between = (longest * flow.fastest_rate()).log2().ceil();
        let between = between.clamp(0.0, MOST_LEVELS_BETWEEN) as usize;
        Self {
            longest,
            top: if flow.holds_for_ever() {
                0
            } else {
                LEVEL_DOUBLINGS
            },
            deepest: LEVEL_DOUBLINGS + between + LEVEL_HALVINGS,
            made: Vec::with_capacity(USUAL_LEVELS),
        }
    }

    /// The level of the flow's longest step. [exact]
    pub const START: usize = LEVEL_DOUBLINGS;

    /// The level of the next longer step, the same where there is none.
    #[inline]
    pub fn above(&self, level: usize) -> usize {
        if level > self.top { level - 1 } else { level }
    }

    /// The step of a level.
    #[inline]
    pub fn step(&self, level: usize) -> f64 {
        step_of(self.longest, level)
    }

    /// The first level whose step does not exceed a span.
    pub fn level_below(&self, span: f64) -> usize {
        let halvings = (self.longest / span).log2().ceil();
        let level = (LEVEL_DOUBLINGS as f64 + halvings).max(self.top as f64);
        if level < self.deepest as f64 {
            level as usize
        } else {
            self.deepest
        }
    }

    /// Makes what the step of a level needs. Where it had to be made: the work that it was, in operations on a block, at the most, for a
    /// state of so many pairs.
    #[inline]
    pub fn prepare(&mut self, flow: &F, level: usize, n_pairs: usize) -> Option<usize> {
        let place = place_of(level);
        if let Some(Some(_)) = self.made.get(place) {
            return None;
        }
        if self.made.len() <= place {
            self.made.resize_with(place + 1, || None);
        }
        let mut propagator = F::Propagator::default();
        flow.prepare(self.step(level), &mut propagator);
        self.made[place] = Some(Level {
            propagator,
            strides: OnceCell::new(),
        });
        Some(n_pairs.pow(3))
    }

    /// What was made for a level.
    #[inline]
    fn made(&self, level: usize) -> Option<&Level<F>> {
        self.made.get(place_of(level))?.as_ref()
    }

    /// Moves a state forward by the step of a level that is prepared.
    #[inline]
    pub fn advance(&self, flow: &F, level: usize, state: &mut [Pair]) {
        if let Some(Level { propagator, .. }) = self.made(level) {
            flow.advance(propagator, state);
        }
    }

    /// What carries a state over one to eight steps of a level that is prepared, if the flow has that.
    #[inline]
    pub fn strides(&self, flow: &F, level: usize) -> Option<&[Stride]> {
        let level = self.made(level)?;
        let made = level
            .strides
            .get_or_init(|| flow.strides(&level.propagator));
        made.as_deref()
    }
}

/// Where a level is kept: from the longest step on, the shorter and the longer ones in turn.
#[inline]
fn place_of(level: usize) -> usize {
    if level >= LEVEL_DOUBLINGS {
        2 * (level - LEVEL_DOUBLINGS)
    } else {
        2 * (LEVEL_DOUBLINGS - 1 - level) + 1
    }
}

/// The step of a level below the longest step.
#[inline]
fn step_of(longest: f64, level: usize) -> f64 {
    // A power of two by its exponent.
    longest * f64::from_bits(((1023 + LEVEL_DOUBLINGS - level) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_has_a_place_of_its_own() {
        let mut places: Vec<usize> = (0..2 * LEVEL_DOUBLINGS).map(place_of).collect();
        places.sort_unstable();
        assert!(places.into_iter().eq(0..2 * LEVEL_DOUBLINGS));
        assert_eq!(place_of(LEVEL_DOUBLINGS), 0);
    }
}
