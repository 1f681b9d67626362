//! Lists of periodic orbits in Python, and the search that makes them.

use crate::model::Parameter;
use crate::orbit::{self, Family, FreeParameter, OrbitOptions, Orbits, Verdict};
use crate::python::answered::no_attribute;
use crate::python::array::out_matrix;
use crate::python::model::PyScene;
use crate::python::orbit::PyOrbit;
use crate::python::orbit_facts::{PyFamily, family};
use crate::python::pattern::pattern;
use crate::python::text::html;
use crate::python::{argument, files, interrupt};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyList, PySlice, PyTuple};

/// Every orbit of a pattern: stable and admissible ones first, then admissible ones, then undecided ones, then by depth of violation.
///
/// In systems of more than 60 degrees of freedom stability has no say in the order: the multipliers, which cost O(n^3), are
/// computed only when asked for.
#[pyclass(name = "Orbits", module = "vibroimpact", frozen)]
pub(crate) struct PyOrbits {
    orbits: Vec<Py<PyOrbit>>,
    verdict: Verdict,
    reason: String,
    margin: Option<f64>,
    family: Option<Family>,
}

impl PyOrbits {
    fn wrap(py: Python<'_>, orbits: Orbits) -> PyResult<Self> {
        let (verdict, reason) = (orbits.verdict(), orbits.reason().to_owned());
        let (margin, family) = (orbits.margin(), orbits.family().cloned());
        let orbits = orbits
            .into_iter()
            .map(|o| Py::new(py, PyOrbit(o)))
            .collect::<PyResult<Vec<_>>>()?;
        Ok(Self {
            orbits,
            verdict,
            reason,
            margin,
            family,
        })
    }
}

#[pymethods]
impl PyOrbits {
    /// "found", "none" or "family".
    #[getter]
    fn verdict(&self) -> &'static str {
        match self.verdict {
            Verdict::Found => "found",
            Verdict::None => "none",
            Verdict::Family => "family",
        }
    }

    /// Why, in words.
    #[getter]
    fn reason(&self) -> &str {
        &self.reason
    }

    /// ``1 - |d|/|alpha|`` [-]: distance of the parameters from the fold where orbits meet and vanish; negative: none.
    #[getter]
    fn margin(&self) -> Option<f64> {
        self.margin
    }

    /// The family, where the verdict is one.
    #[getter]
    fn family(&self) -> Option<PyFamily> {
        self.family.clone().map(PyFamily)
    }

    fn __len__(&self) -> usize {
        self.orbits.len()
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let orbits: Vec<Py<PyOrbit>> = self.orbits.iter().map(|o| o.clone_ref(py)).collect();
        PyTuple::new(py, orbits)?.call_method0("__iter__")
    }

    fn __reversed__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let orbits: Vec<Py<PyOrbit>> = self.orbits.iter().rev().map(|o| o.clone_ref(py)).collect();
        PyTuple::new(py, orbits)?.call_method0("__iter__")
    }

    fn __getitem__<'py>(
        &self,
        py: Python<'py>,
        index: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let n = isize::try_from(self.orbits.len()).unwrap_or(isize::MAX);
        if let Ok(slice) = index.cast::<PySlice>() {
            let range = slice.indices(n)?;
            let picked = (0..range.slicelength).map(|k| {
                let i = range.start + range.step * isize::try_from(k).unwrap_or(0);
                self.orbits[usize::try_from(i).unwrap_or(0)].clone_ref(py)
            });
            return Ok(PyTuple::new(py, picked.collect::<Vec<_>>())?.into_any());
        }
        let i: isize = index.extract()?;
        let i = if i < 0 { i + n } else { i };
        match usize::try_from(i).ok().and_then(|i| self.orbits.get(i)) {
            Some(orbit) => Ok(orbit.bind(py).clone().into_any()),
            None => Err(PyIndexError::new_err(format!(
                "there are {n} orbits: {}",
                self.reason
            ))),
        }
    }

    fn _repr_html_(slf: &Bound<'_, Self>) -> PyResult<String> {
        html(slf.as_any(), "orbits")
    }

    fn __getattr__(slf: &Bound<'_, Self>, name: &str) -> PyResult<()> {
        Err(no_attribute(slf.as_any(), name))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let margin = self
            .margin
            .map_or_else(String::new, |m| format!(", margin {m:.6}"));
        let mut text = format!("Orbits: {} ({}{margin})", self.verdict(), self.reason);
        for orbit in self.orbits.iter().take(4) {
            text.push('\n');
            text.push_str(&orbit.bind(py).get().__repr__(py)?);
        }
        Ok(text)
    }

    /// Write the list to a file, from which ``load`` reads it again, equal to the bit.
    ///
    /// The file is an ``.npz`` archive of arrays with a header in JSON: the versions of the format and of the library, the scene, and what
    /// the list is made of. Nothing in it is pickled.
    ///
    /// Parameters
    /// ----------
    /// path : str or path-like
    ///     The file, as it is to be called.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     A scene with functions (NonlinearSystem, NonlinearStop), which a file cannot hold.
    fn save(slf: &Bound<'_, Self>, path: &Bound<'_, PyAny>) -> PyResult<()> {
        files::save(slf.as_any(), path)
    }

    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let orbits: Vec<Py<PyOrbit>> = self.orbits.iter().map(|o| o.clone_ref(py)).collect();
        let basis = match &self.family {
            Some(family) => out_matrix(py, &family.basis)?.into_any(),
            None => py.None().into_bound(py),
        };
        let arguments = PyTuple::new(
            py,
            [
                PyList::new(py, orbits)?.into_any(),
                self.verdict().into_pyobject(py)?.into_any(),
                self.reason.clone().into_pyobject(py)?.into_any(),
                self.margin.into_pyobject(py)?.into_any(),
                basis,
            ],
        )?;
        Ok((
            py.import("vibroimpact._core")?.getattr("_restore_orbits")?,
            arguments,
        ))
    }
}

