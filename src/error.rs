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
    /// A branch that does not reach a value of its number between two of its points.
    #[error("the branch was not followed to {value} between its points at {} and {}: it came to {reached} ({reason})", beside[0], beside[1])]
    NotReached {
        /// The value.
        value: f64,
        /// The values at the points on both sides, shape `(2,)`, \[unit of the number\].
        beside: [f64; 2],
        /// The value nearest to it that was reached.
        reached: f64,
        /// Why it came no further.
        reason: String,
    },
    /// Arrays larger than the memory there is.
    #[error("{what} takes {} GB, more memory than there is", digits(*gigabytes))]
    OutOfMemory {
        /// What was to be held.
        what: String,
        /// What it takes.
        gigabytes: f64,
    },
    /// A function given by the caller failed: its own error.
    #[error(transparent)]
    Function(#[from] FunctionError),
    /// A long computation that its observer stopped.
    #[error("the computation was interrupted")]
    Interrupted,
}

impl Error {
    /// Whether it is about an argument.
    pub(crate) fn is_about(&self, name: &str) -> bool {
        matches!(self, Self::BadValue { argument, .. } if argument == name)
    }

    /// The value that broke a rule.
    pub(crate) fn value(&self) -> &str {
        match self {
            Self::BadValue { value, .. } => value,
            _ => "",
        }
    }

    /// Whether a value was no finite number, as of a step that led too far.
    pub(crate) fn is_not_finite(&self) -> bool {
        let number = |value: &str| value.parse::<f64>().is_ok_and(|x| !x.is_finite());
        matches!(self, Self::BadValue { value, .. } if number(value))
    }
}

/// Sizes of numbers that are shown without an exponent. [exact]
const PLAIN_SIZES: std::ops::Range<f64> = 1e-4..1e7;

/// A number as messages show it, to six digits; with an exponent where it is very small or large.
pub(crate) fn digits(x: f64) -> String {
    let rounded: f64 = format!("{x:.5e}").parse().unwrap_or(x);
    if rounded == 0.0 || PLAIN_SIZES.contains(&rounded.abs()) || !x.is_finite() {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}

/// Number of digits beyond which a number is shown in scientific form: no count has more, and no double of usual size. [exact]
const MOST_DIGITS: usize = 22;

/// A text with numbers of hundreds of digits in their shortest scientific form.
pub(crate) fn shortened(text: String) -> String {
    let is_digit = |c: char| c.is_ascii_digit() || c == '.';
    let longest = text.split(|c| !is_digit(c)).map(str::len).max();
    if longest.is_none_or(|length| length <= MOST_DIGITS) {
        return text;
    }
    let mut short = String::new();
    let mut rest = text.as_str();
    while let Some(start) = rest.find(is_digit) {
        let (before, number) = rest.split_at(start);
        let (number, after) =
            number.split_at(number.find(|c| !is_digit(c)).unwrap_or(number.len()));
        short.push_str(before);
        match number.parse::<f64>() {
            Ok(x) if number.len() > MOST_DIGITS => short.push_str(&format!("{x:e}")),
            _ => short.push_str(number),
        }
        rest = after;
    }
    short + rest
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

/// What went wrong, and at which of many items.
pub(crate) type Failure = (usize, Error);

impl Error {
    /// Bad input: `argument` is `value`, but `rule`. Numbers of more than 22 digits are shown in scientific form.
    pub fn bad_value(
        argument: impl Into<String>,
        value: impl ToString,
        rule: impl Into<String>,
    ) -> Self {
        Self::BadValue {
            argument: shortened(argument.into()),
            value: shortened(value.to_string()),
            rule: shortened(rule.into()),
        }
    }

    /// The same, with the place of the input among several in front of the name of the argument.
    pub(crate) fn at(self, place: impl std::fmt::Display) -> Self {
        match self {
            Self::BadValue {
                argument,
                value,
                rule,
            } => Self::bad_value(format!("{place}: {argument}"), value, rule),
            other => other,
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
    fn no_number_of_a_message_has_hundreds_of_digits() {
        let span = format!("({}, {})", -1e300, 5e-324);
        let error = Error::bad_value("t_span", span, format!("below {}", f64::MAX));
        let text = "t_span is (-1e300, 5e-324), but below 1.7976931348623157e308";
        assert_eq!(error.to_string(), text);
        let text = |x: f64| Error::bad_value("x", x, "1.5. No more").to_string();
        for (x, shown) in [
            (0.1, "0.1"),
            (1e21, "1000000000000000000000"),
            (1e22, "1e22"),
            (-1.25e-300, "-1.25e-300"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(text(x), format!("x is {shown}, but 1.5. No more"));
        }
        let complex = nalgebra::Complex::new(1e200, -1e-200);
        let error = Error::bad_value("x", complex, "small");
        assert_eq!(error.to_string(), "x is 1e200-1e-200i, but small");
        let count = usize::MAX;
        assert_eq!(shortened(count.to_string()), count.to_string());
    }

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
