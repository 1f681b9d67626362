//! The multipliers of an orbit of a branch.

use crate::error::Result;
use crate::orbit::PeriodicOrbit;
use crate::tolerance::MARGINAL;
use nalgebra::Complex;

pub(super) fn is_free(orbit: &PeriodicOrbit) -> bool {
    orbit.scene().frequency().is_none()
}

/// The multipliers of an orbit but, without forcing, the one of a shift in time, which is 1; `None` where it has none.
pub(super) fn own_multipliers(orbit: &PeriodicOrbit) -> Result<Option<Vec<Complex<f64>>>> {
    let Some(order) = orbit.stability()?.orders.first() else {
        return Ok(None);
    };
    let mut own: Vec<Complex<f64>> = order.multipliers.iter().copied().collect();
    if is_free(orbit) {
        let off = |mu: &Complex<f64>| (mu - 1.0).norm();
        let nearest = (0..own.len()).min_by(|&i, &j| off(&own[i]).total_cmp(&off(&own[j])));
        nearest.map(|i| own.remove(i));
    }
    Ok(Some(own))
}

/// How many of them lie outside the unit circle, by more than rounding.
pub(super) fn n_outside(orbit: &PeriodicOrbit) -> Result<Option<usize>> {
    let own = own_multipliers(orbit)?;
    Ok(own.map(|own| own.iter().filter(|mu| mu.norm() > 1.0 + MARGINAL).count()))
}

/// The pair of conjugate multipliers that is nearest to the unit circle, one of it.
pub(super) fn pair_at_circle(own: &[Complex<f64>]) -> Option<Complex<f64>> {
    let off = |mu: &Complex<f64>| mu.norm().ln().abs();
    let pairs = own.iter().copied().filter(|mu| mu.im > 0.0);
    pairs.min_by(|a, b| off(a).total_cmp(&off(b)))
}