/// A list of orbits from what it was saved as; used by pickle.
#[pyfunction]
pub(crate) fn _restore_orbits(
    orbits: &Bound<'_, PyAny>,
    verdict: &str,
    reason: String,
    margin: &Bound<'_, PyAny>,
    basis: Option<&Bound<'_, PyAny>>,
) -> PyResult<PyOrbits> {
    let orbits: Vec<Py<PyOrbit>> = argument::saved("orbits", orbits)?;
    let margin: Option<f64> = argument::saved("margin", margin)?;
    let refused = |message: String| Err(PyValueError::new_err(message));
    let verdict = match verdict {
        "found" => Verdict::Found,
        "family" => Verdict::Family,
        "none" => Verdict::None,
        _ => {
            return refused(format!(
                "verdict is {verdict:?}, but there is no such verdict"
            ));
        }
    };
    if (verdict == Verdict::Found) == orbits.is_empty() && verdict != Verdict::Family {
        return refused(format!(
            "verdict is {verdict:?}, but there are {} orbits",
            orbits.len()
        ));
    }
    if margin.is_some_and(f64::is_nan) {
        return refused("margin is nan, but it must be a number or None".to_owned());
    }
    let family = basis.map(family).transpose()?;
    Ok(PyOrbits {
        orbits,
        verdict,
        reason,
        margin,
        family,
    })
}

