//! The Dormand-Prince pair of orders 5 and 4 on `q'' = a(t, q, v)`, with its quartic dense output (theory 8). States live
//! in arrays of fixed length for few degrees of freedom, in vectors for many.

use crate::error::Result;
use crate::flow::tableau::{DENSE, ERROR, NODES, ROWS, STAGES};
use crate::model::{Dynamics, Moment};

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

/// Tolerances of one step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tolerance {
    pub relative: f64,
    pub absolute: f64,
}

/// A step of a given length from a state whose rate is known, ready for its error and its dense output.
#[derive(Debug, Clone)]
pub(crate) struct Stepper<S> {
    /// Rates at the stages; the first at the start, the last at the end.
    stages: [S; STAGES],
    trial: S,
    error: S,
    /// The state at the end of the step last taken.
    pub end: S,
    /// Evaluations of the right-hand side so far.
    pub n_rhs: usize,
}

/// Moves on by `s`.
#[inline]
pub(crate) fn later(at: Moment, s: f64, frequency: f64) -> Moment {
    Moment {
        time: at.time + s,
        angle: at.angle + frequency * s,
    }
}

/// The rate at a state: one copy for all stages, into which the acceleration is inlined.
#[inline(never)]
fn rate<S: State, D: Dynamics>(dynamics: &D, drive: D::Drive, x: &S, out: &mut S) -> Result<()> {
    // Half a length that arrays have at compile time.
    let n = x.slice().len() / 2;
    let (q, v) = x.slice().split_at(n);
    let (dq, dv) = out.slice_mut().split_at_mut(n);
    dq.copy_from_slice(v);
    dynamics.driven(drive, q, v, dv)
}

/// `sum_k c_k y_k` over the first K rates.
#[inline]
fn weighted_sum<S: State, const K: usize>(rates: &[S], weights: &[f64], sum: &mut S) {
    sum.slice_mut().fill(0.0);
    for k in 0..K {
        if weights[k] != 0.0 {
            for (sum, rate) in sum.slice_mut().iter_mut().zip(rates[k].slice()) {
                *sum += weights[k] * rate;
            }
        }
    }
}

impl<S: State> Stepper<S> {
    /// A stepper of n degrees of freedom.
    pub fn new(n_dof: usize) -> Self {
        let zeros = S::zeros(2 * n_dof);
        Self {
            stages: std::array::from_fn(|_| zeros.clone()),
            trial: zeros.clone(),
            error: zeros.clone(),
            end: zeros,
            n_rhs: 0,
        }
    }

    /// Makes a state the start of the next step.
    pub fn begin<D: Dynamics>(&mut self, dynamics: &D, at: Moment, x: &S) -> Result<()> {
        self.n_rhs += 1;
        rate(dynamics, dynamics.drive(at), x, &mut self.stages[0])
    }

    /// Makes the end of the step last taken the start of the next one.
    pub fn go_on(&mut self) {
        self.stages.swap(0, STAGES - 1);
    }

    /// The rate of the state at the start.
    pub fn start_rate(&self) -> &S {
        &self.stages[0]
    }

    /// The rate of the state at the end of the step last taken.
    pub fn end_rate(&self) -> &S {
        &self.stages[STAGES - 1]
    }

    /// Takes a step of length h from x; afterwards `end` is the state of order 5 there.
    #[inline]
    pub fn step<D: Dynamics>(
        &mut self,
        dynamics: &D,
        at: Moment,
        frequency: f64,
        x: &S,
        h: f64,
    ) -> Result<()> {
        let drive_at = |node: f64| dynamics.drive(later(at, node * h, frequency));
        self.stage::<D, 1>(dynamics, drive_at(NODES[0]), x, h)?;
        self.stage::<D, 2>(dynamics, drive_at(NODES[1]), x, h)?;
        self.stage::<D, 3>(dynamics, drive_at(NODES[2]), x, h)?;
        self.stage::<D, 4>(dynamics, drive_at(NODES[3]), x, h)?;
        // The last two stages are at one time.
        let last = drive_at(NODES[4]);
        self.stage::<D, 5>(dynamics, last, x, h)?;
        self.stage::<D, 6>(dynamics, last, x, h)?;
        self.n_rhs += STAGES - 1;
        Ok(())
    }

    /// The rate at stage K from those before it; the number is known at compile time, so that the sum is written out and
    /// its zeros are left out.
    #[inline]
    fn stage<D: Dynamics, const K: usize>(
        &mut self,
        dynamics: &D,
        drive: D::Drive,
        x: &S,
        h: f64,
    ) -> Result<()> {
        let row = &ROWS[K - 1];
        let (known, next) = self.stages.split_at_mut(K);
        let target = if K == STAGES - 1 {
            &mut self.end
        } else {
            &mut self.trial
        };
        weighted_sum::<S, K>(known, row, target);
        for (y, x) in target.slice_mut().iter_mut().zip(x.slice()) {
            *y = x + h * *y;
        }
        rate(dynamics, drive, target, &mut next[0])
    }

