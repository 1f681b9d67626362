//! Taylor series of a pendulum's large motions, to any order up to [`MOST_ORDER`] (theory 8).
//!
//! With `s_i = sin q_i`, `c_i = cos q_i` the equations of motion are `c_i P_i - s_i Q_i = -(C v)_i + f_i`, where
//! `P_i = sum_j I_ij s_j'' - h_i b` and `Q_i = sum_j I_ij c_j'' - h_i g`: products of series of one link alone, and linear
//! combinations of links. Coefficient k of each product is a convolution, in which the unknown acceleration appears with
//! the mass matrix at the start; `s' = c v` and `c' = -s v` give the rest.

use crate::flow::shaking::{Shaking, Two};

/// Highest order of a series.
pub(crate) const MOST_ORDER: usize = 24;
/// Coefficients of the positions, which have one order more than the velocities.
pub(crate) const ROWS: usize = MOST_ORDER + 2;

/// `1/k`, zero for k = 0.
const RECIPROCALS: [f64; ROWS] = {
    let mut all = [0.0; ROWS];
    let mut k = 1;
    while k < ROWS {
        all[k] = 1.0 / k as f64;
        k += 1;
    }
    all
};

/// The series of two links: coefficient k is that of `t^k`.
#[derive(Debug, Clone)]
pub(crate) struct Lane {
    pub q: [Two; ROWS],
    pub v: [Two; ROWS],
    pub sin: [Two; ROWS],
    pub cos: [Two; ROWS],
    /// P and Q of the equations of motion.
    across: [Two; ROWS],
    along: [Two; ROWS],
    /// The second derivatives of sine and cosine at the order in work: without the acceleration, then its part alone.
    bent: [Two; 2],
    /// What drives the acceleration of the order in work.
    rest: Two,
    acceleration: Two,
}

impl Lane {
    /// All zeros.
    pub const EMPTY: Self = Self {
        q: [[0.0; 2]; ROWS],
        v: [[0.0; 2]; ROWS],
        sin: [[0.0; 2]; ROWS],
        cos: [[0.0; 2]; ROWS],
        across: [[0.0; 2]; ROWS],
        along: [[0.0; 2]; ROWS],
        bent: [[0.0; 2]; 2],
        rest: [0.0; 2],
        acceleration: [0.0; 2],
    };
}

/// A matrix over the links: entries of two rows in one column, block row after block row.
#[derive(Debug, Clone, Default)]
pub(crate) struct Blocks(pub Vec<Two>);

impl Blocks {
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

    /// Block row r of a matrix over so many lanes.
    #[inline]
    fn row(&self, r: usize, lanes: usize) -> &[Two] {
        &self.0[2 * r * lanes..2 * (r + 1) * lanes]
    }
}

/// `sum += row x`, x given by lanes.
#[inline]
fn add_product(sum: &mut Two, row: &[Two], lanes: &[Lane], of: impl Fn(&Lane) -> Two) {
    for (columns, lane) in row.chunks_exact(2).zip(lanes) {
        let x = of(lane);
        for i in 0..2 {
            sum[i] += columns[0][i] * x[0] + columns[1][i] * x[1];
        }
    }
}

/// What does not change with the state.
#[derive(Debug, Clone)]
pub(crate) struct Coefficients {
    /// The order of the velocities.
    pub order: usize,
    /// I
    pub inertia: Blocks,
    /// C, empty without damping.
    pub damping: Blocks,
    /// `h_i g`
    pub weight: Vec<Two>,
}

