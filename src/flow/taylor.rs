//! Taylor series of a pendulum's large motions, to any order up to [`MOST_ORDER`] (theory 8).
//!
//! With `s_i = sin q_i`, `c_i = cos q_i` the equations of motion are `c_i P_i - s_i Q_i = -(C v)_i + f_i`, where
//! `P_i = sum_j I_ij s_j'' - h_i b` and `Q_i = sum_j I_ij c_j'' - h_i g`: products of series of one link alone, and linear
//! combinations of links. Coefficient k of each product is a convolution, in which the unknown acceleration appears with
//! the mass matrix at the start; `s' = c v` and `c' = -s v` give the rest.

use crate::flow::registers::Arithmetic;
use crate::flow::series_forcing::{LinkPair, SeriesForcing, Two, each};

/// Highest order of a series. [work]
pub(crate) const MOST_ORDER: usize = 24;
/// Coefficients of the positions, which have one order more than the velocities. [exact]
pub(crate) const ROWS: usize = MOST_ORDER + 2;

/// `1/k`, zero for k = 0. [exact]
pub(crate) const RECIPROCALS: [f64; ROWS] = {
    let mut all = [0.0; ROWS];
    let mut k = 1;
    while k < ROWS {
        all[k] = 1.0 / k as f64;
        k += 1;
    }
    all
};

/// The series of two links of K motions: coefficient k is that of `t^k`. A register is filled from one line of the cache.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub(crate) struct Lane<const K: usize> {
    pub q: [LinkPair<K>; ROWS],
    pub v: [LinkPair<K>; ROWS],
    pub sin: [LinkPair<K>; ROWS],
    pub cos: [LinkPair<K>; ROWS],
    /// P and Q of the equations of motion.
    pub across: [LinkPair<K>; ROWS],
    pub along: [LinkPair<K>; ROWS],
    /// The second derivatives of sine and cosine at the order in work: without the acceleration, then its part alone.
    bent: [LinkPair<K>; 2],
    /// The right-hand side of the acceleration of the order in work.
    rest: LinkPair<K>,
    acceleration: LinkPair<K>,
}

impl<const K: usize> Lane<K> {
    /// All zeros.
    pub const EMPTY: Self = Self {
        q: [[[0.0; K]; 2]; ROWS],
        v: [[[0.0; K]; 2]; ROWS],
        sin: [[[0.0; K]; 2]; ROWS],
        cos: [[[0.0; K]; 2]; ROWS],
        across: [[[0.0; K]; 2]; ROWS],
        along: [[[0.0; K]; 2]; ROWS],
        bent: [[[0.0; K]; 2]; 2],
        rest: [[0.0; K]; 2],
        acceleration: [[0.0; K]; 2],
    };
}

/// A matrix over the links: entries of two rows in one column, block row after block row.
#[derive(Debug, Clone, Default)]
pub(crate) struct Blocks<T>(pub Vec<T>);

impl<T> Blocks<T> {
    /// Block row r of a matrix over so many lanes.
    #[inline]
    fn row(&self, r: usize, lanes: usize) -> &[T] {
        &self.0[2 * r * lanes..2 * (r + 1) * lanes]
    }

    /// The entries of column j in the rows of the lane of row i.
    #[inline]
    pub fn beside(&self, i: usize, j: usize, lanes: usize) -> &T {
        &self.0[i / 2 * 2 * lanes + j]
    }
}

impl Blocks<Two> {
    /// The matrix of n links with these entries.
    pub fn new(n: usize, entry: impl Fn(usize, usize) -> f64) -> Self {
        let lanes = n.div_ceil(2);
        let at = |i: usize, j: usize| if i < n && j < n { entry(i, j) } else { 0.0 };
        let blocks = (0..lanes).flat_map(|r| (0..2 * lanes).map(move |j| (r, j)));
        Self(
            blocks
                .map(|(r, j)| [at(2 * r, j), at(2 * r + 1, j)])
                .collect(),
        )
    }
}

impl<const K: usize> Blocks<LinkPair<K>> {
    /// The matrices of no motions, n links each.
    pub fn zeros(n: usize) -> Self {
        let lanes = n.div_ceil(2);
        Self(vec![[[0.0; K]; 2]; 2 * lanes * lanes])
    }
}

/// `sum += row x`, x given by lanes; `entry(column, i)` is that of the row i of the block for each motion.
#[allow(clippy::inline_always, reason = "a part of the innermost loop")]
#[inline(always)]
fn add_product<A: Arithmetic, const K: usize>(
    sum: &mut LinkPair<K>,
    entry: impl Fn(usize, usize, usize) -> f64,
    lanes: &[Lane<K>],
    of: impl Fn(&Lane<K>) -> &LinkPair<K>,
) {
    for (r, lane) in lanes.iter().enumerate() {
        let x = of(lane);
        *sum = each(|i, m| {
            let first = A::add_product(entry(2 * r, i, m), x[0][m], sum[i][m]);
            A::add_product(entry(2 * r + 1, i, m), x[1][m], first)
        });
    }
}

/// The coefficients that do not depend on the state.
#[derive(Debug, Clone)]
pub(crate) struct MotionCoefficients {
    /// The order of the velocities.
    pub order: usize,
    /// I
    pub inertia: Blocks<Two>,
    /// C, empty without damping.
    pub damping: Blocks<Two>,
    /// `h_i g`
    pub weight: Vec<Two>,
}

