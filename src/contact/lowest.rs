//! The lowest place of a gap on a flight, to rounding.

use crate::flow::{GapRow, LinearFlow};
use crate::modal::Pair;

/// Steps of Newton's method: the guess is that of a cubic, from which each doubles the digits.
const STEPS: usize = 2;

/// A place where a gap is lowest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lowest {
    pub time: f64,
    pub gap: f64,
}

impl Lowest {
    /// The place to rounding, by Newton's method on the speed of the gap; times count from a state of the flow.
    ///
    /// Where the gap is too flat for its parabola to say where it turns, the place stays what it was.
    pub fn sharpened<F: LinearFlow>(mut self, flow: &F, gap: &GapRow, from: &[Pair]) -> Self {
        let (mut propagator, mut derivatives) = (F::Propagator::default(), Vec::new());
        let mut state = Vec::with_capacity(from.len());
        for _ in 0..STEPS {
            state.clear();
            state.extend_from_slice(from);
            flow.prepare(self.time, &mut propagator);
            flow.advance(&propagator, &mut state);
            flow.derivatives(&state, &mut derivatives);
            let jet = gap.jet(&derivatives);
            let step = -0.5 * jet.c[1] / jet.c[2];
            let is_parabola = jet.c[2] > 0.0 && (jet.c[3] * step).abs() < jet.c[2];
            if !is_parabola {
                return self;
            }
            self = Self {
                time: self.time + step,
                gap: jet.value(step),
            };
        }
        self
    }
}
