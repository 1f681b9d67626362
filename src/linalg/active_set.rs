//! A scaled linear complementarity problem by exact active sets: three unknowns and fewer by trying every set, more by
//! Lemke's method; then one solve on the set found, and a check.

use crate::linalg::lemke;
use crate::linalg::small::eliminate;
use crate::tolerance::DEPENDENT_ACTIVE;
use nalgebra::{DMatrix, DVector};

/// What `M x + q` may miss zero by, relative to the size of its terms: by rounding; by rounding of an ill-conditioned M; by
/// columns that count as dependent but are not, since a pivot is the square of the angle between normals. Tried in turn.
pub(super) const ROUNDINGS: [f64; 3] = [1e-14, 1e-11, 1e-7];
/// Pivots of Lemke's method up to this are rounding: many dependent columns need more, narrow angles less. Tried in turn.
pub(super) const PIVOT_TOLS: [f64; 3] = [1e-11, 1e-13, 1e-9];
/// Up to this size, every set is tried before anything else.
const FEW: usize = 3;
/// Up to this size, every set is tried when Lemke's method finds none: 4096 solves.
const EVERY: usize = 12;

/// A solution of `0 <= x perp w = M x + q >= 0`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ComplementarySolution {
    pub x: DVector<f64>,
    /// `M x + q`; exactly zero where x is not, and where it is zero up to rounding.
    pub w: DVector<f64>,
}

/// A problem with entries of M of order one.
pub(super) struct Complementarity {
    pub m: DMatrix<f64>,
    pub q: Vec<f64>,
    pub slack: Vec<f64>,
}

impl Complementarity {
    /// A solution, if one was found.
    pub fn solve(&self) -> Option<ComplementarySolution> {
        let k = self.q.len();
        let mut work = Work::default();
        if k <= FEW {
            return self.try_every(&mut work);
        }
        PIVOT_TOLS
            .iter()
            .find_map(|&pivot_tol| {
                let set = lemke::active_set(&self.m, &self.q, pivot_tol);
                self.on(&set, ROUNDINGS[0], &mut work)
            })
            .or_else(|| self.try_every(&mut work))
            .or_else(|| {
                let set = lemke::active_set(&self.m, &self.q, PIVOT_TOLS[0]);
                let mut rest = ROUNDINGS[1..].iter();
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
        if k > EVERY {
            return None;
        }
        ROUNDINGS.iter().find_map(|&rounding| {
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
