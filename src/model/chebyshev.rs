//! A function as polynomials of degree 8 in pieces: each goes through the function at the nine points of Chebyshev and Lobatto, its
//! ends among them, and is halved until it is the function between them too; at a corner, to straight lines (theory 11).

use crate::error::{Error, Result};
use crate::tolerance::{FUNCTION_TOL, MOST_PIECES};
use std::f64::consts::PI;

/// The degree of the pieces.
pub(super) const DEGREE: usize = 8;
pub(crate) const NODES: usize = DEGREE + 1;
/// Pieces up to this part of the span, where halves of it have led to a corner, are straight lines: high powers would have no digits.
const CORNER: f64 = 1.0 / 67_108_864.0;
/// What the last place of the time may make of a function, in parts of its largest value: more is a jump.
const MOST_BY_TIME: f64 = 1e-6;
/// A function is rough where the miss of half a piece is more than this part of that of the whole, if no more than this part of its largest
/// value: halving a piece of a smooth one takes 1/512 of it, at a corner a half.
const ROUGH: f64 = 0.7;
const ROUGHEST: f64 = 1e-9;
/// Places between the nodes at which a piece is held against the function.
const CHECKS: usize = DEGREE;

/// The nodes in [-1, 1], from the left.
fn nodes() -> [f64; NODES] {
    std::array::from_fn(|j| -(PI * j as f64 / DEGREE as f64).cos())
}

/// Places between them.
fn checks() -> [f64; CHECKS] {
    std::array::from_fn(|j| -(PI * (j as f64 + 0.5) / DEGREE as f64).cos())
}

