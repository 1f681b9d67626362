//! `periodic_orbits`: from a scene and a pattern to every orbit, its verdict and its order.

use crate::error::{Error, Result, digits};
use crate::flow::ModalScene;
use crate::model::{Change, Parameter, Scene};
use crate::orbit::admissible::Ruling;
use crate::orbit::free::{Free, free_clearance, free_forcing, free_parameter};
use crate::orbit::impulses::Instant;
use crate::orbit::one_instant::{Crossing, Solution, clearance_given, phase_given};
use crate::orbit::periodic_orbit::Parts;
use crate::orbit::two_instants::two_instants;
use crate::orbit::{Family, OrbitOptions, Orbits, Pattern, PeriodicOrbit, Verdict};
use crate::watch::Watch;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::sync::Arc;

/// Systems of more degrees of freedom are listed by admissibility alone: their multipliers cost O(n^3) and are computed
/// only when asked for.
const SORT_BY_STABILITY_UP_TO: usize = 60;

/// Every periodic orbit of a linear, forced scene that hits stops in the given pattern (theory 5).
///
/// With the clearances given (the default) the forcing phase at the first impact is found; with `options.phase` given,
/// the clearances of the stops in the pattern come out. Orbits that are not admissible are returned with their
/// violation, which is searched for when first asked for.
///
/// The list is in the order of [`Orbits`]: stable and admissible ones first; in systems of more than 60 degrees of freedom
/// admissible ones first, stable or not.
///
/// A pattern of two instants is searched in the flight time between them, every one of which is decided by bounds;
/// `Orbits::reason` says what was proved. One stop hit twice gives one orbit for each pair of flight times that add up to
/// the period, and none that is an orbit of half the period gone through twice. Flight times nearer to 0 or the period than
/// 1e-9 of it are not searched, no margin is reported, no free parameter is taken, and of undamped modes in step with the
/// period there may be four.
///
/// # Errors
/// A nonlinear or unforced scene, a pattern that does not fit it or has more than two instants, options that contradict
/// each other, a phase given for two instants without a common stop; a motion that grows beyond the doubles within a period,
/// a period of more than 1e12 turns of the fastest mode, whose phase is lost.
///
/// # References
/// The source paper, eqs. (29) and (38), with the corrections of theory section 3.
///
/// # Examples
/// ```
/// use vibroimpact::{Kind, OrbitOptions, PaperOptions, Pattern, paper_scene, periodic_orbits};
/// let scene = paper_scene(Kind::Three, &PaperOptions::default())?;
/// let options = OrbitOptions { n_periods: 2, ..Default::default() };
/// let orbits = periodic_orbits(&scene, &Pattern::single(1), &options)?;
/// assert_eq!(orbits[0].is_admissible(), Some(true));
/// assert_eq!(orbits[0].stability()?.is_stable, Some(true));
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn periodic_orbits(scene: &Scene, pattern: &Pattern, options: &OrbitOptions) -> Result<Orbits> {
    periodic_orbits_checked(scene, pattern, options, &mut || ControlFlow::Continue(()))
}

