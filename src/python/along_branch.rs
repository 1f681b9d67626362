//! What Python asks of a branch that it has: orbits at a value, functions along it, whether an orbit is one of its.

use crate::branch::{
    BranchNode, ContinuationParameter, MonitorZero, SpecialKind, is_on_branch, monitored, nodes,
    orbits_at,
};
use crate::error::{Error, Result};
use crate::orbit::PeriodicOrbit;
use crate::python::array::number;
use crate::python::interrupt;
use crate::python::made::raised_or;
use crate::python::orbit::PyOrbit;
use crate::python::record::fields;
use crate::python::special::GivenSpecial;
use crate::python::varied::varied;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::sync::Mutex;

/// A branch as Python has it.
#[derive(FromPyObject)]
pub(crate) struct GivenBranch {
    orbits: Vec<Py<PyOrbit>>,
    parameter: Vec<f64>,
    arclength: Vec<f64>,
    special: Vec<GivenSpecial>,
    ends: [(String, String); 2],
    parameter_name: Option<String>,
}

impl GivenBranch {
    /// What a function of the core makes of the branch, and of what varies along it.
    fn asked<'a, T: Send>(
        &'a self,
        py: Python<'_>,
        make: Option<&Py<PyAny>>,
        ask: impl FnOnce(&[BranchNode<'a>], ContinuationParameter<'_>) -> Result<T> + Send,
    ) -> PyResult<T> {
        let orbits = self.orbits.iter().map(|orbit| &orbit.get().0);
        let points = orbits.enumerate();
        let points = points.map(|(k, orbit)| (self.arclength[k], self.parameter[k], orbit));
        let divides =
            |own: &&GivenSpecial| SpecialKind::of_name(&own.kind).is_some_and(SpecialKind::divides);
        let folds = self.special.iter().filter(divides);
        let folds = folds.map(|own| (own.arclength, own.parameter, &own.orbit.get().0));
        let is_doubled = [0, 1].map(|end: usize| self.ends[end].0 == "doubling");
        let nodes = nodes(points, folds, is_doubled);
        let (scene, start) = (self.orbits[0].get().0.scene(), self.parameter[0]);
        let varied = varied(scene, self.parameter_name.as_deref(), make, Some(start))?;
        let raised = Mutex::new(None);
        let found = interrupt::run(py, false, || {
            varied.with(scene, &raised, |parameter| ask(&nodes, parameter))
        });
        raised_or(found, raised)
    }

    /// An orbit as Python has it: that of a point or of a fold itself.
    fn object(&self, py: Python<'_>, orbit: &PeriodicOrbit) -> PyResult<Py<PyOrbit>> {
        let special = self.special.iter().map(|own| &own.orbit);
        let mut own = self.orbits.iter().chain(special);
        match own.find(|own| std::ptr::eq(&raw const own.get().0, orbit)) {
            Some(own) => Ok(own.clone_ref(py)),
            None => Py::new(py, PyOrbit(orbit.clone())),
        }
    }
}

/// Every orbit that a branch has at a value.
#[pyfunction]
pub(crate) fn _orbits_at(
    py: Python<'_>,
    branch: GivenBranch,
    make: Option<Py<PyAny>>,
    value: f64,
) -> PyResult<Vec<Py<PyOrbit>>> {
    let found = branch.asked(py, make.as_ref(), |nodes, parameter| {
        orbits_at(nodes, parameter, value)
    });
    let each = found?.into_iter();
    each.map(|orbit| branch.object(py, &orbit)).collect()
}

/// Whether a branch has an orbit at a value, or its mirror image.
#[pyfunction]
pub(crate) fn _is_on_branch(
    py: Python<'_>,
    branch: GivenBranch,
    make: Option<Py<PyAny>>,
    orbit: &Bound<'_, PyOrbit>,
    value: f64,
) -> PyResult<bool> {
    let orbit = &orbit.get().0;
    branch.asked(py, make.as_ref(), |nodes, parameter| {
        is_on_branch(nodes, (orbit, value), parameter)
    })
}

/// The values of a function of orbits along a branch, and its zeros as special points.
#[pyfunction]
pub(crate) fn _monitored<'py>(
    py: Python<'py>,
    branch: GivenBranch,
    make: Option<Py<PyAny>>,
    name: &str,
    measure: Py<PyAny>,
) -> PyResult<Bound<'py, PyDict>> {
    let object = |py: Python<'_>, orbit: &PeriodicOrbit| branch.object(py, orbit);
    let measure = &mut |orbit: &PeriodicOrbit| {
        let measured = |py: Python<'_>| {
            let value = measure.bind(py).call1((object(py, orbit)?,))?;
            number(&format!("monitor['{name}']"), &value)
        };
        Python::attach(measured).map_err(Error::function)
    };
    let found = branch.asked(py, make.as_ref(), |nodes, parameter| {
        monitored(nodes, parameter, name, measure)
    })?;
    let kind = format!("user:{name}");
    let zeros = found.zeros.into_iter().map(|own| zero(py, &kind, own));
    let zeros = PyList::new(py, zeros.collect::<PyResult<Vec<_>>>()?)?;
    Ok(fields!(py, found => values; zeros: zeros.into_any()))
}

/// A zero as a special point.
fn zero<'py>(py: Python<'py>, kind: &str, own: MonitorZero) -> PyResult<Bound<'py, PyDict>> {
    let none = None::<usize>;
    Ok(fields!(py, own => parameter error arclength orbit;
        kind: kind.to_owned();
        stop: none;
        time: none;
        data: PyDict::new(py);
        direction: Vec::<f64>::new();
    ))
}
