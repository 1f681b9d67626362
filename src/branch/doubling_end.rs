//! The end of a doubled branch at its period doubling: both rounds of the motion become one there, and beyond it the branch would come back
//! over itself, half a period later (theory 19, "Switching").

use crate::branch::parametric_loop::{BranchDirection, ParametricLoop};
use crate::branch::predictor::{AcceptedPoint, StepTarget, step_to};
use crate::branch::problem::BranchProblem;
use crate::branch::shooting_nodes::period;
use crate::branch::special::{Special, SpecialKind};
use crate::branch::test_functions::TestFunctionValues;
use crate::branch::zero_problem::CorrectedPoint;
use crate::continuation::{ScaledDirection, attempted, corrected};
use crate::error::Result;
use crate::hybrid::carried;
use crate::itinerary::{Instant, turned};
use crate::law::Regime;
use crate::linalg::rank;
use crate::orbit::with_maps;
use crate::root::Secant;
use crate::tolerance::{
    DOUBLING_END_REACH, DOUBLING_LAST_STEP, DOUBLING_SECANT_STEP, DOUBLING_STEP_ROUNDING,
    SAME_ROUND,
};

/// Secants of the search for the doubling. `[work]`
const MOST_DOUBLING_SECANTS: usize = 20;

/// The end of a doubled branch: the doubling of the motion that both rounds become, and the last point of the branch.
pub(super) struct DoublingEnd {
    pub doubling: Special,
    pub last: AcceptedPoint,
}

/// The two rounds of a loop: its instants begun with the second round, and the chord from the loop to itself half a period later.
struct Rounds {
    second: Vec<Instant>,
    apart: BranchDirection,
}

/// The doubling between a point and a loop, if it lies between them: the difference of the two rounds has opposite directions there.
pub(super) fn doubling_end(
    problem: &BranchProblem<'_>,
    from: &AcceptedPoint,
    to: &ParametricLoop,
) -> Result<Option<DoublingEnd>> {
    let Some(before) = problem.rounds(&from.place)? else {
        return Ok(None);
    };
    let Some(after) = problem.rounds(to)? else {
        return Ok(None);
    };
    // A doubled branch whose two halves coincide is the original orbit: there is no doubling to end at.
    let is_two = before.apart.length().min(after.apart.length()) > SAME_ROUND;
    if !is_two || before.apart.dot(&after.apart) > 0.0 {
        return Ok(None);
    }
    let near = if before.apart.length() < after.apart.length() {
        (&from.place, before.second)
    } else {
        (to, after.second)
    };
    let reach = problem.between(&from.place, to).length();
    let Some((one, settled, error)) = doubling_near(problem, near, reach)? else {
        return Ok(None);
    };
    let (_, place) = one.repeated(&settled.iterate, &settled.iterate.state, &[0.0, 0.0])?;
    let along = problem.between(&from.place, &place).length();
    if along > DOUBLING_END_REACH * reach {
        return Ok(None);
    }
    let arclength = from.arclength + along;
    // At the doubling the tangent is the difference of the two rounds.
    let tangent = before.apart.unit();
    let equations = problem.equations(&place)?;
    let Ok(orbit) = attempted(problem.closed_orbit(&place), place.value)? else {
        return Ok(None);
    };
    let test_values = TestFunctionValues {
        fold: from.test_values.fold,
        crossing: from.test_values.crossing,
        ..TestFunctionValues::at(problem, (&place, &equations, &tangent), &orbit)?
    };
    let last = AcceptedPoint {
        place,
        equations,
        tangent,
        orbit,
        arclength,
        test_values,
    };
    let doubling = Special {
        orbit: one.orbit(&settled.iterate)?,
        ..Special::at(SpecialKind::PeriodDoubling, &last, error)
    };
    Ok(Some(DoublingEnd { doubling, last }))
}

impl BranchProblem<'_> {
    /// The two rounds of a loop; none if it does not consist of two with the same instants.
    fn rounds(&self, place: &ParametricLoop) -> Result<Option<Rounds>> {
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
            vec![self.half_period_later(place, instants[0].clone())?]
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

    /// Whether loops without instants are unique at their value (of linear scenes), or have no phase (without forcing).
    fn is_alone(&self, place: &ParametricLoop) -> Result<bool> {
        let scene = self.scene(place.value)?;
        Ok(self.is_free || scene.linear_system("continuation").is_ok())
    }

    /// The instant half a period after the only one of a loop in which nothing happens.
    fn half_period_later(&self, place: &ParametricLoop, instant: Instant) -> Result<Instant> {
        let scene = self.scene(place.value)?;
        let half = 0.5 * period(&place.state);
        let span = (instant.start, instant.start + half);
        let state = with_maps(&scene, &self.signature, |motion| {
            carried(motion, Regime::free(), span, &instant.state)
        })?;
        Ok(Instant { state, ..instant }.later(half))
    }
}

/// The doubling on the branch of the mean of the two rounds of a loop, no farther than some arclength: its problem, the point there, and
/// the error of the parameter.
fn doubling_near<'a>(
    problem: &BranchProblem<'a>,
    (place, second): (&ParametricLoop, Vec<Instant>),
    reach: f64,
) -> Result<Option<(BranchProblem<'a>, CorrectedPoint, f64)>> {
    let count = problem.signature.stages.len().div_ceil(2);
    let rounds = problem.instants(&place.state).into_iter().zip(second);
    let mean = rounds.take(count).map(|(a, b)| Instant {
        time: 0.5 * (a.time + b.time),
        start: 0.5 * (a.start + b.start),
        state: (a.state + b.state) * 0.5,
        stage: a.stage,
    });
    let length = (0.5 * period(&place.state), problem.signature.n_periods / 2);
    let (one, guess) = problem.with_instants(place.value, mean.collect(), length)?;
    // The guess is corrected across the branch, which may have a fold next to the doubling.
    let across = rank::weakest(&one.equations(&guess)?.all_columns(), 1)?;
    let across = BranchDirection::of(&across.column(0).into_owned());
    let Ok(base) = corrected(&one, guess, &across.unit())? else {
        return Ok(None);
    };
    let test = |there: &CorrectedPoint| one.multiplier_test((&there.iterate, None), -1.0);
    let mut secant = Secant {
        at: 0.0,
        value: test(&base)?,
    };
    let mut along = DOUBLING_SECANT_STEP;
    let mut last = f64::INFINITY;
    for _ in 0..MOST_DOUBLING_SECANTS {
        let Ok(settled) = step_to(&one, base.base(), StepTarget::Length(along))? else {
            return Ok(None);
        };
        let value = test(&settled)?;
        let step = secant.step(along, value);
        // Where steps are short, one that is no shorter than the one before is rounding.
        let is_rounding = last <= DOUBLING_STEP_ROUNDING && step.abs() >= 0.5 * last;
        if value == 0.0 || step.abs() <= DOUBLING_LAST_STEP || is_rounding {
            let error = step.abs().min(last).max(DOUBLING_LAST_STEP) * one.span();
            return Ok(Some((one, settled, error)));
        }
        last = step.abs();
        along += step;
        if along.is_nan() || along.abs() > reach {
            return Ok(None);
        }
    }
    Ok(None)
}
