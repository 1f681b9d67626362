//! The phi functions of exponential integrators, `phi1(z) = (e^z - 1)/z` and its divided difference, without
//! cancellation anywhere in the complex plane.

use crate::tolerance::SINC_SERIES;
use nalgebra::Complex;

/// `sin(x)/x`, 1 at 0.
pub(crate) fn sinc(x: f64) -> f64 {
    if x.abs() < SINC_SERIES {
        1.0 - x * x / 6.0
    } else {
        x.sin() / x
    }
}

/// `1 - sin(x)/x` without cancellation.
pub(crate) fn one_minus_sinc(x: f64) -> f64 {
    let y = x * x;
    if y < 0.25 {
        // Alternating series; the first term left out is below 1e-18 relative.
        y / 6.0
            * (1.0
                - y / 20.0
                    * (1.0
                        - y / 42.0
                            * (1.0
                                - y / 72.0
                                    * (1.0 - y / 110.0 * (1.0 - y / 156.0 * (1.0 - y / 210.0))))))
    } else {
        1.0 - x.sin() / x
    }
}

/// `phi2(x) = (e^x - 1 - x)/x^2` for real x.
pub(crate) fn phi2(x: f64) -> f64 {
    if x.abs() < 0.5 {
        taylor_phi2(x)
    } else {
        (x.exp_m1() - x) / (x * x)
    }
}

fn taylor_phi2(x: f64) -> f64 {
    // sum x^k / (k + 2)!: what 15 terms leave out is below 1e-18 for |x| < 0.5
    (0..15)
        .rev()
        .fold(0.0, |sum, k| (1.0 + x * sum) / f64::from(k + 2))
}

/// `phi1(z) = (e^z - 1)/z`.
pub(crate) fn phi1(z: Complex<f64>) -> Complex<f64> {
    if z.norm_sqr() < 0.25 {
        (0..16).rev().fold(Complex::new(0.0, 0.0), |sum, k| {
            (z * sum + 1.0) / f64::from(k + 1)
        })
    } else {
        (z.exp() - 1.0) / z
    }
}

/// Divided difference `(phi1(z1) - phi1(z2))/(z1 - z2)`, its limit `phi1'` where they meet.
pub(crate) fn phi1_divided(z1: Complex<f64>, z2: Complex<f64>) -> Complex<f64> {
    let (middle, half) = ((z1 + z2) * 0.5, (z1 - z2) * 0.5);
    if half.norm_sqr() > 0.0625 {
        return (phi1(z1) - phi1(z2)) / (half * 2.0);
    }
    // sum over j of phi1^(2j+1)(middle) half^(2j) / (2j+1)!
    let square = half * half;
    let mut term = Complex::new(1.0, 0.0);
    let mut sum = Complex::new(0.0, 0.0);
    for derivative in phi1_odd_derivatives(middle) {
        sum += derivative * term;
        term *= square;
    }
    sum
}

/// Odd derivatives in a divided difference of phi1: with the arguments no more than 1/2 apart the next term is below rounding. [exact]
const ODD: usize = 7;

/// `phi1^(k)(z)/k!` for the odd k, `k = 2 j + 1`.
fn phi1_odd_derivatives(z: Complex<f64>) -> [Complex<f64>; ODD] {
    let mut out = [Complex::new(0.0, 0.0); ODD];
    if z.norm_sqr() < 1.0 {
        let size = z.norm();
        for (j, value) in out.iter_mut().enumerate() {
            *value = phi1_series(2 * j + 1, z, size);
        }
    } else {
        // z phi1 = e^z - 1: c_k = (e^z/k! - c_{k-1})/z for the Taylor coefficients c_k.
        let exponential = z.exp();
        let mut factorial = 1.0;
        let mut of_order = (exponential - 1.0) / z;
        for k in 1..2 * ODD {
            factorial *= k as f64;
            of_order = (exponential / factorial - of_order) / z;
            if k % 2 == 1 {
                out[k / 2] = of_order;
            }
        }
    }
    out
}

