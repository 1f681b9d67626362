//! Stops hit together ask for one more unknown than the phase (theory 5): the forcing times a factor in closed
//! form (as the clearances times a factor are, in `one_instant/solve.rs`), any other parameter by a search of its range.

use crate::error::Result;
use crate::model::Parameter;
use crate::observer::Observer;
use crate::orbit::one_instant::periodic_conditions::PeriodicConditions;
use crate::orbit::one_instant::solve::{at_clearance, at_phase, clearance_margin};
use crate::orbit::orbits::{Orbits, Verdict, sorted};
use crate::orbit::periodic_orbit::PeriodicOrbit;
use crate::orbit::problem::Problem;
use crate::orbit::value_roots::{Roots, roots};
use crate::tolerance::SOLVABLE;

/// Undecided stretches that a reason names. [work]
const MOST_STRETCHES_SHOWN: usize = 5;

/// Stops hit together at a forcing amplitude times one unknown factor: `u` off the unit circle.
pub(super) fn free_forcing(problem: &Problem<'_>, observer: &mut Observer) -> Result<Orbits> {
    let conditions = PeriodicConditions::new(&problem.modal, problem.stops(), problem.period);
    let set = conditions.at_clearance(None)?;
    let u = conditions.phase_part(&set.particular);
    let scale = u[0].hypot(u[1]);
    let between = problem.options.between;
    let inside = between.is_none_or(|(low, high)| (low..=high).contains(&scale));
    if set.residual > SOLVABLE || set.null_space.ncols() > 0 || scale == 0.0 || !inside {
        return Ok(Orbits::none(
            "no factor on the forcing lets the stops be hit together",
        ));
    }
    let scene = problem
        .scene
        .replace(Parameter::ForcingScale.change(scale))?;
    let scaled = problem.of_scene(&scene)?;
    let mut orbits = Orbits::new(&scaled, at_clearance(&scaled)?, observer)?;
    orbits.reason = format!("one solution, at forcing_scale = {scale}");
    Ok(orbits)
}

/// How far the contact equations of stops hit together are from being met by one phase.
fn mismatch(problem: &Problem<'_>) -> Result<Option<f64>> {
    let conditions = PeriodicConditions::new(&problem.modal, problem.stops(), problem.period);
    Ok(clearance_margin(&conditions)?.filter(|m| m.is_finite()))
}

/// Stops hit together at some values of a parameter: the roots of the mismatch on a range, as far as its values show them.
pub(super) fn free_parameter(
    problem: &Problem<'_>,
    parameter: Parameter,
    observer: &mut Observer,
) -> Result<Orbits> {
    let (low, high) = problem.options.between.unwrap_or((0.0, 0.0));
    let changed = |x: f64| problem.scene.replace(parameter.change(x));
    let mut best: Option<f64> = None;
    let found = roots((low, high), |x| {
        observer.ask()?;
        let Some(margin) = mismatch(&problem.of_scene(&changed(x)?)?)? else {
            return Ok(None);
        };
        if best.is_none_or(|b| margin.abs() < b.abs()) {
            best = Some(margin);
        }
        Ok(Some(bounded(margin)))
    })?;
    let mut all: Vec<PeriodicOrbit> = Vec::new();
    let mut apart = 0;
    for &root in &found.places {
        let scene = changed(root)?;
        let at_root = problem.of_scene(&scene)?;
        let solutions = at_phase(&at_root, contact_phase(&at_root)?)?;
        let orbits = Orbits::new(&at_root, solutions, observer)?.all;
        apart += usize::from(orbits.is_empty());
        all.extend(orbits);
    }
    let verdict = if all.is_empty() {
        Verdict::None
    } else {
        Verdict::Found
    };
    Ok(Orbits {
        reason: described(all.len(), apart, (low, high), &found),
        all: sorted(all, observer)?,
        verdict,
        margin: best,
        family: None,
    })
}

/// The phase of the contact at a root of the mismatch: rounding of the root is taken up by the clearances, which move by as
/// little.
fn contact_phase(problem: &Problem<'_>) -> Result<f64> {
    let conditions = PeriodicConditions::new(&problem.modal, problem.stops(), problem.period);
    let set = conditions.at_clearance(None)?;
    let u = conditions.phase_part(&set.particular);
    Ok(u[1].atan2(u[0]))
}

/// A mismatch `1 - r` as `(1 - r^2)/(1 + r^2)`: the same roots, and smooth where r has a pole.
fn bounded(margin: f64) -> f64 {
    let square = (1.0 - margin).powi(2);
    if square.is_finite() {
        margin * (2.0 - margin) / (1.0 + square)
    } else {
        -1.0
    }
}

/// What the search of a range came to, in words.
fn described(solutions: usize, apart: usize, (low, high): (f64, f64), found: &Roots) -> String {
    let solutions = match solutions {
        0 => "no solution".to_owned(),
        1 => "one solution".to_owned(),
        n => format!("{n} solutions"),
    };
    let mut text = format!(
        "{solutions} in [{low}, {high}], by {} values of the mismatch, at which its second differences leave no room for more (no \
         proof by bounds)",
        found.values
    );
    if apart > 0 {
        text.push_str(&format!("; at {apart} more the motion does not repeat"));
    }
    if !found.undecided.is_empty() {
        let shown = found.undecided.iter().take(MOST_STRETCHES_SHOWN);
        let places: Vec<String> = shown.map(|(a, b)| format!("[{a}, {b}]")).collect();
        let more = found.undecided.len().saturating_sub(MOST_STRETCHES_SHOWN);
        text.push_str(&format!("; undecided: {}", places.join(", ")));
        if more > 0 {
            text.push_str(&format!(" and {more} more stretches"));
        }
    }
    text
}
