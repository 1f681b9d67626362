//! Integrals along an arc by Gauss's rule of six points, on stretches so short that the fastest motion there that has not died out
//! turns by half a radian at the most.

use crate::error::{Error, Result};
use crate::path::fading::Rates;
use crate::tolerance::QUADRATURE_STRETCH;

/// Nodes and weights of Gauss's rule of six points on [0, 1].
const GAUSS: [(f64, f64); 6] = [
    (0.033_765_242_898_423_975, 0.085_662_246_189_585_18),
    (0.169_395_306_766_867_76, 0.180_380_786_524_069_3),
    (0.380_690_406_958_401_5, 0.233_956_967_286_345_5),
    (0.619_309_593_041_598_5, 0.233_956_967_286_345_5),
    (0.830_604_693_233_132_2, 0.180_380_786_524_069_3),
    (0.966_234_757_101_576, 0.085_662_246_189_585_18),
];
/// The most stretches of a part of a flight: years of work. [work]
const MOST_QUADRATURE_STRETCHES: f64 = 1e12;

/// A node of the rule: where along the arc, what a value there counts, the length of its stretch.
#[derive(Debug, Clone, Copy)]
pub(super) struct QuadratureNode {
    pub at: f64,
    pub weight: f64,
    pub stretch: f64,
}

/// Visits the nodes of the rule on a part of an arc whose fastest rates are known.
pub(super) fn each_node(
    rates: &Rates,
    (from, to): (f64, f64),
    mut visit: impl FnMut(QuadratureNode) -> Result<()>,
) -> Result<()> {
    let mut start = from;
    while start < to {
        let (rate, until) = rates.at(start);
        let end = until.min(to);
        let count = ((end - start) * rate / QUADRATURE_STRETCH).ceil().max(1.0);
        let may_be_counted = count <= MOST_QUADRATURE_STRETCHES;
        if !may_be_counted {
            return Err(Error::NoConvergence {
                stage: "the quadrature of a flight, in which the fastest motion turns too often",
                iterations: MOST_QUADRATURE_STRETCHES as usize,
                residual: count,
            });
        }
        let stretch = (end - start) / count;
        for k in 0..count as usize {
            for (node, weight) in GAUSS {
                visit(QuadratureNode {
                    at: start + stretch * (k as f64 + node),
                    weight: weight * stretch,
                    stretch,
                })?;
            }
        }
        start = end;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rule_integrates_polynomials_of_degree_eleven() {
        let mut sums = [0.0; 12];
        let (from, to) = (0.3, 1.1);
        let visited = each_node(&Rates::default(), (from, to), |node| {
            for (k, sum) in sums.iter_mut().enumerate() {
                *sum += node.weight * node.at.powi(i32::try_from(k).expect("small"));
            }
            Ok(())
        });
        visited.expect("nothing fails");
        for (k, sum) in (1..).zip(sums) {
            let exact = (f64::powi(to, k) - f64::powi(from, k)) / f64::from(k);
            assert!((sum - exact).abs() < 1e-15, "{k}");
        }
    }
}
