//! The border of a chatter from the side of finitely many impacts: the limit of a sequence of grazes (theory 19, "Chatter border").

use crate::branch::border::CriticalBounces;
use crate::branch::continuation_parameter::ContinuationParameter;
use crate::branch::continued::continuation_of;
use crate::branch::options::ContinuationOptions;
use crate::branch::problem::{BranchProblem, span_of};
use crate::branch::special::{Special, SpecialKind};
use crate::branch::switching::born_at;
use crate::continuation::EndReason;
use crate::error::{Error, Result};
use crate::model::Scene;
use crate::tolerance::{ACCUMULATING_GRAZE_GAP, ACCUMULATION_FACTOR_MATCH, NEAREST_GRAZES};

/// Branches that are followed one after another from graze to graze, at the most. `[work]`
const MOST_BORN_BRANCHES: usize = 40;
/// Grazes from which on there is a limit with an error: an extrapolation takes three values, and the second one is to give two. `[exact]`
const LEAST_GRAZES: usize = 6;

/// The border of a chatter as the limit of a sequence of grazes that begins with this one: at each graze one more impact is born, after
/// others that become ever slower. None where the grazes do not accumulate. From the graze to the branch that is born there, to its graze,
/// and so on, up to 40 times; the border is extrapolated, and its error is by how much the last steps of that change the limit.
///
/// `over` and `between` are what the branch goes over, and its range, as in [`branches`](crate::branches). The orbit is the last one that touches; the arclength
/// is not a number, as the border is on none of the branches.
///
/// # Errors
/// A special point that is no graze; as [`continuation`](fn@crate::continuation); [`Error::Interrupted`].
///
/// # References
/// Theory section 19, "Chatter border"; C. J. Budd and F. Dux, Phil. Trans. R. Soc. A 347 (1994) 365.
///
/// # Examples
/// ```
/// use vibroimpact::{ContinuationOptions, Heading, Parameter, accumulation, continuation, find_orbit, simulate};
/// use vibroimpact::nalgebra::{dmatrix, dvector};
/// use vibroimpact::{Harmonic, LinearSystem, Scene, SimulateOptions, Stop};
/// let system = LinearSystem::new(dvector![1.0], dmatrix![0.0], dmatrix![1.0])?;
/// let force = Harmonic::new(dvector![1.0.into()], 0.5, 0.0)?;
/// let scene = Scene::new(system, force, [Stop::new(0, 0.25, 0.5)?])?;
/// let until = 40.0 * scene.period().expect("forced");
/// let run = simulate(&scene, &dvector![-0.5], &dvector![0.0], (0.0, until), &SimulateOptions::default())?;
/// let orbit = find_orbit(&scene, &run, None)?;
/// let (parameter, range) = (Parameter::CLEARANCE, (0.0, 0.5));
/// let down = ContinuationOptions { heading: Heading::Down, ..Default::default() };
/// let branch = continuation(&orbit, parameter, range, &down)?;
/// let graze = &branch.special[0];
/// let border = accumulation(graze, parameter, range)?.expect("they accumulate");
/// assert!(border.parameter < graze.parameter && border.error < 1e-6);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn accumulation<'a>(
    special: &Special,
    over: impl Into<ContinuationParameter<'a>>,
    between: (f64, f64),
) -> Result<Option<Special>> {
    let over = over.into();
    // Elastic impacts do not accumulate.
    if let ContinuationParameter::Energy = over {
        return Ok(None);
    }
    let make = &|value: f64| over.scene(&special.orbit, special.parameter, value);
    let (SpecialKind::Graze, Some(stop)) = (special.kind, special.stop) else {
        let rule = "it must be a graze, behind which an impact more is born";
        return Err(Error::bad_value("special", special.kind.name(), rule));
    };
    // Compliant stops have no chatter to which grazes could lead.
    if !special.orbit.scene().stops()[stop].contact().is_rigid() {
        return Ok(None);
    }
    let mut last = special.clone();
    let mut values = vec![special.parameter];
    while values.len() <= MOST_BORN_BRANCHES {
        let Some(next) = next_graze(&last, make, between)? else {
            break;
        };
        let step = next.parameter - last.parameter;
        let is_back = values.len() > 1 && step * (last.parameter - values[values.len() - 2]) <= 0.0;
        if next.stop != Some(stop) || is_back || !touches(&next)? {
            break;
        }
        values.push(next.parameter);
        last = next;
        if step.abs() <= NEAREST_GRAZES * span_of(between) {
            break;
        }
    }
    let restitution = last.orbit.scene().stops()[stop].restitution();
    let limit = limit(&values, CriticalBounces::of(restitution).growth);
    Ok(limit.map(|(parameter, error)| Special {
        kind: SpecialKind::ChatterBorder,
        parameter,
        error,
        arclength: f64::NAN,
        ..last
    }))
}

