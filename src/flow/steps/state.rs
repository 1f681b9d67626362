//! States of motions that are integrated: arrays of fixed length for few degrees of freedom, vectors for many.

use crate::error::Result;
use crate::model::Dynamics;

/// A state `(q, v)`, or its rate, of 2n entries.
pub(crate) trait State: Clone + 'static {
    /// Zeros.
    fn zeros(len: usize) -> Self;
    fn slice(&self) -> &[f64];
    fn slice_mut(&mut self) -> &mut [f64];
}

impl<const N: usize> State for [f64; N] {
    fn zeros(_len: usize) -> Self {
        [0.0; N]
    }
    #[inline]
    fn slice(&self) -> &[f64] {
        self
    }
    #[inline]
    fn slice_mut(&mut self) -> &mut [f64] {
        self
    }
}

impl State for Vec<f64> {
    fn zeros(len: usize) -> Self {
        vec![0.0; len]
    }
    fn slice(&self) -> &[f64] {
        self
    }
    fn slice_mut(&mut self) -> &mut [f64] {
        self
    }
}

/// `sum_k c_k y_k` over the first rates, as many as there are weights.
#[allow(
    clippy::inline_always,
    reason = "the weights of a caller are known when it is compiled: sums are written out, zeros are left out"
)]
#[inline(always)]
pub(super) fn weighted_sum<S: State>(rates: &[S], weights: &[f64], sum: &mut S) {
    for (sum, rate) in sum.slice_mut().iter_mut().zip(rates[0].slice()) {
        *sum = weights[0] * rate;
    }
    for k in 1..weights.len() {
        if weights[k] != 0.0 {
            for (sum, rate) in sum.slice_mut().iter_mut().zip(rates[k].slice()) {
                *sum += weights[k] * rate;
            }
        }
    }
}

/// The rate at a state: one copy for all stages, into which the acceleration is inlined.
#[inline(never)]
pub(super) fn rate<S: State, D: Dynamics>(
    dynamics: &D,
    drive: &D::Drive,
    x: &S,
    out: &mut S,
) -> Result<()> {
    // Half a length that arrays have at compile time.
    let n = x.slice().len() / 2;
    let (q, v) = x.slice().split_at(n);
    let (dq, dv) = out.slice_mut().split_at_mut(n);
    dq.copy_from_slice(v);
    dynamics.driven(*drive, q, v, dv)
}

/// The state at a stage of an explicit method, `x + h sum_k c_k y_k` over the rates before it.
#[allow(
    clippy::inline_always,
    reason = "the weights of a caller are known when it is compiled"
)]
#[inline(always)]
pub(super) fn stage_state<S: State>(
    rates: &[S],
    weights: &[f64],
    (x, h): (&S, f64),
    state: &mut S,
) {
    weighted_sum(rates, weights, state);
    for (y, x) in state.slice_mut().iter_mut().zip(x.slice()) {
        *y = x + h * *y;
    }
}

/// Hairer's quotient `h |f(b) - f(a)|/|b - a|` of two states of a step that are at one time (Hairer and Wanner, Solving Ordinary
/// Differential Equations II, section IV.2).
#[inline]
pub(super) fn stiffness<S: State>(h: f64, rates: [&S; 2], states: [&S; 2]) -> f64 {
    let square_distance = |[a, b]: [&S; 2]| -> f64 {
        let pairs = a.slice().iter().zip(b.slice());
        pairs.map(|(a, b)| (a - b).powi(2)).sum()
    };
    let (rates, states) = (square_distance(rates), square_distance(states));
    if states > 0.0 {
        h.abs() * (rates / states).sqrt()
    } else {
        0.0
    }
}
