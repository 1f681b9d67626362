//! Newton's method back to a branch from a place beside it, and the direction in which the branch goes on (theory 19).

use crate::branch::end::{BranchEnd, EndReason};
use crate::branch::equations::{ByValue, Equations};
use crate::branch::family::Family;
use crate::branch::place::{Direction, Place};
use crate::error::{Error, Result, digits};
use crate::hybrid::chatter_map::NO_REST;
use crate::linalg::rank;
use crate::tolerance::{FREE_DIRECTION, ORBIT_CLOSED, ORBIT_MARGIN};
use nalgebra::DVector;

/// Corrections of one point.
const MOST_CORRECTIONS: usize = 6;
/// The last correction is no longer than this; the equations before it are those of the point.
const SETTLED: f64 = 1e-10;
/// What is left then is to be below what the rules of contact see, unless corrections come no nearer.
const SHARP: f64 = 0.1 * ORBIT_MARGIN;
const NO_SHORTER: f64 = 0.5;
/// Where a branch is crossed a closed loop is known no better than this.
const NEARLY: f64 = 1e-6;
/// Of corrections as short as this the ratio is rounding.
const LOUD: f64 = 1e-8;

/// A point of a branch.
pub(super) struct Settled {
    pub place: Place,
    pub equations: Equations,
    /// Along the branch, of length one.
    pub tangent: Direction,
    /// How much shorter the second correction was than the first.
    pub contraction: f64,
}

/// Why Newton's method did not come to the branch.
pub(super) enum Missed {
    /// It did not settle, at a value, for a reason.
    Stalled { value: f64, reason: String },
    /// Impacts that accumulated before come to no end, or do not begin to.
    NoRest { value: f64 },
    /// Two instants came to one time, and would change their order.
    Met { value: f64, instant: usize },
    /// Half a motion is found, and its mirror image is not the other half.
    NotOdd { value: f64 },
    /// There is no scene.
    NoScene(String),
}

impl Missed {
    /// The end of what comes no further.
    pub fn end(&self) -> BranchEnd {
        match self {
            Missed::Stalled { value, reason } => {
                let detail = format!("Newton's method stalls at {}: {reason}", digits(*value));
                BranchEnd::new(EndReason::Step, detail)
            }
            Missed::NoRest { value } => {
                let value = digits(*value);
                let detail = format!(
                    "at {value} impacts that accumulated come to no rest, or are not let go"
                );
                BranchEnd::new(EndReason::Boundary, detail)
            }
            Missed::Met { value, .. } => {
                let detail = format!(
                    "at {} an instant comes to the one before it",
                    digits(*value)
                );
                BranchEnd::new(EndReason::Boundary, detail)
            }
            Missed::NotOdd { value } => {
                let value = digits(*value);
                let detail = format!(
                    "at {value} the scene is not odd along the motion any more, which the symmetry q(t + T/2) = -q(t) asks for"
                );
                BranchEnd::new(EndReason::Domain, detail)
            }
            Missed::NoScene(reason) => BranchEnd::new(EndReason::Domain, reason.clone()),
        }
    }
}

/// What cannot be got over, or a place that was missed.
pub(super) type Attempt<T> = Result<std::result::Result<T, Missed>>;

/// A refusal of a scene's numbers is a missed place; whatever else is said by the functions of a user is theirs.
pub(super) fn attempted<T>(found: Result<T>, value: f64) -> Attempt<T> {
    match found {
        Ok(found) => Ok(Ok(found)),
        Err(Error::NoConvergence { stage, .. }) if stage == NO_REST => {
            Ok(Err(Missed::NoRest { value }))
        }
        Err(error @ Error::NoConvergence { .. }) => {
            let reason = error.to_string();
            Ok(Err(Missed::Stalled { value, reason }))
        }
        Err(error @ Error::BadValue { .. }) => Ok(Err(Missed::NoScene(error.to_string()))),
        Err(error) => Err(error),
    }
}

/// The solution of the equations beside one more row.
fn solved(equations: &Equations, border: &Direction, right: &DVector<f64>) -> Option<Direction> {
    let matrix = equations.bordered(border);
    // Of stops hit at one instant there is a gap too many.
    if !matrix.is_square() {
        return None;
    }
    let found = matrix.lu().solve(right)?;
    found
        .iter()
        .all(|x| x.is_finite())
        .then(|| Direction::of(&found))
}

/// The direction of the branch at a place, on the side of another direction.
pub(super) fn tangent(equations: &Equations, border: &Direction) -> Option<Direction> {
    let mut right = DVector::zeros(equations.rows.nrows() + 1);
    right[equations.rows.nrows()] = 1.0;
    let found = solved(equations, border, &right)?;
    Some(found.scaled(1.0 / found.length()))
}