/// [`periodic_orbits`], asking `observer` from time to time whether to go on.
///
/// # Errors
/// As [`periodic_orbits`]; `Error::Interrupted` when the observer breaks off.
pub fn periodic_orbits_checked(
    scene: &Scene,
    pattern: &Pattern,
    options: &OrbitOptions,
    observer: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<Orbits> {
    let watch = &mut Watch::new(observer);
    check(scene, pattern, options, "periodic_orbits")?;
    let modal = Arc::new(ModalScene::new(scene, "periodic_orbits")?);
    match pattern.instants() {
        [] => without_impacts(scene, &modal, options, watch),
        [stops] => one_instant(scene, &modal, stops, options, watch),
        _ => two_instants(scene, &modal, pattern, options, watch),
    }
}

/// Whether a search for orbits can be begun; `purpose` is the name under which it was asked for.
pub(crate) fn check(
    scene: &Scene,
    pattern: &Pattern,
    options: &OrbitOptions,
    purpose: &str,
) -> Result<()> {
    scene.linear_system(purpose)?;
    if scene.forcing().frequency().is_none() {
        return Err(Error::bad_value(
            "scene",
            "unforced",
            format!(
                "{purpose} looks for motions in step with the forcing; give the scene a forcing"
            ),
        ));
    }
    pattern.check(scene.stops().len())?;
    if pattern.instants().len() > 2 {
        return Err(Error::bad_value(
            "pattern",
            format!("of {} instants", pattern.instants().len()),
            format!(
                "{purpose} solves patterns of one or two instants; use find_orbit with a guess for more"
            ),
        ));
    }
    if options.n_periods == 0 {
        return Err(Error::bad_value("n_periods", 0, "it must be at least 1"));
    }
    if let Some(phase) = options.phase {
        crate::quantity::finite("phase", phase)?;
    }
    let Some(free) = options.free else {
        return match options.between {
            None => Ok(()),
            Some(range) => Err(Error::bad_value(
                "between",
                shown(Some(range)),
                "it is the range of `free`; name one",
            )),
        };
    };
    if !matches!(pattern.instants(), [stops] if stops.len() >= 2) {
        let rule = "a free parameter needs a pattern with two stops or more at one instant";
        return Err(Error::bad_value("free", free, rule));
    }
    if options.phase.is_some() {
        return Err(Error::bad_value(
            "free",
            free,
            "give either a phase or a free parameter",
        ));
    }
    match (free, options.between) {
        (Free::Clearance | Free::Parameter(Parameter::ForcingScale), _) => Ok(()),
        (_, Some((low, high))) if low < high && low.is_finite() && high.is_finite() => Ok(()),
        (_, range) => Err(Error::bad_value(
            "between",
            shown(range),
            "it must be (low, high) with low < high",
        )),
    }
}

/// A range as Python writes it.
fn shown(range: Option<(f64, f64)>) -> String {
    range.map_or_else(
        || "None".to_owned(),
        |(low, high)| format!("({low}, {high})"),
    )
}

/// Turns of the fastest mode in a period beyond which its phase is lost: a phase of so many turns is known to three digits
/// of a radian, and a flight that long is not searched in a day.
const MOST_TURNS: f64 = 1e12;

/// The refusal of a motion that doubles do not hold.
pub(crate) fn outgrown() -> Error {
    let rule = "its motion grows beyond the largest number within a period";
    Error::bad_value("scene", "unstable", rule)
}

/// The period of an orbit of so many forcing periods.
///
/// # Errors
/// `Error::BadValue` where it holds more than `MOST_TURNS` turns of the forcing or of the fastest mode, or the free motion
/// outgrows the doubles in it.
pub(crate) fn period(modal: &ModalScene, n_periods: usize) -> Result<f64> {
    let period = TAU * n_periods as f64 / modal.frequency;
    let fastest = modal.form.fastest_rate().max(modal.frequency);
    let is_known = fastest * period <= TAU * MOST_TURNS;
    if !is_known {
        let rule = format!(
            "it must hold no more than {MOST_TURNS:e} turns of the fastest mode, of rate {}: beyond them double precision \
             has no digits left for its phase",
            digits(fastest)
        );
        return Err(Error::bad_value("the period", digits(period), rule));
    }
    if modal.form.fastest_growth() * period >= f64::MAX.ln() {
        return Err(outgrown());
    }
    Ok(period)
}

fn without_impacts(
    scene: &Scene,
    modal: &Arc<ModalScene>,
    options: &OrbitOptions,
    watch: &mut Watch<'_>,
) -> Result<Orbits> {
    let phase = options.phase.unwrap_or_else(|| scene.forcing().phase());
    let instant = Instant::new(modal, &[], period(modal, options.n_periods)?);
    let crossing = phase_given(&instant, phase)?;
    let reason = match (crossing.points.is_empty(), crossing.basis.ncols()) {
        (true, _) => {
            "no motion repeats: an undamped mode is in resonance with the forcing, or a load has nothing to rest on"
        }
        (false, 0) => "the steady response",
        (false, _) => "a free motion that repeats can be added to the steady response",
    };
    finish(
        scene,
        modal,
        &Pattern::none(),
        options,
        &instant,
        &crossing,
        reason.to_owned(),
        watch,
    )
}

pub(super) fn one_instant(
    scene: &Scene,
    modal: &Arc<ModalScene>,
    stops: &[usize],
    options: &OrbitOptions,
    watch: &mut Watch<'_>,
) -> Result<Orbits> {
    let instant = Instant::new(modal, stops, period(modal, options.n_periods)?);
    let pattern = Pattern::together(stops)?;
    match (options.phase, options.free) {
        (Some(phase), _) => {
            let crossing = phase_given(&instant, phase)?;
            let reason = describe(
                &crossing,
                "I - R e^(AT) is singular and the forcing is not in its range",
            );
            finish(
                scene, modal, &pattern, options, &instant, &crossing, reason, watch,
            )
        }
        (None, None) => {
            let crossing = clearance_given(&instant)?;
            let hint = if stops.len() > 1 {
                "the stops hit together ask for two phases at once, or more; free one parameter (free=\"clearance\")"
            } else {
                "the forcing is too weak for a contact at this clearance: no phase reaches it"
            };
            let reason = describe(&crossing, hint);
            finish(
                scene, modal, &pattern, options, &instant, &crossing, reason, watch,
            )
        }
        (None, Some(Free::Clearance)) => {
            free_clearance(scene, modal, &pattern, options, &instant, watch)
        }
        (None, Some(Free::Parameter(Parameter::ForcingScale))) => {
            free_forcing(scene, &pattern, options, &instant, watch)
        }
        (None, Some(Free::Parameter(parameter))) => {
            free_parameter(scene, &pattern, options, parameter, watch)
        }
    }
}

pub(super) fn describe(crossing: &Crossing, none: &str) -> String {
    if crossing.points.is_empty() {
        none.to_owned()
    } else if crossing.is_any_phase {
        "every phase has an orbit".to_owned()
    } else if crossing.basis.ncols() > 0 {
        format!(
            "a family with {} parameters: the contact state may be moved along its basis",
            crossing.basis.ncols()
        )
    } else {
        match crossing.points.len() {
            1 => "one solution".to_owned(),
            n => format!("{n} solutions"),
        }
    }
}

/// Builds the orbits of a crossing, and orders them.
pub(super) fn finish(
    scene: &Scene,
    modal: &Arc<ModalScene>,
    pattern: &Pattern,
    options: &OrbitOptions,
    instant: &Instant<'_>,
    crossing: &Crossing,
    reason: String,
    watch: &mut Watch<'_>,
) -> Result<Orbits> {
    let mut orbits = crossing
        .points
        .iter()
        .map(|x| build(scene, modal, pattern, options, instant, x))
        .collect::<Result<Vec<_>>>()?;
    let mut reason = reason;
    keep_closed(&mut orbits, &mut reason);
    let basis = family_basis(modal, instant, crossing);
    let is_family = basis.ncols() > 0 || crossing.is_any_phase;
    let verdict = match (orbits.is_empty(), is_family) {
        (true, _) => Verdict::None,
        (false, true) => Verdict::Family,
        (false, false) => Verdict::Found,
    };
    let family = (verdict == Verdict::Family).then_some(Family { basis });
    Ok(Orbits {
        all: sorted(orbits, watch)?,
        verdict,
        reason,
        margin: crossing.margin,
        family,
    })
}

/// Takes the orbits out that do not close, and says so: there rounding has left no digits of them.
pub(super) fn keep_closed(orbits: &mut Vec<PeriodicOrbit>, reason: &mut String) {
    let mut lost = Vec::new();
    orbits.retain(|orbit| {
        let misfit = orbit.lost();
        lost.extend(misfit);
        misfit.is_none()
    });
    if let Some(worst) = lost.iter().copied().reduce(f64::max) {
        reason.push_str(&format!(
            "; {} of these cannot be told from rounding: gone through once, the motion misses its beginning by {} of its size",
            lost.len(),
            digits(worst)
        ));
    }
}

/// Null vectors as changes of the contact state (q, v).
fn family_basis(modal: &ModalScene, instant: &Instant<'_>, crossing: &Crossing) -> DMatrix<f64> {
    let n = modal.form.n_dof();
    let columns: Vec<DVector<f64>> = crossing
        .basis
        .column_iter()
        .map(|x| {
            let (q, v) = modal
                .form
                .to_physical(&instant.state_after(&x.into_owned(), 0.0));
            DVector::from_iterator(2 * n, q.iter().chain(v.iter()).copied())
        })
        .collect();
    if columns.is_empty() {
        DMatrix::zeros(2 * n, 0)
    } else {
        DMatrix::from_columns(&columns)
    }
}

fn build(
    scene: &Scene,
    modal: &Arc<ModalScene>,
    pattern: &Pattern,
    options: &OrbitOptions,
    instant: &Instant<'_>,
    x: &DVector<f64>,
) -> Result<PeriodicOrbit> {
    let Solution {
        phase,
        flight,
        impulses,
    } = Solution::new(instant, x, period(modal, options.n_periods)?)?;
    let contacts = instant.contacts(&flight.after);
    let parts = Parts {
        pattern: pattern.clone(),
        n_periods: options.n_periods,
        phase,
        flights: vec![flight],
        impulses: impulses.as_slice().to_vec(),
    };
    if options.phase.is_none() || contacts.is_empty() {
        return PeriodicOrbit::new(scene, modal.clone(), parts);
    }
    let (scene, modal) = with_contacts(scene, modal, &pattern.instants()[0], &contacts)?;
    PeriodicOrbit::new(&scene, modal, parts)
}

/// The scene with the clearances of the given stops set so that they are where the contacts are.
pub(super) fn with_contacts(
    scene: &Scene,
    modal: &Arc<ModalScene>,
    stops: &[usize],
    contacts: &[f64],
) -> Result<(Scene, Arc<ModalScene>)> {
    let mut geometry = (*modal.geometry).clone();
    for (&stop, &contact) in stops.iter().zip(contacts) {
        geometry.clearances[stop] = contact;
    }
    let clearances = geometry.clearances.as_slice().to_vec();
    Ok((
        scene.replace(Change::Clearance(clearances))?,
        Arc::new(ModalScene {
            geometry: Arc::new(geometry),
            ..(**modal).clone()
        }),
    ))
}

/// The order of orbits: stable and admissible first, then admissible, then undecided, then by depth of violation. Asks for
/// stability only where it decides.
pub(crate) fn ranking(
    n_dof: usize,
    rulings: &[Ruling],
    mut is_stable: impl FnMut(usize) -> Result<bool>,
) -> Result<Vec<usize>> {
    let is_admissible = |ruling: &&Ruling| **ruling == Ruling::Admissible;
    let asks = n_dof <= SORT_BY_STABILITY_UP_TO && rulings.iter().filter(is_admissible).count() > 1;
    let mut keys = Vec::with_capacity(rulings.len());
    for (i, ruling) in rulings.iter().enumerate() {
        keys.push(match *ruling {
            Ruling::Admissible if asks && is_stable(i)? => (0, 0.0),
            Ruling::Admissible => (1, 0.0),
            Ruling::Undecided => (2, 0.0),
            Ruling::Broken(depth) => (3, depth),
        });
    }
    let mut order: Vec<usize> = (0..rulings.len()).collect();
    order.sort_by(|&i, &j| {
        keys[i]
            .0
            .cmp(&keys[j].0)
            .then(keys[i].1.total_cmp(&keys[j].1))
    });
    Ok(order)
}

/// The orbits in the order of [`ranking`]. A single one is not judged before somebody asks.
pub(super) fn sorted(
    mut orbits: Vec<PeriodicOrbit>,
    watch: &mut Watch<'_>,
) -> Result<Vec<PeriodicOrbit>> {
    if orbits.len() < 2 {
        return Ok(orbits);
    }
    let rulings = orbits
        .iter()
        .map(|o| Ok(o.judged(watch)?.ruling()))
        .collect::<Result<Vec<_>>>()?;
    let order = ranking(orbits[0].scene().n_dof(), &rulings, |i| {
        Ok(orbits[i].decided(watch)?.is_stable == Some(true))
    })?;
    let mut slots: Vec<Option<PeriodicOrbit>> = orbits.drain(..).map(Some).collect();
    Ok(order.into_iter().filter_map(|i| slots[i].take()).collect())
}
