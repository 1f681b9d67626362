//! A periodic problem: what is asked of which scene; refused where it cannot be begun.

use crate::error::{Error, Result, digits};
use crate::flow::ModalScene;
use crate::model::{Parameter, Scene};
use crate::orbit::options::{FreeParameter, OrbitOptions};
use crate::orbit::pattern::Pattern;
use crate::quantity::at_least_one;
use crate::tolerance::MOST_TURNS_IN_PERIOD;
use std::f64::consts::TAU;
use std::sync::Arc;

/// A scene in modes, the pattern that is looked for in it and how.
pub(crate) struct Problem<'a> {
    pub scene: &'a Scene,
    pub modal: Arc<ModalScene>,
    pub pattern: &'a Pattern,
    pub options: &'a OrbitOptions,
    /// The period of the orbits \[s\].
    pub period: f64,
}

impl<'a> Problem<'a> {
    /// The problem of a scene for which [`check`] has passed what is asked.
    pub fn new(scene: &'a Scene, pattern: &'a Pattern, options: &'a OrbitOptions) -> Result<Self> {
        let modal = Arc::new(ModalScene::new(scene, "periodic_orbits")?);
        let period = period(&modal, options.n_periods)?;
        Ok(Self {
            scene,
            modal,
            pattern,
            options,
            period,
        })
    }

    /// The same asked of a changed scene.
    pub fn of_scene<'b>(&self, scene: &'b Scene) -> Result<Problem<'b>>
    where
        'a: 'b,
    {
        Problem::new(scene, self.pattern, self.options)
    }

    /// The stops of the one instant that the pattern has, if any.
    pub fn stops(&self) -> &'a [usize] {
        self.pattern.instants().first().map_or(&[], Vec::as_slice)
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
    scene.check_period(purpose)?;
    if scene.frequency().is_none() {
        return Err(Error::bad_value(
            "scene",
            "unforced",
            format!(
                "{purpose} looks for motions in step with the forcing; give the scene a forcing"
            ),
        ));
    }
    pattern.check(scene.stops().len())?;
    let gives_way = compliant_stops(scene, pattern, purpose)?.is_some();
    let harmonics = scene.excitation().rotations.n_harmonics;
    if harmonics > 1 && (pattern.instants().len() > 1 || options.free.is_some() || gives_way) {
        let found = format!("of {harmonics} harmonics");
        let rule = format!(
            "{purpose} solves patterns of two instants, and of stops that give way, and frees a parameter, under one; use find_orbit with a \
             guess"
        );
        return Err(Error::bad_value("forcing", found, rule));
    }
    if pattern.instants().len() > 1 {
        scene.check_stops_rest(&format!("{purpose} of two instants"))?;
    }
    if pattern.instants().len() > 2 {
        return Err(Error::bad_value(
            "pattern",
            format!("of {} instants", pattern.instants().len()),
            format!(
                "{purpose} solves patterns of one or two instants; use find_orbit with a guess for more"
            ),
        ));
    }
    at_least_one("n_periods", options.n_periods)?;
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
        (FreeParameter::Clearance | FreeParameter::Parameter(Parameter::ForcingScale), _) => Ok(()),
        (_, Some((low, high))) if low < high && low.is_finite() && high.is_finite() => Ok(()),
        (_, range) => Err(Error::bad_value(
            "between",
            shown(range),
            "it must be (low, high) with low < high",
        )),
    }
}

/// The stops of a pattern whose contacts last: one, or two that are to be each other's mirror images; none of a pattern of impacts.
///
/// # Errors
/// `Error::BadValue` for other patterns with stops that give way.
pub(crate) fn compliant_stops(
    scene: &Scene,
    pattern: &Pattern,
    purpose: &str,
) -> Result<Option<Vec<usize>>> {
    let stops: Vec<usize> = pattern.instants().concat();
    let is_rigid = |stop: &usize| scene.stops()[*stop].contact().is_rigid();
    if stops.iter().all(is_rigid) {
        return Ok(None);
    }
    let is_one_each = pattern.instants().iter().all(|instant| instant.len() == 1);
    if is_one_each && stops.len() <= 2 && !stops.iter().any(is_rigid) {
        return Ok(Some(stops));
    }
    let found = format!("{:?}", pattern.instants());
    let rule = format!(
        "of stops that give way {purpose} solves one contact in the period, and two stops that are each other's mirror images; use find_orbit \
         with a guess"
    );
    Err(Error::bad_value("pattern", found, rule))
}

/// A range as Python writes it.
fn shown(range: Option<(f64, f64)>) -> String {
    range.map_or_else(
        || "None".to_owned(),
        |(low, high)| format!("({low}, {high})"),
    )
}

/// The refusal of a motion that doubles do not hold.
pub(crate) fn outgrown() -> Error {
    let rule = "its motion grows beyond the largest number within a period";
    Error::bad_value("scene", "unstable", rule)
}

/// The period of an orbit of so many forcing periods.
///
/// # Errors
/// `Error::BadValue` where it holds more than `MOST_TURNS_IN_PERIOD` turns of the forcing or of the fastest mode, or the free motion
/// outgrows the doubles in it.
pub(crate) fn period(modal: &ModalScene, n_periods: usize) -> Result<f64> {
    let period = TAU * n_periods as f64 / modal.frequency;
    check_turns(modal, period)?;
    if modal.form.fastest_growth() * period >= f64::MAX.ln() {
        return Err(outgrown());
    }
    Ok(period)
}

/// Refuses a period of more than `MOST_TURNS_IN_PERIOD` turns of the forcing or of the fastest mode, in a file too.
///
/// # Errors
/// `Error::BadValue` with the rate.
pub(crate) fn check_turns(modal: &ModalScene, period: f64) -> Result<()> {
    let fastest = modal.form.fastest_rate().max(modal.frequency);
    let is_known = fastest * period <= TAU * MOST_TURNS_IN_PERIOD;
    if is_known {
        return Ok(());
    }
    let rule = format!(
        "it must hold no more than {MOST_TURNS_IN_PERIOD:e} turns of the fastest mode, of rate {}: beyond them double precision has no \
         digits left for its phase",
        digits(fastest)
    );
    Err(Error::bad_value("the period", digits(period), rule))
}
