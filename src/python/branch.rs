//! Branches in Python.

use crate::branch::{Branch, ContinuationOptions, Heading, Virtual};
use crate::error::Result;
use crate::observer::unobserved;
use crate::orbit::PeriodicOrbit;
use crate::python::options::Options;
use crate::python::orbit::PyOrbit;
use crate::python::record::fields;
use crate::python::text::shown;
use crate::python::varied::varied;
use crate::python::{argument, interrupt};
use nalgebra::{Complex, DMatrix};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Mutex;

impl Options<'_> {
    /// How a curve is followed.
    pub fn of_continuation(&self) -> PyResult<ContinuationOptions> {
        let (smallest, first, largest) = self.get("step")?;
        Ok(ContinuationOptions {
            heading: self.direction([Heading::Up, Heading::Down, Heading::Both])?,
            max_points: self.count("max_points", 1)?,
            steps: [smallest, first, largest],
            ..ContinuationOptions::default()
        })
    }
}

/// The fields of a branch of an orbit over a number of its scene, or over scenes that a function makes, and the exception that broke it off.
#[pyfunction]
pub(crate) fn _continuation<'py>(
    py: Python<'py>,
    orbit: &Bound<'py, PyAny>,
    name: Option<String>,
    make: Option<Py<PyAny>>,
    #[pyo3(from_py_with = argument::start)] start: Option<f64>,
    between: (f64, f64),
    options: Options<'py>,
) -> PyResult<(Bound<'py, PyDict>, Option<PyErr>)> {
    let progress = options.get("progress")?;
    let options = ContinuationOptions {
        beyond: if options.get("keeps_virtual")? {
            Virtual::Keep
        } else {
            Virtual::Stop
        },
        symmetric: options.get("symmetric")?,
        ..options.of_continuation()?
    };
    let orbit = orbit.extract::<PyRef<'_, PyOrbit>>().map_err(|_| {
        let found = shown(orbit);
        PyTypeError::new_err(format!("orbit is {found}, but an Orbit is needed"))
    })?;
    let own = &orbit.0;
    let varied = varied(own.scene(), name.as_deref(), make.as_ref(), start)?;
    let raised = Mutex::new(None);
    let (found, signal) = interrupt::run_keeping(py, progress, None, || {
        let found = varied.with(own.scene(), &raised, |parameter| {
            parameter.continuation((own, varied.start()), between, &options)
        });
        // What was followed is kept, and judged, when the rest is broken off.
        found.and_then(|branch| unobserved(|| judged(branch)))
    })?;
    let raised = raised.into_inner().ok().flatten();
    let (found, raised) = match (found, raised) {
        (Ok(found), raised) => (found, raised.or(signal)),
        // Before there is a branch.
        (Err(_), Some(raised)) => return Err(raised),
        (Err(error), None) => return Err(signal.unwrap_or_else(|| error.into())),
    };
    Ok((out(py, found)?, raised))
}

/// A branch whose orbits have been judged, with what was found.
struct Judged {
    branch: Branch,
    is_admissible: Vec<Option<bool>>,
    is_stable: Vec<Option<bool>>,
    n_unstable: Vec<Option<usize>>,
    multipliers: DMatrix<Complex<f64>>,
}

fn judged(branch: Branch) -> Result<Judged> {
    let nan = Complex::new(f64::NAN, f64::NAN);
    let first = branch.orbits.first();
    let mut multipliers = DMatrix::from_element(
        branch.orbits.len(),
        2 * first.map_or(0, |orbit| orbit.scene().n_dof()),
        nan,
    );
    // Of many modes they were counted without an eigenproblem.
    let known = if branch.outside.is_none() {
        branch.orbits.as_slice()
    } else {
        &[]
    };
    for (k, orbit) in known.iter().enumerate() {
        let stability = orbit.stability()?;
        if let Some(order) = stability.orders.first() {
            let own = order.multipliers.transpose();
            // Of a stop that relaxes as the period begins there is one more.
            if own.len() > multipliers.ncols() {
                multipliers = multipliers.resize_horizontally(own.len(), nan);
            }
            multipliers.view_mut((k, 0), (1, own.len())).copy_from(&own);
        }
    }
    Ok(Judged {
        is_admissible: branch
            .orbits
            .iter()
            .map(PeriodicOrbit::is_admissible)
            .collect(),
        is_stable: branch.is_stable()?,
        n_unstable: branch.n_unstable()?,
        multipliers,
        branch,
    })
}

fn out(py: Python<'_>, found: Judged) -> PyResult<Bound<'_, PyDict>> {
    Ok(
        fields!(py, found.branch => orbits parameter arclength special ends is_closed;
            is_admissible: found.is_admissible;
            is_stable: found.is_stable;
            n_unstable: found.n_unstable;
            multipliers: found.multipliers;
        ),
    )
}
