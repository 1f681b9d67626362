//! A function as a polynomial of degree 8 on a piece: through its values at the nine points of Chebyshev and Lobatto, the ends among them,
//! and held against it between them (theory 11).

use std::f64::consts::PI;

/// The golden ratio less one, of whose multiples the fractions repeat at no step.
pub(super) const GOLDEN: f64 = 0.618_033_988_749_895;
/// The degree of the pieces.
pub(super) const DEGREE: usize = 8;
pub(crate) const NODES: usize = DEGREE + 1;
/// Places between the nodes at which a piece is held against the function.
const CHECKS: usize = DEGREE;
/// Nodes, then places between them.
pub(super) const PLACES: usize = NODES + CHECKS;

/// The nodes in [-1, 1], from the left.
fn nodes() -> [f64; NODES] {
    std::array::from_fn(|j| -(PI * j as f64 / DEGREE as f64).cos())
}

/// Places between them, about in the middle of the angles: in the very middle a polynomial of 32 times the degree could be one value, as it
/// is at the nodes.
fn checks() -> [f64; CHECKS] {
    let part = |j: usize| 0.25 + 0.5 * (GOLDEN * (j + 1) as f64).fract();
    std::array::from_fn(|j| -(PI * (j as f64 + part(j)) / DEGREE as f64).cos())
}

/// The coefficients of Chebyshev polynomials of what has some values at the nodes.
pub(super) fn coefficients(values: &[f64]) -> [f64; NODES] {
    let half = |j: usize| if j == 0 || j == DEGREE { 0.5 } else { 1.0 };
    std::array::from_fn(|k| {
        let term = |j: usize| {
            // T_k at the j-th node from the left
            let angle = PI * ((k * (DEGREE - j)) % (2 * DEGREE)) as f64 / DEGREE as f64;
            half(j) * values[j] * angle.cos()
        };
        (0..NODES).map(term).sum::<f64>() * 2.0 * half(k) / DEGREE as f64
    })
}

/// `sum_k c_k T_k(x)`
pub(super) fn sum(c: &[f64; NODES], x: f64) -> f64 {
    let (mut next, mut after) = (0.0, 0.0);
    for k in (1..NODES).rev() {
        (next, after) = (c[k] + 2.0 * x * next - after, next);
    }
    c[0] + x * next - after
}

/// The coefficients of `sum_k c_k T_k(2 x - 1)` in powers of x.
pub(super) fn powers(c: &[f64; NODES]) -> [f64; NODES] {
    let (mut before, mut now) = ([0.0; NODES], [0.0; NODES]);
    (before[0], now[0], now[1]) = (1.0, -1.0, 2.0);
    let mut total: [f64; NODES] = std::array::from_fn(|m| c[0] * before[m] + c[1] * now[m]);
    for &factor in &c[2..] {
        let next: [f64; NODES] = std::array::from_fn(|m| {
            let raised = if m > 0 { now[m - 1] } else { 0.0 };
            4.0 * raised - 2.0 * now[m] - before[m]
        });
        (before, now) = (now, next);
        for (total, x) in total.iter_mut().zip(&now) {
            *total += factor * x;
        }
    }
    total
}

/// The coefficients of the straight line between the ends of a piece with some values.
pub(super) fn line(values: &[f64; PLACES]) -> [f64; NODES] {
    let (first, last) = (values[0], values[DEGREE]);
    let mut c = [0.0; NODES];
    (c[0], c[1]) = (0.5 * (first + last), 0.5 * (last - first));
    c
}

/// One piece that is looked at: where, at the nodes and then between them, and what was seen.
pub(super) struct Piece {
    pub places: [f64; PLACES],
    pub values: [f64; PLACES],
}

impl Piece {
    /// Where a function is asked for on a piece; as far inside its ends as is said.
    pub fn at((start, end): (f64, f64), inside: [f64; 2]) -> Self {
        let mut places = nodes().into_iter().chain(checks());
        let mut places: [f64; PLACES] = std::array::from_fn(|_| {
            let x = places.next().unwrap_or_default();
            start + (end - start) * 0.5 * (1.0 + x)
        });
        (places[0], places[DEGREE]) = (start + inside[0], end - inside[1]);
        Self {
            places,
            values: [0.0; PLACES],
        }
    }

    /// How far a polynomial is off what was seen.
    pub fn miss(&self, c: &[f64; NODES]) -> f64 {
        let off = |(x, value): (f64, &f64)| (sum(c, x) - value).abs();
        let places = nodes().into_iter().chain(checks());
        places.zip(&self.values).map(off).fold(0.0, f64::max)
    }

    /// The largest slope between nodes.
    pub fn steepest(&self) -> f64 {
        steepest(&self.places[..NODES], &self.values[..NODES])
    }
}

/// The largest slope between neighbours, of those that are at two times.
pub(super) fn steepest(places: &[f64], values: &[f64]) -> f64 {
    let pairs = places.windows(2).zip(values.windows(2));
    let slopes = pairs.map(|(t, x)| ((x[1] - x[0]) / (t[1] - t[0])).abs());
    slopes.fold(0.0, f64::max)
}
