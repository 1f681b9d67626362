//! The first point of a curve: the condition that holds on it, and the loop of the special point.

use crate::branch::curve::condition::Condition;
use crate::branch::curve::problem::{CurveProblem, RecentScenesOfBoth, TwoParameterLoop};
use crate::branch::parametric_loop::ParametricLoop;
use crate::branch::problem::BranchProblem;
use crate::branch::shooting_nodes::period;
use crate::branch::special::{Special, SpecialKind};
use crate::error::{Error, Result};
use crate::itinerary::turned;
use crate::model::Scene;
use crate::orbit::PeriodicOrbit;
use crate::tolerance::HIT_AT_CORNER;

/// The special point or the orbit from which a curve is followed.
#[derive(Debug, Clone, Copy)]
pub enum CurveOf<'a> {
    /// A special point of a branch.
    Special(&'a Special),
    /// An orbit that hits stops at one instant.
    Orbit(&'a PeriodicOrbit),
}

impl CurveOf<'_> {
    /// Its orbit.
    pub fn orbit(&self) -> &PeriodicOrbit {
        match self {
            Self::Special(special) => &special.orbit,
            Self::Orbit(orbit) => orbit,
        }
    }

    pub(super) fn kind(&self) -> Option<SpecialKind> {
        match self {
            Self::Special(special) => Some(special.kind),
            Self::Orbit(_) => None,
        }
    }
}

/// The problem of the curve through a special point, and its loop there.
pub(super) fn begun<'a>(
    of: CurveOf<'_>,
    make: &'a dyn Fn(f64, f64) -> Result<Scene>,
    start: [f64; 2],
    between: [(f64, f64); 2],
) -> Result<(CurveProblem<'a>, TwoParameterLoop)> {
    let along = |value: f64| make(value, start[1]);
    let (whole, place) = BranchProblem::around(of.orbit(), &along, start[0], between[0])?;
    let half = || -> Result<(BranchProblem<'_>, ParametricLoop)> {
        let half = whole.half(&place)?;
        half.ok_or_else(|| refused("a pitchfork of a scene that is not odd over the first number"))
    };
    let (condition, (problem, place)) = match of {
        CurveOf::Orbit(_) => (Condition::Together, (whole, place)),
        CurveOf::Special(special) => match (special.kind, special.stop.zip(special.time)) {
            (SpecialKind::Fold, _) if special.direction.len() <= whole.n_unknowns(&place) => {
                (Condition::Multiplier(1.0), half()?)
            }
            (SpecialKind::Fold, _) => (Condition::Multiplier(1.0), (whole, place)),
            (SpecialKind::PeriodDoubling, _) => (Condition::Multiplier(-1.0), (whole, place)),
            (SpecialKind::Pitchfork, _) => (Condition::Multiplier(-1.0), half()?),
            (SpecialKind::Torus, _) => (Condition::OnCircle, (whole, place)),
            (kind, Some(touch)) if is_touched(&whole, &place, (kind, touch.0))? => {
                let touched = whole.with_touch(&place, touch)?;
                let (problem, place) = (touched.problem, touched.place);
                (Condition::NoSpeed(touched.instant), (problem, place))
            }
            (SpecialKind::LostImpact, Some(touch)) => {
                let instant = whole.instant_of(&place, touch);
                let instant =
                    instant.ok_or_else(|| refused("a lost impact that the orbit has not"))?;
                (Condition::NoSpeed(instant), (whole, place))
            }
            (SpecialKind::Corner, Some(touch)) if !is_hit(&whole, &place, touch) => {
                let instant = nearest_strike(&whole, &place, touch.1);
                let instant = instant.ok_or_else(|| refused("a corner without an impact"))?;
                let stop = touch.0;
                (Condition::Reached { stop, instant }, (whole, place))
            }
            (SpecialKind::Corner, _) => {
                let together = together(&whole, &place)?;
                let together = together.ok_or_else(|| {
                    refused("a corner of impacts that are not next to each other")
                })?;
                (Condition::Together, together)
            }
            (kind, _) => return Err(refused(&format!("a {}", kind.name()))),
        },
    };
    let is_touch = match condition {
        Condition::NoSpeed(k) => {
            let touched = problem.signature.stages[k].transition.touched();
            of.kind() == Some(SpecialKind::Graze) || touched.is_some()
        }
        _ => false,
    };
    let plane = CurveProblem {
        recent: RecentScenesOfBoth::default(),
        make,
        between,
        signature: problem.signature.clone(),
        phase: problem.phase,
        is_free: problem.is_free,
        units: problem.units,
        condition,
        is_touch,
    };
    let second = start[1];
    Ok((plane, TwoParameterLoop { place, second }))
}

/// Whether the orbit of a special point of a kind touches its stop: where the contact with one that gives way comes to its end it does.
fn is_touched(
    problem: &BranchProblem<'_>,
    place: &ParametricLoop,
    (kind, stop): (SpecialKind, usize),
) -> Result<bool> {
    Ok(match kind {
        SpecialKind::Touch | SpecialKind::BorderCollision | SpecialKind::Graze => true,
        SpecialKind::LostImpact => !problem.is_rigid_at(place, stop)?,
        _ => false,
    })
}

/// The refusal of a special point that has no curve.
fn refused(what: &str) -> Error {
    let rule = "a curve there is of a fold, a period_doubling, a torus, a pitchfork, a touch, a border_collision, a graze, a lost_impact, a corner, or of an orbit that hits \
                stops at one instant";
    Error::bad_value("special", what, rule)
}

/// The difference between an instant and a time that counts from the first one, in parts of the period \[-\].
fn apart(
    problem: &BranchProblem<'_>,
    place: &ParametricLoop,
    (instant, time): (usize, f64),
) -> f64 {
    let whole = period(&place.state);
    let own = problem.instants(&place.state)[instant].time - place.state.times[0];
    let late = (time - own).rem_euclid(whole);
    late.min(whole - late) / whole
}

/// Whether a stop of a corner is hit there, not only reached where another is hit.
fn is_hit(problem: &BranchProblem<'_>, place: &ParametricLoop, (stop, time): (usize, f64)) -> bool {
    let own = problem.instant_of(place, (stop, place.state.times[0] + time));
    own.is_some_and(|instant| apart(problem, place, (instant, time)) <= HIT_AT_CORNER)
}

/// The impact that is nearest to a time.
fn nearest_strike(problem: &BranchProblem<'_>, place: &ParametricLoop, time: f64) -> Option<usize> {
    let strikes = problem.signature.stages.impacts();
    let each = strikes.map(|instant| (apart(problem, place, (instant, time)), instant));
    each.min_by(|a, b| a.0.total_cmp(&b.0)).map(|own| own.1)
}

/// A loop in which both stops of a corner are hit at one instant, and its problem.
fn together<'a>(
    problem: &BranchProblem<'a>,
    place: &ParametricLoop,
) -> Result<Option<(BranchProblem<'a>, ParametricLoop)>> {
    let mut instants = problem.instants(&place.state);
    let Some(first) = place.shortest_flight() else {
        return Ok(None);
    };
    let whole = period(&place.state);
    instants = turned(instants, first, whole);
    let one = instants.remove(0);
    let next = &mut instants[0].stage.transition;
    let Some(both) = one.stage.transition.together(next) else {
        return Ok(None);
    };
    *next = both;
    let length = (whole, problem.signature.n_periods);
    problem
        .with_instants(place.value, instants, length)
        .map(Some)
}
