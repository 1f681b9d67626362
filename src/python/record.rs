//! Results on their way to Python: their fields by the names that `results/record.py` declares, in a dict.

use crate::attractor::AttractorKind;
use crate::branch::{BeyondOutcome, BranchEnd, SpecialKind};
use crate::continuation::EndReason;
use crate::exponents::Attraction;
use crate::orbit::Pattern;
use crate::python::array::{out_complex, out_matrix, out_vector};
use crate::python::pattern::out_pattern;
use crate::simulate::Status;
use nalgebra::{Complex, DMatrix, DVector};
use numpy::IntoPyArray;
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

/// What a field of a result may hold: what Python has of it.
pub(crate) trait Field<'py> {
    fn field(self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>>;
}

/// What Python has of values of some types.
macro_rules! field {
    ($($type:ty),* => |$own:ident, $py:ident| $field:expr) => {$(
        impl<'py> $crate::python::record::Field<'py> for $type {
            fn field(self, $py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
                let $own = self;
                Ok($field.into_any())
            }
        }
    )*};
}
pub(crate) use field;

/// The fields of a result: those named of a value of the core, then others.
macro_rules! fields {
    ($py:expr, $of:expr => $($own:ident)* $(; $name:ident: $field:expr)* $(;)?) => {{
        use $crate::python::record::Field;
        let fields = pyo3::types::PyDict::new($py);
        $(fields.set_item(stringify!($own), Field::field($of.$own, $py)?)?;)*
        $(fields.set_item(stringify!($name), Field::field($field, $py)?)?;)*
        fields
    }};
}
pub(crate) use fields;

/// A list, of which a result makes a tuple.
pub(crate) fn objects<'py, T: Field<'py>>(
    py: Python<'py>,
    each: Vec<T>,
) -> PyResult<Bound<'py, PyList>> {
    let each = each.into_iter().map(|own| own.field(py));
    PyList::new(py, each.collect::<PyResult<Vec<_>>>()?)
}

fn integer(count: usize) -> i64 {
    i64::try_from(count).unwrap_or(i64::MAX)
}

field!(bool, f64, i64, usize, u32, String, &str, [f64; 2], Vec<String>, PyErr => |own, py| own.into_bound_py_any(py)?);
field!(Vec<f64>, Vec<bool>, Vec<u32>, Vec<i64>, Vec<i32>, Vec<i16> => |own, py| own.into_pyarray(py));
// Names that stand for a choice.
field!(AttractorKind, Attraction, BeyondOutcome, EndReason, SpecialKind, Status => |own, py| own.name().field(py)?);
field!(Vec<Pattern>, Vec<Status> => |own, py| objects(py, own)?);
field!(Vec<usize> => |own, py| own.into_iter().map(integer).collect::<Vec<_>>().field(py)?);
// Stops, or how many there are, -1 where there is none; verdicts, false where nothing is decided.
field!(Vec<Option<usize>> => |own, py| own.into_iter().map(|own| own.map_or(-1, integer)).collect::<Vec<_>>().field(py)?);
field!(Vec<Option<bool>> => |own, py| own.into_iter().map(|own| own == Some(true)).collect::<Vec<_>>().field(py)?);
field!(&Vec<f64> => |own, py| own.clone().into_pyarray(py));
field!(DVector<f64> => |own, py| out_vector(py, &own));
field!(&DVector<f64> => |own, py| out_vector(py, own));
field!(&DVector<Complex<f64>> => |own, py| out_complex(py, own));
field!(DMatrix<f64>, DMatrix<Complex<f64>> => |own, py| out_matrix(py, &own)?);
field!(&DMatrix<f64> => |own, py| out_matrix(py, own)?);
field!(Pattern => |own, py| out_pattern(py, &own)?);
field!([BranchEnd; 2] => |own, py| own.map(|end| (end.reason.name(), end.detail)).into_pyobject(py)?);
field!(Bound<'py, PyAny>, Bound<'py, PyDict>, Bound<'py, PyList> => |own, _py| own);

impl<'py, T: Field<'py>> Field<'py> for Option<T> {
    fn field(self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.map_or_else(|| Ok(py.None().into_bound(py)), |own| own.field(py))
    }
}

/// A class of plain values: its attributes, which are also what pickle keeps of it in their order, and its other methods.
macro_rules! plain_class {
    ($(#[$outer:meta])* $class:ident |$own:ident| { $($(#[$doc:meta])* $name:ident: $value:expr,)* } $($rest:tt)*) => {
        #[pymethods]
        $(#[$outer])*
        impl $class {
            $(
                $(#[$doc])*
                #[getter]
                fn $name<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
                    let $own = &self.0;
                    $crate::python::record::Field::field($value, py)
                }
            )*

            fn __getnewargs__<'py>(
                &self,
                py: Python<'py>,
            ) -> PyResult<Bound<'py, pyo3::types::PyTuple>> {
                pyo3::types::PyTuple::new(py, [$(self.$name(py)?),*])
            }

            $($rest)*
        }
    };
}
pub(crate) use plain_class;
