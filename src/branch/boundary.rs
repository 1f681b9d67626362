//! Where a branch comes to a boundary, beyond which its orbits break a rule of contact: between a point that keeps them and one that does
//! not, by what is zero there, and by halves.

use crate::branch::corrector::{Attempt, Settled, attempted};
use crate::branch::family::Family;
use crate::branch::place::Place;
use crate::branch::risen::strongest_pull;
use crate::branch::special::{BreachKind, Special, SpecialKind, breach_kind, of_boundary};
use crate::branch::step::{Point, Target, step_to};
use crate::branch::zero::{Tried, Zero, zero_between};
use crate::error::Result;
use crate::orbit::{PeriodicOrbit, Touch};

/// Halvings of a step.
const MOST_HALVINGS: usize = 60;
/// Behind an impact without speed a stop is passed by the third power of the acceleration: where that changes its sign is known to this
/// part of the range by the passage.
const LANDED: f64 = 1e-4;
/// A boundary is known when it lies between points no farther apart than this, in arclength.
const KNOWN: f64 = 1e-11;
/// A stop is passed at a touch if it is so near to it, in parts of the period.
const AT_TOUCH: f64 = 1e-3;
/// How much farther from where a boundary was expected it is looked for each time.
const FARTHER: f64 = 16.0;

/// What lies on both sides of a boundary on a step: the point nearest to it on the side of the step's beginning, the orbit on the other.
pub(super) struct Boundary {
    pub last: Option<(Settled, PeriodicOrbit)>,
    pub other: PeriodicOrbit,
    /// By how much the number of the branch differs between them.
    pub width: f64,
    /// How much of the step is left between them where the branch was lost there: from the last point it may be found again.
    pub left: Option<f64>,
    /// Of a graze the value at which the stop is touched, how far that is known, and the orbit.
    touch: Option<(f64, f64, PeriodicOrbit)>,
}

impl Boundary {
    /// What it is, by the orbit that breaks a rule, next to a point; with the unit of velocities.
    pub fn special(&self, broken: &PeriodicOrbit, at: &Point, speed: f64) -> Option<Special> {
        let own = of_boundary(broken, at, self.width, speed)?;
        Some(match &self.touch {
            Some((parameter, error, orbit)) => Special {
                parameter: *parameter,
                error: *error,
                orbit: orbit.clone(),
                ..own
            },
            None => own,
        })
    }
}

/// Whether an orbit breaks a rule of contact.
pub(super) fn is_broken(orbit: &PeriodicOrbit) -> bool {
    orbit.is_admissible() == Some(false)
}

/// Comes nearer to a boundary that lies within a step from a point.
pub(super) fn located(
    family: &Family<'_>,
    from: &Point,
    step: f64,
    (there, other): (&Place, PeriodicOrbit),
) -> Result<Boundary> {
    let was_broken = is_broken(&from.orbit);
    let (mut low, mut high) = (0.0, step);
    let (mut before, mut behind) = (from.place.value, there.value);
    let mut there = there.clone();
    let mut found = Boundary {
        last: None,
        other,
        width: 0.0,
        left: None,
        touch: None,
    };
    let mut beside = [0.25 * KNOWN; 2];
    let mut expected: Option<Expected> = None;
    for _ in 0..MOST_HALVINGS {
        if high - low <= KNOWN {
            break;
        }
        if expected.is_none() {
            let last = found.last.as_ref();
            let last = last.map_or((&from.place, &from.orbit), |(own, orbit)| {
                (&own.place, orbit)
            });
            let ends = [last, (&there, &found.other)];
            expected = zero_of_breach(family, from, [low, high], ends)?;
        }
        let root = expected.as_ref().map(|zero| zero.along);
        let middle = aimed(root, [low, high], &mut beside);
        let tried: Attempt<Settled> = step_to(family, from.foot(), Target::Length(middle));
        let Ok(settled) = tried? else {
            found.left = Some(high - low);
            break;
        };
        let value = settled.place.value;
        let Ok(orbit) = attempted(family.closed_orbit(&settled.place), value)? else {
            found.left = Some(high - low);
            break;
        };
        if is_broken(&orbit) == was_broken {
            (low, before, found.last) = (middle, value, Some((settled, orbit)));
        } else {
            (high, behind, found.other) = (middle, value, orbit);
            there = settled.place;
        }
    }
    found.width = (before - behind).abs();
    let kept = found.last.as_ref().map_or(&from.orbit, |(_, orbit)| orbit);
    let breach = between(family, [kept, &found.other]);
    let Some(BreachKind {
        kind, stop, time, ..
    }) = breach
    else {
        return Ok(found);
    };
    // The touch itself, before what is seen to pass, which is more than rounding.
    let is_near =
        |own: &Touch| own.stop == stop && (own.time - time).abs() <= AT_TOUCH * kept.period();
    let is_touch = |zero: &Expected| {
        let touches = zero
            .point
            .1
            .as_ref()
            .map_or(&[][..], PeriodicOrbit::touches);
        kind == SpecialKind::Graze && zero.along <= high && touches.iter().any(is_near)
    };
    if let Some(Zero {
        point: (settled, Some(orbit)),
        error,
        ..
    }) = expected.filter(is_touch)
    {
        let error = error.max(f64::EPSILON * family.span());
        found.touch = Some((settled.place.value, error, orbit));
        return Ok(found);
    }
    let landing = family.instant_of(&from.place, (stop, from.place.state.times[0] + time));
    let sharp = match (kind, landing) {
        (SpecialKind::LandingBorder, Some(k)) => zero_of(family, from, step, &|there| {
            family.opening(there, k).map(Some)
        })?,
        (SpecialKind::Rise, _) => zero_of(family, from, step, &|there| {
            Ok(strongest_pull(family, there, (stop, time))?.map(|pull| pull.most))
        })?,
        _ => None,
    };
    if let Some((there, error)) = sharp {
        (found.last, found.width) = (Some(there), error);
    } else if breach.is_some_and(|own| own.is_by_cube) {
        found.width = LANDED * family.span();
    }
    Ok(found)
}

