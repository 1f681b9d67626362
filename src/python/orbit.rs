//! A periodic orbit in Python.

use crate::orbit::{PeriodicOrbit, SavedMode, SavedOrbit, Stability};
use crate::path::{KeptMotion, Motion, Stretch};
use crate::python::array::{out_complex, out_matrix, out_vector};
use crate::python::model::PyScene;
use crate::python::motion::motion_class;
use crate::python::orbit_facts::{PyCoefficients, PyStability, PyViolation};
use crate::python::pattern::{out_pattern, pattern, shown};
use crate::python::record::{field, objects};
use crate::python::rows::out_grazes;
use crate::python::text::{fixed_complex, list};
use crate::python::{argument, derivative, interrupt};
use crate::simulate::SegmentKind;
use nalgebra::Complex;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};

/// A periodic motion that hits stops in a given pattern; t = 0 is right after its first impact.
///
/// Where stops are held and let go that is the first impact that follows a release.
#[pyclass(name = "Orbit", module = "vibroimpact", frozen)]
pub(crate) struct PyOrbit(pub PeriodicOrbit);

field!(PeriodicOrbit => |own, py| Bound::new(py, PyOrbit(own))?);
field!(Vec<PeriodicOrbit> => |own, py| objects(py, own)?);

impl PyOrbit {
    /// The orbit, judged: searched for violations on the first call, which may be long.
    fn judged(&self, py: Python<'_>) -> PyResult<&PeriodicOrbit> {
        interrupt::run(py, false, || self.0.try_is_admissible())?;
        Ok(&self.0)
    }

    /// The orbit's stability, computed on the first call, which may be long.
    fn decided(&self, py: Python<'_>) -> PyResult<&Stability> {
        interrupt::run(py, false, || self.0.stability())
    }
}

