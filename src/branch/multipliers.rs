//! The Floquet multipliers of an orbit of a branch.

use crate::error::Result;
use crate::orbit::PeriodicOrbit;
use crate::tolerance::{MARGINAL, MEETING};
use nalgebra::Complex;

/// Whether an orbit has no forcing.
pub(super) fn is_free(orbit: &PeriodicOrbit) -> bool {
    orbit.scene().frequency().is_none()
}

/// The multipliers of an orbit, without forcing except that of a shift in time, which is 1; `None` where the return map has no derivative.
pub(super) fn own_multipliers(orbit: &PeriodicOrbit) -> Result<Option<Vec<Complex<f64>>>> {
    let Some(order) = orbit.stability()?.orders.first() else {
        return Ok(None);
    };
    let mut own: Vec<Complex<f64>> = order.multipliers.iter().copied().collect();
    if is_free(orbit) {
        without_one(&mut own);
    }
    Ok(Some(own))
}

/// Leaves out the multiplier that is nearest to 1.
pub(super) fn without_one(own: &mut Vec<Complex<f64>>) {
    let off = |mu: &Complex<f64>| (mu - 1.0).norm();
    let nearest = (0..own.len()).min_by(|&i, &j| off(&own[i]).total_cmp(&off(&own[j])));
    nearest.map(|i| own.remove(i));
}

/// How many multipliers lie outside the unit circle, by more than rounding. If the motion keeps its energy another one is 1, and those on
/// the circle meet in pairs: a larger margin holds.
pub(super) fn n_outside(orbit: &PeriodicOrbit, keeps_energy: bool) -> Result<Option<usize>> {
    let mut own = own_multipliers(orbit)?;
    if keeps_energy {
        own.iter_mut().for_each(without_one);
    }
    let margin = if keeps_energy { MEETING } else { MARGINAL };
    Ok(own.map(|own| n_beyond_circle(&own, margin)))
}

/// How many of some multipliers lie outside the unit circle by more than a margin.
pub(super) fn n_beyond_circle(all: &[Complex<f64>], margin: f64) -> usize {
    all.iter().filter(|mu| mu.norm() > 1.0 + margin).count()
}

/// How far the conjugate pair nearest to the unit circle is from it, one where there is none; and how many multipliers lie outside, without
/// a margin, as the pair is on the circle at a torus itself.
pub(super) fn off_circle(orbit: &PeriodicOrbit) -> Result<(f64, Option<usize>)> {
    let own = own_multipliers(orbit)?.unwrap_or_default();
    let size = pair_at_circle(&own).map_or(1.0, |mu| mu.norm().ln().abs());
    Ok((size, Some(own.iter().filter(|mu| mu.norm() > 1.0).count())))
}

/// The multiplier on the upper half plane of the conjugate pair nearest to the unit circle.
pub(super) fn pair_at_circle(own: &[Complex<f64>]) -> Option<Complex<f64>> {
    let off = |mu: &Complex<f64>| mu.norm().ln().abs();
    let pairs = own.iter().copied().filter(|mu| mu.im > 0.0);
    pairs.min_by(|a, b| off(a).total_cmp(&off(b)))
}

/// Two multipliers that are conjugate, or real and of one sign.
#[derive(Debug, Clone, Copy)]
pub(super) struct MultiplierPair {
    pub sum: f64,
    pub product: f64,
}

/// The pair whose product is nearest to 1. Its sum and product are smooth where its multipliers meet on the real axis.
pub(super) fn pair_of_product_one(own: &[Complex<f64>]) -> Option<MultiplierPair> {
    let conjugate = own
        .iter()
        .filter(|mu| mu.im > 0.0)
        .map(|mu| MultiplierPair {
            sum: 2.0 * mu.re,
            product: mu.norm_sqr(),
        });
    let real: Vec<f64> = own
        .iter()
        .filter(|mu| mu.im == 0.0)
        .map(|mu| mu.re)
        .collect();
    let of_two = real.iter().enumerate().flat_map(|(i, a)| {
        let others = real[..i].iter().filter(move |b| *a * **b > 0.0);
        others.map(move |b| MultiplierPair {
            sum: a + b,
            product: a * b,
        })
    });
    let off = |pair: &MultiplierPair| pair.product.ln().abs();
    conjugate
        .chain(of_two)
        .min_by(|a, b| off(a).total_cmp(&off(b)))
}
