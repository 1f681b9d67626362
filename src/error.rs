//! Every failure of the crate. Bad input names the argument, its value and the rule; a computation that failed says
//! where and how far it got. Facts of mechanics (no orbit, a family, grazing) are values of the results, not errors.

use thiserror::Error;

/// What can go wrong: bad input, found in a constructor, or a computation that did not reach its end.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Error {
    /// An argument whose value breaks a rule.
    #[error("{argument} is {value}, but {rule}")]
    BadValue {
        /// The argument's public name.
        argument: String,
        /// The value given, as text.
        value: String,
        /// The rule it breaks, with the remedy where there is one.
        rule: String,
    },
    /// An array of the wrong shape.
    #[error("{argument} has shape {found}, but {expected} is needed")]
    BadShape {
        /// The argument's public name.
        argument: String,
        /// The shape found.
        found: String,
        /// The shape that is needed, and why.
        expected: String,
    },
    /// An iteration that ended without a result.
    #[error("{stage} did not converge: residual {residual:e} after {iterations} iterations")]
    NoConvergence {
        /// The computation that failed.
        stage: &'static str,
        /// Iterations done.
        iterations: usize,
        /// The residual reached.
        residual: f64,
    },
    /// A long computation that its observer stopped.
    #[error("the computation was interrupted")]
    Interrupted,
}

/// The crate's result.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Bad input: `argument` is `value`, but `rule`.
    pub fn bad_value(
        argument: impl Into<String>,
        value: impl ToString,
        rule: impl Into<String>,
    ) -> Self {
        Self::BadValue {
            argument: argument.into(),
            value: value.to_string(),
            rule: rule.into(),
        }
    }

    /// Bad input: `argument` has the shape `found`, `expected` is needed.
    pub fn bad_shape(
        argument: impl Into<String>,
        found: impl ToString,
        expected: impl Into<String>,
    ) -> Self {
        Self::BadShape {
            argument: argument.into(),
            found: found.to_string(),
            expected: expected.into(),
        }
    }
}
