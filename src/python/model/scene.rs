//! Scenes in Python.

use crate::model::{
    self, BaseMotion, Change, Constraint, Forcing, Harmonic, Parameter, Scene, System,
};
use crate::observer::unless_broken_off;
use crate::python::answered::{answered, called_here, no_attribute};
use crate::python::array::{Numbers, complex_vector, number, numbers, vector};
use crate::python::model::bad;
use crate::python::model::base_motion::amplitudes;
use crate::python::model::forcing::{forcing, out_forcing};
use crate::python::model::linear::PyLinearSystem;
use crate::python::model::nonlinear::PyNonlinearSystem;
use crate::python::model::nonlinear_stop::PyNonlinearStop;
use crate::python::model::pendulum::{PyDoublePendulum, PyPendulumChain};
use crate::python::model::stop::{PyStop, PyWall, constraints};
use crate::python::ramp::ramps;
use crate::python::text::html;
use crate::python::{argument, interrupt};
use crate::quantity::finite;
use nalgebra::DVector;
use numpy::IntoPyArray;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

fn system(value: &Bound<'_, PyAny>) -> PyResult<System> {
    if let Ok(s) = value.cast::<PyLinearSystem>() {
        return Ok(s.get().0.clone().into());
    }
    if let Ok(s) = value.cast::<PyDoublePendulum>() {
        return Ok(s.get().0.clone().into());
    }
    if let Ok(s) = value.cast::<PyPendulumChain>() {
        return Ok(s.get().0.clone().into());
    }
    if let Ok(s) = value.cast::<PyNonlinearSystem>() {
        return Ok(s.get().0.clone().into());
    }
    Err(PyTypeError::new_err(format!(
        "system is {}, but a LinearSystem, DoublePendulum, PendulumChain or NonlinearSystem is needed",
        value.get_type().name()?
    )))
}

/// System, forcing and stops: what is analysed or simulated.
///
/// Parameters
/// ----------
/// system : LinearSystem, DoublePendulum, PendulumChain or NonlinearSystem
///     The system.
/// forcing : Harmonic, Fourier, BaseMotion, Load, BaseAcceleration, a sequence of them, or None, optional
///     What drives it. Several have a period where the frequencies of all are whole multiples of the lowest (to 1e-12, up to 4096
///     times it). Where they are not, and with signals, there is none: ``period`` is None, the phase of impacts is NaN, and what
///     needs a period says so.
/// stops : Stop, Wall, NonlinearStop or a sequence of them, default ()
///     One stop or several.
///
/// Raises
/// ------
/// ValueError
///     A forcing or stop that does not fit the system.
///
/// Examples
/// --------
/// >>> import vibroimpact as vi
/// >>> oscillator = vi.LinearSystem(1.0, 0.1, 1.0)
/// >>> scene = vi.Scene(oscillator, vi.Harmonic(1.0, 2.8), vi.Stop(0, 0.5, 0.8))
/// >>> scene.gaps([0.2])
/// array([0.3])
#[pyclass(name = "Scene", module = "vibroimpact", frozen)]
#[derive(Clone)]
pub(crate) struct PyScene(pub Scene);

fn wrap_system(py: Python<'_>, system: &System) -> PyResult<Py<PyAny>> {
    Ok(match system {
        System::Linear(s) => Py::new(py, PyLinearSystem((**s).clone()))?.into_any(),
        System::DoublePendulum(s) => Py::new(py, PyDoublePendulum(s.clone()))?.into_any(),
        System::PendulumChain(s) => Py::new(py, PyPendulumChain(s.clone()))?.into_any(),
        System::Nonlinear(s) => Py::new(py, PyNonlinearSystem(s.clone()))?.into_any(),
    })
}

impl PyScene {
    fn with_amplitude(&self, value: &Bound<'_, PyAny>) -> PyResult<Change> {
        let f = self.0.forcing();
        let (frequency, phase) = (f.frequency().unwrap_or(1.0), f.phase());
        Ok(Change::Forcing(match f {
            Forcing::Unforced => {
                return Err(bad(
                    "amplitude is given, but the scene has no forcing to change".to_owned(),
                ));
            }
            Forcing::Harmonic(_) => {
                Harmonic::new(complex_vector("amplitude", value)?, frequency, phase)?.into()
            }
            Forcing::BaseMotion(_) => {
                BaseMotion::of_harmonics(amplitudes(value)?, frequency, phase)?.into()
            }
            Forcing::Fourier(_)
            | Forcing::Load(_)
            | Forcing::BaseAcceleration(_)
            | Forcing::Several(_) => {
                let what = match f {
                    Forcing::Fourier(_) => "a Fourier has several",
                    Forcing::Several(_) => "the scene has several forcings",
                    _ => "what follows a signal has none",
                };
                return Err(bad(format!(
                    "amplitude is given, but {what}: give the scene another `forcing`, or a `forcing_scale`"
                )));
            }
        }))
    }