/// Fills the series of K motions, damped or not, each from its coefficients of order zero, the inverse of its mass matrix and
/// its angle of the forcing.
#[allow(
    clippy::inline_always,
    reason = "the loops over lanes are written out where their number is known"
)]
#[inline(always)]
pub(crate) fn expand<A: Arithmetic, E: SeriesForcing<K>, const K: usize, const IS_DAMPED: bool>(
    lanes: &mut [Lane<K>],
    c: &MotionCoefficients,
    inverse: &Blocks<LinkPair<K>>,
    excitation: &E,
    angles: &[f64; K],
) {
    let count = lanes.len();
    let mut factor = excitation.begin(angles);
    for lane in lanes.iter_mut() {
        lane.sin[1] = each(|i, m| lane.cos[0][i][m] * lane.v[0][i][m]);
        lane.cos[1] = each(|i, m| -lane.sin[0][i][m] * lane.v[0][i][m]);
    }
    for k in 0..c.order {
        let next = (k + 1) as f64;
        for lane in lanes.iter_mut() {
            known_part::<A, K>(lane, k);
        }
        for r in 0..count {
            let row = c.inertia.row(r, count);
            let entry = |column: usize, i: usize, _: usize| row[column][i];
            let push = excitation.base(&factor, r);
            let (mut across, mut along) = (each(|i, m| -push[i][m]), [[0.0; K]; 2]);
            if k == 0 {
                along = each(|i, _| -c.weight[r][i]);
            }
            add_product::<A, K>(&mut across, entry, lanes, |lane| &lane.bent[0]);
            add_product::<A, K>(&mut along, entry, lanes, |lane| &lane.bent[1]);
            let mut drag = [[0.0; K]; 2];
            if IS_DAMPED {
                let row = c.damping.row(r, count);
                let entry = |column: usize, i: usize, _: usize| row[column][i];
                add_product::<A, K>(&mut drag, entry, lanes, |lane| &lane.v[k]);
            }
            let force = excitation.force(&factor, r);
            let lane = &mut lanes[r];
            let (cos, sin) = (&lane.cos[0], &lane.sin[0]);
            lane.rest = each(|i, m| {
                let driven = lane.rest[i][m] + (force[i][m] - drag[i][m]);
                let driven = A::add_product(-cos[i][m], across[i][m], driven);
                A::add_product(sin[i][m], along[i][m], driven)
            });
            (lane.across[k], lane.along[k]) = (across, along);
        }
        for r in 0..count {
            let row = inverse.row(r, count);
            let entry = |column: usize, i: usize, m: usize| row[column][i][m];
            let mut acceleration = [[0.0; K]; 2];
            add_product::<A, K>(&mut acceleration, entry, lanes, |lane| &lane.rest);
            lanes[r].acceleration = acceleration;
        }
        let (by_next, by_both) = (RECIPROCALS[k + 1], RECIPROCALS[k + 1] * RECIPROCALS[k + 2]);
        for lane in lanes.iter_mut() {
            let (a, [sin, cos]) = (&lane.acceleration, &lane.bent);
            let turned = [
                each(|i, m| lane.cos[0][i][m] * a[i][m]),
                each(|i, m| -lane.sin[0][i][m] * a[i][m]),
            ];
            lane.v[k + 1] = each(|i, m| a[i][m] * by_next);
            lane.sin[k + 2] = each(|i, m| (sin[i][m] + turned[0][i][m]) * by_both);
            lane.cos[k + 2] = each(|i, m| (cos[i][m] + turned[1][i][m]) * by_both);
            lane.bent = turned;
        }
        for r in 0..count {
            let row = c.inertia.row(r, count);
            let entry = |column: usize, i: usize, _: usize| row[column][i];
            let (mut across, mut along) = (lanes[r].across[k], lanes[r].along[k]);
            add_product::<A, K>(&mut across, entry, lanes, |lane| &lane.bent[0]);
            add_product::<A, K>(&mut along, entry, lanes, |lane| &lane.bent[1]);
            (lanes[r].across[k], lanes[r].along[k]) = (across, along);
        }
        factor = excitation.raise(&factor, next);
    }
    for lane in lanes {
        let last = &lane.v[c.order];
        lane.q[c.order + 1] = each(|i, m| last[i][m] * RECIPROCALS[c.order + 1]);
    }
}

/// The parts of order k of a lane that do not need the acceleration of order k: the position, the second derivatives of
/// sine and cosine, the products of the equations of motion.
#[allow(clippy::inline_always, reason = "the innermost loop of the series")]
#[inline(always)]
fn known_part<A: Arithmetic, const K: usize>(lane: &mut Lane<K>, k: usize) {
    let next = (k + 1) as f64;
    let (mut sin, mut cos, mut rest) = ([[0.0; K]; 2], [[0.0; K]; 2], [[0.0; K]; 2]);
    // The coefficients found last come last: the sum does not wait for them.
    let (c, s, v) = (&lane.cos[1..][..k], &lane.sin[1..][..k], &lane.v[1..][..k]);
    let (p, q) = (&lane.across[..k], &lane.along[..k]);
    for j in 0..k {
        let back = k - 1 - j;
        for i in 0..2 {
            for m in 0..K {
                let (c, s, v) = (c[back][i][m], s[back][i][m], v[j][i][m]);
                sin[i][m] = A::add_product(c, v, sin[i][m]);
                cos[i][m] = A::add_product(s, v, cos[i][m]);
                let without = A::add_product(-c, p[j][i][m], rest[i][m]);
                rest[i][m] = A::add_product(s, q[j][i][m], without);
            }
        }
    }
    let (c, s, v) = (&lane.cos[k + 1], &lane.sin[k + 1], &lane.v[0]);
    lane.bent = [
        each(|i, m| next * A::add_product(c[i][m], v[i][m], sin[i][m])),
        each(|i, m| -next * A::add_product(s[i][m], v[i][m], cos[i][m])),
    ];
    lane.q[k + 1] = each(|i, m| lane.v[k][i][m] * RECIPROCALS[k + 1]);
    lane.rest = rest;
}