/// Fills the series from their coefficients of order zero.
#[allow(
    clippy::inline_always,
    reason = "the loops over lanes are written out where their number is known"
)]
#[inline(always)]
fn expand<E: Shaking>(
    lanes: &mut [Lane],
    c: &Coefficients,
    inverse: &Blocks,
    excitation: &E,
    angle: f64,
) {
    let count = lanes.len();
    let mut factor = excitation.begin(angle);
    for lane in lanes.iter_mut() {
        for i in 0..2 {
            lane.sin[1][i] = lane.cos[0][i] * lane.v[0][i];
            lane.cos[1][i] = -lane.sin[0][i] * lane.v[0][i];
        }
    }
    for k in 0..c.order {
        let next = (k + 1) as f64;
        for lane in lanes.iter_mut() {
            known_part(lane, k);
        }
        for r in 0..count {
            let row = c.inertia.row(r, count);
            let (mut across, mut along) = (excitation.base(factor, r).map(|b| -b), [0.0; 2]);
            if k == 0 {
                along = c.weight[r].map(|w| -w);
            }
            add_product(&mut across, row, lanes, |lane| lane.bent[0]);
            add_product(&mut along, row, lanes, |lane| lane.bent[1]);
            let mut drag = [0.0; 2];
            if !c.damping.0.is_empty() {
                add_product(&mut drag, c.damping.row(r, count), lanes, |lane| lane.v[k]);
            }
            let force = excitation.force(factor, r);
            let lane = &mut lanes[r];
            for i in 0..2 {
                lane.rest[i] +=
                    force[i] - drag[i] - lane.cos[0][i] * across[i] + lane.sin[0][i] * along[i];
            }
            (lane.across[k], lane.along[k]) = (across, along);
        }
        for r in 0..count {
            let mut acceleration = [0.0; 2];
            add_product(&mut acceleration, inverse.row(r, count), lanes, |lane| {
                lane.rest
            });
            lanes[r].acceleration = acceleration;
        }
        let (by_next, by_both) = (RECIPROCALS[k + 1], RECIPROCALS[k + 1] * RECIPROCALS[k + 2]);
        for lane in lanes.iter_mut() {
            for i in 0..2 {
                let a = lane.acceleration[i];
                let turned = [lane.cos[0][i] * a, -lane.sin[0][i] * a];
                lane.v[k + 1][i] = a * by_next;
                lane.sin[k + 2][i] = (lane.bent[0][i] + turned[0]) * by_both;
                lane.cos[k + 2][i] = (lane.bent[1][i] + turned[1]) * by_both;
                (lane.bent[0][i], lane.bent[1][i]) = (turned[0], turned[1]);
            }
        }
        for r in 0..count {
            let row = c.inertia.row(r, count);
            let (mut across, mut along) = (lanes[r].across[k], lanes[r].along[k]);
            add_product(&mut across, row, lanes, |lane| lane.bent[0]);
            add_product(&mut along, row, lanes, |lane| lane.bent[1]);
            (lanes[r].across[k], lanes[r].along[k]) = (across, along);
        }
        factor = excitation.raise(factor, next);
    }
    for lane in lanes {
        lane.q[c.order + 1] = lane.v[c.order].map(|v| v * RECIPROCALS[c.order + 1]);
    }
}

/// The parts of order k of a lane that do not need the acceleration of order k: the position, the second derivatives of
/// sine and cosine, the products of the equations of motion.
#[allow(clippy::inline_always, reason = "the innermost loop of the series")]
#[inline(always)]
fn known_part(lane: &mut Lane, k: usize) {
    let next = (k + 1) as f64;
    let (mut sin, mut cos, mut rest) = ([0.0; 2], [0.0; 2], [0.0; 2]);
    // The coefficients found last come last: the sum does not wait for them.
    let (c, s, v) = (&lane.cos[1..][..k], &lane.sin[1..][..k], &lane.v[1..][..k]);
    let (p, q) = (&lane.across[..k], &lane.along[..k]);
    for j in 0..k {
        let back = k - 1 - j;
        for i in 0..2 {
            sin[i] += c[back][i] * v[j][i];
            cos[i] += s[back][i] * v[j][i];
            rest[i] += s[back][i] * q[j][i] - c[back][i] * p[j][i];
        }
    }
    let (c, s, v) = (lane.cos[k + 1], lane.sin[k + 1], lane.v[0]);
    for i in 0..2 {
        sin[i] = next * (sin[i] + c[i] * v[i]);
        cos[i] = -next * (cos[i] + s[i] * v[i]);
        lane.q[k + 1][i] = lane.v[k][i] * RECIPROCALS[k + 1];
    }
    lane.bent = [sin, cos];
    lane.rest = rest;
}

/// [`expand`] with the number of lanes known at compile time where it is small.
pub(crate) fn expand_lanes<E: Shaking>(
    lanes: &mut [Lane],
    c: &Coefficients,
    inverse: &Blocks,
    excitation: &E,
    angle: f64,
) {
    match lanes {
        [_] => expand(&mut lanes[..1], c, inverse, excitation, angle),
        [_, _] => expand(&mut lanes[..2], c, inverse, excitation, angle),
        [_, _, _] => expand(&mut lanes[..3], c, inverse, excitation, angle),
        _ => expand(lanes, c, inverse, excitation, angle),
    }
}