/// Whether a stop is touched to rounding at a graze; where bounces are lower than the rules of contact see, it is passed unnoticed.
fn touches(special: &Special) -> Result<bool> {
    let size = special.orbit.max_displacement()?.into_iter();
    let unseen = ACCUMULATING_GRAZE_GAP * size.fold(0.0, f64::max);
    let mut all = special.orbit.touches().iter();
    Ok(all.any(|own| Some(own.stop) == special.stop && own.gap.abs() <= unseen))
}

/// The graze at the other end of the branch with one impact more that begins at a graze.
fn next_graze(
    special: &Special,
    make: &dyn Fn(f64) -> Result<Scene>,
    between: (f64, f64),
) -> Result<Option<Special>> {
    let Some(touch) = special.stop.zip(special.time) else {
        return Ok(None);
    };
    let (problem, place) = BranchProblem::around(&special.orbit, make, special.parameter, between)?;
    let Some(born) = born_at(&problem, &place, touch)?.pop() else {
        return Ok(None);
    };
    let options = ContinuationOptions::default();
    let branch = continuation_of(&born.orbit, make, born.parameter, between, &options)?;
    if branch
        .ends
        .iter()
        .any(|end| end.reason == EndReason::Interrupted)
    {
        return Err(Error::Interrupted);
    }
    let mut grazes = branch.special.into_iter();
    Ok(grazes.find(|own| own.kind == SpecialKind::Graze))
}

/// The limit of values whose differences shrink by a factor that tends to a given one, and its error: Aitken's extrapolation, done twice,
/// up to the value at which the second one and the last two values change the limit least. None for too few values, or other factors.
fn limit(values: &[f64], factor: f64) -> Option<(f64, f64)> {
    let is_like = |x: &[f64]| {
        let ratio = (x[1] - x[0]) / (x[2] - x[1]);
        (ratio - factor).abs() < ACCUMULATION_FACTOR_MATCH * (factor - 1.0)
    };
    let once = extrapolated(values);
    let twice = extrapolated(&once);
    let each = (LEAST_GRAZES..=values.len()).filter(|&count| is_like(&values[count - 3..count]));
    let each = each.map(|count| {
        let (own, last) = (twice[count - 5], twice[count - 6]);
        let changes = [own - once[count - 3], own - last, last - once[count - 4]];
        (
            own,
            changes.iter().fold(0.0, |most: f64, x| most.max(x.abs())),
        )
    });
    each.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Aitken's extrapolation: the limits that each three successive values would have if their differences were a geometric sequence.
fn extrapolated(values: &[f64]) -> Vec<f64> {
    let each = values.windows(3).map(|x| {
        let (one, two) = (x[1] - x[0], x[2] - x[1]);
        x[2] - two * two / (two - one)
    });
    each.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_is_that_of_values_that_come_nearer_by_the_factor() {
        // What is left after k steps: 0.8^-k, and less of 0.64^k as it goes on.
        let value = |k: i32| 0.3 + 0.01 * 0.8f64.powi(k) - 0.004 * 0.64f64.powi(k);
        let values: Vec<f64> = (0..30).map(value).collect();
        let (found, error) = limit(&values, 1.25).expect("a limit");
        assert!((found - 0.3).abs() <= error && error < 1e-7, "{error:e}");
        assert!(limit(&values[..5], 1.25).is_none());
        assert!(limit(&values, 2.0).is_none());
        // Evenly spaced, and of elastic impacts.
        let even: Vec<f64> = (0..10).map(f64::from).collect();
        assert!(limit(&even, 1.25).is_none() && limit(&even, 1.0).is_none());
    }

    #[test]
    fn rounding_of_the_last_values_is_left_out() {
        let value = |k: i32| 0.3 + 0.01 * 0.5f64.powi(k) + if k > 18 { 1e-9 } else { 0.0 };
        let values: Vec<f64> = (0..24).map(value).collect();
        let (found, error) = limit(&values, 2.0).expect("a limit");
        assert!(
            (found - 0.3).abs() <= 1e-10 && error < 1e-10,
            "{found} {error:e}"
        );
    }
}
