//! The points of attractors at a phase of the forcing far from their impacts. At a phase near an impact, one of two neighbouring motions
//! may have had it and the other not, so that their states differ by the jump of the velocity. Points are rows (q, v) in units of the
//! scene, phases are in \[rad\].

use crate::attractor::record::Attractor;
use crate::error::{Error, Result};
use crate::model::{PhysicalState, Scene};
use crate::orbit::PeriodicOrbit;
use crate::section::{farthest_from, wait};
use crate::simulate::{ImpactSide, Keep, Motion, SimulateOptions, Status, Trajectory, simulate};
use nalgebra::DMatrix;

/// The phase farthest from the impacts of all orbits \[rad\]; `usual` where there are none.
pub(crate) fn quiet_phase<'a>(
    attractors: impl IntoIterator<Item = &'a Attractor>,
    usual: f64,
) -> f64 {
    let orbits = attractors.into_iter().filter_map(|one| one.orbit.as_ref());
    farthest_from(orbits.flat_map(phases).collect()).unwrap_or(usual)
}

/// The phases of an orbit's impacts.
fn phases(orbit: &PeriodicOrbit) -> impl Iterator<Item = f64> {
    orbit.impacts().iter().map(|impact| impact.phase)
}

/// The points of an orbit at the phase farthest from its impacts, and that phase.
pub(super) fn quiet_points(
    scene: &Scene,
    orbit: &PeriodicOrbit,
    usual: f64,
) -> (DMatrix<f64>, f64) {
    let quiet = farthest_from(phases(orbit).collect()).unwrap_or(usual);
    (orbit_points(scene, orbit, quiet), quiet)
}

/// The points of an orbit at a phase.
pub(crate) fn orbit_points(scene: &Scene, orbit: &PeriodicOrbit, phase: f64) -> DMatrix<f64> {
    let period = scene.period().unwrap_or_default();
    let late = wait(period, orbit.phase(), phase);
    let state = |k: usize| {
        let t = late + k as f64 * period;
        orbit.state_at(t.rem_euclid(orbit.period()), ImpactSide::After)
    };
    rows(&(0..orbit.n_periods()).map(state).collect::<Vec<_>>())
}

/// The points at the phase `to` of an attractor whose points are at the phase `from`.
pub(crate) fn points_at(
    scene: &Scene,
    one: &Attractor,
    (from, to): (f64, f64),
    options: &SimulateOptions,
) -> Result<DMatrix<f64>> {
    if let Some(orbit) = &one.orbit {
        return Ok(orbit_points(scene, orbit, to));
    }
    let (n, period) = (scene.n_dof(), scene.period().unwrap_or_default());
    let start = wait(period, scene.phase(), from);
    let span = (start, start + wait(period, from, to));
    let keep = SimulateOptions {
        keep: Keep::Final,
        ..options.clone()
    };
    let row = |k: usize| {
        let part = |first: usize| one.points.row(k).columns(first, n).transpose();
        (part(0), part(n))
    };
    if scene.periods_to_forget() > 0 && span.1 > span.0 {
        // Where its stops were at each point is not known: the points of a motion over the same set, or over the same cycle.
        let found = strobed(scene, &row(0), (span.0, span.1, one.points.nrows()), &keep)?;
        return found.ok_or_else(|| {
            let rule =
                "a motion from its first point must go on for as many periods as it has points";
            Error::bad_value("attractor", "one whose motion ends", rule)
        });
    }
    let state = |k: usize| -> Result<PhysicalState> {
        let (q, v) = row(k);
        let run = simulate(scene, &q, &v, span, &keep)?;
        Ok((run.last().0.clone(), run.last().1.clone()))
    };
    let states = (0..one.points.nrows()).map(state);
    Ok(rows(&states.collect::<Result<Vec<_>>>()?))
}

/// So many states, one in each period of the forcing, of a motion that begins in a state at a time: from another time on, and later where it has to
/// forget where stops were. None where it ends before.
pub(super) fn strobed(
    scene: &Scene,
    (q, v): &PhysicalState,
    (start, first, count): (f64, f64, usize),
    options: &SimulateOptions,
) -> Result<Option<DMatrix<f64>>> {
    let period = scene.period().unwrap_or_default();
    let lost = scene.periods_to_forget();
    let times = (lost..lost + count).map(|k| first + period * k as f64);
    let sampled = SimulateOptions {
        t_eval: Some(times.collect()),
        ..options.clone()
    };
    let span = (start, first + period * (lost + count - 1) as f64);
    let run = simulate(scene, q, v, span, &sampled)?;
    if run.status() != Status::Finished {
        return Ok(None);
    }
    sampled_states(&run).map(Some)
}

/// The states of a run at the times that were asked for, as rows.
pub(super) fn sampled_states(run: &Trajectory) -> Result<DMatrix<f64>> {
    let (_, q, v) = run.samples()?;
    let n = q.ncols();
    Ok(DMatrix::from_fn(q.nrows(), 2 * n, |k, j| {
        if j < n { q[(k, j)] } else { v[(k, j - n)] }
    }))
}

/// States as rows.
fn rows(states: &[PhysicalState]) -> DMatrix<f64> {
    let n = states.first().map_or(0, |(q, _)| q.len());
    DMatrix::from_fn(states.len(), 2 * n, |k, j| {
        let (q, v) = &states[k];
        if j < n { q[j] } else { v[j - n] }
    })
}
