//! Signals in Python.

use crate::error::Error;
use crate::model::Signal;
use crate::python::array::{numbers, out_matrix, out_vector, times, vector};
use crate::python::{argument, callable::Callable};
use nalgebra::{DMatrix, DVector};
use numpy::PyArray1;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// Function of time in pieces, each a polynomial; zero before the first and after the last.
///
/// It has the breakpoints and coefficients of SciPy's ``PPoly``; ``Load`` and ``BaseAcceleration`` take such an object, or samples
/// ``(t, values)``, as they are.
///
/// Parameters
/// ----------
/// x : array_like, shape (m + 1,)
///     Breakpoints [s], increasing.
/// c : array_like, shape (degree + 1, m)
///     Coefficients of the pieces, the highest power of ``t - x[i]`` first; a degree up to 16.
///
/// Raises
/// ------
/// ValueError
///     Breakpoints that do not increase or are not one more than the pieces, numbers that are not finite.
///
/// Examples
/// --------
/// >>> import vibroimpact as vi
/// >>> ramp = vi.Signal([0.0, 1.0, 2.0], [[1.0, 0.0], [0.0, 1.0]])  # t, then 1
/// >>> ramp([0.5, 1.5, 2.5])
/// array([0.5, 1. , 0. ])
#[pyclass(name = "Signal", module = "vibroimpact", frozen)]
#[derive(Clone)]
pub(crate) struct PySignal(pub Signal);

#[pymethods]
impl PySignal {
    #[new]
    fn new(x: &Bound<'_, PyAny>, c: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(Self(pieces("x", x, "c", c)?))
    }

    /// A function on a span, by Chebyshev pieces of degree 8, to 1e-14 of its largest value and what the last place of the time makes of it.
    ///
    /// It is looked at in 4096 places all over the span first, and each piece at places of its own: nothing that lasts a thousandth of the
    /// span is lost. What is shorter, such as a shock of a millisecond in a record of ten seconds, may be: name its start and end in
    /// `breaks`. Kinks are found by halving; they cost some tens of pieces each, and none where they are named.
    ///
    /// Parameters
    /// ----------
    /// f : callable
    ///     Takes times of shape (m,) and gives values of shape (m,). It must be continuous but at `breaks`.
    /// span : (float, float)
    ///     Start and end [s]; outside the signal is zero.
    /// breaks : array_like, shape (k,), default ()
    ///     Times in the span, in any order, at which f or a derivative of it jumps [s]. f is asked beside them, two last places of the time
    ///     away, and the smooth parts between are looked at one by one, however short. An end of the span may be among them, where f has
    ///     its value from inside only beside it.
    ///
    /// Returns
    /// -------
    /// Signal
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     A span that is empty, breaks outside it, values that are not finite or of another shape, a function that a million pieces do not
    ///     follow to 1e-14, such as one that jumps at no break or is itself not known so far; the message names the place.
    ///
    /// Examples
    /// --------
    /// >>> import numpy as np
    /// >>> import vibroimpact as vi
    /// >>> chirp = vi.Signal.from_function(lambda t: np.sin(t * (1 + 0.1 * t)), (0.0, 20.0))
    /// >>> bool(abs(chirp(7.0) - np.sin(7.0 * 1.7)) < 1e-13)
    /// True
    /// >>> step = vi.Signal.from_function(lambda t: np.where(t < 3.0, 0.0, np.cos(t)), (0.0, 20.0), breaks=[3.0])
    /// >>> float(step(2.9)), bool(step(3.0) == np.cos(3.0))
    /// (0.0, True)
    #[staticmethod]
    #[pyo3(signature = (f, span, *, breaks=None), text_signature = "(f, span, *, breaks=())")]
    fn from_function(
        f: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = argument::span)] span: (f64, f64),
        breaks: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let py = f.py();
        let breaks = breaks.map(|breaks| vector("breaks", breaks)).transpose()?;
        let breaks = breaks.map_or_else(Vec::new, |breaks| breaks.as_slice().to_vec());
        let function = Callable::new("f", f)?;
        let ask = |t: &[f64]| -> Result<Vec<f64>, Error> {
            py.check_signals().map_err(Error::function)?;
            let given = PyArray1::from_slice(py, t);
            let values = function.function.bind(py).call1((given,));
            let values = values.and_then(|values| vector("f(t)", &values));
            Ok(values.map_err(Error::function)?.as_slice().to_vec())
        };
        Ok(Self(Signal::from_function_with_breaks(ask, span, &breaks)?))
    }

    /// Breakpoints [s], shape (m + 1,).
    #[getter]
    fn x<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        let breaks: Vec<f64> = self.0.breaks().collect();
        out_vector(py, &DVector::from_vec(breaks)).into_any()
    }

    /// Coefficients of the pieces, the highest power first, shape (degree + 1, m).
    #[getter]
    fn c<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(out_matrix(py, &self.0.coefficients())?.into_any())
    }

    /// The values at times t; where two pieces meet, that of the later.
    ///
    /// Parameters
    /// ----------
    /// t : float or array_like, shape (m,)
    ///     Times [s].
    ///
    /// Returns
    /// -------
    /// float or ndarray, shape (m,)
    fn __call__<'py>(&self, t: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let py = t.py();
        let (times, is_one) = times("t", t)?;
        let values: Vec<f64> = times.iter().map(|&t| self.0.value(t)).collect();
        if is_one {
            return Ok(values[0].into_pyobject(py)?.into_any());
        }
        Ok(out_vector(py, &DVector::from_vec(values)).into_any())
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    pub(super) fn __repr__(&self) -> String {
        let (start, end) = self.0.span();
        let count = self.0.breaks().count() - 1;
        let degree = self.0.degree();
        format!("Signal({count} pieces of degree {degree} on [{start}, {end}])")
    }

    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let (breaks, degree, derivatives, shift, factor) = self.0.parts();
        let array = |x: &[f64]| PyArray1::from_slice(py, x).into_any();
        let parts = (array(breaks), degree, array(derivatives), (shift, factor));
        let restore = py.get_type::<Self>().getattr("_restore")?;
        Ok((restore, parts.into_pyobject(py)?))
    }

    /// A signal as it was saved.
    #[staticmethod]
    fn _restore(
        breaks: &Bound<'_, PyAny>,
        degree: usize,
        derivatives: &Bound<'_, PyAny>,
        moved: (f64, f64),
    ) -> PyResult<Self> {
        let list = |name: &str, x: &Bound<'_, PyAny>| -> PyResult<Vec<f64>> {
            Ok(vector(name, x)?.as_slice().to_vec())
        };
        let (breaks, derivatives) = (list("breaks", breaks)?, list("derivatives", derivatives)?);
        Ok(Self(Signal::from_parts(
            breaks,
            degree,
            derivatives,
            moved,
        )?))
    }
}

