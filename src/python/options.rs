//! Options that a function of the Python package hands on in a dict, by the names of its own arguments; and what runs its work.

use crate::error::Result;
use crate::python::argument::{ArgumentKind, given};
use crate::python::interrupt;
use crate::python::simulate;
use crate::simulate::Solver;
use crate::sweep::SweepOptions;
use pyo3::conversion::FromPyObjectOwned;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Options by their names.
#[derive(FromPyObject)]
pub(crate) struct Options<'py>(Bound<'py, PyDict>);

impl<'py> Options<'py> {
    /// An option as it is.
    fn any(&self, name: &str) -> PyResult<Bound<'py, PyAny>> {
        self.0.as_any().get_item(name)
    }

    /// An option as it is, where it is not None.
    pub fn any_or_none(&self, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        Ok(Some(self.any(name)?).filter(|own| !own.is_none()))
    }

    /// An option of a type; the message of another type names it.
    pub fn get<T: FromPyObjectOwned<'py> + ArgumentKind>(&self, name: &str) -> PyResult<T> {
        given(name, &self.any(name)?)
    }

    /// A whole number that counts something.
    pub fn count(&self, name: &str, least: i64) -> PyResult<usize> {
        count(name, self.get(name)?, least)
    }

    /// A whole number that counts something, where there is one.
    pub fn count_or_none(&self, name: &str, least: i64) -> PyResult<Option<usize>> {
        let value: Option<i64> = self.get(name)?;
        value.map(|value| count(name, value, least)).transpose()
    }

    /// What runs a scene.
    pub fn solver(&self) -> PyResult<Solver> {
        simulate::solver(
            &self.get::<String>("method")?,
            self.get("rtol")?,
            self.get("atol")?,
        )
    }

    /// The one of three values that stands for the direction "up", "down" or "both".
    pub fn direction<T>(&self, [up, down, both]: [T; 3]) -> PyResult<T> {
        match self.get::<String>("direction")?.as_str() {
            "up" => Ok(up),
            "down" => Ok(down),
            "both" => Ok(both),
            other => Err(PyValueError::new_err(format!(
                "direction is \"{other}\", but it must be \"up\", \"down\" or \"both\""
            ))),
        }
    }
}

/// A whole number that counts something.
fn count(argument: &str, value: i64, least: i64) -> PyResult<usize> {
    let count = usize::try_from(value).ok().filter(|_| value >= least);
    count.ok_or_else(|| {
        let rule = format!("it must be at least {least}");
        PyValueError::new_err(format!("{argument} is {value}, but {rule}"))
    })
}

/// What runs a piece of work: threads (`None`: one for each core), whether it shows progress, and what it asks whether to go on.
#[derive(FromPyObject)]
pub(crate) struct Engine<'py>(Option<usize>, Bound<'py, PyAny>, Option<Py<PyAny>>);

impl Engine<'_> {
    pub fn sweep(&self) -> SweepOptions {
        SweepOptions { threads: self.0 }
    }

    /// Runs work with the interpreter released, and observed.
    pub fn run<T: Send>(&self, work: impl FnOnce() -> Result<T> + Send) -> PyResult<T> {
        let progress = given("progress", &self.1)?;
        interrupt::run_asking(self.1.py(), progress, self.2.as_ref(), work)
    }
}
