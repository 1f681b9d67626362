//! Checked scalars and arrays: a value that exists is valid, so nothing further in checks it again.

use crate::error::{Error, Result};
use nalgebra::{Complex, DMatrix, DVector};

/// Bytes of a gigabyte. [exact]
const GIGABYTE: f64 = 1e9;

/// Restitution coefficient `e` in [0, 1]: minus the ratio of the normal velocity after an impact to the one before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Restitution(f64);

impl Restitution {
    /// A restitution coefficient.
    ///
    /// # Errors
    /// `Error::BadValue` unless `0 <= value <= 1`.
    pub fn new(value: f64) -> Result<Self> {
        if (0.0..=1.0).contains(&value) {
            Ok(Self(value))
        } else {
            Err(Error::bad_value(
                "restitution",
                value,
                "it must lie in [0, 1]",
            ))
        }
    }

    /// A coefficient that is known to be one.
    pub(crate) fn known(value: f64) -> Self {
        debug_assert!((0.0..=1.0).contains(&value));
        Self(value)
    }

    /// The coefficient [-].
    pub const fn value(self) -> f64 {
        self.0
    }
}

/// A number above zero, or zero without a sign: for speeds that rounding may have turned round.
pub(crate) fn positive_part(x: f64) -> f64 {
    if x > 0.0 { x } else { 0.0 }
}

/// The larger of two numbers, the first where one is none: one instruction, where `f64::max` takes seven.
#[inline]
pub(crate) fn larger(x: f64, y: f64) -> f64 {
    if y > x { y } else { x }
}

/// `x - y`; nothing, where that is but the last rounding of numbers that cancel: what an impact stops altogether has no speed of
/// that size.
pub(crate) fn difference(x: f64, y: f64) -> f64 {
    let left = x - y;
    if left.abs() <= f64::EPSILON * x.abs() {
        0.0
    } else {
        left
    }
}

/// Whether both parts of a complex number are finite.
pub(crate) fn is_finite(z: &Complex<f64>) -> bool {
    z.re.is_finite() && z.im.is_finite()
}

/// Finite complex numbers, or an error that names the one that is not.
pub(crate) fn finite_complex(argument: &str, values: &DVector<Complex<f64>>) -> Result<()> {
    match values.iter().position(|z| !is_finite(z)) {
        None => Ok(()),
        Some(i) => {
            let argument = format!("{argument}[{i}]");
            Err(Error::bad_value(argument, values[i], "it must be finite"))
        }
    }
}

/// A finite number, or an error that names the argument.
pub(crate) fn finite(argument: &str, value: f64) -> Result<f64> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(Error::bad_value(argument, value, "it must be finite"))
    }
}

/// A count that is not zero, or an error that names the argument.
pub(crate) fn at_least_one(argument: &str, count: usize) -> Result<()> {
    if count > 0 {
        Ok(())
    } else {
        Err(Error::bad_value(argument, count, "it must be at least 1"))
    }
}

/// A finite number above zero, or an error that names the argument.
pub(crate) fn positive(argument: &str, value: f64) -> Result<f64> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(Error::bad_value(
            argument,
            value,
            "it must be finite and greater than zero",
        ))
    }
}

/// A finite number that is not below zero, or an error that names the argument.
pub(crate) fn not_negative(argument: &str, value: f64) -> Result<f64> {
    if value.is_finite() && value >= 0.0 {
        return Ok(value);
    }
    let rule = "it must be finite and not negative";
    Err(Error::bad_value(argument, value, rule))
}

/// A vector of `len` finite numbers, or an error that names the argument.
pub(crate) fn finite_vector(argument: &str, vector: &DVector<f64>, len: usize) -> Result<()> {
    if vector.len() != len {
        return Err(Error::bad_shape(
            argument,
            format!("({},)", vector.len()),
            format!("({len},)"),
        ));
    }
    match vector.iter().position(|x| !x.is_finite()) {
        Some(i) => Err(Error::bad_value(
            format!("{argument}[{i}]"),
            vector[i],
            "it must be finite",
        )),
        None => Ok(()),
    }
}

/// An `n` by `n` matrix of finite numbers, or an error that names the argument.
pub(crate) fn finite_square(argument: &str, matrix: &DMatrix<f64>, n: usize) -> Result<()> {
    if matrix.shape() != (n, n) {
        let found = format!("({}, {})", matrix.nrows(), matrix.ncols());
        return Err(Error::bad_shape(argument, found, format!("({n}, {n})")));
    }
    for j in 0..n {
        for i in 0..n {
            if !matrix[(i, j)].is_finite() {
                let name = format!("{argument}[{i}, {j}]");
                return Err(Error::bad_value(name, matrix[(i, j)], "it must be finite"));
            }
        }
    }
    Ok(())
}

/// Refuses an array of so many rows and columns of numbers that the memory has no room for, where making it would end the
/// process.
pub(crate) fn room_for(what: &str, rows: usize, columns: usize) -> Result<()> {
    let numbers = rows.checked_mul(columns);
    let is_there = |numbers| Vec::<f64>::new().try_reserve_exact(numbers).is_ok();
    if numbers.is_some_and(is_there) {
        return Ok(());
    }
    Err(Error::OutOfMemory {
        what: what.to_owned(),
        gigabytes: rows as f64 * columns as f64 * size_of::<f64>() as f64 / GIGABYTE,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_that_no_memory_holds_are_refused() {
        assert_eq!(room_for("a table", 1000, 1000), Ok(()));
        for (rows, columns) in [(1 << 40, 1 << 20), (usize::MAX, 3)] {
            let message = room_for("a table", rows, columns).unwrap_err().to_string();
            assert!(message.starts_with("a table takes "), "{message}");
        }
    }

    #[test]
    fn the_last_rounding_of_numbers_that_cancel_is_nothing() {
        let x = 0.1 + 0.2;
        assert_eq!((difference(x, 0.3), difference(-x, -0.3)), (0.0, 0.0));
        assert_eq!(difference(1.0, 1.0 - 1e-15), 1.0 - (1.0 - 1e-15));
        assert!(difference(f64::INFINITY, f64::INFINITY).is_nan());
    }

    #[test]
    fn restitution_lies_in_the_unit_interval() {
        for e in [0.0, 1e-12, 1.0 - 1e-12, 1.0] {
            assert!((Restitution::new(e).expect("in range").value() - e).abs() < f64::MIN_POSITIVE);
        }
        for e in [-1e-12, 1.0 + 1e-12, f64::NAN, f64::INFINITY] {
            assert!(Restitution::new(e).is_err());
        }
    }

    #[test]
    fn arrays_must_be_finite_and_of_the_right_shape() {
        let message = finite_vector("load", &DVector::from_vec(vec![0.0, f64::NAN]), 2)
            .unwrap_err()
            .to_string();
        assert_eq!(message, "load[1] is NaN, but it must be finite");
        assert!(finite_vector("load", &DVector::zeros(3), 2).is_err());
        assert!(finite_square("mass", &DMatrix::zeros(2, 3), 2).is_err());
    }
}