/// Every periodic orbit of a linear, forced scene that hits stops in the given pattern.
///
/// Parameters
/// ----------
/// scene : Scene
///     A linear scene with a forcing.
/// pattern : list
///     Indices of stops in order of impact; a tuple is hit at one instant; ``[]``: none is hit.
/// n_periods : int, default 1
///     Forcing periods in one period of the orbit.
/// phase : float, optional
///     Forcing phase at the first impact [rad]: the clearances of the stops in the pattern come out, as in the paper. Without
///     it the clearances are given and the phases found.
/// free : str, optional
///     One more unknown, as stops hit at one instant need: "clearance" (all times one factor), or a name of
///     ``Scene.replace``.
/// between : pair of float, optional
///     Range in which a free parameter is searched; "clearance" and "forcing_scale" need none.
///
/// Returns
/// -------
/// Orbits
///     A sequence: stable and admissible orbits first, then admissible ones, then those of which the search could not decide it
///     (``is_admissible`` is None), then by depth of violation; with ``verdict``,
///     ``reason``, ``margin``, ``family``. In systems of more than 60 degrees of freedom admissible orbits come first, stable
///     or not: the multipliers, which cost O(n^3), are computed only when asked for.
///
/// Raises
/// ------
/// ValueError
///     A nonlinear or unforced scene, a pattern that does not fit it, options that contradict each other; of stops that give way other
///     patterns than ``[i]``, and ``[i, j]`` of two that are each other's images; a motion that
///     outgrows the doubles within a period, a period of more than 1e12 turns of the fastest mode, whose phase is lost.
/// ConvergenceError
///     If an eigenvalue iteration fails.
///
/// Notes
/// -----
/// With R the recovery matrix, s the steady response and T the period, ``(I - R e^{AT}) z = (R - I) s(0)`` gives the contact
/// state ``x(0+) = z + s(0)``: eqs. (29) and (38) of [1]_, for any number of modes and any R.
///
/// A pattern of two instants is searched in the flight time between them, every one of which is an orbit's or excluded by
/// bounds; ``reason`` says what was proved. Flight times nearer to 0 or the period than 1e-9 of it are not searched,
/// ``margin`` is None there, ``free`` is not taken, and of undamped modes in step with the period there may be four.
///
/// Of a stop (``Spring``) that gives way every orbit is found that has one contact with it in the period, of two such stops, each the image of the other in
/// a scene that is odd, those that are their own images half a period later: by an equation in the duration of the contact, every one of
/// which is an orbit's or excluded by bounds. Stops of any law that are not met may stand by.
///
/// References
/// ----------
/// .. [1] "Periodic Solution of a Non-Smooth Double Pendulum with Unilateral Rigid Constrain", Symmetry 2019, 11(7), 886.
///
/// Examples
/// --------
/// >>> import vibroimpact as vi
/// >>> scene = vi.paper_scene(kind=3)
/// >>> orbits = vi.periodic_orbits(scene, pattern=[1], n_periods=2)
/// >>> orbits.verdict, len(orbits), orbits[0].is_admissible, orbits[0].is_stable
/// ('found', 2, True, True)
#[pyfunction]
#[pyo3(signature = (scene, pattern, n_periods=1, *, phase=None, free=None, between=None))]
pub(crate) fn periodic_orbits(
    py: Python<'_>,
    #[pyo3(from_py_with = argument::scene)] scene: PyRef<'_, PyScene>,
    pattern: &Bound<'_, PyAny>,
    #[pyo3(from_py_with = argument::n_periods)] n_periods: i64,
    #[pyo3(from_py_with = argument::phase)] phase: Option<f64>,
    #[pyo3(from_py_with = argument::free)] free: Option<&str>,
    #[pyo3(from_py_with = argument::between)] between: Option<(f64, f64)>,
) -> PyResult<PyOrbits> {
    let pattern = self::pattern(pattern)?;
    let n_periods = usize::try_from(n_periods).map_err(|_| {
        PyValueError::new_err(format!(
            "n_periods is {n_periods}, but it must be at least 1"
        ))
    })?;
    let free = match free {
        None => None,
        Some("clearance") => Some(FreeParameter::Clearance),
        Some(name) => {
            let parameter = name.parse::<Parameter>().map_err(|e| {
                PyValueError::new_err(format!("free: {}", PyErr::from(e).value(py)))
            })?;
            Some(FreeParameter::Parameter(parameter))
        }
    };
    let options = OrbitOptions {
        n_periods,
        phase,
        free,
        between,
    };
    let core = &scene.0;
    let orbits = interrupt::run(py, false, || {
        orbit::periodic_orbits(core, &pattern, &options)
    })?;
    PyOrbits::wrap(py, orbits)
}