motion_class! { PyOrbit as "orbit" |own| own.0; (t): &Bound<'py, PyAny>;
    /// Period [s].
    #[getter]
    fn period(&self) -> f64 {
        self.0.period()
    }

    /// Forcing phase at t = 0 [rad], in [0, 2 pi).
    #[getter]
    fn phase(&self) -> f64 {
        self.0.phase()
    }

    /// Forcing periods in one period.
    #[getter]
    fn n_periods(&self) -> usize {
        self.0.n_periods()
    }

    /// Stops hit, in order; a tuple is hit at one instant.
    #[getter]
    fn pattern<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        out_pattern(py, self.0.pattern())
    }

    /// What happens in one period, in order: tuple of (event, element), "strike", "chatter" and "release" of rigid stops, of those that give
    /// way "press", "leave" and "relax"; impacts that accumulate are one "chatter".
    #[getter]
    fn signature<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let elements = self.0.scene().elements();
        let events = self.0.signature().into_iter();
        PyTuple::new(py, events.map(|(event, stop)| (event, elements[stop].clone())))
    }

    /// Position right after the first impact [m], shape (n,).
    #[getter]
    fn q0<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        out_vector(py, &self.0.q0())
    }

    /// Velocity right after the first impact [m/s], shape (n,).
    #[getter]
    fn v0<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        out_vector(py, &self.0.v0())
    }

    /// Coefficients a, b, A, B of the paper's (14) in the shapes of ``modes``; None where the modes are complex
    /// or the first impact leads to lasting contact.
    #[getter]
    fn coefficients(&self) -> Option<PyCoefficients> {
        self.0.coefficients().map(PyCoefficients)
    }

    /// Whether the orbit keeps the rules of contact at every time; None where the search found no breach and could not prove that
    /// there is none: ``violation`` says where.
    #[getter]
    fn is_admissible(&self, py: Python<'_>) -> PyResult<Option<bool>> {
        Ok(self.judged(py)?.is_admissible())
    }

    /// The worst breach of the rules of contact, None where there is none; with a depth of nan the place from which on the search
    /// could not decide.
    #[getter]
    fn violation(&self, py: Python<'_>) -> PyResult<Option<PyViolation>> {
        Ok(self.judged(py)?.violation().cloned().map(PyViolation))
    }

    /// Touches without impact, within the margin: structured array of time [s], stop, depth [m].
    #[getter]
    fn grazes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let touches = self.judged(py)?.touches();
        out_grazes(py, touches.iter().map(|t| (t.time, t.stop, -t.gap)))
    }

    /// Floquet multipliers [-], shape (2n,) complex, largest modulus first; of several orders the worst; None where undefined.
    /// One more for each stop that relaxes at t = 0 and is met before it is back.
    #[getter]
    fn floquet_multipliers<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<Option<Bound<'py, PyArray1<Complex<f64>>>>> {
        Ok(self
            .decided(py)?
            .orders
            .first()
            .map(|o| out_complex(py, &o.multipliers)))
    }

    /// Monodromy matrix in (q, v) [m, m/s], shape (2n, 2n), of the order of ``floquet_multipliers``; None where undefined. Behind
    /// them are the places [m] of stops that relax at t = 0 and are met before they are back.
    #[getter]
    fn monodromy<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        self.decided(py)?
            .orders
            .first()
            .map(|o| out_matrix(py, &o.monodromy))
            .transpose()
    }

    /// Whether all multipliers lie inside the unit circle: True, False, or None where that decides nothing.
    #[getter]
    fn is_stable(&self, py: Python<'_>) -> PyResult<Option<bool>> {
        Ok(self.decided(py)?.is_stable)
    }

    /// Stability with its reason and every order of simultaneous impacts.
    #[getter]
    fn stability(&self, py: Python<'_>) -> PyResult<PyStability> {
        Ok(PyStability(self.decided(py)?.clone()))
    }

    /// Return the mirror image of the orbit: of the motion ``q(t)`` the motion ``-q(t + T/2)``, T the period of the forcing.
    ///
    /// Returns
    /// -------
    /// Orbit
    ///     Counted from its own first impact; the orbit itself, half a period later, if that is its own image.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     A scene that is not odd: opposite states half a period later have to have opposite accelerations, and every stop an
    ///     opposite one that is alike.
    ///
    /// Examples
    /// --------
    /// >>> import vibroimpact as vi
    /// >>> stops = [vi.Stop(0, 0.5, 0.7), vi.Stop(0, 0.5, 0.7, side="lower")]
    /// >>> scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([1.0], 1.2), stops)
    /// >>> orbit = vi.periodic_orbits(scene, [0, 1])[0]
    /// >>> bool(abs(orbit.mirrored().phase - orbit.phase) < 3.2)
    /// True
    fn mirrored(&self, py: Python<'_>) -> PyResult<Self> {
        let own = &self.0;
        Ok(Self(py.detach(|| own.mirrored())?))
    }

    /// The least gap of every stop over a period [m], shape (stops,): zero for one that is hit, unless it is passed too; sought between the
    /// points at which the motion is drawn.
    #[getter]
    fn min_gap<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let orbit = &self.0;
        let found = interrupt::run(py, false, || orbit.min_gap())?;
        Ok(found.into_pyarray(py))
    }

    /// The largest distance of every coordinate from zero over a period [m], max abs(q_i), shape (n,); sought as ``min_gap``.
    #[getter]
    fn max_displacement<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let orbit = &self.0;
        let found = interrupt::run(py, false, || orbit.max_displacement())?;
        Ok(found.into_pyarray(py))
    }

    /// Derivatives of the orbit by numbers of its scene: those of the orbits of the same pattern in scenes nearby.
    ///
    /// Parameters
    /// ----------
    /// parameters : str, sequence of str, or callable
    ///     Numbers of ``Scene.replace`` ("frequency", "clearance[1]", "forcing_scale", ...; not "phase", which shifts time alone), or
    ///     a callable ``p (d,) -> Scene``.
    /// start : array_like, shape (d,), optional
    ///     Of a callable, its p at the orbit: the scene that it makes of it is the orbit's but for the phase.
    ///
    /// Returns
    /// -------
    /// Derivatives
    ///     Of position, velocity and phase right after the first impact, speeds and times of impacts, multipliers, least gaps and
    ///     largest displacements; nan where one does not exist, with the reason.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     A number that does not exist or that the stops do not share; a callable without ``start``, names with one; a ``start`` in
    ///     whose scene the orbit does not close; a callable that refuses p both above and below it.
    /// TypeError
    ///     A callable that does not return a Scene.
    ///
    /// Notes
    /// -----
    /// The equations of ``find_orbit`` are differentiated, ``G_Z dZ = -G_p``, with G_p and what is measured of the motion by central
    /// differences at phases held: no orbit is searched for. Extremes change as the value at the place where they are.
    ///
    /// Examples
    /// --------
    /// >>> import numpy as np
    /// >>> import vibroimpact as vi
    /// >>> scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([8.5], 2.4), vi.Stop(0, 1.0, 0.8))
    /// >>> orbit = vi.periodic_orbits(scene, [0])[0]
    /// >>> names = "forcing_scale", "clearance"
    /// >>> speed = orbit.derivatives(names).speeds_before.sum()
    /// >>> bool(np.isclose(speed, orbit.impacts[0].item()[2]))  # twice both is twice the motion, its speed too
    /// True
    #[pyo3(signature = (parameters, *, start=None))]
    fn derivatives<'py>(
        &self,
        py: Python<'py>,
        parameters: &Bound<'py, PyAny>,
        start: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        derivative::derivatives(py, &self.0, parameters, start)
    }

    /// Arrays of the orbit, for ``numpy.savez``.
    ///
    /// Returns
    /// -------
    /// dict of ndarray
    fn to_arrays<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let arrays = PyDict::new(py);
        let scalar = |x: f64| vec![x].into_pyarray(py);
        arrays.set_item("period", scalar(self.0.period()))?;
        arrays.set_item("phase", scalar(self.0.phase()))?;
        arrays.set_item("q0", self.q0(py))?;
        arrays.set_item("v0", self.v0(py))?;
        arrays.set_item("impacts", self.impacts(py)?)?;
        arrays.set_item("segments", self.segments(py)?)?;
        arrays.set_item(
            "is_admissible",
            vec![self.is_admissible(py)? == Some(true)].into_pyarray(py),
        )?;
        if let Some(multipliers) = self.floquet_multipliers(py)? {
            arrays.set_item("floquet_multipliers", multipliers)?;
        }
        Ok(arrays)
    }

    pub fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let o = self.judged(py)?;
        let admissible = match o.violation() {
            None if o.touches().is_empty() => "admissible".to_owned(),
            None => "admissible, touching a stop without impact".to_owned(),
            Some(v) if v.depth.is_nan() => format!("admissible or not: {}", v.reason),
            Some(v) => format!("not admissible: {}", v.reason),
        };
        let mut text = format!(
            "Orbit of pattern {}, period {:.6}{}\n  contact state q0 = {}, v0 = {}\n  {admissible}",
            shown(o.pattern()),
            o.period(),
            in_forcing(o),
            list(&o.q0()),
            list(&o.v0()),
        );
        let lasting = |part: &Stretch<'_>| !part.lasting().is_free();
        for part in o.stretches()?.into_iter().filter(lasting) {
            let Stretch { start, end, .. } = part;
            for stop in part.stops() {
                text.push_str(&format!(
                    "\n  in contact with stop {stop} from t = {start:.6} to {end:.6}"
                ));
            }
        }
        if o.scene().n_dof() <= 60 {
            let stability = self.decided(py)?;
            let verdict = match stability.is_stable {
                Some(true) => "stable",
                Some(false) => "unstable",
                None => "stability undecided",
            };
            text.push_str(&format!("\n  {verdict}: {}", stability.reason));
            if let Some(order) = stability.orders.first() {
                let shown: Vec<String> = order
                    .multipliers
                    .iter()
                    .take(4)
                    .map(|&z| fixed_complex(z))
                    .collect();
                let more = if order.multipliers.len() > 4 {
                    ", ..."
                } else {
                    ""
                };
                text.push_str(&format!("\n  multipliers {}{more}", shown.join(", ")));
            }
        }
        Ok(text)
    }

    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let saved = self.0.save();
        let modes = saved
            .modes
            .iter()
            .map(|(kind, stops, is_struck, released)| {
                (kind.name(), stops.clone(), *is_struck, *released)
            });
        let modes: Vec<_> = modes.collect();
        let arguments = PyTuple::new(
            py,
            [
                PyScene(self.0.saved_scene().clone())
                    .into_pyobject(py)?
                    .into_any(),
                self.pattern(py)?.into_any(),
                saved.n_periods.into_pyobject(py)?.into_any(),
                saved.phase.into_pyobject(py)?.into_any(),
                PyList::new(py, &saved.spans)?.into_any(),
                PyList::new(py, &saved.states)?.into_any(),
                PyList::new(py, &saved.impulses)?.into_any(),
                PyList::new(py, modes)?.into_any(),
            ],
        )?;
        Ok((
            py.import("vibroimpact._core")?.getattr("_restore_orbit")?,
            arguments,
        ))
    }
}