    fn change(&self, name: &str, value: &Bound<'_, PyAny>) -> PyResult<Change> {
        Ok(match name {
            "amplitude" => self.with_amplitude(value)?,
            _ => match name.parse().map_err(|_| {
                    bad(format!(
                        "{name} is not something a scene has{}; it must be one of system, forcing, stops, frequency, phase, \
                         amplitude, clearance, restitution, contact_stiffness, contact_damping, preload, contact_exponent, forcing_scale, damping_scale",
                        called_here(name)
                    ))
                })? {
                Parameter::EveryStop(number) => {
                    Change::EachStop(number, vector(name, value)?.as_slice().to_vec())
                }
                parameter => parameter.change(number(name, value)?),
            },
        })
    }
}

impl argument::ArgumentKind for PyRef<'_, PyScene> {
    const KIND: &'static str = "a Scene";
}

#[pymethods]
impl PyScene {
    #[new]
    #[pyo3(signature = (*arguments, **named), text_signature = "(system, forcing=None, stops=None)")]
    fn new(arguments: &Bound<'_, PyTuple>, named: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        answered(arguments, named)
    }

    #[staticmethod]
    #[pyo3(name = "_made", signature = (system, forcing=None, stops=None))]
    fn made(
        system: &Bound<'_, PyAny>,
        forcing: Option<&Bound<'_, PyAny>>,
        stops: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        Ok(Self(Scene::new(
            self::system(system)?,
            self::forcing(forcing)?,
            constraints(stops)?,
        )?))
    }

    /// The system.
    #[getter]
    fn system(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        wrap_system(py, self.0.system())
    }

    /// The forcing, None, or a tuple of several.
    #[getter]
    fn forcing(&self, py: Python<'_>) -> PyResult<Option<Py<PyAny>>> {
        out_forcing(py, self.0.forcing())
    }

