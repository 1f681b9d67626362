//! Flows of linear systems in modal pairs: exact propagation over any time, and the rows and bounds that the search along the gap of a
//! stop needs (theory 4 and 8). A flow moves a state of its own, made from the modal state: what it splits off from the motion, or adds
//! to it, is kept in further pairs at its end.

use crate::flow::gap_row::{Derivatives, GapRow, Quantity};
use crate::flow::samples::{SampleDerivatives, Stride};
use crate::modal::{ModalState, Pair};
use crate::model::Moment;
use crate::tolerance::SLOWEST_RATE;

/// Smooth motion of a linear system.
pub(crate) trait LinearFlow: FlowRows + FlowRates {
    /// Everything needed to go forward by one fixed time.
    type Propagator: Default;

    /// The flow's state for the whole motion in modal pairs at a moment.
    fn state_from_modal(&self, modal_state: &ModalState, at: Moment, state: &mut Vec<Pair>);
    /// The whole motion in modal pairs.
    fn modal_from_state(&self, state: &[Pair], modal_state: &mut ModalState);
    /// Puts a state's forcing at a moment that is known better than by adding up steps.
    fn set_moment(&self, state: &mut [Pair], at: Moment);
    /// Fills the propagator for a time.
    fn prepare(&self, t: f64, propagator: &mut Self::Propagator);
    /// The maps of the pairs of a state over one to eight steps, from the propagator of one step; `None` where a flow is only sampled at
    /// one time after another.
    fn strides(&self, _propagator: &Self::Propagator) -> Option<Vec<Stride>> {
        None
    }
    /// The derivatives of a state one to eight steps later, of a flow that has strides; `samples` has a place for each pair.
    #[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
    #[inline(always)]
    fn sample(&self, _strides: &[Stride], _state: &[Pair], _samples: &mut [SampleDerivatives]) {}
    /// Moves a state forward.
    fn advance(&self, propagator: &Self::Propagator, state: &mut [Pair]);
}

/// Gaps and other quantities of the motion, as rows on the state of a flow.
pub(crate) trait FlowRows {
    /// The derivatives of a state.
    fn derivatives(&self, state: &[Pair], derivatives: &mut Vec<Derivatives>);
    /// A quantity of the whole motion as one of the flow's state.
    fn gap_row(&self, quantity: &Quantity) -> GapRow;
    /// The row r with which a normal velocity `row.z` of the whole motion is `r.state`.
    fn velocity_row(&self, row: &[Pair]) -> Vec<Pair>;
    /// The norm of each pair of a state, which bounds a gap for all times by [`GapRow::least`].
    fn norms(&self, state: &[Pair], norms: &mut Vec<f64>);
}

/// The rates of a flow \[1/s\], and the steps \[s\] that they allow.
pub(crate) trait FlowRates {
    /// The longest step for which the remainders of the models hold.
    fn longest_step(&self) -> f64;
    /// Whether they hold for steps of any length.
    fn holds_for_ever(&self) -> bool;
    /// The fastest rate of change.
    fn fastest_rate(&self) -> f64;
    /// The rate of the fastest growth, zero where nothing grows.
    fn fastest_growth(&self) -> f64;
}

/// Exponent of the growth over one piece of a span: an exponential beyond e^709 overflows. [work]
const MOST_GROWTH_EXPONENT: f64 = 600.0;
/// Pieces of a span, at the most; a motion that grows for longer overflows anyway. [work]
const MOST_GROWTH_PIECES: f64 = 4096.0;

/// Moves a state forward over a span of time, in pieces where its exponential would overflow: what the motion does not hold of a
/// growing mode does not grow.
#[inline]
fn forward<F: LinearFlow>(flow: &F, propagator: &mut F::Propagator, state: &mut [Pair], span: f64) {
    let growth = flow.fastest_growth();
    if growth <= 0.0 {
        flow.prepare(span, propagator);
        flow.advance(propagator, state);
        return;
    }
    let pieces = (growth * span / MOST_GROWTH_EXPONENT)
        .ceil()
        .clamp(1.0, MOST_GROWTH_PIECES);
    flow.prepare(span / pieces, propagator);
    for _ in 0..pieces as usize {
        flow.advance(propagator, state);
    }
}

