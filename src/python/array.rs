//! Arrays between `NumPy` and nalgebra: anything array-like comes in (lists, integers, float32, plain numbers, views of any
//! strides and byte order), owned float64 arrays go out; rows first.

use crate::python::text::shown;
use nalgebra::{Complex, DMatrix, DVector};
use numpy::{
    Element, IntoPyArray, PyArray1, PyArray2, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn,
    PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyException, PyMemoryError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyFloat, PyInt, PyList, PyTuple};

static AS_ARRAY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
static COPY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
static EMPTY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
static MASKED_ARRAY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();

/// The numbers of an array, rows first, and its shape.
pub(crate) struct Numbers<T> {
    pub shape: Vec<usize>,
    pub values: Vec<T>,
}

/// A number of an array.
pub(crate) trait Number: Element + Copy {
    /// Its name among the types of `NumPy`.
    const DTYPE: &'static str;
    const IS_COMPLEX: bool;
}

impl Number for f64 {
    const DTYPE: &'static str = "float64";
    const IS_COMPLEX: bool = false;
}

impl Number for Complex<f64> {
    const DTYPE: &'static str = "complex128";
    const IS_COMPLEX: bool = true;
}

/// An array that is one run of numbers of a type in memory, rows first, in the machine's byte order; `None` for any other. No
/// view of another array is read by its strides: they may be no multiples of a number's size, as in a column of records.
fn run<'py, T: Number>(array: &Bound<'py, PyAny>) -> Option<PyReadonlyArrayDyn<'py, T>> {
    let plain = array.cast_exact::<PyUntypedArray>().ok()?;
    if !(plain.is_c_contiguous() && plain.is_aligned()) {
        return None;
    }
    array.cast::<PyArrayDyn<T>>().ok()?.try_readonly().ok()
}

/// Copies a vector of as many numbers as there is room for, where it needs no conversion; else nothing, and false.
pub(crate) fn copy_vector(array: &Bound<'_, PyAny>, out: &mut [f64]) -> bool {
    run::<f64>(array).is_some_and(|array| match array.as_slice() {
        Ok(values) if array.ndim() == 1 && values.len() == out.len() => {
            out.copy_from_slice(values);
            true
        }
        _ => false,
    })
}

impl<T: Number> Numbers<T> {
    fn of_run(array: &Bound<'_, PyAny>) -> Option<Self> {
        let array = run::<T>(array)?;
        Some(Self {
            shape: array.shape().to_vec(),
            values: array.as_slice().ok()?.to_vec(),
        })
    }
}

/// The numbers of anything array-like.
///
/// # Errors
/// What is no array of numbers; masked entries, and imaginary parts that a real number has not, which would be lost.
pub(crate) fn numbers<T: Number>(argument: &str, value: &Bound<'_, PyAny>) -> PyResult<Numbers<T>> {
    if let Some(numbers) = Numbers::of_run(value) {
        return Ok(numbers);
    }
    let refused = |kind: &str| {
        let kind = if T::IS_COMPLEX { "numbers" } else { kind };
        PyValueError::new_err(format!(
            "{argument} is {}, but an array of {kind} is needed",
            shown(value)
        ))
    };
    let py = value.py();
    let given = |error: PyErr| {
        let is_of_value =
            error.is_instance_of::<PyException>(py) && !error.is_instance_of::<PyMemoryError>(py);
        if is_of_value {
            refused("numbers")
        } else {
            error
        }
    };
    let array = AS_ARRAY.import(py, "numpy", "asarray")?;
    let array = array.call1((value,)).map_err(given)?;
    if is_masked(value, array.getattr("ndim")?.extract()?)? {
        return Err(refused("numbers without masked ones"));
    }
    if let Some(numbers) = Numbers::of_run(&array) {
        return Ok(numbers);
    }
    let array = match array.getattr("dtype")?.getattr("kind")?.extract()? {
        'b' | 'i' | 'u' | 'f' | 'O' => array,
        'c' if T::IS_COMPLEX => array,
        'c' if array.getattr("imag")?.call_method0("any")?.is_truthy()? => {
            return Err(refused("real numbers"));
        }
        'c' => array.getattr("real")?,
        _ => return Err(refused("numbers")),
    };
    let options = PyDict::new(py);
    options.set_item("dtype", T::DTYPE)?;
    options.set_item("order", "C")?;
    let copied = COPY.import(py, "numpy", "array")?;
    let copied = copied.call((array,), Some(&options)).map_err(given)?;
    Numbers::of_run(&copied).ok_or_else(|| refused("numbers"))
}

