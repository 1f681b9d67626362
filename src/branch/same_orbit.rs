//! Whether two orbits of one scene are one motion.

use crate::attractor::orbit_points;
use crate::orbit::PeriodicOrbit;
use crate::path::ImpactSide;
use crate::recurrence::{Measure, are_one_cycle};
use crate::section::farthest_from;
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// Whether two orbits are one motion, whichever of its impacts each begins with: by their states at the phase of the forcing that is farthest
/// from the impacts of both, once in each period of it; without forcing by the states after their impacts.
pub(crate) fn are_one_orbit(one: &PeriodicOrbit, other: &PeriodicOrbit) -> bool {
    let both = [one, other];
    if one.n_periods() != other.n_periods() || one.impacts().len() != other.impacts().len() {
        return false;
    }
    let scene = one.scene();
    let frequency = scene.frequency().unwrap_or(TAU / one.period());
    let measure = Measure::new(&vec![0.0; scene.n_dof()], frequency);
    let phases = both.into_iter().flat_map(PeriodicOrbit::impacts);
    let quiet = farthest_from(phases.map(|impact| impact.phase).collect()).unwrap_or(0.0);
    let points = |own: &PeriodicOrbit| {
        if scene.frequency().is_some() {
            orbit_points(own.scene(), own, quiet)
        } else {
            after_impacts(own)
        }
    };
    are_one_cycle(&points(one), &points(other), &measure)
}

/// The states right after the impacts of an orbit, one a row; of one without impacts that at its start.
fn after_impacts(orbit: &PeriodicOrbit) -> DMatrix<f64> {
    let impacts = orbit.impacts().iter().map(|impact| impact.time);
    let times: Vec<f64> = if orbit.impacts().is_empty() {
        vec![0.0]
    } else {
        impacts.collect()
    };
    let n = orbit.scene().n_dof();
    let states: Vec<_> = times
        .iter()
        .map(|&t| orbit.state_at(t, ImpactSide::After))
        .collect();
    DMatrix::from_fn(times.len(), 2 * n, |k, j| {
        let (q, v) = &states[k];
        if j < n { q[j] } else { v[j - n] }
    })
}