    /// Names of its contact elements, in the order of the states of a regime: "stop[0]" and so on.
    #[getter]
    fn elements<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.0.elements())
    }

    /// The stops, a tuple.
    #[getter]
    fn stops<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let stops = self
            .0
            .stops()
            .iter()
            .map(|s| match s {
                Constraint::Stop(s) => Ok(Py::new(py, PyStop(s.clone()))?.into_any()),
                Constraint::Wall(s) => Ok(Py::new(py, PyWall(s.clone()))?.into_any()),
                Constraint::Nonlinear(s) => Ok(Py::new(py, PyNonlinearStop(s.clone()))?.into_any()),
            })
            .collect::<PyResult<Vec<_>>>()?;
        PyTuple::new(py, stops)
    }

    /// Number of degrees of freedom.
    #[getter]
    fn n_dof(&self) -> usize {
        self.0.n_dof()
    }

    /// Forcing period [s], None without forcing, and where there is none.
    #[getter]
    fn period(&self) -> Option<f64> {
        self.0.period()
    }

    /// The gap of every stop at positions q.
    ///
    /// Parameters
    /// ----------
    /// q : array_like, shape (..., n)
    ///     Positions.
    /// t : float, default 0.0
    ///     Time [s], for stops that move.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (..., n_stops)
    ///     Gaps; negative inside a stop.
    #[pyo3(signature = (q, t=0.0))]
    fn gaps<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = argument::t)] t: f64,
    ) -> PyResult<Bound<'py, PyAny>> {
        let Numbers { mut shape, values } = numbers::<f64>("q", q)?;
        let (n, t) = (self.0.n_dof(), finite("t", t)?);
        if shape.is_empty() && n == 1 {
            shape.push(1);
        }
        if shape.last() != Some(&n) {
            let found: Vec<String> = shape.iter().map(ToString::to_string).collect();
            return Err(bad(format!(
                "q has shape ({}), but (..., {n}) is needed",
                found.join(", ")
            )));
        }
        let scene = &self.0;
        let gaps = interrupt::run(py, false, || {
            let mut gaps: Vec<f64> = Vec::new();
            for q in values.chunks(n) {
                unless_broken_off()?;
                gaps.extend(scene.gaps_at(&DVector::from_row_slice(q), t)?.iter());
            }
            Ok(gaps)
        })?;
        if let Some(last) = shape.last_mut() {
            *last = self.0.stops().len();
        }
        gaps.into_pyarray(py).call_method1("reshape", (shape,))
    }

    /// A changed copy of the scene.
    ///
    /// Parameters
    /// ----------
    /// **changes
    ///     Any of ``system``, ``forcing``, ``stops``; ``frequency``, ``phase``, ``amplitude`` of the forcing (of several, ``frequency``
    ///     scales all of them, ``phase`` is that of the first, and all are shifted by the same time); ``clearance``,
    ///     ``restitution``, ``contact_stiffness``, ``contact_damping``, ``preload``, ``contact_exponent`` (a number for every stop that has it, or one each;
    ///     of stop i ``{"preload[i]": ...}``); ``forcing_scale``, ``damping_scale`` (factors on what is there).
    ///
    /// Returns
    /// -------
    /// Scene
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     A name that does not exist, a value that breaks its rule.
    ///
    /// Examples
    /// --------
    /// >>> import vibroimpact as vi
    /// >>> vi.paper_scene(kind=3).replace(clearance=0.12, restitution=[0.9, 0.8]).stops[1]
    /// Stop(1, clearance=0.12, restitution=0.8, side='upper', reaction='coordinate')
    #[pyo3(signature = (**changes))]
    fn replace(&self, changes: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let Some(changes) = changes else {
            return Ok(self.clone());
        };
        let structural = |name: &str| changes.get_item(name);
        let (new_system, new_forcing, new_stops) = (
            structural("system")?,
            structural("forcing")?,
            structural("stops")?,
        );
        let mut scene = self.0.clone();
        if new_system.is_some() || new_forcing.is_some() || new_stops.is_some() {
            scene = Scene::new(
                new_system
                    .as_ref()
                    .map_or_else(|| Ok(scene.system().clone()), system)?,
                new_forcing
                    .as_ref()
                    .map_or_else(|| Ok(scene.forcing().clone()), |f| forcing(Some(f)))?,
                new_stops
                    .as_ref()
                    .map_or_else(|| Ok(scene.stops().to_vec()), |s| constraints(Some(s)))?,
            )?;
        }
        for (name, value) in changes.iter() {
            let name: String = name.extract()?;
            if !matches!(name.as_str(), "system" | "forcing" | "stops") {
                let change = PyScene(scene.clone()).change(&name, &value)?;
                scene = scene.replace(change)?;
            }
        }
        Ok(Self(scene))
    }

    /// The linear scene of small motions: linear system, walls and nonlinear stops as plane stops, the same forcing.
    fn linearise(&self, py: Python<'_>) -> PyResult<Self> {
        let scene = &self.0;
        let linear = interrupt::run(py, false, || model::linearise(scene))?;
        Ok(Self(linear))
    }

    /// What will run for this scene, in words.
    ///
    /// Parameters
    /// ----------
    /// ramp : Ramp, or sequence of Ramp, optional
    ///     Ramps that a run is to follow.
    ///
    /// Examples
    /// --------
    /// >>> import vibroimpact as vi
    /// >>> scene = vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([0.5], 0.5))
    /// >>> scene.plan(vi.Ramp("frequency", 2.0, rate=0.01)).split("; ")[-1]
    /// 'ramp of "frequency": what acts in polynomials of degree 8, to 1e-14 (method "taylor")'
    #[pyo3(signature = (ramp=None))]
    fn plan(&self, py: Python<'_>, ramp: Option<&Bound<'_, PyAny>>) -> PyResult<String> {
        let (scene, ramps) = (&self.0, ramps(ramp)?);
        interrupt::run(py, false, || crate::simulate::plan_under(scene, &ramps))
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn _repr_html_(slf: &Bound<'_, Self>) -> PyResult<String> {
        html(slf.as_any(), "scene")
    }

    fn __getattr__(slf: &Bound<'_, Self>, name: &str) -> PyResult<()> {
        Err(no_attribute(slf.as_any(), name))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let forcing = match self.forcing(py)? {
            Some(forcing) => forcing.bind(py).repr()?.to_string(),
            None => "None".to_owned(),
        };
        let mut text = format!(
            "Scene({},\n      {forcing}",
            self.system(py)?.bind(py).repr()?
        );
        for stop in self.stops(py)?.iter().take(8) {
            text.push_str(&format!(",\n      {}", stop.repr()?));
        }
        if self.0.stops().len() > 8 {
            text.push_str(&format!(
                ",\n      ... {} stops in all",
                self.0.stops().len()
            ));
        }
        text.push(')');
        Ok(text)
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let forcing = self.forcing(py)?.into_pyobject(py)?.into_any();
        PyTuple::new(
            py,
            [
                self.system(py)?.into_bound(py),
                forcing,
                self.stops(py)?.into_any(),
            ],
        )
    }
}
