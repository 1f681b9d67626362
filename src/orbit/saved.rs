//! An orbit as plain numbers, to be stored and made again.

use crate::error::{Error, Result};
use crate::flow::ModalScene;
use crate::hybrid::{IntegratedMaps, SegmentKind};
use crate::law::{ElementState, Regime, Stage, Transition};
use crate::modal::Pair;
use crate::model::{Constraint, Scene};
use crate::orbit::orbit_data::{OrbitArc, OrbitData};
use crate::orbit::orbit_motion::OrbitMotion;
use crate::orbit::pattern::Pattern;
use crate::orbit::periodic_orbit::PeriodicOrbit;
use crate::orbit::problem::check_turns;
use crate::path::{ORBIT, check_motion};
use crate::tolerance::PERIOD_TOL;
use std::sync::Arc;

/// What one flight of an orbit is as plain numbers: the kind of motion, the stops in contact, whether it begins with an instant of the
/// pattern, the stop let go at its start.
pub type SavedMode = (SegmentKind, Vec<usize>, bool, Option<usize>);

/// The arc as a saved mode.
fn saved(arc: &OrbitArc) -> SavedMode {
    let (kind, regime) = arc.drawn();
    let transition = &arc.stage.transition;
    let begins = !transition.begun().is_empty();
    let is_struck = begins || transition.is_nothing() && arc.is_flight();
    (kind, regime.written(), is_struck, arc.departure())
}

/// The stage of the arc that was saved as a mode behind another one; `struck` are the stops of the instant with which it begins, if it does.
fn restored(
    scene: &Scene,
    before: &SavedMode,
    (kind, stops, is_struck, released): &SavedMode,
    mut struck: impl FnMut() -> Stage,
) -> Stage {
    let [earlier, regime] = [&before.1, stops].map(|own| Regime::read(own).unwrap_or_default());
    let begun = is_struck.then(&mut struck);
    let change = changed(scene, [&earlier, &regime]);
    let transition = match (kind, released, stops.first()) {
        (SegmentKind::Chatter, _, Some(stop)) => {
            return Stage::free(Transition::Chatter(*stop));
        }
        (_, Some(stop), _) => Transition::Release(*stop),
        _ => change
            .or(begun.map(|stage| stage.transition))
            .unwrap_or(Transition::Nothing),
    };
    Stage { transition, regime }
}

/// The transition between two regimes in which an element that gives way has another state, if there is one.
fn changed(scene: &Scene, [before, after]: [&Regime; 2]) -> Option<Transition> {
    let laws = scene.stops().iter().map(Constraint::contact).enumerate();
    let mut compliant = laws.filter(|(_, law)| !law.is_rigid());
    compliant.find_map(|(element, law)| {
        let [from, to] = [before, after].map(|regime| regime.state(element));
        // One that is met where it relaxes was back at its place.
        let is_back = from == ElementState::Relaxing;
        let from = if is_back { ElementState::Free } else { from };
        Transition::change(law.by_state(), element, [from, to])
    })
}

/// An orbit as plain numbers, from which it can be made again: spans of its flights, modal states (after, then before the
/// next instant, flight by flight), impulses.
#[derive(Debug, Clone, PartialEq)]
pub struct SavedOrbit {
    /// Forcing periods in one period.
    pub n_periods: usize,
    /// Forcing phase at the first impact.
    pub phase: f64,
    /// Spans of the flights, shape `(flights,)`, \[s\].
    pub spans: Vec<f64>,
    /// States after the instant at the start and before the one at the end of each flight, as pairs of position and velocity of each mode,
    /// shape `(4 n flights,)`, [modal units]; of each coordinate [m, m/s] where the scene has no modes.
    pub states: Vec<f64>,
    /// Impulses in the order of the pattern, shape `(impacts,)`, [N s].
    pub impulses: Vec<f64>,
    /// What each flight is: its kind, the stops in contact, whether it begins with the next instant of the pattern, the
    /// stop let go at its start. Empty: all of them free, from instant to instant.
    pub modes: Vec<SavedMode>,
}

impl PeriodicOrbit {
    /// The orbit as plain numbers.
    pub fn save(&self) -> SavedOrbit {
        let states = self
            .flights()
            .iter()
            .flat_map(|f| f.after.iter().chain(&f.before_next))
            .flatten();
        SavedOrbit {
            n_periods: self.n_periods(),
            phase: self.phase(),
            spans: self.flights().iter().map(|f| f.span).collect(),
            states: states.copied().collect(),
            impulses: self.impacts().iter().map(|i| i.impulse).collect(),
            modes: self.flights().iter().map(saved).collect(),
        }
    }