/// The coefficients of Chebyshev polynomials of what has some values at the nodes.
fn coefficients(values: &[f64]) -> [f64; NODES] {
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
fn sum(c: &[f64; NODES], x: f64) -> f64 {
    let (mut next, mut after) = (0.0, 0.0);
    for k in (1..NODES).rev() {
        (next, after) = (c[k] + 2.0 * x * next - after, next);
    }
    c[0] + x * next - after
}

/// The coefficients of `sum_k c_k T_k(2 x - 1)` in powers of x.
fn powers(c: &[f64; NODES]) -> [f64; NODES] {
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

/// One piece that is looked at.
struct Piece {
    start: f64,
    end: f64,
    values: Vec<f64>,
}

impl Piece {
    /// Where the function is asked for: at the nodes, then at the places between.
    fn places(start: f64, end: f64) -> impl Iterator<Item = f64> {
        let at = move |x: f64| {
            let inner = start + (end - start) * 0.5 * (1.0 + x);
            if x >= 1.0 { end } else { inner }
        };
        nodes().into_iter().chain(checks()).map(at)
    }

    /// The coefficients of the straight line between its ends.
    fn line(&self) -> [f64; NODES] {
        let (first, last) = (self.values[0], self.values[DEGREE]);
        let mut c = [0.0; NODES];
        (c[0], c[1]) = (0.5 * (first + last), 0.5 * (last - first));
        c
    }

    /// How far the polynomial is off, and the largest slope of the values.
    fn miss(&self, c: &[f64; NODES]) -> (f64, f64) {
        let off = |(x, value): (f64, &f64)| (sum(c, x) - value).abs();
        let miss = nodes()
            .into_iter()
            .chain(checks())
            .zip(&self.values)
            .map(off);
        let places: Vec<f64> = Self::places(self.start, self.end).take(NODES).collect();
        let slopes = (1..NODES)
            .map(|j| ((self.values[j] - self.values[j - 1]) / (places[j] - places[j - 1])).abs());
        (miss.fold(0.0, f64::max), slopes.fold(0.0, f64::max))
    }
}

/// A piece of a function: its coefficients in powers of the part of it that has passed.
pub(crate) struct PolynomialPiece {
    pub start: f64,
    pub end: f64,
    pub powers: [f64; NODES],
}

/// The breakpoints of the pieces of a function on a span, and their derivatives of orders 0 to the degree where each begins.
pub(super) fn pieces(
    function: &mut dyn FnMut(&[f64]) -> Result<Vec<f64>>,
    span: (f64, f64),
) -> Result<(Vec<f64>, Vec<f64>)> {
    let all = polynomial_pieces(function, span, 0.0)?;
    let mut breaks: Vec<f64> = all.iter().map(|piece| piece.start).collect();
    breaks.push(span.1);
    let mut derivatives = Vec::with_capacity(NODES * all.len());
    for PolynomialPiece { start, end, powers } in &all {
        let mut factor = 1.0;
        for (m, power) in powers.iter().enumerate() {
            derivatives.push(factor * power);
            factor *= (m + 1) as f64 / (end - start);
        }
    }
    Ok((breaks, derivatives))
}

/// The pieces of a function on a span, in order; it is known to so much, if not to its own rounding. One that is known to something at all
/// may be rougher: where a piece is followed no better by its half, what is left is that.
pub(crate) fn polynomial_pieces(
    function: &mut dyn FnMut(&[f64]) -> Result<Vec<f64>>,
    (start, end): (f64, f64),
    known_to: f64,
) -> Result<Vec<PolynomialPiece>> {
    let mut open = vec![(start, end)];
    let mut missed = vec![f64::INFINITY];
    let mut done: Vec<(f64, f64, [f64; NODES])> = Vec::new();
    let mut largest = 0.0f64;
    while !open.is_empty() {
        let looked = look(function, &open)?;
        let values = looked.iter().flat_map(|piece| &piece.values);
        largest = values.fold(largest, |largest, x| largest.max(x.abs()));
        open.clear();
        let before = std::mem::take(&mut missed);
        let mut worst = 0.0f64;
        for (piece, before) in looked.into_iter().zip(before) {
            let (a, b) = (piece.start, piece.end);
            let c = if b - a <= CORNER * (end - start) {
                piece.line()
            } else {
                coefficients(&piece.values[..NODES])
            };
            let (miss, slope) = piece.miss(&c);
            let by_time = 4.0 * f64::EPSILON * a.abs().max(b.abs()) * slope;
            let allowed = known_to.max(FUNCTION_TOL * largest);
            let is_rough = known_to > 0.0 && miss > ROUGH * before && miss <= ROUGHEST * largest;
            if is_rough || miss <= allowed + by_time.min(MOST_BY_TIME * largest) {
                done.push((a, b, c));
            } else {
                worst = worst.max(miss);
                let middle = 0.5 * (a + b);
                open.extend([(a, middle), (middle, b)]);
                missed.extend([miss; 2]);
            }
        }
        let shortest = f64::EPSILON * (end - start);
        let is_too_short = open
            .iter()
            .any(|(a, b)| b - a <= shortest || a + (b - a) / NODES as f64 <= *a);
        if open.len() + done.len() > MOST_PIECES || is_too_short {
            let value = format!(
                "off by {worst:e} after {} pieces",
                open.len() / 2 + done.len()
            );
            let rule = format!(
                "{MOST_PIECES} polynomials must follow it to {FUNCTION_TOL:e} of its largest value, {largest:e}: shorten the span, or \
                 give what jumps as pieces of your own"
            );
            return Err(Error::bad_value("the function", value, rule));
        }
    }
    done.sort_by(|x, y| x.0.total_cmp(&y.0));
    let piece = |(start, end, c): (f64, f64, _)| PolynomialPiece {
        start,
        end,
        powers: powers(&c),
    };
    Ok(done.into_iter().map(piece).collect())
}

/// The function at all places of some pieces, asked for at once.
fn look(
    function: &mut dyn FnMut(&[f64]) -> Result<Vec<f64>>,
    open: &[(f64, f64)],
) -> Result<Vec<Piece>> {
    let places: Vec<f64> = open
        .iter()
        .flat_map(|&(a, b)| Piece::places(a, b))
        .collect();
    let values = function(&places)?;
    if values.len() != places.len() {
        let (found, expected) = (
            format!("({},)", values.len()),
            format!("({},)", places.len()),
        );
        return Err(Error::bad_shape("the function's value", found, expected));
    }
    if let Some(i) = values.iter().position(|x| !x.is_finite()) {
        let argument = format!("the function at t = {}", places[i]);
        return Err(Error::bad_value(argument, values[i], "it must be finite"));
    }
    let each = open.iter().zip(values.chunks(NODES + CHECKS));
    Ok(each
        .map(|(&(start, end), values)| Piece {
            start,
            end,
            values: values.to_vec(),
        })
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::signal::Signal;

    fn each(f: impl Fn(f64) -> f64) -> impl FnMut(&[f64]) -> Result<Vec<f64>> {
        move |t: &[f64]| Ok(t.iter().map(|&t| f(t)).collect())
    }

    #[test]
    fn smooth_functions_are_followed_to_rounding() {
        let functions: [(&str, fn(f64) -> f64); 4] = [
            ("a chirp", |t| ((1.0 + t) * t).sin()),
            ("a polynomial", |t| 1.0 + t * (2.0 - t * t * t)),
            ("a pulse", |t| (-4.0 * (t - 5.0).powi(2)).exp()),
            ("nothing", |_| 0.0),
        ];
        for (name, f) in functions {
            let signal = Signal::from_function(each(f), (-3.0, 10.0)).expect("smooth");
            let samples = (1..9_999).map(|i| -3.0 + 13.0 * f64::from(i) / 10_000.0);
            let largest = samples.clone().fold(0.0f64, |m, t| m.max(f(t).abs()));
            let slope = |t: f64| ((f(t + 1e-6) - f(t - 1e-6)) / 2e-6).abs();
            let steepest = samples.clone().map(slope).fold(0.0, f64::max);
            for t in samples {
                let off = (signal.value(t) - f(t)).abs();
                let by_time = f64::EPSILON * t.abs() * steepest;
                let allowed = 2e-14 * largest + 4.0 * by_time;
                assert!(off <= allowed, "{name} at {t}: {off:e}");
            }
        }
    }

    #[test]
    fn a_fast_function_far_from_zero_is_followed_as_far_as_its_time_is_known() {
        let signal = Signal::from_function(each(|t| (1e3 * t).sin()), (1000.0, 1001.0));
        let signal = signal.expect("as far as the time is known");
        for i in 0..1000 {
            let t = 1000.0 + f64::from(i) * 1e-3;
            assert!((signal.value(t) - (1e3 * t).sin()).abs() < 1e-9);
        }
    }

    #[test]
    fn a_corner_is_followed_by_lines_and_a_jump_is_refused() {
        let corner = |t: f64| (t - 0.3).abs();
        let signal = Signal::from_function(each(corner), (0.0, 1.0)).expect("continuous");
        for i in 0..10_000 {
            let t = 0.2999 + 2e-8 * f64::from(i);
            assert!((signal.value(t) - corner(t)).abs() < 1e-14, "{t}");
        }
        let jump = Signal::from_function(each(|t| (t - 0.3).signum()), (0.0, 1.0));
        let message = jump.expect_err("a jump").to_string();
        assert!(message.starts_with("the function is off by "), "{message}");
        for (f, span) in [
            (f64::NAN, (0.0, 1.0)),
            (1.0, (1.0, 1.0)),
            (1.0, (0.0, f64::INFINITY)),
        ] {
            assert!(Signal::from_function(each(move |_| f), span).is_err());
        }
    }
}
