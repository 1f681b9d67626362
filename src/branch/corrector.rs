//! The corrector: Newton's method from a predicted loop back to the branch; and the tangent of the branch there (theory 19).

use crate::branch::end::{BranchEnd, EndReason};
use crate::branch::equations::{Equations, ParameterDerivative};
use crate::branch::parametric_loop::{BranchDirection, ParametricLoop};
use crate::branch::problem::BranchProblem;
use crate::error::{Error, Result, digits};
use crate::hybrid::chatter_map::NO_REST;
use crate::linalg::rank;
use crate::tolerance::{
    CORRECTION_NO_SHORTER, CROSSING_CORRECTION, FREE_DIRECTION, LAST_CORRECTION_LENGTH,
    ORBIT_CLOSED, ROUNDED_CORRECTION, SHARP_MISMATCH,
};
use nalgebra::DVector;

/// Corrections of one point of a branch (theory 19). `[work]`
const MOST_BRANCH_CORRECTIONS: usize = 6;

/// A point of a branch as the corrector leaves it.
pub(super) struct CorrectedPoint {
    pub place: ParametricLoop,
    pub equations: Equations,
    /// The tangent of the branch, of length one.
    pub tangent: BranchDirection,
    /// The ratio of the second correction to the first \[-\]; zero if there was no second one.
    pub contraction: f64,
}

/// Why the corrector found no point.
pub(super) enum CorrectionFailure {
    /// Newton's method did not converge.
    Stalled { value: f64, reason: String },
    /// Impacts that accumulate do not come to rest, or do not stay at rest.
    NoRest { value: f64 },
    /// Two instants coincide, and would change their order.
    Met { value: f64, instant: usize },
    /// The loop of half a period closes with its mirror image, which is not the other half.
    NotOdd { value: f64 },
    /// The scene refuses the value of the parameter.
    NoScene(String),
}

impl CorrectionFailure {
    /// The end of a branch that comes no further for this reason.
    pub fn end(&self) -> BranchEnd {
        match self {
            CorrectionFailure::Stalled { value, reason } => {
                let detail = format!("Newton's method stalls at {}: {reason}", digits(*value));
                BranchEnd::new(EndReason::Step, detail)
            }
            CorrectionFailure::NoRest { value } => {
                let value = digits(*value);
                let detail = format!(
                    "at {value} impacts that accumulated come to no rest, or are not let go"
                );
                BranchEnd::new(EndReason::Boundary, detail)
            }
            CorrectionFailure::Met { value, .. } => {
                let detail = format!(
                    "at {} an instant comes to the one before it",
                    digits(*value)
                );
                BranchEnd::new(EndReason::Boundary, detail)
            }
            CorrectionFailure::NotOdd { value } => {
                let value = digits(*value);
                let detail = format!(
                    "at {value} the scene is not odd along the motion any more, which the symmetry q(t + T/2) = -q(t) asks for"
                );
                BranchEnd::new(EndReason::Domain, detail)
            }
            CorrectionFailure::NoScene(reason) => BranchEnd::new(EndReason::Domain, reason.clone()),
        }
    }
}

/// A result that may also be a failure of the corrector, from which a shorter step recovers; the outer error ends the computation.
pub(super) type Attempt<T> = Result<std::result::Result<T, CorrectionFailure>>;

/// Takes a scene that is refused, or a solver that does not converge, for a failure of the corrector; errors of a user's functions stay
/// errors.
pub(super) fn attempted<T>(found: Result<T>, value: f64) -> Attempt<T> {
    match found {
        Ok(found) => Ok(Ok(found)),
        Err(Error::NoConvergence { stage, .. }) if stage == NO_REST => {
            Ok(Err(CorrectionFailure::NoRest { value }))
        }
        Err(error @ Error::NoConvergence { .. }) => {
            let reason = error.to_string();
            Ok(Err(CorrectionFailure::Stalled { value, reason }))
        }
        Err(error @ Error::BadValue { .. }) => {
            Ok(Err(CorrectionFailure::NoScene(error.to_string())))
        }
        Err(error) => Err(error),
    }
}

/// The solution of the equations bordered by one more row.
fn solved(
    equations: &Equations,
    border: &BranchDirection,
    right: &DVector<f64>,
) -> Option<BranchDirection> {
    let matrix = equations.bordered(border);
    // Stops that are hit at one instant give one equation too many.
    if !matrix.is_square() {
        return None;
    }
    let found = matrix.lu().solve(right)?;
    found
        .iter()
        .all(|x| x.is_finite())
        .then(|| BranchDirection::of(&found))
}

/// The tangent of the branch, on the side of a direction.
pub(super) fn tangent(equations: &Equations, border: &BranchDirection) -> Option<BranchDirection> {
    let mut right = DVector::zeros(equations.rows.nrows() + 1);
    right[equations.rows.nrows()] = 1.0;
    let found = solved(equations, border, &right)?;
    Some(found.scaled(1.0 / found.length()))
}

/// Whether a loop with some mismatch closes sharply with the remaining correction, or corrections come no nearer, by the last two.
pub(super) fn is_sharp(mismatch: f64, [last, left]: [f64; 2]) -> bool {
    let shorter = (left / last).min(1.0);
    mismatch * shorter <= SHARP_MISMATCH || shorter > CORRECTION_NO_SHORTER
}

