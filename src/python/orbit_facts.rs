//! What is known of a periodic orbit, in Python: coefficients, violation, family, stability.

use crate::error::Error;
use crate::orbit::{Coefficients, Family, OrderMultipliers, Stability, Violation};
use crate::python::argument;
use crate::python::array::{complex_vector, matrix, out_complex, out_matrix, vector};
use crate::python::record::plain_class;
use crate::quantity::{finite, finite_square, finite_vector};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// Coefficients of eq. (14) in the mass-normalised modes, ascending; t = 0 just after the first impact.
#[pyclass(name = "Coefficients", module = "vibroimpact", frozen)]
pub(crate) struct PyCoefficients(pub Coefficients);

plain_class! { #[allow(non_snake_case)] /* the paper's letters */ PyCoefficients |own| {
    /// Cosine amplitudes of the free motion [m], shape (n,).
    a: &own.a,
    /// Sine amplitudes of the free motion [m], shape (n,).
    b: &own.b,
    /// Sine amplitudes of the steady response [m], shape (n,).
    A: &own.sine,
    /// Cosine amplitudes of the steady response [m], shape (n,).
    B: &own.cosine,
}

    #[new]
    fn new(
        a: &Bound<'_, PyAny>,
        b: &Bound<'_, PyAny>,
        A: &Bound<'_, PyAny>,
        B: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let a = vector("a", a)?;
        let like_a = |name: &str, value| -> PyResult<_> {
            let values = vector(name, value)?;
            finite_vector(name, &values, a.len())?;
            Ok(values)
        };
        let (b, sine, cosine) = (like_a("b", b)?, like_a("A", A)?, like_a("B", B)?);
        finite_vector("a", &a, a.len())?;
        Ok(Self(Coefficients { a, b, sine, cosine }))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!(
            "Coefficients(a={}, b={}, A={}, B={})",
            self.a(py)?.repr()?,
            self.b(py)?.repr()?,
            self.A(py)?.repr()?,
            self.B(py)?.repr()?
        ))
    }
}

/// Where and by how much an orbit breaks the rules of contact.
#[pyclass(name = "Violation", module = "vibroimpact", frozen)]
pub(crate) struct PyViolation(pub Violation);

plain_class! { PyViolation |own| {
    /// The stop.
    stop: own.stop,
    /// Time of the deepest point, or of the impact [s].
    time: own.time,
    /// How far the stop is passed [m]; zero where an impulse pulls.
    depth: own.depth,
    /// The rule that is broken, in words.
    reason: own.reason.as_str(),
}

    #[new]
    fn new(
        stop: &Bound<'_, PyAny>,
        time: &Bound<'_, PyAny>,
        depth: &Bound<'_, PyAny>,
        reason: String,
    ) -> PyResult<Self> {
        let number = |name, value| -> PyResult<f64> {
            let number = argument::saved(name, value)?;
            Ok(finite(name, number)?)
        };
        Ok(Self(Violation {
            stop: argument::saved("stop", stop)?,
            time: number("time", time)?,
            depth: number("depth", depth)?,
            reason,
        }))
    }

    fn __repr__(&self) -> String {
        format!("Violation({})", self.0.reason)
    }
}

/// The directions of a family of orbits.
#[pyclass(name = "Family", module = "vibroimpact", frozen)]
pub(crate) struct PyFamily(pub Family);

/// A family from its basis, shape (2n, dimension).
pub(crate) fn family(basis: &Bound<'_, PyAny>) -> PyResult<Family> {
    let basis = matrix("basis", basis)?;
    if basis.nrows() % 2 == 1 || basis.ncols() > basis.nrows() {
        let found = format!("({}, {})", basis.nrows(), basis.ncols());
        return Err(Error::bad_shape("basis", found, "(2n, dimension)").into());
    }
    match basis.iter().find(|x| !x.is_finite()) {
        None => Ok(Family { basis }),
        Some(x) => Err(Error::bad_value("basis", x, "it must be finite").into()),
    }
}

plain_class! { PyFamily |own| {
    /// Directions [m, m/s] of the contact state (q, v) in which the orbit may be changed, shape (2n, dimension).
    basis: &own.basis,
}

    #[new]
    fn new(basis: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(Self(family(basis)?))
    }

    /// Number of directions.
    #[getter]
    fn dimension(&self) -> usize {
        self.0.basis.ncols()
    }

    fn __repr__(&self) -> String {
        format!("Family(dimension={})", self.0.basis.ncols())
    }
}

/// Whether small deviations die out.
#[pyclass(name = "Stability", module = "vibroimpact", frozen)]
pub(crate) struct PyStability(pub Stability);

/// One order of impacts as plain values: stops, multipliers, monodromy matrix.
type OrderTuple<'py> = (Vec<usize>, Bound<'py, PyAny>, Bound<'py, PyAny>);

#[pymethods]
impl PyStability {
    #[new]
    fn new(is_stable: Option<bool>, reason: String, orders: &Bound<'_, PyAny>) -> PyResult<Self> {
        let orders: Vec<OrderTuple<'_>> = argument::saved("orders", orders)?;
        let orders = orders
            .into_iter()
            .map(|(order, multipliers, monodromy)| {
                let multipliers = complex_vector("multipliers", &multipliers)?;
                let monodromy = matrix("monodromy", &monodromy)?;
                let n = multipliers.len();
                finite_vector("multipliers", &multipliers.map(|z| z.re + z.im), n)?;
                finite_square("monodromy", &monodromy, n)?;
                Ok(OrderMultipliers {
                    order,
                    multipliers,
                    monodromy,
                })
            })
            .collect::<PyResult<_>>()?;
        Ok(Self(Stability {
            is_stable,
            reason,
            orders,
        }))
    }

    fn __getnewargs__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Option<bool>, &str, Vec<OrderTuple<'py>>)> {
        let orders = self.0.orders.iter().map(|o| {
            let multipliers = out_complex(py, &o.multipliers).into_any();
            Ok((
                o.order.clone(),
                multipliers,
                out_matrix(py, &o.monodromy)?.into_any(),
            ))
        });
        Ok((
            self.0.is_stable,
            &self.0.reason,
            orders.collect::<PyResult<_>>()?,
        ))
    }

    /// All multipliers inside the unit circle, in every order; None where that decides nothing.
    #[getter]
    fn is_stable(&self) -> Option<bool> {
        self.0.is_stable
    }

    /// What was decided, and on what ground.
    #[getter]
    fn reason(&self) -> &str {
        &self.0.reason
    }

    /// Floquet multipliers of every order of the impacts, {tuple of stops: (2n,) complex}, the worst first.
    #[getter]
    fn orders<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let orders = PyDict::new(py);
        for order in &self.0.orders {
            orders.set_item(
                PyTuple::new(py, &order.order)?,
                out_complex(py, &order.multipliers),
            )?;
        }
        Ok(orders)
    }

    fn __repr__(&self) -> String {
        format!("Stability({})", self.0.reason)
    }
}
