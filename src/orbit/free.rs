//! Stops hit together ask for one more unknown than the phase (theory 5): the clearances times a factor and the forcing
//! times a factor in closed form, any other parameter by a search of its range.

use crate::error::Result;
use crate::flow::ModalScene;
use crate::model::{Change, Parameter, Scene};
use crate::orbit::impulses::Instant;
use crate::orbit::one_instant::{clearance_margin, meet_circle};
use crate::orbit::search::{describe, finish, one_instant, period, sorted};
use crate::orbit::{OrbitOptions, Orbits, Pattern, PeriodicOrbit, Verdict};
use crate::watch::Watch;
use std::sync::Arc;

/// Samples of a free parameter's range.
const SAMPLES: usize = 400;

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

/// Stops hit together at some values of a parameter: the roots of the mismatch on a range, as good as its samples.
pub(super) fn free_parameter(
    scene: &Scene,
    pattern: &Pattern,
    options: &OrbitOptions,
    parameter: Parameter,
    watch: &mut Watch<'_>,
) -> Result<Orbits> {
    let stops = &pattern.instants()[0];
    let (low, high) = options.between.unwrap_or((0.0, 0.0));
    let at = |x: f64, watch: &mut Watch<'_>| {
        watch.look()?;
        mismatch(&scene.replace(parameter.change(x))?, stops, options)
    };
    let mut best: Option<f64> = None;
    let mut roots = Vec::new();
    let mut previous: Option<(f64, f64)> = None;
    for i in 0..=SAMPLES {
        let x = low + (high - low) * i as f64 / SAMPLES as f64;
        let Some(y) = at(x, watch)? else {
            previous = None;
            continue;
        };
        if best.is_none_or(|b| y.abs() < b.abs()) {
            best = Some(y);
        }
        if y == 0.0 {
            roots.push(x);
        } else if let Some((x0, y0)) = previous.filter(|&(_, y0)| y0 * y < 0.0)
            && let Some(root) = bracketed(|x| at(x, watch), (x0, y0), (x, y))?
        {
            roots.push(root);
        }
        previous = Some((x, y));
    }
    let mut all: Vec<PeriodicOrbit> = Vec::new();
    for &root in &roots {
        let changed = scene.replace(parameter.change(root))?;
        all.extend(at_root(&changed, pattern, options, watch)?);
    }
    let verdict = if all.is_empty() {
        Verdict::None
    } else {
        Verdict::Found
    };
    let reason = if all.is_empty() {
        format!(
            "no value in [{low}, {high}] was found on {} samples",
            SAMPLES + 1
        )
    } else {
        format!(
            "{} solutions in [{low}, {high}], found on {} samples",
            all.len(),
            SAMPLES + 1
        )
    };
    Ok(Orbits {
        all: sorted(all, watch)?,
        verdict,
        reason,
        margin: best,
        family: None,
    })
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

/// The root of a continuous function in a bracket by bisection and secants; `None` where the sign changes at a pole.
fn bracketed(
    mut f: impl FnMut(f64) -> Result<Option<f64>>,
    (mut x0, mut y0): (f64, f64),
    (mut x1, mut y1): (f64, f64),
) -> Result<Option<f64>> {
    let start = y0.abs().max(y1.abs());
    for round in 0..200 {
        let secant = x1 - y1 * (x1 - x0) / (y1 - y0);
        let x = if round % 3 == 2 || !secant.is_finite() {
            0.5 * (x0 + x1)
        } else {
            secant
        };
        if x <= x0.min(x1) || x >= x0.max(x1) || (x1 - x0).abs() <= 4.0 * f64::EPSILON * x.abs() {
            break;
        }
        let Some(y) = f(x)? else { return Ok(None) };
        if y == 0.0 {
            return Ok(Some(x));
        }
        if y * y0 < 0.0 {
            (x1, y1) = (x, y);
        } else {
            (x0, y0) = (x, y);
        }
    }
    let (x, y) = if y0.abs() < y1.abs() {
        (x0, y0)
    } else {
        (x1, y1)
    };
    Ok((y.abs() < 1e-6 * start.max(1e-6)).then_some(x))
}
