//! Arguments that are called otherwise elsewhere: a constructor or function answers with the name that exists here.

use pyo3::PyClass;
use pyo3::exceptions::{PyAttributeError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// What an argument is called in other programs and texts, and behind the arrow what here; the first of these that is taken is meant.
const OTHER_NAMES: &str = "
force forces f0 load drive forcing_amplitude -> forcing_scale
m masses mass_matrix -> mass masses mass_ratio
c d damping_matrix dampings zeta -> damping
k stiffness_matrix stiff spring -> stiffness
l length -> lengths length_ratio
g -> gravity
w omega freq angular_frequency f -> frequency
phi phase_angle theta -> phase
a amp amplitudes amplitude force f0 -> amplitude amplitudes
e r cor coefficient restitution_coefficient -> restitution
gap distance position clearance delta -> clearance position
n direction coordinate dof index -> normal bob direction
jac gradient dgap -> jacobian gradient
f fun rhs func -> acceleration gap
p params args -> parameters
force forces excitation drive -> forcing
stop walls wall obstacles constraints -> stops
tspan span time t tend t_end -> t_span
x0 y0 q position0 -> q0
dq0 qd0 v velocity0 -> v0
teval times saveat -> t_eval
tol reltol abstol -> rtol atol
param parameter name values range par -> axis x parameter between parameters
transient settle discard warmup -> skip transient
period periods m -> n_periods periods
n_workers threads n_jobs pool executor client -> workers
modes n -> n_modes
x positions displacement displacements pos -> q position
xdot dq velocities speed vel -> v velocity
time times ts -> t
multipliers eigenvalues floquet floquet_exponents -> floquet_multipliers multipliers
stable -> is_stable
admissible valid -> is_admissible
specials special_points bifurcations specialpoint -> special
parameters value values param p -> parameter
events hits collisions contacts -> impacts
";

/// The name here of what is called so elsewhere, among the names of some arguments.
pub(crate) fn name_here<'a>(given: &str, names: &[&'a str]) -> Option<&'a str> {
    let given = given.to_lowercase();
    let lines = OTHER_NAMES
        .lines()
        .filter_map(|line| line.split_once(" -> "));
    let meant = lines.filter(|(others, _)| others.split(' ').any(|other| other == given));
    let mut here = meant.flat_map(|(_, here)| here.split(' '));
    here.find_map(|here| names.iter().find(|name| **name == here).copied())
}

/// The numbers of a scene.
const OF_SCENES: [&str; 10] = [
    "forcing_scale",
    "frequency",
    "phase",
    "clearance",
    "restitution",
    "contact_stiffness",
    "contact_damping",
    "preload",
    "contact_exponent",
    "amplitude",
];

/// What is said of a number of a scene that is called otherwise elsewhere; nothing of others.
pub(crate) fn called_here(given: &str) -> String {
    let here = name_here(given, &OF_SCENES);
    here.map_or(String::new(), |here| format!(" (it is called {here} here)"))
}

/// What an unknown name is answered with.
pub(crate) fn unknown(of: &str, given: &str, names: &[&str]) -> String {
    let all = names.join(", ");
    match name_here(given, names) {
        Some(here) => format!("{of} has no {given}: it is called {here} here (of {all})"),
        None => format!("{of} has no {given}: it has {all}"),
    }
}

/// What a result answers that is asked for an attribute which it has not: with the name here, or with all that it has.
pub(crate) fn no_attribute(of: &Bound<'_, PyAny>, given: &str) -> PyErr {
    let class = of.get_type();
    let name = class
        .name()
        .map_or_else(|_| "this".to_owned(), |name| name.to_string());
    if given.starts_with('_') {
        return PyAttributeError::new_err(format!("{name} has no {given}"));
    }
    let listed = class
        .as_any()
        .dir()
        .and_then(|names| names.extract::<Vec<String>>());
    let mut names = listed.unwrap_or_default();
    names.retain(|name| !name.starts_with('_'));
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    PyAttributeError::new_err(unknown(&name, given, &names))
}

/// What Python's functions answer an unknown name with.
#[pyfunction]
#[pyo3(signature = (of, given, names, /))]
pub(crate) fn _unknown(of: &str, given: &str, names: Vec<String>) -> String {
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    unknown(of, given, &names)
}

/// A value of a class by its static method `_made`, which takes the arguments; a name that it has not is answered with those that it has.
pub(crate) fn answered<T: PyClass<Frozen = pyo3::pyclass::boolean_struct::True> + Clone + Sync>(
    arguments: &Bound<'_, PyTuple>,
    named: Option<&Bound<'_, PyDict>>,
) -> PyResult<T> {
    let class = arguments.py().get_type::<T>();
    match class.getattr("_made")?.call(arguments, named) {
        Ok(made) => Ok(made.cast::<T>()?.get().clone()),
        Err(error) => Err(explained(
            &class.name()?.to_string(),
            class.as_any(),
            named,
            error,
        )?),
    }
}

/// The error of a constructor, by the class's own name, about a name that it has not before one that is missing.
fn explained(
    of: &str,
    class: &Bound<'_, PyAny>,
    named: Option<&Bound<'_, PyDict>>,
    error: PyErr,
) -> PyResult<PyErr> {
    let py = class.py();
    if !error.is_instance_of::<PyTypeError>(py) {
        return Ok(error);
    }
    let message = error.value(py).to_string();
    let Some(rest) = message.strip_prefix(&format!("{of}._made()")) else {
        return Ok(error);
    };
    let signature = py.import("inspect")?.call_method1("signature", (class,))?;
    let all = signature.getattr("parameters")?;
    let all: Vec<String> = all
        .try_iter()?
        .map(|name| name?.extract())
        .collect::<PyResult<_>>()?;
    let names: Vec<&str> = all.iter().map(String::as_str).collect();
    for (given, _) in named.into_iter().flat_map(PyDictMethods::iter) {
        let given: String = given.extract()?;
        if !all.contains(&given) {
            return Ok(PyTypeError::new_err(unknown(of, &given, &names)));
        }
    }
    let taken = if rest.contains("takes") {
        format!(": {}", all.join(", "))
    } else {
        String::new()
    };
    Ok(PyTypeError::new_err(format!("{of}(){rest}{taken}")))
}
