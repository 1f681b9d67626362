//! Rayleigh damping `C = alpha M + beta K`, which gives a mode of frequency w the damping ratio `alpha/(2 w) + beta w/2` (theory 13).

use crate::error::{Error, Result};
use crate::model::linear::Coefficient;
use crate::quantity::{finite, positive};
use crate::tolerance::IMPACT_ROUNDING;

/// The coefficients `(alpha, beta)` \[1/s, s\] of Rayleigh damping from the damping ratios at two frequencies, pairs `(w, zeta)` with w in
/// rad/s. Between the two every mode has less damping, outside of them more.
///
/// # Errors
/// `Error::BadValue` for frequencies that are not above zero or are equal, for ratios below zero, and for ratios so unlike that a
/// coefficient would be negative: other modes would then grow.
///
/// # Examples
/// ```
/// use vibroimpact::rayleigh_coefficients;
///
/// let (alpha, beta) = rayleigh_coefficients([(10.0, 0.02), (100.0, 0.05)])?;
/// let ratio = |w: f64| alpha / (2.0 * w) + beta * w / 2.0;
/// assert!((ratio(10.0) - 0.02).abs() < 1e-15 && (ratio(100.0) - 0.05).abs() < 1e-15);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn rayleigh_coefficients(ratios: [(f64, f64); 2]) -> Result<(f64, f64)> {
    for (w, zeta) in ratios {
        positive("a frequency of ratios", w)?;
        not_negative(&format!("ratios[{w}]"), zeta)?;
    }
    let [(w1, z1), (w2, z2)] = ratios;
    if w1 == w2 {
        let rule = "two different frequencies are needed";
        return Err(Error::bad_value("both frequencies of ratios", w1, rule));
    }
    // Relative to the second frequency, so that no square leaves the doubles.
    let r = w1 / w2;
    let alpha = 2.0 * w1 * difference(z1, z2 * r) / ((1.0 - r) * (1.0 + r));
    let beta = 2.0 * difference(z2, z1 * r) / w2 / ((1.0 - r) * (1.0 + r));
    if alpha < 0.0 || beta < 0.0 {
        return Err(Error::bad_value(
            "ratios",
            format!("{{{w1}: {z1}, {w2}: {z2}}}"),
            "one of both ratios may be larger than the other by the ratio of the frequencies at the most: alpha or beta \
             would be negative, and modes at other frequencies would grow",
        ));
    }
    finite("alpha of ratios", alpha)?;
    finite("beta of ratios", beta)?;
    Ok((alpha, beta))
}

/// Rayleigh damping `C = alpha M + beta K`, by its coefficients or by the damping ratios at two frequencies.
/// Here by its coefficients ([`rayleigh_coefficients`] has them for two ratios); diagonal where both matrices are.
///
/// # Errors
/// `Error::BadValue` for coefficients that are below zero or not finite, `Error::BadShape` for matrices of different order.
///
/// # Examples
/// ```
/// use nalgebra::dvector;
/// use vibroimpact::{Coefficient, LinearSystem, rayleigh_damping};
///
/// let (mass, stiffness) = (Coefficient::from(dvector![1.0, 1.0]), Coefficient::from(dvector![4.0, 9.0]));
/// let damping = rayleigh_damping(&mass, &stiffness, 0.1, 0.01)?;
/// assert_eq!(damping, Coefficient::from(dvector![0.14, 0.19]));
/// let system = LinearSystem::new(mass, damping, stiffness)?;
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn rayleigh_damping(
    mass: &Coefficient,
    stiffness: &Coefficient,
    alpha: f64,
    beta: f64,
) -> Result<Coefficient> {
    not_negative("alpha", alpha)?;
    not_negative("beta", beta)?;
    let n = mass.order();
    mass.check("mass", n)?;
    stiffness.check("stiffness", n)?;
    Ok(match (mass, stiffness) {
        (Coefficient::Diagonal(m), Coefficient::Diagonal(k)) => (m * alpha + k * beta).into(),
        (m, k) => (m.to_dense() * alpha + k.to_dense() * beta).into(),
    })
}

