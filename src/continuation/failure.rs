//! Why a step leads to no point, or to none that is trusted.

use crate::continuation::end::{BranchEnd, EndReason};
use crate::error::{Error, Result, digits};
use crate::hybrid::chatter_map::NO_REST;

/// Why a step leads to no point: a shorter one may do, and if none does the curve ends for this reason.
pub(crate) enum StepFailure {
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
    /// A point was found that is not trusted.
    Distrusted(BranchEnd),
}

impl StepFailure {
    /// The failure of Newton's method at a value, with some mismatch.
    pub fn stalled(value: f64, mismatch: f64) -> Self {
        let reason = format!("mismatch {}", digits(mismatch));
        Self::Stalled { value, reason }
    }

    /// The failure of a step whose point is not trusted.
    pub fn distrusted(detail: String) -> Self {
        Self::Distrusted(BranchEnd::new(EndReason::Step, detail))
    }

    /// The end of a branch that comes no further for this reason.
    pub fn end(&self) -> BranchEnd {
        match self {
            StepFailure::Stalled { value, reason } => {
                let detail = format!("Newton's method stalls at {}: {reason}", digits(*value));
                BranchEnd::new(EndReason::Step, detail)
            }
            StepFailure::NoRest { value } => {
                let value = digits(*value);
                let detail = format!(
                    "at {value} impacts that accumulated come to no rest, or are not let go"
                );
                BranchEnd::new(EndReason::Boundary, detail)
            }
            StepFailure::Met { value, .. } => {
                let detail = format!(
                    "at {} an instant comes to the one before it",
                    digits(*value)
                );
                BranchEnd::new(EndReason::Boundary, detail)
            }
            StepFailure::NotOdd { value } => {
                let value = digits(*value);
                let detail = format!(
                    "at {value} the scene is not odd along the motion any more, which the symmetry q(t + T/2) = -q(t) asks for"
                );
                BranchEnd::new(EndReason::Domain, detail)
            }
            StepFailure::NoScene(reason) => BranchEnd::new(EndReason::Domain, reason.clone()),
            StepFailure::Distrusted(end) => end.clone(),
        }
    }
}

/// A result that may also be a failure of the corrector, from which a shorter step recovers; the outer error ends the computation.
pub(crate) type Attempt<T> = Result<std::result::Result<T, StepFailure>>;

/// Takes a scene that is refused, or a solver that does not converge, for a failure of the corrector; errors of a user's functions stay
/// errors.
pub(crate) fn attempted<T>(found: Result<T>, value: f64) -> Attempt<T> {
    match found {
        Ok(found) => Ok(Ok(found)),
        Err(Error::NoConvergence { stage, .. }) if stage == NO_REST => {
            Ok(Err(StepFailure::NoRest { value }))
        }
        Err(error @ Error::NoConvergence { .. }) => {
            let reason = error.to_string();
            Ok(Err(StepFailure::Stalled { value, reason }))
        }
        Err(error @ Error::BadValue { .. }) => Ok(Err(StepFailure::NoScene(error.to_string()))),
        Err(error) => Err(error),
    }
}
