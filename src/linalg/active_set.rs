//! A scaled linear complementarity problem by exact active sets: three unknowns and fewer by trying every set, more by
//! Lemke's method; then one solve on the set found, and a check.

use crate::linalg::lemke;
use crate::linalg::small::eliminate;
use crate::tolerance::{COMPLEMENTARITY_ROUNDINGS, DEPENDENT_ACTIVE, LEMKE_PIVOTS};
use nalgebra::{DMatrix, DVector};

/// Number of unknowns up to which every active set is tried before Lemke's method is. [work]
const ENUMERATED_FIRST: usize = 3;
/// Number of unknowns up to which every active set is tried where Lemke's method finds none: 4096 solves. [work]
const ENUMERATED_LAST: usize = 12;

/// A solution of `0 <= x perp w = M x + q >= 0`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ComplementarySolution {
    /// The unknowns x, shape `(k,)`, [-], in units of those that the problem was given in.
    pub x: DVector<f64>,
    /// `M x + q`, shape `(k,)`, [-], in units of q; exactly zero where x is not, and where it is zero up to rounding.
    pub w: DVector<f64>,
}

/// A problem with entries of M of order one.
pub(super) struct Complementarity {
    /// M, shape `(k, k)`, [-], scaled to diagonal entries of order one.
    pub m: DMatrix<f64>,
    /// q, shape `(k,)`, [-], in units of the scaled w.
    pub q: Vec<f64>,
    /// The amounts by which q may be larger, shape `(k,)`, [-], in units of the scaled w.
    pub slack: Vec<f64>,
}

impl Complementarity {
    /// A solution, if one was found.
    pub fn solve(&self) -> Option<ComplementarySolution> {
        let k = self.q.len();
        let mut work = Work::default();
        if k <= ENUMERATED_FIRST {
            return self.try_every(&mut work);
        }
        LEMKE_PIVOTS
            .iter()
            .find_map(|&pivot_tol| {
                let set = lemke::active_set(&self.m, &self.q, pivot_tol);
                self.on(&set, COMPLEMENTARITY_ROUNDINGS[0], &mut work)
            })
            .or_else(|| self.try_every(&mut work))
            .or_else(|| {
                let set = lemke::active_set(&self.m, &self.q, LEMKE_PIVOTS[0]);
                let mut rest = COMPLEMENTARITY_ROUNDINGS[1..].iter();
                rest.find_map(|&rounding| self.on(&set, rounding, &mut work))
            })
    }

    /// The problem with every q at the upper end of what it may be.
    pub fn relaxed(&self) -> Self {
        Self {
            m: self.m.clone(),
            q: self.q.iter().zip(&self.slack).map(|(q, s)| q + s).collect(),
            slack: self.slack.clone(),
        }
    }

    /// The first set that solves the problem: up to rounding, else up to what counts as dependent.
    pub fn try_every(&self, work: &mut Work) -> Option<ComplementarySolution> {
        let k = self.q.len();
        if k > ENUMERATED_LAST {
            return None;
        }
        COMPLEMENTARITY_ROUNDINGS.iter().find_map(|&rounding| {
            (0..1_usize << k).find_map(|mask| {
                let mut set = std::mem::take(&mut work.set);
                set.clear();
                set.extend((0..k).filter(|i| mask >> i & 1 == 1));
                let solution = self.on(&set, rounding, work);
                work.set = set;
                solution
            })
        })
    }

    /// The solution with `w = 0` on the set and `x = 0` off it, if it is one.
    pub fn on(
        &self,
        set: &[usize],
        rounding: f64,
        work: &mut Work,
    ) -> Option<ComplementarySolution> {
        let (k, size) = (self.q.len(), set.len());
        work.matrix.clear();
        for &i in set {
            work.matrix.extend(set.iter().map(|&j| self.m[(i, j)]));
        }
        work.right.clear();
        work.right.extend(set.iter().map(|&i| -self.q[i]));
        if !eliminate(
            &mut work.matrix,
            &mut work.right,
            DEPENDENT_ACTIVE * self.m.amax(),
        ) {
            return None;
        }
        for (x, &i) in work.right.iter_mut().zip(set) {
            // A negative zero, or rounding below zero, is zero; a NaN or an infinity is no solution.
            if *x <= 0.0 && *x >= -self.slack[i] - rounding * self.q[i].abs() {
                *x = 0.0;
            }
            if !x.is_finite() || *x < 0.0 {
                return None;
            }
        }
        let mut w = DVector::zeros(k);
        let mut place = 0;
        for i in 0..k {
            let (mut value, mut terms) = (self.q[i], self.q[i].abs());
            for (x, &j) in work.right.iter().zip(set) {
                value += self.m[(i, j)] * x;
                terms += (self.m[(i, j)] * x).abs();
            }
            let bound = self.slack[i] + rounding * terms;
            let is_active = place < size && set[place] == i && work.right[place] > 0.0;
            place += usize::from(place < size && set[place] == i);
            if value.is_nan() || value < -bound || is_active && value > bound {
                return None;
            }
            w[i] = if value <= bound { 0.0 } else { value };
        }
        let mut x = DVector::zeros(k);
        for (value, &i) in work.right.iter().zip(set) {
            x[i] = *value;
        }
        Some(ComplementarySolution { x, w })
    }
}

/// Buffers of the sets tried.
#[derive(Default)]
pub(super) struct Work {
    set: Vec<usize>,
    matrix: Vec<f64>,
    right: Vec<f64>,
}