/// `x - y`; nothing, where that is rounding: ratios of proportional damping leave no other coefficient.
fn difference(x: f64, y: f64) -> f64 {
    let left = x - y;
    if left.abs() <= IMPACT_ROUNDING * x {
        0.0
    } else {
        left
    }
}

fn not_negative(argument: &str, value: f64) -> Result<()> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    let rule = "it must be finite and not below zero";
    Err(Error::bad_value(argument, value, rule))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::LinearSystem;
    use nalgebra::{dmatrix, dvector};

    #[test]
    fn both_ratios_are_met_over_many_orders() {
        for (w1, w2) in [(1.0, 3.0), (3.0, 1.0), (1e-160, 1e-150), (1e150, 1e155)] {
            let (z1, z2) = (0.02, 0.03);
            let (alpha, beta) = rayleigh_coefficients([(w1, z1), (w2, z2)]).expect("valid");
            for (w, zeta) in [(w1, z1), (w2, z2)] {
                let ratio = 0.5 * (alpha / w + beta * w);
                assert!((ratio / zeta - 1.0).abs() < 1e-14, "{w}: {ratio}");
            }
        }
    }

    #[test]
    fn ratios_of_proportional_damping_have_one_coefficient() {
        let coefficients = |ratios| rayleigh_coefficients(ratios).expect("valid");
        let (alpha, beta) = coefficients([(3.0, 0.03), (10.0, 0.1)]);
        assert!(alpha == 0.0 && (beta - 0.02).abs() < 1e-16);
        let (alpha, beta) = coefficients([(10.0, 0.03), (3.0, 0.1)]);
        assert!(beta == 0.0 && (alpha - 0.6).abs() < 1e-15);
    }

    #[test]
    fn the_damping_is_a_sum_of_the_matrices() {
        let (m, k) = (dmatrix![2.0, 0.5; 0.5, 1.0], dvector![3.0, 4.0]);
        let damping = rayleigh_damping(&m.into(), &k.into(), 0.5, 0.25).expect("valid");
        let expected = dmatrix![1.75, 0.25; 0.25, 1.5];
        assert_eq!(damping, expected.clone().into());
        let system = LinearSystem::new(dmatrix![2.0, 0.5; 0.5, 1.0], damping, dvector![3.0, 4.0]);
        assert_eq!(system.expect("valid").damping().to_dense(), expected);
    }

    #[test]
    fn bad_coefficients_and_ratios_are_refused_by_name() {
        let message = |ratios| rayleigh_coefficients(ratios).unwrap_err().to_string();
        assert!(message([(0.0, 0.1), (1.0, 0.1)]).starts_with("a frequency of ratios is 0"));
        assert!(message([(2.0, 0.1), (2.0, 0.1)]).starts_with("both frequencies of ratios"));
        assert!(message([(1.0, -0.1), (2.0, 0.1)]).starts_with("ratios[1] is -0.1"));
        assert!(message([(1.0, f64::NAN), (2.0, 0.1)]).starts_with("ratios[1] is NaN"));
        assert!(message([(1.0, 0.01), (2.0, 0.1)]).starts_with("ratios is {1: 0.01, 2: 0.1}"));
        let one = || Coefficient::from(dvector![1.0]);
        for (alpha, beta) in [(-1.0, 0.0), (0.0, f64::NAN)] {
            assert!(rayleigh_damping(&one(), &one(), alpha, beta).is_err());
        }
        let two = Coefficient::from(dvector![1.0, 2.0]);
        let message = rayleigh_damping(&one(), &two, 1.0, 1.0)
            .unwrap_err()
            .to_string();
        assert!(message.starts_with("stiffness has shape (2,)"), "{message}");
    }
}