/// `phi1^(k)(z)/k!` for |z| < 1: `phi1(z) = sum z^m/(m+1)!` term by term, until no digit of either part changes any more.
fn phi1_series(k: usize, z: Complex<f64>, size: f64) -> Complex<f64> {
    let mut value = Complex::new(0.0, 0.0);
    let mut power = Complex::new(1.0, 0.0);
    let mut left = 1.0;
    let mut factor = 1.0 / (1..=k + 1).map(|i| i as f64).product::<f64>(); // binomial(m, k)/(m+1)! at m = k
    for m in k..k + 20 {
        value += power * factor;
        power *= z;
        left *= size;
        factor *= (m + 1) as f64 / ((m + 1 - k) as f64 * (m + 2) as f64);
        // The terms to come are together less than twice the next.
        let is_lost = |part: f64| 2.0 * left * factor < 0.25 * f64::EPSILON * part.abs();
        if is_lost(value.re) && (z.im == 0.0 || is_lost(value.im)) {
            break;
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: Complex<f64>, b: Complex<f64>, tolerance: f64) {
        assert!(
            (a - b).norm() <= tolerance * (1.0 + b.norm()),
            "{a} against {b}"
        );
    }

    #[test]
    fn phi1_and_phi2_join_where_the_formula_changes() {
        for angle in 0..12 {
            let direction = Complex::from_polar(1.0, f64::from(angle) * 0.5);
            close(
                phi1(direction * (0.5 - 1e-14)),
                phi1(direction * (0.5 + 1e-14)),
                1e-13,
            );
            let z = direction * 0.3;
            close(phi1(z) * z, z.exp() - 1.0, 1e-15);
        }
        for x in [-3.0, -0.5, -0.1, 1e-9, 0.2, 0.5, 2.0f64] {
            let series: f64 = (0..60)
                .map(|k| x.powi(k) / (1..=k + 2).map(f64::from).product::<f64>())
                .sum();
            assert!(
                (phi2(x) - series).abs() < 4e-16 * (1.0 + series),
                "{x}: {} {series}",
                phi2(x)
            );
        }
    }

    #[test]
    fn divided_difference_is_the_mean_of_the_derivative() {
        // int_0^1 phi1'(z2 + t (z1 - z2)) dt by Gauss-Legendre on 8 points of each of 8 panels.
        let nodes = [
            0.183_434_642_495_649_8,
            0.525_532_409_916_329,
            0.796_666_477_413_626_7,
            0.960_289_856_497_536_3,
        ];
        let weights = [
            0.362_683_783_378_362,
            0.313_706_645_877_887_3,
            0.222_381_034_453_374_5,
            0.101_228_536_290_376_3,
        ];
        let derivative = |z: Complex<f64>| {
            (0..60).rev().fold(Complex::new(0.0, 0.0), |sum, m: i32| {
                sum * z + f64::from(m + 1) / (1..=m + 2).map(f64::from).product::<f64>()
            })
        };
        for (z1, z2) in [
            (Complex::new(0.1, 0.2), Complex::new(0.1, -0.2)),
            (Complex::new(-2.0, 1.0), Complex::new(-2.0, 1.0 + 1e-9)),
            (Complex::new(-1.5, 0.3), Complex::new(-1.1, 0.2)),
            (Complex::new(0.0, 0.0), Complex::new(0.0, 0.0)),
            (Complex::new(-2.0, 3.0), Complex::new(0.1, -3.0)),
            (Complex::new(0.9, 0.1), Complex::new(1.2, 0.1)),
        ] {
            let mut mean = Complex::new(0.0, 0.0);
            for panel in 0..8 {
                for (x, w) in nodes.iter().zip(weights) {
                    for sign in [-1.0, 1.0] {
                        let t = (f64::from(panel) + 0.5 + 0.5 * sign * x) / 8.0;
                        mean += derivative(z2 + (z1 - z2) * t) * (w / 16.0);
                    }
                }
            }
            close(phi1_divided(z1, z2), mean, 2e-14);
        }
    }

    #[test]
    fn one_minus_sinc_keeps_its_digits() {
        for x in [1e-8, 1e-3, 0.1, 0.4999f64] {
            let series: f64 = (1..12)
                .map(|k: i32| -(-x * x).powi(k) / (1..=2 * k + 1).map(f64::from).product::<f64>())
                .sum();
            assert!((one_minus_sinc(x) / series - 1.0).abs() < 1e-15);
        }
        assert!((one_minus_sinc(2.0) - (1.0 - sinc(2.0))).abs() < 1e-16);
    }
}
