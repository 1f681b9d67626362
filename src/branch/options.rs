//! Options of a continuation.

use crate::error::{Error, Result};
use crate::quantity::{at_least_one, finite};

/// The direction in which a branch is followed from the orbit that is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Heading {
    /// Towards larger values at first.
    Up,
    /// Towards smaller values at first.
    Down,
    /// Both ways.
    #[default]
    Both,
}

/// What becomes of a branch beyond a boundary, where its orbits break a rule of contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Virtual {
    /// It ends there.
    #[default]
    Stop,
    /// It goes on with orbits that say that they are not admissible. The boundary is one of its special points; further rules that are
    /// broken beyond are not located.
    Keep,
}

/// Options of [`continuation`](fn@crate::continuation).
#[derive(Debug, Clone, PartialEq)]
pub struct ContinuationOptions {
    /// Which way, default both.
    pub heading: Heading,
    /// Points each way at the most, default 2000.
    pub max_points: usize,
    /// The smallest, the first and the largest step, in arclength of scaled unknowns; default 1e-8, 1e-3, 0.05.
    pub steps: [f64; 3],
    /// What becomes of it beyond a boundary, default an end.
    pub beyond: Virtual,
    /// Whether the motion is kept its own mirror image half a period later, `q(t + T/2) = -q(t)`: default where it is, in scenes that are
    /// odd. A branch cannot leave its symmetry then, and where it is broken a branch of others is born (a pitchfork).
    pub symmetric: Option<bool>,
}

/// The shortest, the first and the longest step that are usual, in arclength. [work]
const USUAL_STEPS: [f64; 3] = [1e-8, 1e-3, 0.05];

impl Default for ContinuationOptions {
    fn default() -> Self {
        Self {
            heading: Heading::Both,
            max_points: 2000,
            steps: USUAL_STEPS,
            beyond: Virtual::Stop,
            symmetric: None,
        }
    }
}

impl ContinuationOptions {
    /// Refuses steps that are not in order, and zero points.
    pub(super) fn check(&self) -> Result<()> {
        let [smallest, first, largest] = self.steps;
        for step in self.steps {
            finite("step", step)?;
        }
        if !(0.0 < smallest && smallest <= first && first <= largest) {
            let value = format!("({smallest}, {first}, {largest})");
            let rule =
                "it must be (smallest, first, largest) with 0 < smallest <= first <= largest";
            return Err(Error::bad_value("step", value, rule));
        }
        at_least_one("max_points", self.max_points)?;
        Ok(())
    }
}

/// Refuses an empty range, or one without the first value.
pub(super) fn check_range(name: &str, (low, high): (f64, f64), start: f64) -> Result<()> {
    for value in [low, high, start] {
        finite(name, value)?;
    }
    let value = format!("({low}, {high})");
    if low >= high {
        let rule = "the first must be the lower one";
        return Err(Error::bad_value(name, value, rule));
    }
    if !(low..=high).contains(&start) {
        let of = if start == 1.0 {
            " (a factor is 1 in the orbit's own scene)"
        } else {
            ""
        };
        let rule = format!("the orbit is at {start}{of}: it must lie inside");
        return Err(Error::bad_value(name, value, rule));
    }
    Ok(())
}
