//! What will run for a scene, in words: the same choice that the machinery makes by type.

use crate::error::Result;
use crate::flow::ModalScene;
use crate::modal::Form;
use crate::model::Scene;
use crate::simulate::SimulateOptions;
use crate::simulate::stepping::{has_series, series_order};

/// The machinery that a scene needs, in words.
///
/// # Errors
/// `Error::NoConvergence` if an eigenvalue iteration of a linear scene fails.
pub fn plan(scene: &Scene) -> Result<String> {
    let Ok(_) = scene.linear_system("plan") else {
        let forcing = match scene.forcing().frequency() {
            Some(_) => "harmonic forcing",
            None => "no forcing",
        };
        let (steps, course) = if has_series(scene) {
            let order = series_order(SimulateOptions::default().rtol);
            let steps = format!(
                "Taylor series whose order grows with the digits asked for, {order} by default"
            );
            (steps, "the series")
        } else {
            let steps = "Runge-Kutta steps of orders 5 and 4".to_owned();
            (steps, "the interpolant")
        };
        let stops = match scene.stops().len() {
            0 => "no stops: no event search".to_owned(),
            1 => format!("1 stop: every contact on {course} found"),
            k => format!("{k} stops: every contact on {course} found"),
        };
        return Ok(format!(
            "nonlinear scene: {steps}, no modes; {forcing}; {stops}"
        ));
    };
    let modal = ModalScene::new(scene, "plan")?;
    let flights = match &modal.form.form {
        Form::Blocks(_) if modal.form.shapes().is_some() => "closed-form flights in real modes",
        Form::Blocks(_) => "closed-form flights in complex modes (the damping is not proportional)",
        Form::Dense(_) => {
            "closed-form flights by the matrix exponential (the state matrix is defective)"
        }
    };
    let forcing = if modal.frequency > 0.0 {
        "harmonic forcing"
    } else {
        "no forcing: free response"
    };
    let stops = match modal.n_stops() {
        0 => "no stops: one flight to the end, no event search".to_owned(),
        1 => "1 stop: every next impact proved to be the first".to_owned(),
        k => format!("{k} stops: every next impact proved to be the first"),
    };
    Ok(format!("{flights}; {forcing}; {stops}"))
}
