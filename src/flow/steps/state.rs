//! States of motions that are integrated: arrays of fixed length for few degrees of freedom, vectors for many.

/// A state `(q, v)`, or its rate, of 2n entries.
pub(crate) trait State: Clone {
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

/// `sum_k c_k y_k` over the first K rates.
#[inline]
pub(super) fn weighted_sum<S: State, const K: usize>(rates: &[S], weights: &[f64], sum: &mut S) {
    sum.slice_mut().fill(0.0);
    for k in 0..K {
        if weights[k] != 0.0 {
            for (sum, rate) in sum.slice_mut().iter_mut().zip(rates[k].slice()) {
                *sum += weights[k] * rate;
            }
        }
    }
}