/// Whether entries are masked (`numpy.ma`), in an array or in one within so many lists.
fn is_masked(value: &Bound<'_, PyAny>, lists: usize) -> PyResult<bool> {
    let is_plain = value.is_exact_instance_of::<PyFloat>()
        || value.is_exact_instance_of::<PyInt>()
        || value.cast_exact::<PyUntypedArray>().is_ok();
    if is_plain {
        return Ok(false);
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        if lists == 0 {
            return Ok(false);
        }
        for item in value.try_iter()? {
            if is_masked(&item?, lists - 1)? {
                return Ok(true);
            }
        }
        return Ok(false);
    }
    let class = MASKED_ARRAY.import(value.py(), "numpy.ma", "MaskedArray")?;
    if !value.is_instance(class)? {
        return Ok(false);
    }
    let any = value.getattr("mask")?.call_method0("any");
    // A mask of records has no single truth.
    Ok(any.and_then(|any| any.is_truthy()).unwrap_or(true))
}

/// The shape of a matrix, as a message asks for it.
const SQUARE: &str = "shape (n, n)";

fn shape_error(argument: &str, shape: &[usize], expected: &str) -> PyErr {
    let shown: Vec<String> = shape.iter().map(ToString::to_string).collect();
    PyValueError::new_err(format!(
        "{argument} has shape ({}), but {expected} is needed",
        shown.join(", ")
    ))
}

fn as_vector<T: Number + nalgebra::Scalar>(
    argument: &str,
    numbers: Numbers<T>,
    expected: &str,
) -> PyResult<DVector<T>> {
    match numbers.shape.len() {
        0 | 1 => Ok(DVector::from_vec(numbers.values)),
        _ => Err(shape_error(argument, &numbers.shape, expected)),
    }
}

fn as_matrix(argument: &str, numbers: &Numbers<f64>, expected: &str) -> PyResult<DMatrix<f64>> {
    match *numbers.shape {
        [rows, columns] => Ok(DMatrix::from_row_slice(rows, columns, &numbers.values)),
        _ => Err(shape_error(argument, &numbers.shape, expected)),
    }
}

/// A vector; a plain number is one of length 1.
pub(crate) fn vector(argument: &str, value: &Bound<'_, PyAny>) -> PyResult<DVector<f64>> {
    as_vector(argument, numbers(argument, value)?, "shape (n,)")
}

/// A complex vector; a plain number is one of length 1.
pub(crate) fn complex_vector(
    argument: &str,
    value: &Bound<'_, PyAny>,
) -> PyResult<DVector<Complex<f64>>> {
    as_vector(argument, numbers(argument, value)?, "shape (n,)")
}

/// A matrix with rows first.
pub(crate) fn matrix(argument: &str, value: &Bound<'_, PyAny>) -> PyResult<DMatrix<f64>> {
    as_matrix(argument, &numbers(argument, value)?, SQUARE)
}

/// A matrix with rows first; where it has one entry a plain number will do.
pub(crate) fn matrix_or_number(
    argument: &str,
    value: &Bound<'_, PyAny>,
    (rows, columns): (usize, usize),
) -> PyResult<DMatrix<f64>> {
    let mut numbers = numbers(argument, value)?;
    if (rows, columns) == (1, 1) && numbers.values.len() == 1 && numbers.shape.len() < 2 {
        numbers.shape = vec![1, 1];
    }
    as_matrix(argument, &numbers, &format!("({rows}, {columns})"))
}

/// Either a vector or a matrix, as a diagonal or dense coefficient.
pub(crate) fn coefficient(
    argument: &str,
    value: &Bound<'_, PyAny>,
) -> PyResult<crate::model::Coefficient> {
    let numbers = numbers(argument, value)?;
    if numbers.shape.len() == 2 {
        return Ok(as_matrix(argument, &numbers, SQUARE)?.into());
    }
    let expected = "shape (n, n), or (n,) for a diagonal";
    Ok(as_vector(argument, numbers, expected)?.into())
}

