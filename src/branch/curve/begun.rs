//! Where a curve begins: what holds on it, and the loop of a special point there.

use crate::branch::curve::condition::Condition;
use crate::branch::curve::plane::{Plane, RecentOfBoth, Spot};
use crate::branch::family::Family;
use crate::branch::instants::{period, turned};
use crate::branch::place::Place;
use crate::branch::special::{Special, SpecialKind};
use crate::error::{Error, Result};
use crate::model::Scene;
use crate::orbit::{Event, PeriodicOrbit};

/// A stop is hit at a corner if one of its impacts is no farther from it than this part of the period.
const AT_CORNER: f64 = 1e-6;

/// What a curve is followed from.
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

/// The plane about a special point, and its loop there.
pub(super) fn begun<'a>(
    of: CurveOf<'_>,
    make: &'a dyn Fn(f64, f64) -> Result<Scene>,
    start: [f64; 2],
    between: [(f64, f64); 2],
) -> Result<(Plane<'a>, Spot)> {
    let along = |value: f64| make(value, start[1]);
    let (whole, place) = Family::around(of.orbit(), &along, start[0], between[0])?;
    let half = || -> Result<(Family<'_>, Place)> {
        let half = whole.half(&place)?;
        half.ok_or_else(|| refused("a pitchfork of a scene that is not odd over the first number"))
    };
    let (condition, (family, place)) = match of {
        CurveOf::Orbit(_) => (Condition::Together, (whole, place)),
        CurveOf::Special(special) => match (special.kind, special.stop.zip(special.time)) {
            (SpecialKind::Fold, _) if special.direction.len() <= whole.n_unknowns(&place) => {
                (Condition::Multiplier(1.0), half()?)
            }
            (SpecialKind::Fold, _) => (Condition::Multiplier(1.0), (whole, place)),
            (SpecialKind::PeriodDoubling, _) => (Condition::Multiplier(-1.0), (whole, place)),
            (SpecialKind::Pitchfork, _) => (Condition::Multiplier(-1.0), half()?),
            (SpecialKind::Torus, _) => (Condition::OnCircle, (whole, place)),
            (SpecialKind::Graze, Some(touch)) => {
                let touched = whole.with_touch(&place, touch)?;
                let (family, place) = (touched.family, touched.place);
                (Condition::NoSpeed(touched.instant), (family, place))
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
    let plane = Plane {
        recent: RecentOfBoth::default(),
        make,
        between,
        signature: family.signature.clone(),
        phase: family.phase,
        is_free: family.is_free,
        units: family.units,
        condition,
        is_touch: of.kind() == Some(SpecialKind::Graze),
    };
    let second = start[1];
    Ok((plane, Spot { place, second }))
}

/// The refusal of what has no curve.
fn refused(what: &str) -> Error {
    let rule = "a curve there is of a fold, a period_doubling, a torus, a pitchfork, a graze, a lost_impact, a corner, or of an orbit that hits \
                stops at one instant";
    Error::bad_value("special", what, rule)
}

/// How far an instant is from a time that counts from the first, in parts of the period.
fn apart(family: &Family<'_>, place: &Place, (instant, time): (usize, f64)) -> f64 {
    let whole = period(&place.state);
    let own = family.instants(&place.state)[instant].time - place.state.times[0];
    let late = (time - own).rem_euclid(whole);
    late.min(whole - late) / whole
}

/// Whether a stop of a corner is hit there, and not only reached where another is hit.
fn is_hit(family: &Family<'_>, place: &Place, (stop, time): (usize, f64)) -> bool {
    let own = family.instant_of(place, (stop, place.state.times[0] + time));
    own.is_some_and(|instant| apart(family, place, (instant, time)) <= AT_CORNER)
}

/// The impact that is nearest to a time.
fn nearest_strike(family: &Family<'_>, place: &Place, time: f64) -> Option<usize> {
    let stages = family.signature.stages.iter().enumerate();
    let strikes = stages.filter(|(_, stage)| matches!(stage.event, Event::Strike(_)));
    let each = strikes.map(|(instant, _)| (apart(family, place, (instant, time)), instant));
    each.min_by(|a, b| a.0.total_cmp(&b.0)).map(|own| own.1)
}

/// A loop whose two stops of a corner are hit at one instant.
fn together<'a>(family: &Family<'a>, place: &Place) -> Result<Option<(Family<'a>, Place)>> {
    let mut instants = family.instants(&place.state);
    let Some(first) = place.shortest_flight() else {
        return Ok(None);
    };
    let whole = period(&place.state);
    instants = turned(instants, first, whole);
    let one = instants.remove(0);
    let (Event::Strike(mut stops), Event::Strike(others)) =
        (one.stage.event, instants[0].stage.event.clone())
    else {
        return Ok(None);
    };
    stops.extend(others);
    stops.sort_unstable();
    instants[0].stage.event = Event::Strike(stops);
    let length = (whole, family.signature.n_periods);
    family
        .with_instants(place.value, instants, length)
        .map(Some)
}
