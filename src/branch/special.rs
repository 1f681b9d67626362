//! Special points of a branch: where it turns, where a multiplier passes through -1, and the boundaries at which it ends.

use crate::branch::boundary::Boundary;
use crate::branch::corrector::Settled;
use crate::branch::family::Family;
use crate::branch::place::Direction;
use crate::branch::step::{Point, Target, step_to};
use crate::error::Result;
use crate::orbit::{Breach, Event, PeriodicOrbit, Rule};

/// What happens at a special point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SpecialKind {
    /// The branch turns back: two orbits meet.
    Fold,
    /// A multiplier passes through -1: an orbit of twice the period is born.
    PeriodDoubling,
    /// A stop that is not hit is touched.
    Graze,
    /// An impact has lost its speed.
    LostImpact,
    /// Two stops are hit at one instant.
    Corner,
    /// Lasting contact has no duration left.
    ChatterBorder,
}

impl SpecialKind {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fold => "fold",
            Self::PeriodDoubling => "period_doubling",
            Self::Graze => "graze",
            Self::LostImpact => "lost_impact",
            Self::Corner => "corner",
            Self::ChatterBorder => "chatter_border",
        }
    }
}

/// A special point of a branch.
#[derive(Debug, Clone)]
pub struct Special {
    /// What happens there.
    pub kind: SpecialKind,
    /// The number of the branch there.
    pub parameter: f64,
    /// How far that is known: the last correction of the search, or the width of what it was shut in.
    pub error: f64,
    /// How far along the branch it is.
    pub arclength: f64,
    /// The orbit there; of a boundary the last one before it.
    pub orbit: PeriodicOrbit,
    /// The stop that it is about.
    pub stop: Option<usize>,
    /// The time of the touch or the impact \[s\], counted from the first impact.
    pub time: Option<f64>,
}

/// Evaluations of a search, and a part of a step below which it is over.
const MOST_TRIES: usize = 40;
const SHARP: f64 = 1e-13;
/// The search is over when the number of the branch moves by no more than this part of its range.
const KNOWN: f64 = 1e-12;
/// An impact is the one that a stop is passed at if it is no farther in time than this part of the period.
const AT_IMPACT: f64 = 1e-3;

/// A zero on a step from a point.
struct Zero {
    settled: Settled,
    along: f64,
    error: f64,
}

/// The zero of a function of the branch between a point, where it has a value, and another so far along the step from it, by the method
/// of the false position in its Illinois form; none where the branch cannot be reached between.
fn zero_between(
    family: &Family<'_>,
    from: &Point,
    [length, at_start, at_end]: [f64; 3],
    of: &dyn Fn(&Settled) -> Result<f64>,
) -> Result<Option<Zero>> {
    let (mut low, mut high) = ((0.0, at_start), (length, at_end));
    let mut found: Option<Zero> = None;
    let mut side = 0;
    for _ in 0..MOST_TRIES {
        let wanted = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        let along = if wanted > low.0 && wanted < high.0 {
            wanted
        } else {
            0.5 * (low.0 + high.0)
        };
        let Ok(settled) = step_to(family, from, Target::Length(along))? else {
            break;
        };
        let value = of(&settled)?;
        let before = found.as_ref().map_or(f64::INFINITY, |zero| {
            (zero.settled.place.value - settled.place.value).abs()
        });
        let is_over = before <= KNOWN * family.span() && high.0 - low.0 < 0.5 * length
            || high.0 - low.0 <= SHARP * length
            || value == 0.0;
        found = Some(Zero {
            settled,
            along,
            error: if value == 0.0 {
                0.0
            } else {
                before.min(length * family.span())
            },
        });
        if is_over {
            break;
        }
        if (value > 0.0) == (low.1 > 0.0) {
            low = (along, value);
            if side == -1 {
                high.1 *= 0.5;
            }
            side = -1;
        } else {
            high = (along, value);
            if side == 1 {
                low.1 *= 0.5;
            }
            side = 1;
        }
    }
    Ok(found)
}

