//! Where a polynomial on `[0, end]` first falls below zero: its critical points come from those of its derivative, and so on
//! up from a derivative of one sign, so that every minimum is seen however shallow.

use crate::runs::double_double::Dd;

pub fn value(p: &[f64], t: f64) -> f64 {
    p.iter().rev().fold(0.0, |sum, c| sum * t + c)
}

fn derivative(p: &[f64]) -> Vec<f64> {
    p.iter()
        .enumerate()
        .skip(1)
        .map(|(k, c)| k as f64 * c)
        .collect()
}

/// Whether the constant term outweighs the others on `[0, end]`.
fn is_of_one_sign(p: &[f64], end: f64) -> bool {
    let rest = p[1..]
        .iter()
        .rev()
        .fold(0.0, |sum, c| (sum + c.abs()) * end);
    p[0].abs() > rest || p.iter().all(|&c| c >= 0.0) || p.iter().all(|&c| c <= 0.0)
}

/// A root between two points of opposite sign.
fn bisect(p: &[f64], mut low: f64, mut high: f64) -> f64 {
    let sign = value(p, low) > 0.0;
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if (value(p, middle) > 0.0) == sign {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

/// All sign changes on `(0, end)`, ascending.
pub fn roots(p: &[f64], end: f64) -> Vec<f64> {
    if p.len() < 2 || is_of_one_sign(p, end) {
        return Vec::new();
    }
    let mut points = vec![0.0];
    points.extend(roots(&derivative(p), end));
    points.push(end);
    let mut found = Vec::new();
    for pair in points.windows(2) {
        let (a, b) = (value(p, pair[0]), value(p, pair[1]));
        if (a > 0.0) != (b > 0.0) {
            found.push(bisect(p, pair[0], pair[1]));
        }
    }
    found
}

/// The first fall below zero, in a bracket, and the minima before it.
pub struct Fall {
    pub bracket: Option<(f64, f64)>,
    /// `(where, value)`
    pub minima: Vec<(f64, f64)>,
}

/// Where `t^order p(t)` first falls below `-margin`, from above zero; a zero right at the end counts.
pub fn first_fall(p: &[f64], end: f64, margin: f64) -> Fall {
    let none = Fall {
        bracket: None,
        minima: Vec::new(),
    };
    let rest = p[1..]
        .iter()
        .rev()
        .fold(0.0, |sum, c| (sum + c.abs()) * end);
    if p[0] > rest {
        return none;
    }
    let mut points = roots(&derivative(p), end);
    points.push(end);
    let (mut low, mut minima) = (0.0, Vec::new());
    for &t in &points {
        let y = value(p, t);
        let falls = if t == end && margin == 0.0 {
            y <= 0.0
        } else {
            y < -margin
        };
        if t < end && y < value(p, 0.5 * (low + t)) {
            minima.push((t, y));
        }
        if falls {
            return Fall {
                bracket: Some((low, t)),
                minima,
            };
        }
        low = t;
    }
    Fall { minima, ..none }
}

/// The root of a polynomial in a bracket over which it falls through zero.
pub fn polish(p: &[Dd], bracket: (f64, f64)) -> Dd {
    let at = |t: Dd| {
        let (mut y, mut slope) = (Dd::ZERO, Dd::ZERO);
        for &c in p.iter().rev() {
            slope = slope * t + y;
            y = y * t + c;
        }
        (y, slope)
    };
    let (mut low, mut high) = (Dd::from(bracket.0), Dd::from(bracket.1));
    let mut t = high;
    for _ in 0..300 {
        let (y, slope) = at(t);
        if y > Dd::ZERO {
            low = t;
        } else {
            high = t;
        }
        let width = high - low;
        if width.to_f64() <= 1e-31 * high.to_f64() || y == Dd::ZERO {
            break;
        }
        let newton = if slope < Dd::ZERO { t - y / slope } else { low };
        let next = if newton > low && newton < high {
            newton
        } else {
            (low + high) * 0.5
        };
        if (next - t).abs().to_f64() <= 1e-31 * t.abs().to_f64() {
            return next;
        }
        t = next;
    }
    t
}

#[test]
fn shallow_minima_are_found() {
    // (t - 0.3)^2 (t + 1) - d
    for (depth, falls) in [(1e-13, true), (-1e-13, false)] {
        let p = [0.09 - depth, 0.09 - 0.6, 1.0 - 0.6, 1.0];
        let fall = first_fall(&p, 1.0, 0.0);
        assert_eq!(fall.bracket.is_some(), falls);
        assert!((fall.minima[0].0 - 0.3).abs() < 1e-12);
        if let Some(bracket) = fall.bracket {
            let t = polish(&p.map(Dd::from), bracket).to_f64();
            assert!((t - (0.3 - (depth / 1.3f64).sqrt())).abs() < 1e-9);
        }
    }
}
