//! The collocation polynomial of a step: the cubic through its start and its three stages, in the form of the dense output,
//! `y0 + x (c0 + (1 - x)(c1 + x c2))` with `x = s/h`. Beyond its step it gives the increments that the next iteration begins
//! with.

use crate::flow::steps::dense_output::Dense;
use crate::flow::steps::radau::tableau::{RADAU_NODES, RADAU_STAGES};
use crate::flow::steps::state::State;

/// The cubic of the last step that was solved.
#[derive(Debug, Clone)]
pub(super) struct Cubic<S> {
    c: [S; 3],
    h: f64,
    /// Where the next step begins, in lengths of this one: at 1, or at 0 if it is this one with another length. None if this one
    /// says nothing of it.
    from: Option<f64>,
}

impl<S: State> Cubic<S> {
    pub fn new(n_dof: usize) -> Self {
        Self {
            c: std::array::from_fn(|_| S::zeros(2 * n_dof)),
            h: 0.0,
            from: None,
        }
    }

    pub fn forget(&mut self) {
        self.from = None;
    }

    /// The next step begins where this one ends.
    pub fn go_on(&mut self) {
        self.from = Some(1.0);
    }

    /// Sets the cubic of a step with these increments.
    pub fn set(&mut self, z: &[S; RADAU_STAGES], h: f64) {
        for i in 0..self.c[0].slice().len() {
            set_entry(&mut self.c, i, coefficients(entry(z, i)));
        }
        (self.h, self.from) = (h, Some(0.0));
    }

    /// The increments of entry i in the next step, as far as they are known; or zeros.
    #[inline]
    pub fn increments(&self, i: usize, h: f64) -> [f64; RADAU_STAGES] {
        self.from.map_or([0.0; RADAU_STAGES], |from| {
            let c = entry(&self.c, i);
            RADAU_NODES.map(|node| growth(c, from, node * h / self.h))
        })
    }

    /// The motion on the step, on to an end that may have been moved.
    pub fn dense(&self, start: &S, end: &S, h: f64) -> Dense<S, 3> {
        let mut c = self.c.clone();
        let ends = start.slice().iter().zip(end.slice());
        for (c, (x, end)) in c[0].slice_mut().iter_mut().zip(ends) {
            *c = end - x;
        }
        let start = start.clone();
        Dense { start, c, h }
    }
}

/// Entry i of three states.
#[inline]
pub(super) fn entry<S: State>(x: &[S; 3], i: usize) -> [f64; 3] {
    std::array::from_fn(|k| x[k].slice()[i])
}

#[inline]
pub(super) fn set_entry<S: State>(x: &mut [S; 3], i: usize, to: [f64; 3]) {
    for (x, to) in x.iter_mut().zip(to) {
        x.slice_mut()[i] = to;
    }
}

/// The coefficients of the cubic with some increments at the nodes.
#[inline]
fn coefficients(z: [f64; RADAU_STAGES]) -> [f64; 3] {
    let bump =
        |i: usize| (z[i] - RADAU_NODES[i] * z[2]) / (RADAU_NODES[i] * (1.0 - RADAU_NODES[i]));
    let c2 = (bump(1) - bump(0)) / (RADAU_NODES[1] - RADAU_NODES[0]);
    [z[2], bump(0) - RADAU_NODES[0] * c2, c2]
}

/// What the cubic grows by from `from`, which is 0 or 1, to `from + x`.
#[inline]
fn growth(c: [f64; 3], from: f64, x: f64) -> f64 {
    let factor = if from == 0.0 { 1.0 - x } else { -1.0 - x };
    x * (c[0] + factor * (c[1] + (from + x) * c[2]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::steps::dense_output::DenseOutput;

    const Z: [f64; RADAU_STAGES] = [0.3, -0.7, 1.9];

    #[test]
    fn the_cubic_goes_through_the_increments() {
        let c = coefficients(Z);
        for (node, z) in RADAU_NODES.into_iter().zip(Z) {
            assert!((growth(c, 0.0, node) - z).abs() < 1e-14);
        }
        for x in [-0.3, 0.8, 2.0] {
            let apart = growth(c, 0.0, 1.0 + x) - growth(c, 0.0, 1.0);
            assert!((growth(c, 1.0, x) - apart).abs() < 1e-13);
        }
    }

    #[test]
    fn it_is_the_dense_output_and_goes_on_as_the_next_increments() {
        let mut cubic = Cubic::<[f64; 2]>::new(1);
        assert_eq!(cubic.increments(0, 0.5), [0.0; RADAU_STAGES]);
        cubic.set(&Z.map(|z| [z, -z]), 0.5);
        let dense = cubic.dense(&[1.0, 2.0], &[2.9, 0.1], 0.5);
        let state = |s: f64| {
            let mut x = [0.0; 2];
            dense.state(s, &mut x);
            x[0]
        };
        for (from, h) in [(0.0, 0.2), (0.0, 0.5), (0.5, 0.3), (0.5, 1.1)] {
            if from > 0.0 {
                cubic.go_on();
            }
            for (node, z) in RADAU_NODES.into_iter().zip(cubic.increments(0, h)) {
                let apart = state(from + node * h) - state(from);
                assert!((z - apart).abs() < 1e-13 * (1.0 + apart.abs()));
            }
        }
        // An end that was moved.
        let moved = cubic.dense(&[1.0, 2.0], &[2.8, 0.1], 0.5);
        let mut x = [0.0; 2];
        moved.state(0.5, &mut x);
        assert!((x[0] - 2.8).abs() < 1e-15 && (x[1] - 0.1).abs() < 1e-15);
    }
}