/// The special points on a step, by the tests whose signs are not the same at its ends, in their order.
pub(super) fn between(
    family: &Family<'_>,
    from: &Point,
    to: &Point,
    chord: &Direction,
) -> Result<Vec<Special>> {
    let length = from.tangent.dot(chord);
    let fold = |settled: &Settled| Ok(settled.tangent.value_part);
    let doubling = |settled: &Settled| family.multiplier_test(&settled.place, -1.0);
    let tests: [(SpecialKind, f64, f64, &dyn Fn(&Settled) -> Result<f64>); 2] = [
        (
            SpecialKind::Fold,
            from.tangent.value_part,
            to.tangent.value_part,
            &fold,
        ),
        (
            SpecialKind::PeriodDoubling,
            from.doubling,
            to.doubling,
            &doubling,
        ),
    ];
    let mut all = Vec::new();
    for (kind, at_start, at_end, of) in tests {
        if at_start * at_end >= 0.0 {
            continue;
        }
        let found = zero_between(family, from, [length, at_start, at_end], of)?;
        let special = |parameter: f64, error: f64, arclength: f64, orbit: PeriodicOrbit| Special {
            kind,
            parameter,
            error: error.max(f64::EPSILON * family.span()),
            arclength,
            orbit,
            stop: None,
            time: None,
        };
        all.push(if let Some(zero) = found {
            let (value, arclength) = (zero.settled.place.value, from.arclength + zero.along);
            let orbit = family.orbit(&zero.settled.place)?;
            special(value, zero.error, arclength, orbit)
        } else {
            // It is known to lie on the step.
            let width = (to.place.value - from.place.value).abs();
            special(to.place.value, width, to.arclength, to.orbit.clone())
        });
    }
    all.sort_by(|a, b| a.arclength.total_cmp(&b.arclength));
    Ok(all)
}

/// What a boundary is at which a branch ends, the last orbit before it at a point.
pub(super) fn of_boundary(found: &Boundary, last: &Point) -> Option<Special> {
    let Breach {
        stop, time, rule, ..
    } = found.beyond.breach()?;
    let kind = match rule {
        Rule::Pulls { .. } | Rule::Leaves { .. } => SpecialKind::LostImpact,
        Rule::Reached { .. } => SpecialKind::Corner,
        Rule::Passed if is_at_impact(&found.beyond, stop, time) => SpecialKind::LostImpact,
        Rule::Passed => SpecialKind::Graze,
        Rule::Holds { .. } => return None,
    };
    Some(Special {
        kind,
        parameter: last.place.value,
        error: found.width,
        arclength: last.arclength,
        orbit: last.orbit.clone(),
        stop: Some(stop),
        time: Some(time),
    })
}

/// Whether a stop is passed next to an impact on it, which has too little speed to leave it.
fn is_at_impact(orbit: &PeriodicOrbit, stop: usize, time: f64) -> bool {
    let period = orbit.period();
    let mut own = orbit.impacts().iter().filter(|impact| impact.stop == stop);
    own.any(|impact| {
        let off = (time - impact.time).rem_euclid(period);
        off.min(period - off) <= AT_IMPACT * period
    })
}

/// What it is where an instant comes to the one before it, at the end of a branch.
pub(super) fn of_meeting(
    family: &Family<'_>,
    last: &Point,
    (instant, error): (usize, f64),
) -> Special {
    let stages = &family.signature.stages;
    let is_held = !stages[instant].held.is_empty();
    let next = &stages[(instant + 1) % stages.len()];
    let stop = match &next.event {
        Event::Strike(stops) => stops.first().copied(),
        Event::Chatter(stop) | Event::Release(stop) => Some(*stop),
        Event::Nothing => None,
    };
    Special {
        kind: if is_held {
            SpecialKind::ChatterBorder
        } else {
            SpecialKind::Corner
        },
        parameter: last.place.value,
        error,
        arclength: last.arclength,
        orbit: last.orbit.clone(),
        stop,
        time: None,
    }
}