/// What the boundary is between two orbits, of which one breaks a rule.
fn between(family: &Family<'_>, [one, other]: [&PeriodicOrbit; 2]) -> Option<BreachKind> {
    let (broken, kept) = if is_broken(one) {
        (one, other)
    } else {
        (other, one)
    };
    breach_kind(broken, kept, family.units.velocity)
}

/// A point where a boundary is expected, and of one that touches a stop the orbit.
type Expected = Zero<(Settled, Option<PeriodicOrbit>)>;

/// Where between two lengths of a step a boundary is expected, by what is zero there: the speed of an impact, the gap at a touch. None where
/// it is not seen at both.
fn zero_of_breach(
    family: &Family<'_>,
    from: &Point,
    [low, high]: [f64; 2],
    [one, other]: [(&Place, &PeriodicOrbit); 2],
) -> Result<Option<Expected>> {
    let Some(breach) = between(family, [one.1, other.1]) else {
        return Ok(None);
    };
    let (stop, time) = (breach.stop, breach.time);
    let struck = family.instant_of(&from.place, (stop, from.place.state.times[0] + time));
    let speed = |place: &Place| struck.map(|k| family.approach(place, k)).transpose();
    let broken = if is_broken(other.1) { other.1 } else { one.1 };
    let touched = broken.place_on_flight(time);
    let gap = |orbit: &PeriodicOrbit| orbit.least_gap_near(stop, touched);
    let ends = match breach.kind {
        SpecialKind::LostImpact => [speed(one.0)?, speed(other.0)?],
        SpecialKind::Graze => [gap(one.1)?, gap(other.1)?],
        _ => return Ok(None),
    };
    let [Some(before), Some(after)] = ends else {
        return Ok(None);
    };
    if before * after >= 0.0 {
        return Ok(None);
    }
    let mut point = |along: f64| {
        let Ok(settled) = step_to(family, from.foot(), Target::Length(low + along))? else {
            return Ok(None);
        };
        let (value, orbit) = if breach.kind == SpecialKind::Graze {
            let Ok(orbit) = attempted(family.closed_orbit(&settled.place), settled.place.value)?
            else {
                return Ok(None);
            };
            (gap(&orbit)?, Some(orbit))
        } else {
            (speed(&settled.place)?, None)
        };
        Ok(value.map(|value| Tried {
            parameter: settled.place.value,
            value,
            point: (settled, orbit),
        }))
    };
    let zero = zero_between([high - low, before, after], family.span(), &mut point)?;
    Ok(zero.map(|zero| Zero {
        along: low + zero.along,
        ..zero
    }))
}

/// Where between two ends to look next: beside the place that is expected, on the side of the farther end, each time farther from it; in the
/// middle where none is, or no more.
fn aimed(root: Option<f64>, [low, high]: [f64; 2], beside: &mut [f64; 2]) -> f64 {
    let aimed = root.map(|root| {
        let side = usize::from(root - low < high - root);
        let off = beside[side];
        beside[side] *= FARTHER;
        if side == 0 { root - off } else { root + off }
    });
    aimed
        .filter(|along| low < *along && *along < high)
        .unwrap_or(0.5 * (low + high))
}

/// Where a number of a loop is zero on a step, or on as long a one before it, where rules are broken by less than is seen; and how far that is
/// known. None where it does not change its sign.
fn zero_of(
    family: &Family<'_>,
    from: &Point,
    step: f64,
    of: &dyn Fn(&Place) -> Result<Option<f64>>,
) -> Result<Option<((Settled, PeriodicOrbit), f64)>> {
    let at = |along: f64| -> Result<Option<Tried<Settled>>> {
        let Ok(settled) = step_to(family, from.foot(), Target::Length(along))? else {
            return Ok(None);
        };
        let value = of(&settled.place)?;
        Ok(value.map(|value| Tried {
            parameter: settled.place.value,
            value,
            point: settled,
        }))
    };
    let value = |along: f64| at(along).map(|there| there.map(|there| there.value));
    for begin in [0.0, -step] {
        let (Some(before), Some(after)) = (value(begin)?, value(begin + step)?) else {
            continue;
        };
        if before * after >= 0.0 {
            continue;
        }
        let mut point = |along: f64| at(begin + along);
        let zero = zero_between([step, before, after], family.span(), &mut point)?;
        let Some(zero) = zero else {
            return Ok(None);
        };
        let value = zero.point.place.value;
        let orbit = attempted(family.closed_orbit(&zero.point.place), value)?.ok();
        return Ok(orbit.map(|orbit| ((zero.point, orbit), zero.error)));
    }
    Ok(None)
}
