//! Smooth bifurcations on a step of a branch: test functions that change their sign, and the location of their zeros (theory 19).
//!
//! A fold is where the part of the unit tangent in the parameter changes its sign; the functions of other kinds stand beside it in
//! `test_functions.rs`. The signs at the two ends of an accepted step are compared, so that two changes of one function within a step are
//! not seen. A zero is located on the branch by false position (`continuation/locator.rs`), until the parameter moves by no more than
//! `ZERO_PARAMETER_CHANGE` of its range and the function is below `ZERO_VALUE` of its values at the ends, or until the bracket is shorter
//! than `ZERO_BRACKET_LENGTH` of the step. Where it is known worse than [`WELL_LOCATED_BIFURCATION`], of any kind but a torus, it is
//! interpolated as well (`interpolation_locator.rs`), and the smaller error decides; at a branch point it always is, and the interpolation
//! goes first.

use crate::branch::crossings::has_multiplier;
use crate::branch::interpolation_locator::locate_by_interpolation;
use crate::branch::predictor::AcceptedPoint;
use crate::branch::problem::BranchProblem;
use crate::branch::special::{Special, SpecialKind};
use crate::branch::test_functions;
use crate::branch::zero_problem::CorrectedPoint;
use crate::continuation::{LocatedZero, evaluated, locate_zero};
use crate::error::Result;
use crate::tolerance::{TORUS_ON_CIRCLE, WELL_LOCATED_BIFURCATION};
use nalgebra::Complex;
use std::f64::consts::TAU;

/// The bifurcations on a step of some arclength, by the test functions whose signs differ at its ends, in their order.
pub(super) fn bifurcations(
    problem: &BranchProblem<'_>,
    from: &AcceptedPoint,
    to: &AcceptedPoint,
    length: f64,
) -> Result<Vec<Special>> {
    let (a, b) = (&from.test_values, &to.test_values);
    let fold = |settled: &CorrectedPoint| Ok(test_functions::fold(&settled.tangent));
    let doubling =
        |settled: &CorrectedPoint| problem.multiplier_test((&settled.iterate, None), -1.0);
    let crossing = |settled: &CorrectedPoint| Ok(settled.equations.crossing(&settled.tangent));
    let is_half = problem.signature.images.is_some();
    let doubled = if is_half {
        SpecialKind::Pitchfork
    } else {
        SpecialKind::PeriodDoubling
    };
    let tests: [(SpecialKind, [f64; 2], TestFunction<'_>); 3] = [
        (SpecialKind::Fold, [a.fold, b.fold], &fold),
        (doubled, [a.doubling, b.doubling], &doubling),
        (
            SpecialKind::BranchPoint,
            [a.crossing, b.crossing],
            &crossing,
        ),
    ];
    let mut all = Vec::new();
    for (kind, [at_start, at_end], of) in tests {
        if at_start * at_end < 0.0 {
            let ends = [length, at_start, at_end];
            let found = located(problem, (from, to, kind), ends, of)?;
            if kind != SpecialKind::PeriodDoubling || has_multiplier(problem, &found, -1.0)? {
                all.push(found);
            }
        }
    }
    if let (true, Some(one), Some(other)) = (all.is_empty(), a.outside, b.outside)
        && one.abs_diff(other) == 2
    {
        all.extend(torus(problem, (from, to), (length, one))?);
    }
    all.sort_by(|a, b| a.arclength.total_cmp(&b.arclength));
    Ok(all)
}

/// A test function at a point of a step.
type TestFunction<'a> = &'a dyn Fn(&CorrectedPoint) -> Result<f64>;

/// The zero of a test function on a step, as a special point; `between` is the step's length and the values at its ends.
fn located(
    problem: &BranchProblem<'_>,
    (from, to, kind): (&AcceptedPoint, &AcceptedPoint, SpecialKind),
    between: [f64; 3],
    of: TestFunction<'_>,
) -> Result<Special> {
    let mut point = |along: f64| {
        evaluated(problem, from.base(), along, |settled| {
            Ok(Some((settled.iterate.value, of(settled)?)))
        })
    };
    let found = locate_zero(between, problem.span(), &mut point)?;
    // Next to a branch point the corrector fails, or its points are not known well.
    let is_beside_crossing = kind == SpecialKind::BranchPoint
        || kind != SpecialKind::Torus
            && found
                .as_ref()
                .is_none_or(|own| own.error > WELL_LOCATED_BIFURCATION * problem.span());
    let through = if is_beside_crossing {
        let near = found.as_ref().map_or(0.5 * between[0], |own| own.along);
        locate_by_interpolation(problem, from, near, of)?
    } else {
        None
    };
    let found = if kind == SpecialKind::BranchPoint {
        through.or(found)
    } else {
        let both = through.into_iter().chain(found);
        both.min_by(|a, b| a.error.total_cmp(&b.error))
    };
    let Some(LocatedZero {
        point: settled,
        along,
        error,
    }) = found
    else {
        // Nothing more is known than that it lies on the step.
        let width = (to.place.value - from.place.value).abs();
        return Ok(Special::at(kind, to, width));
    };
    let point = AcceptedPoint {
        orbit: problem.orbit(&settled.iterate)?,
        place: settled.iterate,
        equations: settled.equations,
        tangent: settled.tangent,
        arclength: from.arclength + along,
        test_values: from.test_values,
    };
    let error = error.max(f64::EPSILON * problem.span());
    Ok(Special::at(kind, &point, error))
}

/// The torus bifurcation on a step before which a number of multipliers is outside; none where the two that cross are real there.
fn torus(
    problem: &BranchProblem<'_>,
    (from, to): (&AcceptedPoint, &AcceptedPoint),
    (length, before): (f64, usize),
) -> Result<Option<Special>> {
    let off = |settled: &CorrectedPoint| -> Result<f64> {
        let (size, outside) = problem.off_circle(&settled.iterate, None)?;
        Ok(if outside == Some(before) { -size } else { size })
    };
    let [at_start, at_end] = [from, to].map(|own| problem.off_circle(&own.place, Some(&own.orbit)));
    let between = [length, -at_start?.0, at_end?.0];
    let found = located(problem, (from, to, SpecialKind::Torus), between, &off)?;
    let pair = problem.pair_at_circle(&found.orbit, found.parameter)?;
    Ok(on_circle(found, pair))
}

/// The torus with its rotation number, if a multiplier is on the circle there.
fn on_circle(found: Special, multiplier: Option<Complex<f64>>) -> Option<Special> {
    let pair = multiplier.filter(|mu| mu.norm().ln().abs() < TORUS_ON_CIRCLE);
    pair.map(|mu| Special {
        rotation: Some(mu.arg() / TAU),
        ..found
    })
}
