//! Derivatives by differences: central differences of shrinking steps, extrapolated to none (C. J. F. Ridders, Adv. Eng.
//! Software 4 (1982) 75). No scale of the argument need be known.

use crate::error::{Error, Result};
use crate::tolerance::{RIDDERS_FIRST_STEP, RIDDERS_SHRINK, UNSETTLED_DERIVATIVE, ZERO_DERIVATIVE};
use nalgebra::DVector;

/// Number of steps: with the first and the factor between them the shortest is 2e-12. [work]
const RIDDERS_STEPS: usize = 20;

/// The derivative of f at 0, entry by entry: of all extrapolations the one that agrees best with its neighbours; and by how much it may be
/// off, rounding included.
///
/// # Errors
/// What f reports; `Error::NoConvergence` where an entry settles on no value.
pub(crate) fn derivative(
    f: impl Fn(f64) -> Result<DVector<f64>>,
) -> Result<(DVector<f64>, DVector<f64>)> {
    let mut rows = Vec::with_capacity(RIDDERS_STEPS);
    let mut h = RIDDERS_FIRST_STEP;
    let mut height = 0.0;
    for _ in 0..RIDDERS_STEPS {
        let (above, below) = (f(h)?, f(-h)?);
        height = above.amax().max(below.amax());
        let rounding = above.abs().sup(&below.abs()) * (f64::EPSILON / h);
        rows.push(((above - below) / (2.0 * h), rounding));
        h *= RIDDERS_SHRINK;
    }
    let size = rows.iter().map(|(quotient, _)| quotient.amax());
    let mut sizes: Vec<f64> = size.filter(|x| x.is_finite()).collect();
    sizes.sort_by(f64::total_cmp);
    let usual = sizes.get(sizes.len() / 2).copied().unwrap_or(0.0);
    let entries: Vec<(f64, f64)> = (0..rows[0].0.len())
        .map(|i| {
            let along: Vec<[f64; 2]> = rows.iter().map(|(q, r)| [q[i], r[i]]).collect();
            let (value, error) = extrapolated(&along);
            if error <= UNSETTLED_DERIVATIVE * value.abs() || error <= ZERO_DERIVATIVE * usual.max(height) {
                Ok((value, error))
            } else {
                Err(Error::NoConvergence {
                    stage: "a derivative by differences (give the function `jacobian` if it has one)",
                    iterations: RIDDERS_STEPS,
                    residual: error,
                })
            }
        })
        .collect::<Result<_>>()?;
    let (values, errors): (Vec<f64>, Vec<f64>) = entries.into_iter().unzip();
    Ok((DVector::from_vec(values), DVector::from_vec(errors)))
}

/// Neville's table over difference quotients of steps that shrink, each with its rounding: its best entry, and the error of
/// that.
fn extrapolated(quotients: &[[f64; 2]]) -> (f64, f64) {
    let mut best = (f64::NAN, f64::INFINITY);
    let mut above: Vec<f64> = Vec::new();
    for &[quotient, rounding] in quotients {
        let mut row = vec![quotient];
        let mut factor = 1.0;
        for (k, up) in above.iter().enumerate() {
            factor *= 1.0 / (RIDDERS_SHRINK * RIDDERS_SHRINK);
            let next = (factor * row[k] - up) / (factor - 1.0);
            // Without the rounding, noise that agrees by chance would win.
            let error = rounding + (next - row[k]).abs().max((next - up).abs());
            // Where f has no value the error is no number, and never the least.
            if error < best.1 {
                best = (next, error);
            }
            row.push(next);
        }
        above = row;
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_found_at_any_scale() {
        for scale in [1.0, 1e-3, 1e-6, 1e3] {
            let f = |h: f64| {
                let x = h / scale;
                Ok(DVector::from_vec(vec![
                    (x + 0.3).sin(),
                    x.tanh(),
                    3.0,
                    2.0 * x - x * x,
                ]))
            };
            let d = derivative(f).expect("smooth").0 * scale;
            let exact = [0.3f64.cos(), 1.0, 0.0, 2.0];
            for (d, exact) in d.iter().zip(exact) {
                // Rounding over the step that is left to a function of this scale.
                assert!((d - exact).abs() < 1e-9, "{scale}: {d} {exact}");
            }
        }
    }

    #[test]
    fn a_function_without_a_derivative_or_beyond_its_range_is_refused() {
        let jump = |h: f64| Ok(DVector::from_vec(vec![h.signum() + h]));
        assert!(matches!(derivative(jump), Err(Error::NoConvergence { .. })));
        let narrow = |h: f64| Ok(DVector::from_vec(vec![(1e-4 - h * h).sqrt() + h]));
        let (d, _) = derivative(narrow).expect("it has values below 1e-2");
        assert!((d[0] - 1.0).abs() < 1e-9);
    }
}
