//! Arrays between `NumPy` and nalgebra: anything array-like comes in (lists, integers, float32, plain numbers), owned
//! float64 arrays go out; rows first.

use crate::python::text::shown;
use nalgebra::{Complex, DMatrix, DVector};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn,
    PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyDict;

static AS_ARRAY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
static EMPTY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();

fn as_array<'py, T: numpy::Element>(
    argument: &str,
    value: &Bound<'py, PyAny>,
    dtype: &str,
) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
    if let Ok(array) = value.cast::<PyArrayDyn<T>>() {
        return Ok(array.readonly());
    }
    let py = value.py();
    let options = PyDict::new(py);
    options.set_item("dtype", dtype)?;
    let array = AS_ARRAY
        .import(py, "numpy", "asarray")?
        .call((value,), Some(&options))
        .map_err(|_| {
            PyValueError::new_err(format!(
                "{argument} is {}, but an array of numbers is needed",
                shown(value)
            ))
        })?;
    Ok(array.cast_into::<PyArrayDyn<T>>()?.readonly())
}

fn shape_error(argument: &str, shape: &[usize], expected: &str) -> PyErr {
    let shown: Vec<String> = shape.iter().map(ToString::to_string).collect();
    PyValueError::new_err(format!(
        "{argument} has shape ({}), but {expected} is needed",
        shown.join(", ")
    ))
}

/// A vector; a plain number is one of length 1.
pub(crate) fn vector(argument: &str, value: &Bound<'_, PyAny>) -> PyResult<DVector<f64>> {
    let array = as_array::<f64>(argument, value, "float64")?;
    match array.ndim() {
        0 | 1 => Ok(DVector::from_iterator(
            array.len(),
            array.as_array().iter().copied(),
        )),
        _ => Err(shape_error(argument, array.shape(), "shape (n,)")),
    }
}

/// A complex vector; a plain number is one of length 1.
pub(crate) fn complex_vector(
    argument: &str,
    value: &Bound<'_, PyAny>,
) -> PyResult<DVector<Complex<f64>>> {
    let array = as_array::<Complex<f64>>(argument, value, "complex128")?;
    match array.ndim() {
        0 | 1 => Ok(DVector::from_iterator(
            array.len(),
            array.as_array().iter().copied(),
        )),
        _ => Err(shape_error(argument, array.shape(), "shape (n,)")),
    }
}

/// A matrix with rows first.
pub(crate) fn matrix(argument: &str, value: &Bound<'_, PyAny>) -> PyResult<DMatrix<f64>> {
    let array = as_array::<f64>(argument, value, "float64")?;
    match array.shape() {
        &[rows, columns] => Ok(DMatrix::from_row_iterator(
            rows,
            columns,
            array.as_array().iter().copied(),
        )),
        shape => Err(shape_error(argument, shape, "shape (n, n)")),
    }
}

/// Either a vector or a matrix, as a diagonal or dense coefficient.
pub(crate) fn coefficient(
    argument: &str,
    value: &Bound<'_, PyAny>,
) -> PyResult<crate::model::Coefficient> {
    let array = as_array::<f64>(argument, value, "float64")?;
    match array.ndim() {
        0 | 1 => Ok(vector(argument, value)?.into()),
        2 => Ok(matrix(argument, value)?.into()),
        _ => Err(shape_error(
            argument,
            array.shape(),
            "shape (n, n), or (n,) for a diagonal",
        )),
    }
}

/// Rows of vectors, `(k, n)`; one vector is one row.
pub(crate) fn times(argument: &str, value: &Bound<'_, PyAny>) -> PyResult<(Vec<f64>, bool)> {
    let array = as_array::<f64>(argument, value, "float64")?;
    match array.ndim() {
        0 | 1 => Ok((
            array.as_array().iter().copied().collect(),
            array.ndim() == 0,
        )),
        _ => Err(shape_error(
            argument,
            array.shape(),
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
    m.transpose()
        .as_slice()
        .to_vec()
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