/// States of n coordinates, one a row, shape (k, n); for one coordinate a list of numbers is a list of rows.
pub(crate) fn rows(argument: &str, value: &Bound<'_, PyAny>, n: usize) -> PyResult<DMatrix<f64>> {
    let mut numbers = numbers(argument, value)?;
    if numbers.shape.len() == 1 && n == 1 {
        numbers.shape.push(1);
    }
    as_matrix(argument, &numbers, &format!("(k, {n})"))
}

/// Times, shape (m,), and whether a single one was given.
pub(crate) fn times(argument: &str, value: &Bound<'_, PyAny>) -> PyResult<(Vec<f64>, bool)> {
    let numbers: Numbers<f64> = numbers(argument, value)?;
    match numbers.shape.len() {
        0 | 1 => Ok((numbers.values, numbers.shape.is_empty())),
        _ => Err(shape_error(
            argument,
            &numbers.shape,
            "a time or an array of times of shape (m,)",
        )),
    }
}

/// A number that is no array.
pub(crate) fn number(argument: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    let vector = vector(argument, value)?;
    if vector.len() == 1 {
        Ok(vector[0])
    } else {
        Err(shape_error(argument, &[vector.len()], "one number"))
    }
}

/// Anything array-like as an array of real numbers, for what Python does with it.
#[pyfunction]
pub(crate) fn _numbers<'py>(
    argument: &str,
    value: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let numbers: Numbers<f64> = numbers(argument, value)?;
    numbers
        .values
        .into_pyarray(value.py())
        .reshape(numbers.shape)
}

pub(crate) fn out_vector<'py>(py: Python<'py>, v: &DVector<f64>) -> Bound<'py, PyArray1<f64>> {
    v.as_slice().to_vec().into_pyarray(py)
}

pub(crate) fn out_complex<'py>(
    py: Python<'py>,
    v: &DVector<Complex<f64>>,
) -> Bound<'py, PyArray1<Complex<f64>>> {
    v.as_slice().to_vec().into_pyarray(py)
}

/// A matrix out, rows first.
pub(crate) fn out_matrix<'py, T>(
    py: Python<'py>,
    m: &DMatrix<T>,
) -> PyResult<Bound<'py, PyArray2<T>>>
where
    T: numpy::Element + nalgebra::Scalar + Copy,
{
    Vec::from(m.transpose().data)
        .into_pyarray(py)
        .reshape([m.nrows(), m.ncols()])
}

/// Rows of equal length out, shape `(m, n)`.
pub(crate) fn out_rows<'py>(
    py: Python<'py>,
    rows: &[DVector<f64>],
    n: usize,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let flat: Vec<f64> = rows.iter().flat_map(|r| r.iter().copied()).collect();
    flat.into_pyarray(py).reshape([rows.len(), n])
}

/// The type of the rows of a structured array, made when first asked for.
pub(crate) struct RowType {
    fields: &'static [(&'static str, &'static str)],
    dtype: PyOnceLock<Py<PyAny>>,
}

impl RowType {
    /// From the names of the columns and the types of their entries.
    pub const fn new(fields: &'static [(&'static str, &'static str)]) -> Self {
        Self {
            fields,
            dtype: PyOnceLock::new(),
        }
    }

    /// A structured array of so many rows, from its columns.
    pub fn array<'py, const N: usize>(
        &self,
        py: Python<'py>,
        len: usize,
        columns: [Bound<'py, PyAny>; N],
    ) -> PyResult<Bound<'py, PyAny>> {
        let dtype = self.dtype.get_or_try_init(py, || {
            let fields = self.fields.to_vec();
            let dtype = py.import("numpy")?.call_method1("dtype", (fields,))?;
            Ok::<_, PyErr>(dtype.unbind())
        })?;
        let array = EMPTY.import(py, "numpy", "empty")?.call1((len, dtype))?;
        for ((name, _), values) in self.fields.iter().zip(columns) {
            array.set_item(*name, values)?;
        }
        Ok(array)
    }
}
