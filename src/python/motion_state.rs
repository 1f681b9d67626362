//! States that runs go on from, in Python.

use crate::model::PhysicalState;
use crate::python::argument;
use crate::python::array::{out_vector, vector};
use crate::python::model::PyScene;
use crate::simulate::{MotionState, SavedLeft};
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// All that a run goes on from.
///
/// ``Trajectory.state`` is one; ``simulate(scene, state, t_span)`` goes on from it. Position and velocity do not say all: a stop that relaxes
/// has a place of its own, and which of two states an element is in may be known from what came before alone.
///
/// Examples
/// --------
/// >>> import vibroimpact as vi
/// >>> scene = vi.paper_scene(kind=3)
/// >>> first = vi.simulate(scene, [0, 0], [0, 0.1], (0, 20))
/// >>> rest = vi.simulate(scene, first.state, (20, 50))
/// >>> whole = vi.simulate(scene, [0, 0], [0, 0.1], (0, 50))
/// >>> rest.final[0].tolist() == whole.final[0].tolist()
/// True
#[pyclass(name = "MotionState", module = "vibroimpact", frozen)]
pub(crate) struct PyMotionState(pub MotionState);

#[pymethods]
impl PyMotionState {
    /// The scene whose state it is.
    #[getter]
    fn scene(&self) -> PyScene {
        PyScene(self.0.scene().clone())
    }

    /// Time [s].
    #[getter]
    fn time(&self) -> f64 {
        self.0.time()
    }

    /// Position, shape (n,).
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        out_vector(py, self.0.q())
    }

    /// Velocity, shape (n,).
    #[getter]
    fn v<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        out_vector(py, self.0.v())
    }

    /// States of first order, shape (0,): no scene has any yet.
    #[getter]
    fn z<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.z().to_vec().into_pyarray(py)
    }

    /// The mode: 0, the only one yet.
    #[getter]
    fn mode(&self) -> usize {
        self.0.mode()
    }

    /// The state of each element, in the order of ``Scene.elements``: "free", "held", "pressed", "relaxing", "idle" or "seated".
    #[getter]
    fn regime<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.0.regime())
    }

    /// What each element remembers, in the order of ``Scene.elements``: of one that relaxes how far it is from its place [m], nan of others.
    #[getter]
    fn remembered<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.remembered().into_pyarray(py)
    }

    /// Arrays of the state, for ``numpy.savez``.
    ///
    /// Returns
    /// -------
    /// dict of ndarray
    ///     By the names of its attributes.
    fn to_arrays<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let arrays = PyDict::new(py);
        let array = py.import("numpy")?.getattr("array")?;
        arrays.set_item("time", vec![self.time()].into_pyarray(py))?;
        arrays.set_item("q", self.q(py))?;
        arrays.set_item("v", self.v(py))?;
        arrays.set_item("z", self.z(py))?;
        arrays.set_item("mode", array.call1(([self.mode()],))?)?;
        arrays.set_item("regime", array.call1((self.regime(py)?, "<U8"))?)?;
        arrays.set_item("remembered", self.remembered(py))?;
        Ok(arrays)
    }

    #[allow(clippy::type_complexity)] // what pickle keeps
    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(
        Bound<'py, PyAny>,
        (
            PyScene,
            f64,
            Bound<'py, PyArray1<f64>>,
            Bound<'py, PyArray1<f64>>,
            SavedLeft,
        ),
    )> {
        let restore = py.import("vibroimpact._core")?.getattr("_restore_state")?;
        let own = (
            self.scene(),
            self.time(),
            self.q(py),
            self.v(py),
            self.0.save(),
        );
        Ok((restore, own))
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __repr__(&self) -> String {
        let elements = self.0.scene().elements().into_iter().zip(self.0.regime());
        let elements = elements.filter(|own| own.1 != "free");
        let elements: Vec<String> = elements
            .map(|(name, state)| format!(", {name} {state}"))
            .collect();
        format!(
            "MotionState(t = {}, {} degrees of freedom{})",
            self.time(),
            self.0.q().len(),
            elements.concat()
        )
    }
}

/// A state from what it was saved as; used by pickle.
#[pyfunction]
pub(crate) fn _restore_state(
    scene: PyRef<'_, PyScene>,
    time: &Bound<'_, PyAny>,
    q: &Bound<'_, PyAny>,
    v: &Bound<'_, PyAny>,
    left: &Bound<'_, PyAny>,
) -> PyResult<PyMotionState> {
    let state: PhysicalState = (vector("q", q)?, vector("v", v)?);
    let (time, left) = (
        argument::saved("time", time)?,
        argument::saved("state", left)?,
    );
    Ok(PyMotionState(MotionState::restore(
        &scene.0, time, state, left,
    )?))
}