    /// The orbit that was saved; `scene` is the orbit's own, to the last bit its [`saved_scene`](Self::saved_scene).
    ///
    /// # Errors
    /// Numbers that do not fit the scene or each other.
    pub fn restore(scene: &Scene, pattern: Pattern, saved: SavedOrbit) -> Result<Self> {
        let n = scene.n_dof();
        check(scene, &pattern, &saved)?;
        if saved.states.len() != 4 * n * saved.spans.len() || saved.spans.is_empty() {
            let expected = format!("({},)", 4 * n * saved.spans.len());
            return Err(Error::bad_shape(
                "states",
                format!("({},)", saved.states.len()),
                expected,
            ));
        }
        let pairs: Vec<Pair> = saved.states.chunks(2).map(|z| [z[0], z[1]]).collect();
        let mut start = 0.0;
        let mut flights = Vec::new();
        let mut instants = pattern.instants().iter();
        let mut struck = || Stage::impact(instants.next().map_or(&[], |stops| stops));
        for (k, (span, states)) in saved.spans.iter().zip(pairs.chunks(2 * n)).enumerate() {
            let after = states[..n].to_vec().into();
            let before_next = states[n..].to_vec().into();
            let stage = match saved.modes.get(k) {
                Some(mode) => {
                    let before = (k + saved.modes.len() - 1) % saved.modes.len();
                    restored(scene, &saved.modes[before], mode, &mut struck)
                }
                None => struck(),
            };
            flights.push(OrbitArc::over(stage, [start, *span], [after, before_next]));
            start += span;
        }
        let SavedOrbit {
            n_periods,
            phase,
            spans,
            impulses,
            ..
        } = saved;
        let motion = if scene.linear_system("an orbit").is_ok() {
            let modal = ModalScene::new(scene, "an orbit")?;
            check_turns(&modal, spans.iter().sum())?;
            OrbitMotion::modal_along(Arc::new(modal), &flights)?
        } else {
            OrbitMotion::stepped(IntegratedMaps::new(scene, phase), &flights)?
        };
        let parts = OrbitData {
            pattern,
            n_periods,
            phase,
            flights,
            impulses,
            clearances: Vec::new(),
        };
        Self::moved_by(motion, scene, parts)
    }
}

/// Refuses numbers that no orbit of the scene has: a file may have been changed.
fn check(scene: &Scene, pattern: &Pattern, saved: &SavedOrbit) -> Result<()> {
    let refused = |part: &str, found: String, rule: &str| {
        Err(Error::bad_value(
            format!("{part} of the saved orbit"),
            found,
            rule,
        ))
    };
    let count = scene.stops().len();
    pattern.check(count)?;
    let SavedOrbit {
        n_periods,
        phase,
        spans,
        states,
        impulses,
        modes,
    } = saved;
    let mut numbers = spans.iter().chain(states).chain(impulses).chain([phase]);
    if let Some(x) = numbers.find(|x| !x.is_finite()) {
        return refused("a number", x.to_string(), "it must be finite");
    }
    let period: f64 = spans.iter().sum();
    if spans.iter().any(|&span| span < 0.0) || period <= 0.0 {
        let rule = "they must not be negative, nor all zero";
        return refused("spans", format!("{spans:?}"), rule);
    }
    let forcing = scene.period();
    let is_whole =
        |forcing: f64| (period / (forcing * *n_periods as f64) - 1.0).abs() <= PERIOD_TOL;
    if !forcing.is_none_or(is_whole) {
        let found = format!("n_periods = {n_periods} for a period of {period}");
        return refused(
            "the period",
            found,
            "it must be that of the forcing so many times",
        );
    }
    let stops = scene.stops();
    let is_rigid = |stop: &&usize| stops[**stop].contact().is_rigid();
    let n_struck = pattern.instants().iter().flatten().filter(is_rigid).count();
    if impulses.len() != n_struck {
        let found = format!("{} impulses", impulses.len());
        return refused("the pattern", found, &format!("it has {n_struck} impacts"));
    }
    if !modes.is_empty() && modes.len() != spans.len() {
        let found = format!("{} modes", modes.len());
        return refused("the flights", found, &format!("there are {}", spans.len()));
    }
    let begun = if modes.is_empty() {
        spans.len()
    } else {
        modes.iter().filter(|mode| mode.2).count()
    };
    // A period without instants is one flight, which begins with none.
    let n_instants = pattern.instants().len();
    if begun != n_instants && !(n_instants == 0 && spans.len() == 1) {
        let found = format!("{begun} flights that begin with an instant");
        return refused("the pattern", found, &format!("it has {n_instants}"));
    }
    for (kind, stops, _, released) in modes {
        let are_there = |regime: Regime| {
            let mut all = regime.elements().chain(*released);
            all.all(|stop| stop < count)
        };
        if !kind.read(stops).is_some_and(are_there) {
            let found = format!(
                "a {} with stops {stops:?}, released {released:?}",
                kind.name()
            );
            return refused(
                "a contact mode",
                found,
                &format!("the scene has {count} stops"),
            );
        }
    }
    Ok(())
}

impl PeriodicOrbit {
    /// Refuses an orbit that its scene cannot have: flights that do not meet, jumps of the velocity that no stop gives, impacts that are
    /// not of the motion, a period that does not close. Stops may be passed, as by orbits that are not admissible.
    ///
    /// # Errors
    /// What disagrees, with its time; what functions of the scene report.
    pub fn check_kept(&self) -> Result<()> {
        check_motion(ORBIT, self.path(), self.scene(), self.impacts())
    }
}
