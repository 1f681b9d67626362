//! A point of a curve that was accepted, and its test functions, which tell by their signs what else happens on the curve (theory 20).

use crate::branch::curve::condition::Condition;
use crate::branch::curve::problem::CurveProblem;
use crate::branch::curve::zero_problem::CorrectedCurvePoint;
use crate::branch::equations::Equations;
use crate::branch::multipliers::{own_multipliers, pair_of_product_one};
use crate::branch::parametric_loop::ParametricLoop;
use crate::branch::problem::BranchProblem;
use crate::error::Result;
use crate::orbit::PeriodicOrbit;
use crate::tolerance::MULTIPLIER_SLOPE_STEP;

/// A point of a curve that was accepted, with its orbit and its test functions.
#[derive(Clone)]
pub(super) struct AcceptedCurvePoint {
    pub found: CorrectedCurvePoint,
    /// From the first point, in scaled unknowns \[-\].
    pub arclength: f64,
    pub orbit: PeriodicOrbit,
    /// Whether the orbit breaks a rule of contact, other than by the impact of no speed that the curve is of.
    pub is_virtual: bool,
    /// The values of the test functions, by the kinds of points that they tell \[-\].
    pub test_values: Vec<(&'static str, f64)>,
}

impl AcceptedCurvePoint {
    pub fn at(
        plane: &CurveProblem<'_>,
        found: CorrectedCurvePoint,
        arclength: f64,
    ) -> Result<Self> {
        let orbit = plane.orbit(&found.iterate)?;
        Ok(Self {
            arclength,
            is_virtual: plane.is_virtual(&found.iterate, &orbit)?,
            test_values: test_values(plane, &found)?,
            orbit,
            found,
        })
    }
}

/// The test functions of a curve at a point: kinds of points, and values that change their sign there.
pub(super) fn test_values(
    plane: &CurveProblem<'_>,
    found: &CorrectedCurvePoint,
) -> Result<Vec<(&'static str, f64)>> {
    let iterate = &found.iterate;
    let place = &iterate.place;
    let at = (place, Some(&found.equations.first));
    plane.along(0, iterate, |problem| {
        let test = |multiplier: f64| problem.multiplier_test(at, multiplier);
        let speeds = problem.approaches(place)?.into_iter();
        let slowest = speeds.fold(f64::INFINITY, f64::min) / problem.units.velocity;
        let is_half = plane.signature.images.is_some();
        let mut all = Vec::new();
        match plane.condition {
            Condition::Multiplier(mu) => {
                all.push(("resonant_graze", slowest));
                // A multiplier of half a period is the square root of one of the whole, so that -mu is no fold flip.
                if !is_half {
                    all.push(("fold_flip", test(-mu)?));
                }
                // One coordinate alone has two multipliers, and their product is below one.
                let is_alone = place.state.states[0].len() == 2;
                if !(is_alone || is_half && mu < 0.0) {
                    let kind = if mu > 0.0 { "strong_1_1" } else { "strong_1_2" };
                    all.push((kind, slope(problem, at, mu)?));
                }
            }
            Condition::OnCircle => {
                all.push(("resonant_graze", slowest));
                let own = own_multipliers(&problem.orbit(place)?)?.unwrap_or_default();
                let sum = pair_of_product_one(&own).map_or(f64::NAN, |pair| pair.sum);
                // On the circle it is twice the cosine of an angle.
                all.push(("strong_1_1", sum - 2.0));
                all.push(("strong_1_2", sum + 2.0));
                all.push(("strong_1_3", sum + 1.0));
                all.push(("strong_1_4", sum));
            }
            // The touch of a stop that gives way makes no multiplier unbounded.
            Condition::NoSpeed(instant)
                if problem.signature.stages[instant]
                    .transition
                    .touched()
                    .is_some() =>
            {
                all.push(("degenerate_graze", problem.opening(place, instant)?));
            }
            Condition::NoSpeed(instant) => {
                all.push(("graze_fold", test(1.0)?));
                all.push(("resonant_graze", test(-1.0)?));
                all.push(("degenerate_graze", problem.opening(place, instant)?));
            }
            Condition::Together | Condition::Reached { .. } => all.push(("graze_corner", slowest)),
        }
        Ok(all)
    })
}

/// The slope of the determinant that is zero at a multiplier, by the multiplier; zero where two multipliers are equal.
fn slope(
    problem: &BranchProblem<'_>,
    at: (&ParametricLoop, Option<&Equations>),
    mu: f64,
) -> Result<f64> {
    let unit = problem.multiplier_determinant(at, mu)?.lengths;
    let beside = |steps: f64| -> Result<f64> {
        let own = problem.multiplier_determinant(at, mu + steps * MULTIPLIER_SLOPE_STEP)?;
        Ok(own.in_parts_of(unit))
    };
    let near = beside(1.0)? - beside(-1.0)?;
    let far = beside(2.0)? - beside(-2.0)?;
    Ok((8.0 * near - far) / (12.0 * MULTIPLIER_SLOPE_STEP))
}