/// The instant with which the next one coincides, so that its flight takes no time.
pub(super) fn coinciding_instant(place: &ParametricLoop) -> Option<usize> {
    let ends = place.state.times.windows(2);
    let mut flights = place.state.starts.iter().zip(ends);
    flights.position(|(start, ends)| !(ends[0] <= *start && *start < ends[1]))
}

/// A loop that is closed, its equations, and the correction that remains.
struct ClosedIterate {
    place: ParametricLoop,
    equations: Equations,
    left: Option<BranchDirection>,
}

impl BranchProblem<'_> {
    /// The point of the branch near a predicted loop, on the plane through that with a given normal: the tangent for a step of
    /// pseudo-arclength, the direction of the parameter for a point at a given value. Derivatives by the parameter are taken at the first
    /// iterate and at the last.
    pub fn corrected(
        &self,
        mut place: ParametricLoop,
        normal: &BranchDirection,
    ) -> Attempt<CorrectedPoint> {
        let unknowns = normal.loop_part.len();
        let mut total = BranchDirection::of_value(unknowns).scaled(0.0);
        let (mut last, mut first) = (f64::INFINITY, None);
        let mut contraction = 0.0;
        let mut mismatch = f64::INFINITY;
        let mut by_value: Option<ParameterDerivative> = None;
        // The last closed iterate: it is the result where another correction fails.
        let mut closed: Option<ClosedIterate> = None;
        let mut failure = None;
        let mut value = place.value;
        for corrections in 0..=MOST_BRANCH_CORRECTIONS {
            value = place.value;
            if let Some(instant) = coinciding_instant(&place) {
                failure = Some(CorrectionFailure::Met { value, instant });
                break;
            }
            let equations = match &by_value {
                Some(by_value) => self.equations_nearby(&place, by_value),
                None => self.equations(&place),
            };
            let equations = match attempted(equations, place.value)? {
                Ok(equations) => equations,
                Err(own) => {
                    failure = Some(own);
                    break;
                }
            };
            mismatch = equations.mismatch;
            let right = equations.right.clone().push(-normal.dot(&total));
            let Some(by) = solved(&equations, normal, &right) else {
                break;
            };
            let left = by.length();
            match first {
                None => first = Some(left),
                Some(first) if contraction == 0.0 && first > ROUNDED_CORRECTION => {
                    contraction = left / first;
                }
                Some(_) => {}
            }
            let (is_last, is_closed) = (
                corrections == MOST_BRANCH_CORRECTIONS,
                mismatch <= ORBIT_CLOSED,
            );
            let is_there = is_closed && left <= LAST_CORRECTION_LENGTH;
            if is_there && is_sharp(mismatch, [last, left]) {
                closed = Some(ClosedIterate {
                    place,
                    equations,
                    left: Some(by),
                });
                break;
            }
            // Where branches cross, corrections come no nearer than this: the iterate is kept.
            if is_there || is_last && is_closed && last <= CROSSING_CORRECTION {
                closed = Some(ClosedIterate {
                    place: place.clone(),
                    equations: equations.clone(),
                    left: is_there.then(|| by.clone()),
                });
            }
            last = left;
            by_value.get_or_insert_with(|| equations.by_value.clone());
            total = total.plus(&by);
            place = match attempted(self.moved(&place, &equations, &by), place.value)? {
                Ok(place) => place,
                Err(own) => {
                    failure = Some(own);
                    break;
                }
            };
        }
        let found = match closed {
            Some(closed) => self.settled(closed, normal, contraction)?,
            None => Ok(None),
        };
        let stalled = || CorrectionFailure::Stalled {
            value,
            reason: format!("mismatch {}", digits(mismatch)),
        };
        Ok(found.and_then(|found| found.ok_or_else(|| failure.unwrap_or_else(stalled))))
    }

    /// The point after the remaining correction, which is too short to change the equations; none where these have no tangent.
    fn settled(
        &self,
        closed: ClosedIterate,
        normal: &BranchDirection,
        contraction: f64,
    ) -> Attempt<Option<CorrectedPoint>> {
        let ClosedIterate {
            place,
            equations,
            left,
        } = closed;
        let value = place.value;
        let there = self.renewed(&place, equations).and_then(|equations| {
            let place = match &left {
                Some(by) => self.moved(&place, &equations, by)?,
                None => place,
            };
            let equations = self.equations_at(&place, equations)?;
            Ok((place, equations))
        });
        let (place, equations) = match attempted(there, value)? {
            Ok(there) => there,
            Err(failure) => return Ok(Err(failure)),
        };
        if let Some(instant) = coinciding_instant(&place) {
            return Ok(Err(CorrectionFailure::Met { value, instant }));
        }
        let tangent = tangent(&equations, normal);
        Ok(Ok(tangent.map(|tangent| CorrectedPoint {
            place,
            equations,
            tangent,
            contraction,
        })))
    }
}

/// The null space of `[G_Z G_p]`, orthonormal: the tangent alone, but at branch points and in families of orbits more.
pub(super) fn directions(equations: &Equations) -> Result<Vec<BranchDirection>> {
    let all = equations.all_columns();
    let tolerance = FREE_DIRECTION * all.amax();
    let found = rank::solve(&all, &DVector::zeros(all.nrows()), tolerance)?.null_space;
    let each = found.column_iter().map(|numbers| {
        let own = BranchDirection::of(&numbers.into_owned());
        let length = own.length();
        own.scaled(1.0 / length)
    });
    Ok(each.collect())
}
