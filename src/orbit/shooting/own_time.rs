//! Equations that depend on time by themselves, beside a forcing (a `NonlinearSystem` whose function uses t): a search for orbits
//! shifts the phase of the forcing, and so the time of the equations; the motion can repeat only where these do.

use crate::error::{Error, Result};
use crate::model::{Change, NonlinearSystem, Scene, System};
use crate::tolerance::REPEATS;
use nalgebra::DVector;
use std::f64::consts::TAU;

/// Parts of a period, with no simple ratio, at which the equations are compared. [work]
const COMPARED_TIMES: [f64; 7] = [0.0, 0.113, 0.271, 0.377, 0.519, 0.683, 0.857];

fn acceleration(system: &NonlinearSystem, t: f64, state: &DVector<f64>) -> Result<Vec<f64>> {
    let (q, v) = state.as_slice().split_at(system.n_dof());
    let mut a = vec![0.0; q.len()];
    system.acceleration(t, q, v, &mut a)?;
    Ok(a)
}

/// The largest change of the acceleration between two times, and its size.
fn change(system: &NonlinearSystem, times: [f64; 2], state: &DVector<f64>) -> Result<[f64; 2]> {
    let [a, b] = times.map(|t| acceleration(system, t, state));
    let largest = |x: f64, y: f64| x.max(y);
    let (a, b) = (a?, b?);
    let changes = a.iter().zip(&b).map(|(a, b)| (a - b).abs());
    let sizes = a.iter().map(|a| a.abs());
    Ok([changes.fold(0.0, largest), sizes.fold(0.0, largest)])
}

/// Whether equations depend on time by themselves, as far as some states show it.
fn depends_on_time(system: &NonlinearSystem, span: f64, states: &[DVector<f64>]) -> Result<bool> {
    for state in states {
        for part in &COMPARED_TIMES[1..] {
            if change(system, [0.0, part * span], state)?[0] > 0.0 {
                return Ok(true);
            }
        }
    }
    Ok(false)
}

/// Whether the equations of a scene depend on time by themselves.
///
/// # Errors
/// Equations that do, without a forcing or with another period than its; what they report.
pub(crate) fn depends_on_own_time(scene: &Scene, states: &[DVector<f64>]) -> Result<bool> {
    let System::Nonlinear(system) = scene.system() else {
        return Ok(false);
    };
    let period = scene.period().unwrap_or(1.0);
    if !depends_on_time(system, period, states)? {
        return Ok(false);
    }
    let refused = |rule: String| {
        let value = "of equations that depend on time by themselves";
        Err(Error::bad_value("scene", value, rule))
    };
    if scene.frequency().is_none() {
        return refused(
            "without forcing there is no period that they could share; give the scene a harmonic force of theirs, its amplitude \
             zero if need be"
                .to_owned(),
        );
    }
    for state in states {
        for part in COMPARED_TIMES {
            let t = part * period;
            let [changed, size] = change(system, [t, t + period], state)?;
            if changed > REPEATS * size.max(changed.min(1.0)) {
                return refused(format!(
                    "they must repeat after the period of the forcing, {period}, but from t = {t} on the acceleration changes by \
                     {changed} in it"
                ));
            }
        }
    }
    Ok(true)
}

/// The scene from another phase of its forcing on: equations that depend on time are as much later.
pub(crate) fn with_phase(scene: &Scene, phase: f64, depends: bool) -> Result<Scene> {
    let Some(frequency) = scene.frequency() else {
        return Ok(scene.clone());
    };
    let moved = scene.replace(Change::FundamentalPhase(phase))?;
    match scene.system() {
        System::Nonlinear(system) if depends => {
            let turned = (phase - scene.phase()).rem_euclid(TAU);
            let offset = system.time_offset() + turned / frequency;
            let system = system.clone().with_time_offset(offset)?;
            moved.replace(Change::System(system.into()))
        }
        _ => Ok(moved),
    }
}
