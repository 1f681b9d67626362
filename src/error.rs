//! Every failure of the crate. Bad input names the argument, its value and the rule; a computation that failed says
//! where and how far it got. Facts of mechanics (no orbit, a family, grazing) are values of the results, not errors.

use std::fmt;
use std::sync::Arc;
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
    #[error("{stage} did not converge: residual {} after {iterations} iterations", digits(*residual))]
    NoConvergence {
        /// The computation that failed.
        stage: &'static str,
        /// Iterations done.
        iterations: usize,
        /// The residual reached.
        residual: f64,
    },
    /// A function given by the caller failed: its own error.
    #[error(transparent)]
    Function(#[from] FunctionError),
    /// A long computation that its observer stopped.
    #[error("the computation was interrupted")]
    Interrupted,
}

/// A number as messages show it, to six digits; with an exponent where it is very small or large.
pub(crate) fn digits(x: f64) -> String {
    let rounded: f64 = format!("{x:.5e}").parse().unwrap_or(x);
    if rounded == 0.0 || (1e-4..1e7).contains(&rounded.abs()) || !x.is_finite() {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}

/// The error of a function given by the caller, as it was given; equal to itself alone.
#[derive(Clone)]
pub struct FunctionError(Arc<dyn std::error::Error + Send + Sync>);

impl FunctionError {
    /// The error itself, to be downcast by whoever made it.
    pub fn inner(&self) -> &(dyn std::error::Error + Send + Sync + 'static) {
        &*self.0
    }
}

impl fmt::Debug for FunctionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&self.0, f)
    }
}

impl fmt::Display for FunctionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.0, f)
    }
}

impl std::error::Error for FunctionError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.0.source()
    }
}

impl PartialEq for FunctionError {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
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

    /// The error of a function given by the caller, such as the equations of motion of a nonlinear system.
    pub fn function(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::Function(FunctionError(Arc::new(error)))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_show_six_digits_and_exponents_only_where_they_help() {
        let shown = [
            (0.0, "0"),
            (-8.5, "-8.5"),
            (2.823_937_4, "2.82394"),
            (9_999_999.0, "1e7"),
            (123_456.0, "123456"),
            (0.000_123, "0.000123"),
            (2.8e-10, "2.8e-10"),
            (-1.0e300, "-1e300"),
            (f64::NAN, "NaN"),
            (f64::INFINITY, "inf"),
        ];
        for (x, text) in shown {
            assert_eq!(digits(x), text);
        }
        let error = Error::NoConvergence {
            stage: "this",
            iterations: 3,
            residual: 2.823_937,
        };
        let text = "this did not converge: residual 2.82394 after 3 iterations";
        assert_eq!(error.to_string(), text);
    }
}