/// A propagator that is kept for as long as spans are of one length: the pieces of a signal often are, and so are the
/// times between samples.
pub(crate) struct PropagatorCache<F: LinearFlow> {
    propagator: F::Propagator,
    /// The span that it is for; no number where it is for a part of one.
    prepared: f64,
}

impl<F: LinearFlow> Default for PropagatorCache<F> {
    fn default() -> Self {
        Self {
            propagator: F::Propagator::default(),
            prepared: f64::NAN,
        }
    }
}

impl<F: LinearFlow> PropagatorCache<F> {
    /// Moves a state forward over a span of time.
    #[inline]
    pub fn forward(&mut self, flow: &F, state: &mut [Pair], span: f64) {
        if span == self.prepared {
            flow.advance(&self.propagator, state);
            return;
        }
        forward(flow, &mut self.propagator, state, span);
        let is_whole = flow.fastest_growth() <= 0.0;
        self.prepared = if is_whole { span } else { f64::NAN };
    }
}

/// Carries a whole motion over a span of time from a moment.
pub(crate) fn propagate<F: LinearFlow>(
    flow: &F,
    at: Moment,
    span: f64,
    modal_state: &mut ModalState,
) {
    let (mut propagator, mut state) = (F::Propagator::default(), Vec::new());
    flow.state_from_modal(modal_state, at, &mut state);
    forward(flow, &mut propagator, &mut state, span);
    flow.modal_from_state(&state, modal_state);
}

/// The slowest rate in a list of them that counts beside the fastest, 1 if all vanish.
pub(crate) fn softest_rate(rates: impl Iterator<Item = f64>) -> f64 {
    let rates = rates.filter(|&r| r > 0.0 && r.is_finite());
    let (least, most) = rates.fold((f64::INFINITY, 0.0f64), |(least, most), rate| {
        (least.min(rate), most.max(rate))
    });
    if least.is_finite() {
        least.max(SLOWEST_RATE * most)
    } else {
        1.0
    }
}

/// The longest step of a flow whose slowest motion allows one, so that the longest piece of its signals is one of its halves or
/// doubles.
pub(crate) fn fitted_step(longest: f64, pieces: Option<[f64; 2]>) -> f64 {
    let Some([_, piece]) = pieces else {
        return longest;
    };
    let doublings = (longest / piece).log2().floor();
    if doublings.is_finite() {
        piece * doublings.exp2()
    } else {
        longest
    }
}

/// The contract of every flow.
#[cfg(test)]
pub(crate) mod contract {
    use super::*;
    use crate::flow::gap_model::GapModel;
    use crate::flow::samples::SAMPLES_AT_ONCE;
    use crate::model::powers;
    use nalgebra::Complex;

    /// Eight samples at once are those taken one by one, where a flow has them.
    fn check_samples<F: LinearFlow>(flow: &F, state: &[Pair], gap: &GapRow) {
        let mut propagator = F::Propagator::default();
        flow.prepare(0.05 * flow.longest_step(), &mut propagator);
        let Some(strides) = flow.strides(&propagator) else {
            return;
        };
        let (mut samples, mut derivatives) =
            (vec![SampleDerivatives::default(); state.len()], Vec::new());
        flow.sample(&strides, state, &mut samples);
        let (models, mut there) = (gap.models(&samples), state.to_vec());
        let numbers = |m: GapModel| [m.c[0], m.c[1], m.c[2], m.c[3], m.quartic, m.quintic, m.size];
        for k in 0..SAMPLES_AT_ONCE {
            flow.advance(&propagator, &mut there);
            flow.derivatives(&there, &mut derivatives);
            let pairs = samples.iter().flat_map(|sample| sample.pair(k));
            let pairs = pairs.zip(there.iter().flatten().copied());
            let both = numbers(models.at(k))
                .into_iter()
                .zip(numbers(gap.model(&derivatives)));
            for (a, b) in pairs.chain(both) {
                assert!((a - b).abs() <= 1e-13 * b.abs().max(1.0), "{k} {a} {b}");
            }
        }
    }