/// Whether a loop that lacks something closes sharply with the correction that is left, or corrections come no nearer, by the last two.
pub(super) fn is_sharp(mismatch: f64, [last, left]: [f64; 2]) -> bool {
    let shorter = (left / last).min(1.0);
    mismatch * shorter <= SHARP || shorter > NO_SHORTER
}

/// The instant to which the next one has come, whose flight takes no time.
pub(super) fn met(place: &Place) -> Option<usize> {
    let ends = place.state.times.windows(2);
    let mut flights = place.state.starts.iter().zip(ends);
    flights.position(|(start, ends)| !(ends[0] <= *start && *start < ends[1]))
}

/// A place with its equations, and the correction that is left.
struct Nearly {
    place: Place,
    equations: Equations,
    left: Option<Direction>,
}

impl Family<'_> {
    /// The point of the branch near a place on the plane through it that a direction is normal to: the direction itself at a step along
    /// the branch, that of the parameter at a given value. What changes with the parameter is taken where the way begins and where it ends.
    pub fn corrected(&self, mut place: Place, normal: &Direction) -> Attempt<Settled> {
        let unknowns = normal.loop_part.len();
        let mut gone = Direction::of_value(unknowns).scaled(0.0);
        let (mut last, mut first) = (f64::INFINITY, None);
        let mut contraction = 0.0;
        let mut mismatch = f64::INFINITY;
        let mut by_value: Option<ByValue> = None;
        // What is closed, to be corrected once more: it serves where that leads nowhere.
        let mut closed: Option<Nearly> = None;
        let mut missed = None;
        let mut value = place.value;
        for corrections in 0..=MOST_CORRECTIONS {
            value = place.value;
            if let Some(instant) = met(&place) {
                missed = Some(Missed::Met { value, instant });
                break;
            }
            let equations = match &by_value {
                Some(by_value) => self.equations_nearby(&place, by_value),
                None => self.equations(&place),
            };
            let equations = match attempted(equations, place.value)? {
                Ok(equations) => equations,
                Err(own) => {
                    missed = Some(own);
                    break;
                }
            };
            mismatch = equations.mismatch;
            let right = equations.right.clone().push(-normal.dot(&gone));
            let Some(by) = solved(&equations, normal, &right) else {
                break;
            };
            let left = by.length();
            match first {
                None => first = Some(left),
                Some(first) if contraction == 0.0 && first > LOUD => contraction = left / first,
                Some(_) => {}
            }
            let (is_last, is_closed) = (corrections == MOST_CORRECTIONS, mismatch <= ORBIT_CLOSED);
            let is_there = is_closed && left <= SETTLED;
            if is_there && is_sharp(mismatch, [last, left]) {
                closed = Some(Nearly {
                    place,
                    equations,
                    left: Some(by),
                });
                break;
            }
            // As near as it comes where branches cross: it stays there.
            if is_there || is_last && is_closed && last <= NEARLY {
                closed = Some(Nearly {
                    place: place.clone(),
                    equations: equations.clone(),
                    left: is_there.then(|| by.clone()),
                });
            }
            last = left;
            by_value.get_or_insert_with(|| equations.by_value.clone());
            gone = gone.plus(&by);
            place = match attempted(self.moved(&place, &equations, &by), place.value)? {
                Ok(place) => place,
                Err(own) => {
                    missed = Some(own);
                    break;
                }
            };
        }
        let found = match closed {
            Some(nearly) => self.settled(nearly, normal, contraction)?,
            None => Ok(None),
        };
        let stalled = || Missed::Stalled {
            value,
            reason: format!("mismatch {}", digits(mismatch)),
        };
        Ok(found.and_then(|found| found.ok_or_else(|| missed.unwrap_or_else(stalled))))
    }

    /// A point that a short correction leads to, which changes nothing in its equations; none where they have no direction.
    fn settled(
        &self,
        nearly: Nearly,
        normal: &Direction,
        contraction: f64,
    ) -> Attempt<Option<Settled>> {
        let Nearly {
            place,
            equations,
            left,
        } = nearly;
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
            Err(missed) => return Ok(Err(missed)),
        };
        if let Some(instant) = met(&place) {
            return Ok(Err(Missed::Met { value, instant }));
        }
        let tangent = tangent(&equations, normal);
        Ok(Ok(tangent.map(|tangent| Settled {
            place,
            equations,
            tangent,
            contraction,
        })))
    }
}

/// The directions in which a branch may go on from a place, orthonormal: one, but where branches cross and in families.
pub(super) fn directions(equations: &Equations) -> Result<Vec<Direction>> {
    let all = equations.all_columns();
    let tolerance = FREE_DIRECTION * all.amax();
    let found = rank::solve(&all, &DVector::zeros(all.nrows()), tolerance)?.null_space;
    let each = found.column_iter().map(|numbers| {
        let own = Direction::of(&numbers.into_owned());
        let length = own.length();
        own.scaled(1.0 / length)
    });
    Ok(each.collect())
}
