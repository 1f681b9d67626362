//! A function as a polynomial of degree 8 on a piece: through its values at the nine points of Chebyshev and Lobatto, the ends among them,
//! and held against it between them (theory 11).

use std::f64::consts::PI;

/// The golden ratio less one [-]: the fractions of its multiples never repeat. [exact]
pub(super) const GOLDEN_FRACTION: f64 = 0.618_033_988_749_895;
/// The degree of the polynomials. [exact]
pub(super) const CHEBYSHEV_DEGREE: usize = 8;
/// The nodes of a piece, one more than the degree. [exact]
pub(crate) const CHEBYSHEV_NODES: usize = CHEBYSHEV_DEGREE + 1;
/// Points at which a polynomial is compared with the function, one between each two nodes. [exact]
const CHECK_POINTS: usize = CHEBYSHEV_DEGREE;
/// The nodes of a piece and the check points between them. [exact]
pub(super) const SAMPLE_POINTS: usize = CHEBYSHEV_NODES + CHECK_POINTS;

/// The nodes in [-1, 1], from the left.
fn nodes() -> [f64; CHEBYSHEV_NODES] {
    std::array::from_fn(|j| -(PI * j as f64 / CHEBYSHEV_DEGREE as f64).cos())
}

/// The check points in [-1, 1], about in the middle of the angles between nodes: in the very middle a polynomial of 32 times the degree
/// could be constant, as it is at the nodes.
fn checks() -> [f64; CHECK_POINTS] {
    let part = |j: usize| 0.25 + 0.5 * (GOLDEN_FRACTION * (j + 1) as f64).fract();
    std::array::from_fn(|j| -(PI * (j as f64 + part(j)) / CHEBYSHEV_DEGREE as f64).cos())
}

/// The Chebyshev coefficients of the polynomial with given values at the nodes.
pub(super) fn coefficients(values: &[f64]) -> [f64; CHEBYSHEV_NODES] {
    let half = |j: usize| {
        if j == 0 || j == CHEBYSHEV_DEGREE {
            0.5
        } else {
            1.0
        }
    };
    std::array::from_fn(|k| {
        let term = |j: usize| {
            // T_k at the j-th node from the left
            let angle = PI * ((k * (CHEBYSHEV_DEGREE - j)) % (2 * CHEBYSHEV_DEGREE)) as f64
                / CHEBYSHEV_DEGREE as f64;
            half(j) * values[j] * angle.cos()
        };
        (0..CHEBYSHEV_NODES).map(term).sum::<f64>() * 2.0 * half(k) / CHEBYSHEV_DEGREE as f64
    })
}

/// `sum_k c_k T_k(x)`
pub(super) fn sum(c: &[f64; CHEBYSHEV_NODES], x: f64) -> f64 {
    let (mut next, mut after) = (0.0, 0.0);
    for k in (1..CHEBYSHEV_NODES).rev() {
        (next, after) = (c[k] + 2.0 * x * next - after, next);
    }
    c[0] + x * next - after
}

/// The coefficients of `sum_k c_k T_k(2 x - 1)` in powers of x.
pub(super) fn powers(c: &[f64; CHEBYSHEV_NODES]) -> [f64; CHEBYSHEV_NODES] {
    let (mut before, mut now) = ([0.0; CHEBYSHEV_NODES], [0.0; CHEBYSHEV_NODES]);
    (before[0], now[0], now[1]) = (1.0, -1.0, 2.0);
    let mut total: [f64; CHEBYSHEV_NODES] =
        std::array::from_fn(|m| c[0] * before[m] + c[1] * now[m]);
    for &factor in &c[2..] {
        let next: [f64; CHEBYSHEV_NODES] = std::array::from_fn(|m| {
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
pub(super) fn line(values: &[f64; SAMPLE_POINTS]) -> [f64; CHEBYSHEV_NODES] {
    let (first, last) = (values[0], values[CHEBYSHEV_DEGREE]);
    let mut c = [0.0; CHEBYSHEV_NODES];
    (c[0], c[1]) = (0.5 * (first + last), 0.5 * (last - first));
    c
}

/// Samples of a function on one piece: at the nodes, then at the check points between them.
pub(super) struct SampledPiece {
    pub places: [f64; SAMPLE_POINTS],
    pub values: [f64; SAMPLE_POINTS],
}

impl SampledPiece {
    /// The nodes and check points of a piece, the outermost ones as far inside its ends as given.
    pub fn at((start, end): (f64, f64), inside: [f64; 2]) -> Self {
        let mut places = nodes().into_iter().chain(checks());
        let mut places: [f64; SAMPLE_POINTS] = std::array::from_fn(|_| {
            let x = places.next().unwrap_or_default();
            start + (end - start) * 0.5 * (1.0 + x)
        });
        (places[0], places[CHEBYSHEV_DEGREE]) = (start + inside[0], end - inside[1]);
        Self {
            places,
            values: [0.0; SAMPLE_POINTS],
        }
    }

    /// The largest error of a polynomial at the sampled points.
    pub fn miss(&self, c: &[f64; CHEBYSHEV_NODES]) -> f64 {
        let off = |(x, value): (f64, &f64)| (sum(c, x) - value).abs();
        let places = nodes().into_iter().chain(checks());
        places.zip(&self.values).map(off).fold(0.0, f64::max)
    }

    /// The largest slope between nodes.
    pub fn steepest(&self) -> f64 {
        steepest(
            &self.places[..CHEBYSHEV_NODES],
            &self.values[..CHEBYSHEV_NODES],
        )
    }
}

/// The largest slope between neighbouring samples.
pub(super) fn steepest(places: &[f64], values: &[f64]) -> f64 {
    let pairs = places.windows(2).zip(values.windows(2));
    let slopes = pairs.map(|(t, x)| ((x[1] - x[0]) / (t[1] - t[0])).abs());
    slopes.fold(0.0, f64::max)
}