    /// The flow composes, agrees with its derivatives, and keeps its models' promise. `n` is the number of modal pairs, the
    /// frequency that of the forcing, zero without.
    pub(crate) fn check<F: LinearFlow>(flow: &F, n: usize, frequency: f64) {
        let has_forcing = frequency > 0.0;
        let start: ModalState = (0..n)
            .map(|i| [0.3 - 0.1 * i as f64, 0.5 + 0.2 * i as f64])
            .collect();
        let go = |t: f64, state: &mut Vec<Pair>| {
            let mut p = F::Propagator::default();
            flow.prepare(t, &mut p);
            flow.advance(&p, state);
        };
        let entered = |modal_state: &ModalState| {
            let mut state = Vec::new();
            flow.state_from_modal(modal_state, Moment::of_angle(0.4), &mut state);
            state
        };
        let at = |t: f64| {
            let mut state = entered(&start);
            go(t, &mut state);
            state
        };
        let modal_state = |state: &[Pair]| {
            let mut modal_state = ModalState::default();
            flow.modal_from_state(state, &mut modal_state);
            modal_state
        };
        let close = |a: &[Pair], b: &[Pair], tolerance: f64| {
            assert_eq!(a.len(), b.len());
            let error = a
                .iter()
                .flatten()
                .zip(b.iter().flatten())
                .map(|(x, y)| (x - y).abs())
                .fold(0.0, f64::max);
            assert!(error < tolerance, "{error:e}");
        };
        close(&modal_state(&entered(&start)), &start, 1e-14);
        let mut turned = entered(&start);
        flow.set_moment(&mut turned, Moment::of_angle(0.4));
        close(&turned, &entered(&start), 1e-15);
        let mut state = at(0.7);
        go(0.9, &mut state);
        close(&state, &at(1.6), 1e-13);

        let step = 1e-5;
        let (forward, backward) = (modal_state(&at(0.7 + step)), modal_state(&at(0.7 - step)));
        let state = at(0.7);
        let row: Vec<Pair> = (0..n).map(|i| [0.5 + 0.3 * i as f64, 0.1]).collect();
        let dot = |z: &[Pair]| -> f64 {
            row.iter()
                .zip(z)
                .map(|(r, z)| r[0] * z[0] + r[1] * z[1])
                .sum()
        };
        let harmonics = [
            Complex::new(0.3, -0.2),
            Complex::new(0.1, 0.4),
            Complex::new(0.0, -0.2),
        ];
        // As many as the flow has: its state ends with a pair for each.
        let many = entered(&start).len() - n;
        let forcing = if has_forcing {
            harmonics[..many].to_vec()
        } else {
            Vec::new()
        };
        let gap = flow.gap_row(&Quantity {
            constant: 1.0,
            size: 1.0,
            row: row.clone(),
            forcing: forcing.clone(),
            ..Quantity::default()
        });
        let direct = |t: f64| -> f64 {
            let phasors = powers(Complex::cis(0.4 + frequency * t));
            forcing.iter().zip(phasors).map(|(f, u)| (f * u).re).sum()
        };
        let jet_at = |state: &[Pair]| {
            let mut derivatives = Vec::new();
            flow.derivatives(state, &mut derivatives);
            gap.model(&derivatives)
        };
        let model = jet_at(&state);
        assert!((model.c[0] - (1.0 - dot(&modal_state(&state)) - direct(0.7))).abs() < 1e-14);
        let driven = direct(0.7 + step) - direct(0.7 - step);
        let difference = -(dot(&forward) - dot(&backward) + driven) / (2.0 * step);
        assert!((model.c[1] - difference).abs() < 1e-7);
        check_samples(flow, &state, &gap);
        let mut norms = Vec::new();
        flow.norms(&state, &mut norms);
        let (least, size) = gap.least(&norms);
        let further = if flow.holds_for_ever() { 100.0 } else { 1.0 };
        for k in 1..=100 {
            let later = jet_at(&at(0.7 + f64::from(k)));
            assert!(later.c[0] >= least - 1e-14 * later.size && later.size <= size * (1.0 + 1e-14));
            let s = further * flow.longest_step() * f64::from(k) / 100.0;
            let there = jet_at(&at(0.7 + s));
            let miss = (there.c[0] - model.value(s)).abs();
            assert!(
                miss <= model.remainder(s) + 1e-14 * there.size,
                "{s} {miss:e} {:e}",
                model.remainder(s)
            );
        }
    }
}
