//! The motion on a step of an integrator, as a polynomial.

use crate::flow::steps::state::State;

/// The motion on a step.
pub(crate) trait DenseOutput<S>: Clone {
    /// Its degree. [exact]
    const DEGREE: usize;

    /// The state a time s after the start of the step.
    fn state(&self, s: f64, out: &mut [f64]);
    /// Entry i in powers of `x = s/h`.
    fn powers(&self, i: usize) -> Vec<f64>;
    /// A straight line from one state to another.
    fn line(start: &S, end: &S, h: f64) -> Self;
    /// Adds the step as plain numbers, [`written_width`] of them.
    fn write(&self, numbers: &mut Vec<f64>);
}

/// `y0 + x (c0 + y (c1 + x (c2 + y (...))))` with `x = s/h`, `y = 1 - x`: a polynomial whose coefficients are differences of what is
/// known at both ends (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, section II.6).
#[derive(Debug, Clone)]
pub(crate) struct Dense<S, const P: usize> {
    pub start: S,
    pub c: [S; P],
    pub h: f64,
}

impl<S: State, const P: usize> DenseOutput<S> for Dense<S, P> {
    /// That of its coefficients. [exact]
    const DEGREE: usize = P;

    fn state(&self, s: f64, out: &mut [f64]) {
        let x = if self.h == 0.0 { 0.0 } else { s / self.h };
        let y = 1.0 - x;
        for (i, out) in out.iter_mut().enumerate() {
            *out = self.start.slice()[i] + x * nested(|k| self.c[k].slice()[i], P, x, y);
        }
    }

    fn powers(&self, i: usize) -> Vec<f64> {
        let mut powers = Vec::with_capacity(P + 1);
        for (k, c) in self.c.iter().enumerate().rev() {
            // Times x, or times 1 - x.
            powers.insert(0, 0.0);
            if k % 2 == 0 {
                for j in 0..powers.len() - 1 {
                    powers[j] += powers[j + 1];
                    powers[j + 1] = -powers[j + 1];
                }
            }
            powers[0] += c.slice()[i];
        }
        powers.insert(0, self.start.slice()[i]);
        powers
    }

    fn line(start: &S, end: &S, h: f64) -> Self {
        let mut c = std::array::from_fn(|_| S::zeros(start.slice().len()));
        let ends = start.slice().iter().zip(end.slice());
        for (d, (x, end)) in c[0].slice_mut().iter_mut().zip(ends) {
            *d = end - x;
        }
        Self {
            start: start.clone(),
            c,
            h,
        }
    }

    fn write(&self, numbers: &mut Vec<f64>) {
        numbers.push(self.h);
        numbers.extend_from_slice(self.start.slice());
        for c in &self.c {
            numbers.extend_from_slice(c.slice());
        }
    }
}

impl<S: State, const P: usize> Dense<S, P> {
    /// The same polynomial with coefficients up to a higher degree Q, which are zero.
    pub fn raised<const Q: usize>(self) -> Dense<S, Q> {
        let Self { start, c, h } = self;
        let len = start.slice().len();
        let mut all = c.into_iter();
        Dense {
            c: std::array::from_fn(|_| all.next().unwrap_or_else(|| S::zeros(len))),
            start,
            h,
        }
    }
}

impl<const P: usize> Dense<Vec<f64>, P> {
    /// The state a time s after the start of the step.
    pub fn at(&self, s: f64) -> Vec<f64> {
        let mut x = vec![0.0; self.start.len()];
        self.state(s, &mut x);
        x
    }
}

/// `c0 + y (c1 + x (c2 + y (...)))` of some coefficients.
#[inline]
fn nested(c: impl Fn(usize) -> f64, len: usize, x: f64, y: f64) -> f64 {
    let mut sum = c(len - 1);
    for k in (0..len - 1).rev() {
        sum = c(k) + if k % 2 == 0 { y } else { x } * sum;
    }
    sum
}

/// Numbers of a step of n degrees of freedom that was written.
#[inline]
pub(crate) fn written_width(degree: usize, n: usize) -> usize {
    1 + 2 * n * (1 + degree)
}

/// The state a time s after the start of a step that was written.
#[inline]
pub(crate) fn written_state(numbers: &[f64], degree: usize, s: f64) -> Vec<f64> {
    let (h, len) = (numbers[0], (numbers.len() - 1) / (1 + degree));
    let (start, c) = numbers[1..].split_at(len);
    let x = if h == 0.0 { 0.0 } else { s / h };
    let at = |i: usize| start[i] + x * nested(|k| c[len * k + i], degree, x, 1.0 - x);
    (0..len).map(at).collect()
}