fn pieces(
    breaks_name: &str,
    breaks: &Bound<'_, PyAny>,
    coefficients_name: &str,
    coefficients: &Bound<'_, PyAny>,
) -> PyResult<Signal> {
    let breaks = vector(breaks_name, breaks)?;
    let coefficients = numbers::<f64>(coefficients_name, coefficients)?;
    let [rows, columns] = *coefficients.shape else {
        let shown: Vec<String> = coefficients.shape.iter().map(ToString::to_string).collect();
        return Err(PyValueError::new_err(format!(
            "{coefficients_name} has shape ({}), but (degree + 1, m) is needed: one function of time",
            shown.join(", ")
        )));
    };
    let coefficients = DMatrix::from_row_slice(rows, columns, &coefficients.values);
    Ok(Signal::pieces(breaks.as_slice(), &coefficients)?)
}

/// A signal as users give one: samples `(t, values)`, an object with breakpoints `x` and coefficients `c`, or a `Signal`.
pub(crate) fn signal(argument: &str, value: &Bound<'_, PyAny>) -> PyResult<Signal> {
    if let Ok(signal) = value.cast::<PySignal>() {
        return Ok(signal.get().0.clone());
    }
    if let (Ok(x), Ok(c)) = (value.getattr("x"), value.getattr("c")) {
        let extrapolate = value
            .getattr("extrapolate")
            .and_then(|way| way.extract::<String>());
        if extrapolate.is_ok_and(|way| way == "periodic") {
            return Err(PyValueError::new_err(format!(
                "{argument} is a periodic spline, but a signal is zero outside its breakpoints: take Fourier.fit of a period, or a spline over \
                 the run with extrapolate=False"
            )));
        }
        let (breaks, coefficients) = (format!("{argument}.x"), format!("{argument}.c"));
        return pieces(&breaks, &x, &coefficients, &c);
    }
    if value.len().is_ok_and(|len| len == 2)
        && let (Ok(t), Ok(values)) = (value.get_item(0), value.get_item(1))
    {
        let (t, values) = (vector("t", &t)?, vector("values", &values)?);
        return Ok(Signal::samples(t.as_slice(), values.as_slice())?);
    }
    Err(PyTypeError::new_err(format!(
        "{argument} is {}, but {}samples (t, values), a PPoly or a Signal is needed; of a function take Signal.from_function(f, span)",
        value.get_type().name()?,
        if argument == "motion" {
            "a Harmonic, a Fourier, "
        } else {
            ""
        }
    )))
}
