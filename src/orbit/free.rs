//! Stops hit together ask for one more unknown than the phase (theory 5): the clearances times a factor and the forcing
//! times a factor in closed form, any other parameter by a search of its range.

use crate::error::Result;
use crate::flow::ModalScene;
use crate::model::{Change, Parameter, Scene};
use crate::orbit::impulses::Instant;
use crate::orbit::one_instant::{clearance_margin, meet_circle};
use crate::orbit::search::{describe, finish, one_instant, period, sorted};
use crate::orbit::value_roots::{Roots, roots};
use crate::orbit::{OrbitOptions, Orbits, Pattern, PeriodicOrbit, Verdict};
use crate::watch::Watch;
use std::sync::Arc;

/// Undecided stretches that a reason names.
const MOST_SHOWN: usize = 5;

/// The parameter that is one more unknown of a pattern whose stops are hit together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Free {
    /// The clearances of the stops hit, all times one factor (equal ones stay equal).
    Clearance,
    /// A parameter of the scene, searched in a range.
    Parameter(Parameter),
}

impl std::fmt::Display for Free {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Clearance => write!(f, "clearance"),
            Self::Parameter(parameter) => write!(f, "{parameter}"),
        }
    }
}

/// Stops hit together at clearances times one unknown factor (theory 5: kind 1).
pub(super) fn free_clearance(
    scene: &Scene,
    modal: &Arc<ModalScene>,
    pattern: &Pattern,
    options: &OrbitOptions,
    instant: &Instant<'_>,
    watch: &mut Watch<'_>,
) -> Result<Orbits> {
    let given = instant.clearances();
    let direction = if given.amax() > 0.0 {
        given
    } else {
        given.map(|_| 1.0)
    };
    let crossing = meet_circle(&instant.at_clearance(Some(&direction))?, |x| {
        instant.phase_part(x)
    })?;
    let reason = describe(
        &crossing,
        "no common factor on the clearances lets the stops be hit together",
    );
    // The orbits' own contact positions are the clearances.
    let given_phase = OrbitOptions {
        phase: Some(0.0),
        ..options.clone()
    };
    finish(
        scene,
        modal,
        pattern,
        &given_phase,
        instant,
        &crossing,
        reason,
        watch,
    )
}

/// Stops hit together at a forcing amplitude times one unknown factor: `u` off the unit circle.
pub(super) fn free_forcing(
    scene: &Scene,
    pattern: &Pattern,
    options: &OrbitOptions,
    instant: &Instant<'_>,
    watch: &mut Watch<'_>,
) -> Result<Orbits> {
    let set = instant.at_clearance(None)?;
    let u = instant.phase_part(&set.particular);
    let scale = u[0].hypot(u[1]);
    let inside = options
        .between
        .is_none_or(|(low, high)| (low..=high).contains(&scale));
    if set.residual > 1e-11 || set.null_space.ncols() > 0 || scale == 0.0 || !inside {
        return Ok(Orbits {
            all: Vec::new(),
            verdict: Verdict::None,
            reason: "no factor on the forcing lets the stops be hit together".to_owned(),
            margin: None,
            family: None,
        });
    }
    let scene = scene.replace(Change::ForcingScale(scale))?;
    let modal = Arc::new(ModalScene::new(&scene, "periodic_orbits")?);
    let mut orbits = one_instant(
        &scene,
        &modal,
        &pattern.instants()[0],
        &OrbitOptions {
            free: None,
            between: None,
            ..options.clone()
        },
        watch,
    )?;
    orbits.reason = format!("one solution, at forcing_scale = {scale}");
    Ok(orbits)
}

/// How far the contact equations of stops hit together are from being met by one phase.
fn mismatch(scene: &Scene, stops: &[usize], options: &OrbitOptions) -> Result<Option<f64>> {
    let modal = ModalScene::new(scene, "periodic_orbits")?;
    let instant = Instant::new(&modal, stops, period(&modal, options.n_periods)?);
    Ok(clearance_margin(&instant)?.filter(|m| m.is_finite()))
}

/// Stops hit together at some values of a parameter: the roots of the mismatch on a range, as far as its values show them.
pub(super) fn free_parameter(
    scene: &Scene,
    pattern: &Pattern,
    options: &OrbitOptions,
    parameter: Parameter,
    watch: &mut Watch<'_>,
) -> Result<Orbits> {
    let stops = &pattern.instants()[0];
    let (low, high) = options.between.unwrap_or((0.0, 0.0));
    let mut best: Option<f64> = None;
    let found = roots((low, high), |x| {
        watch.look()?;
        let Some(margin) = mismatch(&scene.replace(parameter.change(x))?, stops, options)? else {
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
        let changed = scene.replace(parameter.change(root))?;
        let orbits = at_root(&changed, pattern, options, watch)?;
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
        all: sorted(all, watch)?,
        verdict,
        margin: best,
        family: None,
    })
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
        let shown = found.undecided.iter().take(MOST_SHOWN);
        let places: Vec<String> = shown.map(|(a, b)| format!("[{a}, {b}]")).collect();
        let more = found.undecided.len().saturating_sub(MOST_SHOWN);
        text.push_str(&format!("; undecided: {}", places.join(", ")));
        if more > 0 {
            text.push_str(&format!(" and {more} more stretches"));
        }
    }
    text
}

/// The orbit at a root of the mismatch: rounding of the root is taken up by the clearances, which move by as little.
fn at_root(
    scene: &Scene,
    pattern: &Pattern,
    options: &OrbitOptions,
    watch: &mut Watch<'_>,
) -> Result<Vec<PeriodicOrbit>> {
    let modal = Arc::new(ModalScene::new(scene, "periodic_orbits")?);
    let instant = Instant::new(
        &modal,
        &pattern.instants()[0],
        period(&modal, options.n_periods)?,
    );
    let set = instant.at_clearance(None)?;
    let u = instant.phase_part(&set.particular);
    let phase = u[1].atan2(u[0]);
    let fixed = OrbitOptions {
        phase: Some(phase),
        free: None,
        between: None,
        ..options.clone()
    };
    Ok(one_instant(scene, &modal, &pattern.instants()[0], &fixed, watch)?.all)
}
