//! The value that a number of a scene has.

use crate::error::{Error, Result};
use crate::model::change::Parameter;
use crate::model::constraint::Constraint;
use crate::model::scene::Scene;

/// The value of a number of a scene: of factors one, not a number where the scene has none.
///
/// # Errors
/// A number that its stops do not share; `argument` is what asks for it.
pub(crate) fn value_of(scene: &Scene, parameter: Parameter, argument: &str) -> Result<f64> {
    let stops = scene.stops();
    let shared = |of: fn(&Constraint) -> f64| {
        let values: Vec<f64> = stops.iter().map(of).collect();
        if values.windows(2).all(|pair| pair[0] == pair[1]) {
            return Ok(values.first().copied().unwrap_or(f64::NAN));
        }
        let rule = format!("the stops differ, {values:?}: name one, \"{parameter}[0]\"");
        Err(Error::bad_value(argument, "for every stop", rule))
    };
    Ok(match parameter {
        Parameter::Frequency => scene.lowest_frequency().unwrap_or(f64::NAN),
        Parameter::Phase => scene.first_angle().map_or(f64::NAN, |(_, phase)| phase),
        Parameter::ForcingScale | Parameter::DampingScale => 1.0,
        Parameter::Clearance => shared(Constraint::clearance)?,
        Parameter::Restitution => shared(Constraint::restitution)?,
        Parameter::ClearanceOf(i) => stops.get(i).map_or(f64::NAN, Constraint::clearance),
        Parameter::RestitutionOf(i) => stops.get(i).map_or(f64::NAN, Constraint::restitution),
    })
}

/// The value of a number of a scene that changes its motion.
///
/// # Errors
/// The phase, which shifts time alone; a number that the scene does not have, or that its stops do not share.
pub(crate) fn start_of(scene: &Scene, parameter: Parameter, argument: &str) -> Result<f64> {
    let refused = |rule: &str| Error::bad_value(argument, format!("\"{parameter}\""), rule);
    if parameter == Parameter::Phase {
        let rule = "it must be a number that changes the motion: the phase shifts time alone";
        return Err(refused(rule));
    }
    let value = value_of(scene, parameter, argument)?;
    if value.is_finite() {
        Ok(value)
    } else {
        Err(refused(
            "it must be a number that the scene of the orbit has",
        ))
    }
}

/// The scene in which a number has a value, if it may have that.
pub(crate) fn with_value(scene: &Scene, parameter: Parameter, value: f64) -> Result<Scene> {
    parameter.check(value)?;
    scene.replace(parameter.change(value))
}
