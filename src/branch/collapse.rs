//! The end of a branch at which something vanishes: the duration of a flight or a stick, the speed of all impacts, or the motion itself.

use crate::branch::border::{border, vanishing};
use crate::branch::predictor::AcceptedPoint;
use crate::branch::problem::BranchProblem;
use crate::branch::reduced_motion::{self, LocatedBorder};
use crate::branch::special::{Special, SpecialKind, of_meeting};
use crate::continuation::{BranchEnd, EndReason};
use crate::error::{Result, digits};
use crate::tolerance::{BORDER_REACH, VANISHING_DURATION};

/// The boundary at which an instant coincides with the next one, if one is given, or at which a short flight has no duration left, if it is
/// located.
pub(super) fn meeting(
    problem: &BranchProblem<'_>,
    (last, points): (&AcceptedPoint, &[AcceptedPoint]),
    instant: Option<usize>,
    error: f64,
) -> Result<Option<Special>> {
    let (low, high) = problem.range;
    let at = |instant: usize| -> Result<(Special, bool)> {
        let met = of_meeting(problem, last, (instant, error));
        // A border that is extrapolated out of the range, or far, does not count.
        let is_near = |value: f64| {
            let off = (value - met.parameter).abs();
            (low..=high).contains(&value) && off < BORDER_REACH * problem.span()
        };
        // The error is no less than the distance by which the branch has gone past the border.
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
            let sharp = reduced_motion::border(problem, &last.place, instant)?;
            return Ok(match sharp.filter(|own| is_near(own.value)) {
                Some(LocatedBorder {
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
        let vanish = vanishing(problem, points).filter(|own| is_near(own.0));
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
            match border(problem, points, instant)?.filter(|own| is_near(own.0)) {
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
    if let Some(flight) = problem.short_flight(&last.place)
        && let (met, true) = at(flight)?
    {
        return Ok(Some(met));
    }
    instant
        .map(|instant| at(instant).map(|met| met.0))
        .transpose()
}

/// The border of a short flight after a release: its duration goes like the root of the distance, so that nothing is regular any nearer.
fn at_release(problem: &BranchProblem<'_>, last: &AcceptedPoint) -> Result<Option<Special>> {
    let state = &last.place.state;
    let whole = state.times[state.states.len()] - state.times[0];
    let flight = problem.short_flight(&last.place).filter(|&k| {
        let is_release = problem.signature.stages.departure(k).is_some();
        is_release && state.times[k + 1] - state.starts[k] < VANISHING_DURATION * whole
    });
    let none: (&AcceptedPoint, &[AcceptedPoint]) = (last, &[]);
    flight.map_or(Ok(None), |_| meeting(problem, none, None, 0.0))
}

/// The end of a branch at a point beyond which nothing is regular: the duration of a flight goes to zero, or the motion comes to rest.
pub(super) fn ended(
    problem: &BranchProblem<'_>,
    own: &AcceptedPoint,
) -> Result<Option<(BranchEnd, Option<Special>)>> {
    if let Some(met) = at_release(problem, own)? {
        let detail = format!("at {} a flight comes to nothing", digits(met.parameter));
        let end = named(BranchEnd::new(EndReason::Boundary, detail), Some(&met));
        return Ok(Some((end, Some(met))));
    }
    Ok(problem.is_at_rest(&own.place).then(|| {
        let detail = format!("the motion comes to rest at {}", digits(own.place.value));
        (BranchEnd::new(EndReason::Boundary, detail), None)
    }))
}

/// An end whose detail begins with the name of its boundary.
pub(super) fn named(end: BranchEnd, special: Option<&Special>) -> BranchEnd {
    match special {
        Some(special) => BranchEnd {
            detail: format!("{}: {}", special.kind.name(), end.detail),
            ..end
        },
        None => end,
    }
}
