//! The lowest place of a gap on a flight, to rounding.

use crate::flow::gap_model::GapModel;
use crate::flow::{Derivatives, GapRow, LinearFlow};
use crate::modal::Pair;
use crate::root::Bracket;

/// Steps of Newton's method from the minimum of a cubic, each of which doubles the digits. [work]
const SHARPENING_STEPS: usize = 2;
/// Steps towards one minimum inside its bracket, bisections among them. [work]
const MOST_MINIMUM_STEPS: usize = 60;

/// A place where a gap is lowest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lowest {
    pub time: f64,
    pub gap: f64,
}

impl Lowest {
    /// The place to rounding, by Newton's method on the speed of the gap; times count from a state of the flow.
    ///
    /// Where the gap is too flat for its parabola to say where it turns, the place stays what it was; so it does where a step from it
    /// leads up, from a curvature of rounding.
    pub fn sharpened<F: LinearFlow>(mut self, flow: &F, gap: &GapRow, from: &[Pair]) -> Self {
        let mut evaluator = GapEvaluator::new(flow, from);
        let mut model = evaluator.at(self.time, gap);
        for _ in 0..SHARPENING_STEPS {
            let step = -0.5 * model.c[1] / model.c[2];
            let is_parabola = model.c[2] > 0.0 && (model.c[3] * step).abs() < model.c[2];
            if !is_parabola {
                return self;
            }
            let (time, rounding) = (self.time + step, gap.rounding(&model));
            let left = (model.c[1] * step).abs().max(model.quartic * step.powi(4));
            if left <= f64::EPSILON * model.size {
                let gap = model.value(step);
                return Self { time, gap };
            }
            model = evaluator.at(time, gap);
            let there = model.c[0];
            if there > self.gap + rounding.max(gap.rounding(&model)) {
                return self;
            }
            self = Self { time, gap: there };
        }
        self
    }
}

/// Looks at a gap at any time of a flight, each time from the state at its start.
pub(crate) struct GapEvaluator<'a, F: LinearFlow> {
    flow: &'a F,
    from: &'a [Pair],
    propagator: F::Propagator,
    state: Vec<Pair>,
    derivatives: Vec<Derivatives>,
}

impl<'a, F: LinearFlow> GapEvaluator<'a, F> {
    pub fn new(flow: &'a F, from: &'a [Pair]) -> Self {
        Self {
            flow,
            from,
            propagator: F::Propagator::default(),
            state: Vec::with_capacity(from.len()),
            derivatives: Vec::with_capacity(from.len()),
        }
    }

    /// The model of a gap at a time.
    pub fn at(&mut self, time: f64, gap: &GapRow) -> GapModel {
        self.state.clear();
        self.state.extend_from_slice(self.from);
        self.flow.prepare(time, &mut self.propagator);
        self.flow.advance(&self.propagator, &mut self.state);
        self.flow.derivatives(&self.state, &mut self.derivatives);
        gap.model(&self.derivatives)
    }

    /// The minimum of a gap that falls at the first of two times, rises at the second and is convex between them, and the model
    /// near it: Newton's method on the speed inside the bracket, until what is left to fall is rounding, however long the way to there.
    pub fn bottom(&mut self, gap: &GapRow, between: [f64; 2], guess: f64) -> (Lowest, GapModel) {
        let mut between = Bracket::new(between);
        let mut time = guess;
        let mut model = self.at(time, gap);
        for _ in 0..MOST_MINIMUM_STEPS {
            let [_, slope, bend, _] = model.c;
            between.narrow(time, slope <= 0.0);
            let step = -0.5 * slope / bend;
            let is_inside = (between.before..=between.after).contains(&(time + step));
            if is_inside && (slope * step).abs() <= f64::EPSILON * model.size {
                let (time, gap) = (time + step, model.value(step));
                return (Lowest { time, gap }, model);
            }
            let next = if is_inside {
                time + step
            } else {
                between.middle()
            };
            if next == time {
                break;
            }
            time = next;
            model = self.at(time, gap);
        }
        let gap = model.c[0];
        (Lowest { time, gap }, model)
    }
}
