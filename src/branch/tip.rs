//! The tip of a branch that was doubled: there both rounds of the motion become one, and beyond it the branch would come back over
//! itself, half a period later (theory 19, "Switching").

use crate::branch::corrector::{Settled, attempted};
use crate::branch::family::Family;
use crate::branch::indicators::Indicators;
use crate::branch::instants::{Instant, period, turned};
use crate::branch::place::{Direction, Place};
use crate::branch::special::{Special, SpecialKind};
use crate::branch::step::{Point, Target, step_to};
use crate::error::Result;
use crate::linalg::rank;
use crate::orbit::with_shooting;
use crate::tolerance::SAME_ROUND;
use nalgebra::DMatrix;

/// The second place of the secant method to the doubling, in arclength, and a step below which one is the last.
const BESIDE: f64 = 1e-6;
const KNOWN: f64 = 1e-12;
/// Steps as short as this are rounding where they become no shorter.
const ROUGHLY: f64 = 1e-8;
const MOST_STEPS: usize = 20;
/// The tip of a step is no farther from its start than this part of it.
const FARTHEST: f64 = 1.5;

/// A tip: the doubling of the motion that both rounds become, and the last point of the branch.
pub(super) struct Tip {
    pub doubling: Special,
    pub last: Point,
}

/// The instants of a loop of two rounds, its second round as the first, and the way to that.
struct Rounds {
    second: Vec<Instant>,
    apart: Direction,
}

/// The tip between a point and a place, if these are on both sides of one: from one to the other the rounds change their roles.
pub(super) fn tip(family: &Family<'_>, from: &Point, to: &Place) -> Result<Option<Tip>> {
    let Some(before) = family.rounds(&from.place)? else {
        return Ok(None);
    };
    let Some(after) = family.rounds(to)? else {
        return Ok(None);
    };
    // Of one round that is gone through twice nothing is doubled.
    let is_two = before.apart.length().min(after.apart.length()) > SAME_ROUND;
    if !is_two || before.apart.dot(&after.apart) > 0.0 {
        return Ok(None);
    }
    let near = if before.apart.length() < after.apart.length() {
        (&from.place, before.second)
    } else {
        (to, after.second)
    };
    let reach = family.between(&from.place, to).length();
    let Some((one, settled, error)) = doubling_near(family, near, reach)? else {
        return Ok(None);
    };
    let (_, place) = one.repeated(&settled.place, &settled.place.state, &[0.0, 0.0])?;
    let along = family.between(&from.place, &place).length();
    if along > FARTHEST * reach {
        return Ok(None);
    }
    let arclength = from.arclength + along;
    // The rounds come to each other along what parts them.
    let tangent = before.apart.scaled(1.0 / before.apart.length());
    let equations = family.equations(&place)?;
    let Ok(orbit) = attempted(family.closed_orbit(&place), place.value)? else {
        return Ok(None);
    };
    let indicators = Indicators {
        fold: from.indicators.fold,
        crossing: from.indicators.crossing,
        ..Indicators::at(family, (&place, &equations, &tangent), &orbit)?
    };
    let last = Point {
        place,
        equations,
        tangent,
        orbit,
        arclength,
        indicators,
    };
    let doubling = Special {
        orbit: one.orbit(&settled.place)?,
        ..Special::at(SpecialKind::PeriodDoubling, &last, error)
    };
    Ok(Some(Tip { doubling, last }))
}

impl Family<'_> {
    /// The rounds of a loop that may be two; none of one that has not two alike.
    fn rounds(&self, place: &Place) -> Result<Option<Rounds>> {
        let (stages, n_periods) = (&self.signature.stages, self.signature.n_periods);
        let own = stages.len() / 2;
        let is_even = self.is_free || n_periods.is_multiple_of(2);
        let is_alike = self.is_empty() || stages[..own] == stages[own..];
        let is_whole = self.signature.images.is_none();
        if !(is_even && is_alike && is_whole) || self.is_empty() && self.is_alone(place)? {
            return Ok(None);
        }
        let whole = period(&place.state);
        let instants = self.instants(&place.state);
        let second: Vec<Instant> = if self.is_empty() {
            vec![self.half_way(place, instants[0].clone())?]
        } else {
            turned(instants, own, whole)
        };
        let second: Vec<Instant> = second
            .into_iter()
            .map(|own| own.later(-0.5 * whole))
            .collect();
        let (_, late) = self.with_instants(place.value, second.clone(), (whole, n_periods))?;
        let apart = self.between(place, &late);
        Ok(Some(Rounds { second, apart }))
    }

    /// Whether loops in which nothing happens are alone at their value, or have no phase of their own.
    fn is_alone(&self, place: &Place) -> Result<bool> {
        let scene = self.scene(place.value)?;
        Ok(self.is_free || scene.linear_system("continuation").is_ok())
    }

    /// The instant half a period after that of a loop in which nothing happens.
    fn half_way(&self, place: &Place, instant: Instant) -> Result<Instant> {
        let scene = self.scene(place.value)?;
        let half = 0.5 * period(&place.state);
        let mut state = instant.state.clone();
        let span = (instant.start, instant.start + half);
        with_shooting(&scene, &self.signature, |shooting, _| {
            let none = &mut DMatrix::zeros(state.len(), 0);
            shooting.motion.flow(&[], span, &mut state, none)
        })?;
        Ok(Instant { state, ..instant }.later(half))
    }
}

/// The doubling of the motion that is the mean of the two rounds of a loop, no farther than some arclength: its family, the motion there, and how
/// far the number is known.
fn doubling_near<'a>(
    family: &Family<'a>,
    (place, second): (&Place, Vec<Instant>),
    reach: f64,
) -> Result<Option<(Family<'a>, Settled, f64)>> {
    let count = family.signature.stages.len().div_ceil(2);
    let rounds = family.instants(&place.state).into_iter().zip(second);
    let mean = rounds.take(count).map(|(a, b)| Instant {
        time: 0.5 * (a.time + b.time),
        start: 0.5 * (a.start + b.start),
        state: (a.state + b.state) * 0.5,
        stage: a.stage,
    });
    let length = (0.5 * period(&place.state), family.signature.n_periods / 2);
    let (one, guess) = family.with_instants(place.value, mean.collect(), length)?;
    // Across its branch, which may have a fold next to the doubling.
    let across = rank::weakest(&one.equations(&guess)?.all_columns(), 1)?;
    let across = Direction::of(&across.column(0).into_owned());
    let Ok(foot) = one.corrected(guess, &across.scaled(1.0 / across.length()))? else {
        return Ok(None);
    };
    let test = |there: &Settled| one.multiplier_test((&there.place, None), -1.0);
    let (mut before, mut along) = ((0.0, test(&foot)?), BESIDE);
    let mut last = f64::INFINITY;
    for _ in 0..MOST_STEPS {
        let from = (&foot.place, &foot.equations, &foot.tangent);
        let Ok(settled) = step_to(&one, from, Target::Length(along))? else {
            return Ok(None);
        };
        let value = test(&settled)?;
        let step = -value * (along - before.0) / (value - before.1);
        // A step that is no shorter than the one before is rounding, where both are short.
        let is_rounding = last <= ROUGHLY && step.abs() >= 0.5 * last;
        if value == 0.0 || step.abs() <= KNOWN || is_rounding {
            let error = step.abs().min(last).max(KNOWN) * one.span();
            return Ok(Some((one, settled, error)));
        }
        (before, last) = ((along, value), step.abs());
        along += step;
        if along.is_nan() || along.abs() > reach {
            return Ok(None);
        }
    }
    Ok(None)
}
