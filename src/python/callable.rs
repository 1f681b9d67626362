//! Python functions inside the core: called with the interpreter taken back, given fresh read-only arrays. An exception
//! travels through the core as an error and comes out as itself.

use crate::error::{Error, Result};
use crate::observer::unless_broken_off;
use crate::python::array::{copy_vector, matrix_or_number, vector};
use nalgebra::DMatrix;
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::exceptions::PyRecursionError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::cell::Cell;
use std::fmt::Write;

/// A Python function, with the name of the argument it was given as.
pub(crate) struct Callable {
    name: &'static str,
    pub function: Py<PyAny>,
}

/// Where a function was called, for its errors.
pub(crate) struct CallSite<'a> {
    pub time: Option<f64>,
    pub q: &'a [f64],
}

impl std::fmt::Display for CallSite<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(t) = self.time {
            write!(f, "t = {t}, ")?;
        }
        write!(f, "q = {:?}", self.q)
    }
}

/// A copy that the function cannot write to.
pub(crate) fn read_only<'py>(py: Python<'py>, x: &[f64]) -> Bound<'py, PyAny> {
    let array = PyArray1::from_slice(py, x);
    let locked: PyReadonlyArray1<'py, f64> = array.readwrite().make_nonwriteable();
    locked.as_any().clone()
}

/// An exception as an error of the core.
fn raised(error: PyErr) -> Error {
    Error::function(error)
}

/// How deep calls of users' functions may be nested: the computations between them use stack that the interpreter, which counts its own
/// frames alone, does not see. [work]
const MOST_NESTED_CALLS: u32 = 8;

thread_local! {
    /// Calls of users' functions that this thread is in.
    static DEPTH: Cell<u32> = const { Cell::new(0) };
}

/// A call of a user's function, until it is dropped.
pub(crate) struct Entered(());

impl Entered {
    /// Counts a call.
    ///
    /// # Errors
    /// `RecursionError` where calls are in calls too deep.
    pub fn new() -> Result<Self> {
        let depth = DEPTH.get();
        if depth >= MOST_NESTED_CALLS {
            return Err(raised(PyRecursionError::new_err(format!(
                "the functions of a NonlinearSystem or NonlinearStop start computations that call such functions, {MOST_NESTED_CALLS} deep"
            ))));
        }
        DEPTH.set(depth + 1);
        Ok(Self(()))
    }
}

impl Drop for Entered {
    fn drop(&mut self) {
        DEPTH.set(DEPTH.get() - 1);
    }
}

impl Callable {
    /// A Python function.
    ///
    /// # Errors
    /// `TypeError` for what cannot be called.
    pub fn new(name: &'static str, function: &Bound<'_, PyAny>) -> PyResult<Self> {
        if function.is_callable() {
            let function = function.clone().unbind();
            return Ok(Self { name, function });
        }
        Err(pyo3::exceptions::PyTypeError::new_err(format!(
            "{name} is {}, but a function is needed",
            function.repr()?
        )))
    }

    /// Calls the function and reads its result, the interpreter attached meanwhile.
    fn call<T>(
        &self,
        arguments: impl for<'py> FnOnce(Python<'py>) -> PyResult<Bound<'py, PyTuple>>,
        read: impl FnOnce(&Bound<'_, PyAny>) -> Result<T>,
    ) -> Result<T> {
        let _entered = Entered::new()?;
        Python::attach(|py| {
            // A function that never enters the interpreter's loop would keep Ctrl-C waiting.
            py.check_signals().map_err(raised)?;
            // A thread that no signal reaches.
            unless_broken_off()?;
            let result = arguments(py)
                .and_then(|arguments| self.function.bind(py).call1(arguments))
                .map_err(raised)?;
            read(&result)
        })
    }

    fn bad_shape(&self, found: &[usize], expected: &str, place: &CallSite<'_>) -> Error {
        let mut shown = String::from("(");
        for length in found {
            let _ = write!(shown, "{length},");
        }
        shown.push(')');
        Error::bad_shape(
            format!("the result of {} at {place}", self.name),
            shown,
            expected,
        )
    }

    /// Writes a result of `out.len()` numbers.
    pub fn write_vector(
        &self,
        arguments: impl for<'py> FnOnce(Python<'py>) -> PyResult<Bound<'py, PyTuple>>,
        place: &CallSite<'_>,
        out: &mut [f64],
    ) -> Result<()> {
        let n = out.len();
        self.call(arguments, |result| {
            if copy_vector(result, out) {
                return Ok(());
            }
            let numbers =
                vector(&format!("the result of {}", self.name), result).map_err(raised)?;
            if numbers.len() != n {
                return Err(self.bad_shape(&[numbers.len()], &format!("({n},)"), place));
            }
            out.copy_from_slice(numbers.as_slice());
            Ok(())
        })
    }

    /// A result of one number.
    pub fn number(
        &self,
        arguments: impl for<'py> FnOnce(Python<'py>) -> PyResult<Bound<'py, PyTuple>>,
        place: &CallSite<'_>,
    ) -> Result<f64> {
        let mut out = [0.0];
        self.write_vector(arguments, place, &mut out)?;
        Ok(out[0])
    }

    /// A result of rows and columns; for one entry a plain number will do.
    pub fn matrix(
        &self,
        arguments: impl for<'py> FnOnce(Python<'py>) -> PyResult<Bound<'py, PyTuple>>,
        place: &CallSite<'_>,
        (rows, columns): (usize, usize),
    ) -> Result<DMatrix<f64>> {
        self.call(arguments, |result| {
            let name = format!("the result of {}", self.name);
            let m = matrix_or_number(&name, result, (rows, columns)).map_err(raised)?;
            if m.shape() == (rows, columns) {
                return Ok(m);
            }
            Err(self.bad_shape(
                &[m.nrows(), m.ncols()],
                &format!("({rows}, {columns})"),
                place,
            ))
        })
    }
}

/// The arguments of a function of the position.
pub(crate) fn position<'py>(py: Python<'py>, q: &[f64]) -> PyResult<Bound<'py, PyTuple>> {
    PyTuple::new(py, [read_only(py, q)])
}

/// Whether two Python objects are one, or equal; arrays entry by entry.
pub(crate) fn is_equal(py: Python<'_>, a: &Py<PyAny>, b: &Py<PyAny>) -> bool {
    if a.is(b) {
        return true;
    }
    let equal = || -> PyResult<bool> {
        let equal = a.bind(py).eq(b);
        match equal {
            Ok(equal) => Ok(equal),
            // Arrays of several entries have no single truth.
            Err(_) => py
                .import("numpy")?
                .call_method1("array_equal", (a, b))?
                .extract(),
        }
    };
    equal().unwrap_or(false)
}

/// The name of a function, or what it shows of itself.
pub(crate) fn name_of(py: Python<'_>, function: &Py<PyAny>) -> PyResult<String> {
    let function = function.bind(py);
    match function.getattr("__qualname__") {
        Ok(name) => Ok(name.to_string()),
        Err(_) => Ok(function.repr()?.to_string()),
    }
}