    /// The error of the step last taken, in units of the tolerance (root mean square).
    #[inline]
    pub fn error(&mut self, x: &S, h: f64, tolerance: Tolerance) -> f64 {
        weighted_sum::<S, STAGES>(&self.stages, &ERROR, &mut self.error);
        let mut sum = 0.0;
        let ends = x.slice().iter().zip(self.end.slice());
        for (e, (x, end)) in self.error.slice().iter().zip(ends) {
            let scale = tolerance.absolute + tolerance.relative * x.abs().max(end.abs());
            sum += (e / scale).powi(2);
        }
        h.abs() * (sum / x.slice().len() as f64).sqrt()
    }

    /// Hairer's quotient `h |f(y7) - f(y6)|/|y7 - y6|`: above about 3.25 stability holds the step down, not accuracy.
    pub fn stiffness(&self, h: f64) -> f64 {
        let apart = |a: &S, b: &S| -> f64 {
            a.slice()
                .iter()
                .zip(b.slice())
                .map(|(a, b)| (a - b).powi(2))
                .sum()
        };
        let rates = apart(&self.stages[STAGES - 1], &self.stages[STAGES - 2]);
        let states = apart(&self.end, &self.trial);
        if states > 0.0 {
            h.abs() * (rates / states).sqrt()
        } else {
            0.0
        }
    }

    /// The dense output of the step last taken from x.
    pub fn dense(&self, x: &S, h: f64) -> Dense<S> {
        let mut c: [S; 4] = std::array::from_fn(|_| S::zeros(x.slice().len()));
        for i in 0..x.slice().len() {
            let difference = self.end.slice()[i] - x.slice()[i];
            let first = h * self.stages[0].slice()[i] - difference;
            let last = difference - h * self.stages[STAGES - 1].slice()[i] - first;
            let mut bump = 0.0;
            for (k, d) in self.stages.iter().zip(&DENSE) {
                bump += d * k.slice()[i];
            }
            c[0].slice_mut()[i] = difference;
            c[1].slice_mut()[i] = first;
            c[2].slice_mut()[i] = last;
            c[3].slice_mut()[i] = h * bump;
        }
        Dense {
            start: x.clone(),
            c,
            h,
        }
    }
}

/// The quartic on a step.
#[derive(Debug, Clone)]
pub(crate) struct Dense<S> {
    start: S,
    c: [S; 4],
    h: f64,
}

impl<S: State> Dense<S> {
    /// The state a time s after the start of the step.
    pub fn state(&self, s: f64, out: &mut [f64]) {
        let x = s / self.h;
        let y = 1.0 - x;
        for (i, out) in out.iter_mut().enumerate() {
            let c = |k: usize| self.c[k].slice()[i];
            *out = self.start.slice()[i] + x * (c(0) + y * (c(1) + x * (c(2) + y * c(3))));
        }
    }

    /// A straight line from one state to another.
    pub fn line(start: &S, end: &S, h: f64) -> Self {
        let zeros = S::zeros(start.slice().len());
        let mut difference = end.clone();
        for (d, x) in difference.slice_mut().iter_mut().zip(start.slice()) {
            *d -= x;
        }
        Self {
            start: start.clone(),
            c: [difference, zeros.clone(), zeros.clone(), zeros],
            h,
        }
    }

    /// Entry i in powers of `x = s/h`.
    pub fn powers(&self, i: usize) -> [f64; 5] {
        let c = |k: usize| self.c[k].slice()[i];
        [
            self.start.slice()[i],
            c(0) + c(1),
            -c(1) + c(2) + c(3),
            -c(2) - 2.0 * c(3),
            c(3),
        ]
    }

    /// The step as plain numbers, [`Dense::width`] of them.
    pub fn write(&self, numbers: &mut Vec<f64>) {
        numbers.push(self.h);
        numbers.extend_from_slice(self.start.slice());
        for c in &self.c {
            numbers.extend_from_slice(c.slice());
        }
    }
}

impl Dense<Vec<f64>> {
    /// Numbers of a step of n degrees of freedom.
    pub fn width(n: usize) -> usize {
        1 + 10 * n
    }

    /// The step that was written.
    pub fn read(numbers: &[f64]) -> Self {
        let (h, rest) = numbers
            .split_first()
            .map_or((0.0, numbers), |(h, rest)| (*h, rest));
        let len = rest.len() / 5;
        let part = |k: usize| rest[k * len..(k + 1) * len].to_vec();
        Self {
            start: part(0),
            c: std::array::from_fn(|k| part(k + 1)),
            h,
        }
    }

    /// The state a time s after the start of the step.
    pub fn at(&self, s: f64) -> Vec<f64> {
        if self.h == 0.0 {
            return self.start.clone();
        }
        let mut x = vec![0.0; self.start.len()];
        self.state(s, &mut x);
        x
    }
}
