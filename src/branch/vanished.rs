//! Where a branch comes to its end because something comes to nothing: a flight, a stay, the motion.

use crate::branch::border::{border, vanishing};
use crate::branch::end::{BranchEnd, EndReason};
use crate::branch::family::Family;
use crate::branch::lessened::{self, Sharp};
use crate::branch::special::{Special, SpecialKind, of_meeting};
use crate::branch::step::Point;
use crate::error::{Result, digits};
use crate::orbit::Event;

/// A flight behind a release that is shorter than this part of the period is followed no farther.
const LOW: f64 = 1e-3;
/// A boundary that is extrapolated is no farther from the last point than this part of the range.
const NEAR: f64 = 1e-2;
/// A motion of so small a part of the unit of speeds has come to rest.
const AT_REST: f64 = 1e-4;

/// The boundary at which an instant comes to the one before it, if one does, or a flight from a stop to nothing, where it is seen to.
pub(super) fn meeting(
    family: &Family<'_>,
    (last, points): (&Point, &[Point]),
    instant: Option<usize>,
    error: f64,
) -> Result<Option<Special>> {
    let (low, high) = family.range;
    let at = |instant: usize| -> Result<(Special, bool)> {
        let met = of_meeting(family, last, (instant, error));
        // What is extrapolated out of the range, or far, is none.
        let is_near = |value: f64| {
            let off = (value - met.parameter).abs();
            (low..=high).contains(&value) && off < NEAR * family.span()
        };
        // What the branch has gone past is not known better than that.
        let passed = |value: f64| {
            let off = value - last.place.value;
            if off * last.tangent.value_part < 0.0 {
                off.abs()
            } else {
                0.0
            }
        };
        let is_of_flight = matches!(
            met.kind,
            SpecialKind::LandingBorder | SpecialKind::ReleaseBorder
        );
        if is_of_flight {
            let sharp = lessened::border(family, &last.place, instant)?;
            return Ok(match sharp.filter(|own| is_near(own.value)) {
                Some(Sharp {
                    value,
                    error,
                    orbit,
                }) => {
                    let met = Special {
                        parameter: value,
                        error: error.max(passed(value)),
                        orbit,
                        ..met
                    };
                    (met, true)
                }
                None => (met, false),
            });
        }
        let vanish = vanishing(family, points).filter(|own| is_near(own.0));
        if let Some((parameter, error)) = vanish {
            let met = Special {
                kind: SpecialKind::VanishingImpacts,
                parameter,
                error: error.max(passed(parameter)),
                ..met
            };
            return Ok((met, true));
        }
        Ok(
            match border(family, points, instant)?.filter(|own| is_near(own.0)) {
                Some((parameter, error)) => {
                    let met = Special {
                        parameter,
                        error: error.max(passed(parameter)),
                        ..met
                    };
                    (met, true)
                }
                None => (met, false),
            },
        )
    };
    if let Some(flight) = family.short_flight(&last.place)
        && let (met, true) = at(flight)?
    {
        return Ok(Some(met));
    }
    instant
        .map(|instant| at(instant).map(|met| met.0))
        .transpose()
}

/// The border of a flight behind a release that is nearly nothing: its end goes like the root of the distance, and nearer nothing is regular.
fn at_release(family: &Family<'_>, last: &Point) -> Result<Option<Special>> {
    let state = &last.place.state;
    let whole = state.times[state.states.len()] - state.times[0];
    let flight = family.short_flight(&last.place).filter(|&k| {
        let is_release = matches!(family.signature.stages[k].event, Event::Release(_));
        is_release && state.times[k + 1] - state.starts[k] < LOW * whole
    });
    let none: (&Point, &[Point]) = (last, &[]);
    flight.map_or(Ok(None), |_| meeting(family, none, None, 0.0))
}

/// The end of a branch at a point beyond which nothing is regular: a flight that comes to nothing, or a motion that comes to rest.
pub(super) fn ended(
    family: &Family<'_>,
    own: &Point,
) -> Result<Option<(BranchEnd, Option<Special>)>> {
    if let Some(met) = at_release(family, own)? {
        let detail = format!("at {} a flight comes to nothing", digits(met.parameter));
        let end = named(BranchEnd::new(EndReason::Boundary, detail), Some(&met));
        return Ok(Some((end, Some(met))));
    }
    Ok(is_at_rest(family, own).then(|| {
        let detail = format!("the motion comes to rest at {}", digits(own.place.value));
        (BranchEnd::new(EndReason::Boundary, detail), None)
    }))
}

/// Whether nothing is left of a motion that keeps its energy.
fn is_at_rest(family: &Family<'_>, own: &Point) -> bool {
    let fastest = own.place.state.states.iter().map(|x| {
        let n = x.len() / 2;
        x.rows(n, n).amax()
    });
    family.energetics.is_some() && fastest.fold(0.0, f64::max) <= AT_REST * family.units.velocity
}

/// An end with the name of the boundary that it is.
pub(super) fn named(end: BranchEnd, special: Option<&Special>) -> BranchEnd {
    match special {
        Some(special) => BranchEnd {
            detail: format!("{}: {}", special.kind.name(), end.detail),
            ..end
        },
        None => end,
    }
}