/// An orbit from what it was saved as; used by pickle.
#[pyfunction]
pub(crate) fn _restore_orbit(
    scene: PyRef<'_, PyScene>,
    pattern: &Bound<'_, PyAny>,
    n_periods: &Bound<'_, PyAny>,
    phase: &Bound<'_, PyAny>,
    spans: &Bound<'_, PyAny>,
    states: &Bound<'_, PyAny>,
    impulses: &Bound<'_, PyAny>,
    modes: &Bound<'_, PyAny>,
) -> PyResult<PyOrbit> {
    let mode = |(kind, stops, is_struck, released): (String, _, _, _)| -> PyResult<SavedMode> {
        Ok((SegmentKind::from_name(&kind)?, stops, is_struck, released))
    };
    let modes: Vec<(String, Vec<usize>, bool, Option<usize>)> = argument::saved("modes", modes)?;
    let saved = SavedOrbit {
        n_periods: argument::saved("n_periods", n_periods)?,
        phase: argument::saved("phase", phase)?,
        spans: argument::saved("spans", spans)?,
        states: argument::saved("states", states)?,
        impulses: argument::saved("impulses", impulses)?,
        modes: modes.into_iter().map(mode).collect::<PyResult<_>>()?,
    };
    let (py, pattern) = (pattern.py(), self::pattern(pattern)?);
    let scene = &scene.0;
    let orbit = interrupt::run(py, false, || PeriodicOrbit::restore(scene, pattern, saved))?;
    Ok(PyOrbit(orbit))
}

/// How many periods of the forcing an orbit has, and from which phase on; nothing without forcing. A whole turn is none.
fn in_forcing(orbit: &PeriodicOrbit) -> String {
    if orbit.scene().period().is_none() {
        return String::new();
    }
    let whole = format!("{:.6}", std::f64::consts::TAU);
    let phase = format!("{:.6}", orbit.phase());
    let phase = if phase == whole { "0.000000" } else { &phase };
    let count = orbit.n_periods();
    let plural = if count == 1 { "" } else { "s" };
    format!(" ({count} forcing period{plural}), phase {phase} rad")
}
