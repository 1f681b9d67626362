//! The method that a run of a scene will use, in words: the same choice that is made by type elsewhere.

use crate::error::{Result, digits};
use crate::flow::{ModalScene, SceneFlow};
use crate::hybrid::{has_series, series_order};
use crate::modal::Form;
use crate::model::{
    Constraint, ContactGeometry, Parameter, Ramp, RampProfile, Rotations, Scene, StopNumber,
    overlaps,
};
use crate::simulate::solver::Solver;

/// The machinery that a scene needs, in words, and which stops leave no position between them.
///
/// # Errors
/// `Error::NoConvergence` if an eigenvalue iteration of a linear scene fails.
pub fn plan(scene: &Scene) -> Result<String> {
    let mut plan = machinery(scene)?;
    for (i, j, depth) in overlaps(scene) {
        let depth = digits(depth);
        plan.push_str(&format!(
            "; no position is admissible: stops {i} and {j} overlap by {depth}"
        ));
    }
    Ok(plan)
}

/// [`plan`], and how a run follows ramps.
///
/// # Errors
/// As [`plan`].
pub fn plan_under(scene: &Scene, ramps: &[Ramp]) -> Result<String> {
    let mut plan = plan(scene)?;
    let by = if scene.linear_system("plan").is_ok() {
        " (method \"taylor\")"
    } else {
        ""
    };
    for ramp in ramps {
        let parameter = ramp.parameter();
        let how = match (ramp.profile(), parameter.stop_number()) {
            (RampProfile::Steps { .. }, _) => "a scene of its own at each level".to_owned(),
            (_, Some(StopNumber::Clearance)) => "a moving stop".to_owned(),
            (_, Some(_)) => "that of the instant".to_owned(),
            _ if parameter == Parameter::DampingScale => {
                "steps, with that of the instant".to_owned()
            }
            _ => format!("what acts in polynomials of degree 8, to 1e-14{by}"),
        };
        plan.push_str(&format!("; ramp of \"{}\": {how}", ramp.parameter()));
    }
    Ok(plan)
}

fn machinery(scene: &Scene) -> Result<String> {
    let Ok(_) = scene.linear_system("plan") else {
        let excitation = scene.excitation();
        let forcing = acting(&excitation.rotations, excitation.signals.len());
        let (steps, path) = if has_series(scene) {
            let order = series_order(Solver::default().rtol);
            let steps = format!(
                "Taylor series whose order grows with the digits asked for, {order} by default"
            );
            (steps, "the series")
        } else {
            let steps =
                "Runge-Kutta steps of order 8, implicit ones of order 5 where the motion is stiff"
                    .to_owned();
            (steps, "the interpolant")
        };
        let stops = contacts_along(scene, path);
        let laws = integrated_laws(scene);
        return Ok(format!(
            "nonlinear scene: {steps}, no modes; {forcing}; {stops}{laws}"
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
    let treated = match *modal.flow() {
        _ if modal.rotations.is_empty() && modal.signals.is_empty() => ": free response",
        SceneFlow::Split(_) => ": its steady response split off",
        SceneFlow::Dense(_) => " in the matrix, enlarged",
        _ if !modal.signals.is_empty() => ": the response from rest, exact on each polynomial",
        _ => ": the response from rest (near resonance, or without equilibrium)",
    };
    let forcing = acting(&modal.rotations, modal.signals.len()) + treated;
    let stops = match modal.n_stops() {
        0 => "no stops: one flight to the end, no event search".to_owned(),
        k => format!(
            "{}: every next impact proved to be the first{}",
            count(k),
            together(&modal.geometry)
        ),
    };
    Ok(format!("{flights}; {forcing}; {stops}"))
}

/// The excitation in words.
fn acting(rotations: &Rotations, n_signals: usize) -> String {
    let turning = match (rotations.n_harmonics, rotations.tones.len()) {
        (0, 0) => None,
        (1, 0) => Some("harmonic forcing".to_owned()),
        (k, 0) => Some(format!("forcing of {k} harmonics")),
        (_, tones) => Some(format!(
            "forcing at {tones} frequencies without a common period"
        )),
    };
    let plural = if n_signals == 1 { "" } else { "s" };
    match (turning, n_signals) {
        (None, 0) => "no forcing".to_owned(),
        (Some(turning), 0) => turning,
        (None, k) => format!("forcing after {k} signal{plural}"),
        (Some(turning), k) => format!("{turning}, and {k} signal{plural}"),
    }
}

fn count(stops: usize) -> String {
    format!("{stops} stop{}", if stops == 1 { "" } else { "s" })
}

/// How the contacts of a motion in steps are found: on its path, and where a gap has a bound on its curvature by that.
fn contacts_along(scene: &Scene, path: &str) -> String {
    let k = scene.stops().len();
    if k == 0 {
        return "no stops: no event search".to_owned();
    }
    let bound = |s: &&Constraint| matches!(s, Constraint::Nonlinear(s) if s.curvature().is_some());
    let proved = match scene.stops().iter().filter(bound).count() {
        0 => String::new(),
        n if n == k => ", and none missed by its bound on the curvature".to_owned(),
        n => format!(", and with {n} of them none missed by their bounds on the curvature"),
    };
    let together = if k > 1 {
        "; stops hit together by complementarity where they are coupled: Newton's law for all that are hit or touched at one instant"
    } else {
        ""
    };
    format!(
        "{}: every contact on {path} found{proved}{together}",
        count(k)
    )
}

/// The stops whose forces have no exact flights, in words.
fn integrated_laws(scene: &Scene) -> String {
    let stops = scene.stops().iter().enumerate();
    let laws = stops.filter(|(_, stop)| !stop.contact().is_linear());
    let names = laws.map(|(i, stop)| {
        let law = stop.contact().name();
        format!("; the force of stop {i} by {law} integrated")
    });
    names.collect()
}

/// What several stops do at one instant.
fn together(geometry: &ContactGeometry) -> &'static str {
    let k = geometry.len();
    let mut pairs = (0..k).flat_map(|i| (0..i).map(move |j| (i, j)));
    match k {
        0 | 1 => "",
        _ if pairs.any(|(i, j)| geometry.is_coupled(i, j)) => {
            "; stops hit together by complementarity, for some are coupled: Newton's law for all that are hit or touched at one instant, not for \
             one after the other, which any gap between them gives"
        }
        _ => "; stops hit together each by itself, for none are coupled",
    }
}
