//! Periodic orbits in Python.

use crate::impact::Impact;
use crate::model::Parameter;
use crate::orbit::{
    self, Coefficients, Family, Free, OrbitOptions, Orbits, OrderMultipliers, PeriodicOrbit, Saved,
    Stability, Verdict, Violation,
};
use crate::python::array::{
    complex_vector, out_complex, out_matrix, out_rows, out_vector, structured, times, vector,
};
use crate::python::interrupt;
use crate::python::model::PyScene;
use crate::python::pattern::{out_pattern, pattern, shown};
use nalgebra::{Complex, DVector};
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PySlice, PyTuple};

/// Which side of an impact is meant, from its name.
pub(crate) fn is_before(side: &str) -> PyResult<bool> {
    match side {
        "after" => Ok(false),
        "before" => Ok(true),
        _ => Err(PyValueError::new_err(format!(
            "side is {side:?}, but it must be \"after\" or \"before\""
        ))),
    }
}

/// Impacts as a structured array.
pub(crate) fn out_impacts<'py>(py: Python<'py>, impacts: &[Impact]) -> PyResult<Bound<'py, PyAny>> {
    let column = |f: &dyn Fn(&Impact) -> f64| {
        impacts
            .iter()
            .map(f)
            .collect::<Vec<f64>>()
            .into_pyarray(py)
            .into_any()
    };
    let stops: Vec<i64> = impacts
        .iter()
        .map(|i| i64::try_from(i.stop).unwrap_or(i64::MAX))
        .collect();
    structured(
        py,
        impacts.len(),
        vec![
            ("time", "f8", column(&|i| i.time)),
            ("stop", "i8", stops.into_pyarray(py).into_any()),
            ("speed_before", "f8", column(&|i| i.approach)),
            ("speed_after", "f8", column(&|i| i.departure)),
            ("impulse", "f8", column(&|i| i.impulse)),
            ("phase", "f8", column(&|i| i.phase)),
        ],
    )
}

/// Grazes, each a time, a stop and a depth, as a structured array.
pub(crate) fn out_grazes(
    py: Python<'_>,
    grazes: impl Iterator<Item = (f64, usize, f64)>,
) -> PyResult<Bound<'_, PyAny>> {
    let (mut times, mut stops, mut depths) = (Vec::new(), Vec::new(), Vec::new());
    for (time, stop, depth) in grazes {
        times.push(time);
        stops.push(i64::try_from(stop).unwrap_or(i64::MAX));
        depths.push(depth);
    }
    structured(
        py,
        times.len(),
        vec![
            ("time", "f8", times.into_pyarray(py).into_any()),
            ("stop", "i8", stops.into_pyarray(py).into_any()),
            ("depth", "f8", depths.into_pyarray(py).into_any()),
        ],
    )
}

/// Coefficients of eq. (14) in the mass-normalised modes; t = 0 just after the first impact.
#[pyclass(name = "Coefficients", module = "vibroimpact", frozen)]
pub(crate) struct PyCoefficients(Coefficients);

#[pymethods]
#[allow(non_snake_case)] // the paper's letters
impl PyCoefficients {
    #[new]
    fn new(
        a: &Bound<'_, PyAny>,
        b: &Bound<'_, PyAny>,
        A: &Bound<'_, PyAny>,
        B: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        Ok(Self(Coefficients {
            a: vector("a", a)?,
            b: vector("b", b)?,
            sine: vector("A", A)?,
            cosine: vector("B", B)?,
        }))
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, [self.a(py), self.b(py), self.A(py), self.B(py)])
    }

    /// Cosine amplitudes of the free motion, shape (n,).
    #[getter]
    fn a<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        out_vector(py, &self.0.a)
    }

    /// Sine amplitudes of the free motion, shape (n,).
    #[getter]
    fn b<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        out_vector(py, &self.0.b)
    }

    /// Sine amplitudes of the steady response, shape (n,).
    #[getter]
    fn A<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        out_vector(py, &self.0.sine)
    }

    /// Cosine amplitudes of the steady response, shape (n,).
    #[getter]
    fn B<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        out_vector(py, &self.0.cosine)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!(
            "Coefficients(a={}, b={}, A={}, B={})",
            self.a(py).repr()?,
            self.b(py).repr()?,
            self.A(py).repr()?,
            self.B(py).repr()?
        ))
    }
}

/// Where and by how much an orbit breaks the rules of contact.
#[pyclass(name = "Violation", module = "vibroimpact", frozen)]
pub(crate) struct PyViolation(Violation);

#[pymethods]
impl PyViolation {
    #[new]
    fn new(stop: usize, time: f64, depth: f64, reason: String) -> Self {
        Self(Violation {
            stop,
            time,
            depth,
            reason,
        })
    }

    fn __getnewargs__(&self) -> (usize, f64, f64, &str) {
        (self.0.stop, self.0.time, self.0.depth, &self.0.reason)
    }

    /// The stop.
    #[getter]
    fn stop(&self) -> usize {
        self.0.stop
    }

    /// Time of the deepest point, or of the impact [s].
    #[getter]
    fn time(&self) -> f64 {
        self.0.time
    }

    /// How far the stop is passed, in units of the gap; zero where an impulse pulls.
    #[getter]
    fn depth(&self) -> f64 {
        self.0.depth
    }

    /// The rule that is broken, in words.
    #[getter]
    fn reason(&self) -> &str {
        &self.0.reason
    }

    fn __repr__(&self) -> String {
        format!("Violation({})", self.0.reason)
    }
}

/// The directions of a family of orbits.
#[pyclass(name = "Family", module = "vibroimpact", frozen)]
pub(crate) struct PyFamily(Family);

#[pymethods]
impl PyFamily {
    #[new]
    fn new(basis: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(Self(Family {
            basis: crate::python::array::matrix("basis", basis)?,
        }))
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyArray2<f64>>,)> {
        Ok((self.basis(py)?,))
    }

    /// Directions of the contact state (q, v) in which the orbit may be changed, shape (2n, dimension).
    #[getter]
    fn basis<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        out_matrix(py, &self.0.basis)
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
pub(crate) struct PyStability(Stability);

/// One order of impacts as plain values: stops, multipliers, monodromy matrix.
type Order<'py> = (Vec<usize>, Bound<'py, PyAny>, Bound<'py, PyAny>);

#[pymethods]
impl PyStability {
    #[new]
    fn new(is_stable: Option<bool>, reason: String, orders: Vec<Order<'_>>) -> PyResult<Self> {
        let orders = orders
            .into_iter()
            .map(|(order, multipliers, monodromy)| {
                Ok(OrderMultipliers {
                    order,
                    multipliers: complex_vector("multipliers", &multipliers)?,
                    monodromy: crate::python::array::matrix("monodromy", &monodromy)?,
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
    ) -> PyResult<(Option<bool>, &str, Vec<Order<'py>>)> {
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

/// A periodic motion that hits stops in a given pattern; t = 0 is right after its first impact.
#[pyclass(name = "Orbit", module = "vibroimpact", frozen)]
pub(crate) struct PyOrbit(pub PeriodicOrbit);

impl PyOrbit {
    /// The orbit, judged: searched for violations on the first call, which may be long.
    fn judged(&self, py: Python<'_>) -> PyResult<&PeriodicOrbit> {
        interrupt::run(py, false, |observe| {
            self.0.is_admissible_checked(&mut || observe(0.0))
        })?;
        Ok(&self.0)
    }

    /// The orbit's stability, computed on the first call, which may be long.
    fn decided(&self, py: Python<'_>) -> PyResult<&Stability> {
        interrupt::run(py, false, |observe| {
            self.0.stability_checked(&mut || observe(0.0))
        })
    }

    fn states(
        &self,
        t: &Bound<'_, PyAny>,
        before: bool,
    ) -> PyResult<(Vec<(DVector<f64>, DVector<f64>)>, bool)> {
        let (times, is_single) = times("t", t)?;
        if let Some(bad) = times.iter().find(|t| !t.is_finite()) {
            return Err(PyValueError::new_err(format!(
                "t is {bad}, but it must be finite"
            )));
        }
        Ok((
            times.iter().map(|&t| self.0.state(t, before)).collect(),
            is_single,
        ))
    }
}

/// Rows out as (m, n), a single one as (n,).
pub(crate) fn out_states<'py>(
    py: Python<'py>,
    rows: &[DVector<f64>],
    n: usize,
    is_single: bool,
) -> PyResult<Bound<'py, PyAny>> {
    if is_single {
        return Ok(out_vector(py, &rows[0]).into_any());
    }
    Ok(out_rows(py, rows, n)?.into_any())
}

#[pymethods]
impl PyOrbit {
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

    /// The scene with the orbit's phase and clearances: simulated from (q0, v0) at t = 0 it retraces the orbit.
    #[getter]
    fn scene(&self) -> PyScene {
        PyScene(self.0.scene().clone())
    }

    /// Position right after the first impact, shape (n,).
    #[getter]
    fn q0<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        out_vector(py, &self.0.q0())
    }

    /// Velocity right after the first impact, shape (n,).
    #[getter]
    fn v0<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        out_vector(py, &self.0.v0())
    }

    /// Position at any times.
    ///
    /// Parameters
    /// ----------
    /// t : float or `array_like`, shape (m,)
    ///     Times [s], any real numbers.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (m, n), or (n,) for a single time
    fn position<'py>(&self, py: Python<'py>, t: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let (states, is_single) = self.states(t, false)?;
        let rows: Vec<DVector<f64>> = states.into_iter().map(|s| s.0).collect();
        out_states(py, &rows, self.0.scene().n_dof(), is_single)
    }

    /// Velocity at any times.
    ///
    /// Parameters
    /// ----------
    /// t : float or `array_like`, shape (m,)
    ///     Times [s], any real numbers.
    /// side : {"after", "before"}, default "after"
    ///     Which velocity is meant at an impact.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (m, n), or (n,) for a single time
    #[pyo3(signature = (t, side="after"))]
    fn velocity<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
        side: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (states, is_single) = self.states(t, is_before(side)?)?;
        let rows: Vec<DVector<f64>> = states.into_iter().map(|s| s.1).collect();
        out_states(py, &rows, self.0.scene().n_dof(), is_single)
    }

    /// Impacts of one period: structured array of time, stop, `speed_before`, `speed_after`, impulse, phase.
    #[getter]
    fn impacts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        out_impacts(py, self.0.impacts())
    }

    /// Coefficients a, b, A, B of the paper's (14) in the shapes of ``modes``; None where the modes are complex.
    #[getter]
    fn coefficients(&self) -> Option<PyCoefficients> {
        self.0.coefficients().map(PyCoefficients)
    }

    /// Whether the orbit keeps the rules of contact at every time.
    #[getter]
    fn is_admissible(&self, py: Python<'_>) -> PyResult<bool> {
        Ok(self.judged(py)?.is_admissible())
    }

    /// The worst breach of the rules of contact, None where there is none.
    #[getter]
    fn violation(&self, py: Python<'_>) -> PyResult<Option<PyViolation>> {
        Ok(self.judged(py)?.violation().cloned().map(PyViolation))
    }

    /// Touches without impact, within the margin: structured array of time, stop, depth.
    #[getter]
    fn grazes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let touches = self.judged(py)?.touches();
        out_grazes(py, touches.iter().map(|t| (t.time, t.stop, -t.gap)))
    }

    /// Floquet multipliers, shape (2n,) complex, largest modulus first; of several orders the worst; None where undefined.
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

    /// Monodromy matrix in (q, v), shape (2n, 2n), of the order of `floquet_multipliers`; None where undefined.
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
        arrays.set_item(
            "is_admissible",
            vec![self.is_admissible(py)?].into_pyarray(py),
        )?;
        if let Some(multipliers) = self.floquet_multipliers(py)? {
            arrays.set_item("floquet_multipliers", multipliers)?;
        }
        Ok(arrays)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let o = self.judged(py)?;
        let list = |v: &DVector<f64>| {
            let shown: Vec<String> = v.iter().take(6).map(|x| format!("{x:.6}")).collect();
            format!(
                "[{}{}]",
                shown.join(", "),
                if v.len() > 6 { ", ..." } else { "" }
            )
        };
        let admissible = match o.violation() {
            None if o.touches().is_empty() => "admissible".to_owned(),
            None => "admissible, touching a stop without impact".to_owned(),
            Some(v) => format!("not admissible: {}", v.reason),
        };
        let mut text = format!(
            "Orbit of pattern {}, period {:.6} ({} forcing periods), phase {:.6} rad\n  contact state q0 = {}, v0 = {}\n  {admissible}",
            shown(o.pattern()),
            o.period(),
            o.n_periods(),
            o.phase(),
            list(&o.q0()),
            list(&o.v0()),
        );
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
                    .map(|z| format!("{z:.6}"))
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
        let arguments = PyTuple::new(
            py,
            [
                self.scene().into_pyobject(py)?.into_any(),
                self.pattern(py)?.into_any(),
                saved.n_periods.into_pyobject(py)?.into_any(),
                saved.phase.into_pyobject(py)?.into_any(),
                PyList::new(py, &saved.spans)?.into_any(),
                PyList::new(py, &saved.states)?.into_any(),
                PyList::new(py, &saved.impulses)?.into_any(),
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
    n_periods: usize,
    phase: f64,
    spans: Vec<f64>,
    states: Vec<f64>,
    impulses: Vec<f64>,
) -> PyResult<PyOrbit> {
    let saved = Saved {
        n_periods,
        phase,
        spans,
        states,
        impulses,
    };
    Ok(PyOrbit(PeriodicOrbit::restore(
        &scene.0,
        self::pattern(pattern)?,
        saved,
    )?))
}

/// Every orbit of a pattern: stable and admissible ones first, then admissible ones, then by depth of violation.
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

    /// ``1 - |d|/|alpha|``: distance of the parameters from the fold where orbits meet and vanish; negative: none.
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
    orbits: Vec<Py<PyOrbit>>,
    verdict: &str,
    reason: String,
    margin: Option<f64>,
    basis: Option<&Bound<'_, PyAny>>,
) -> PyResult<PyOrbits> {
    let verdict = match verdict {
        "found" => Verdict::Found,
        "family" => Verdict::Family,
        _ => Verdict::None,
    };
    let family = basis
        .map(|b| crate::python::array::matrix("basis", b))
        .transpose()?
        .map(|basis| Family { basis });
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
/// `n_periods` : int, default 1
///     Forcing periods in one period of the orbit.
/// phase : float, optional
///     Forcing phase at the first impact [rad]: the clearances of the stops in the pattern come out, as in the paper. Without
///     it the clearances are given and the phases found.
/// free : str, optional
///     One more unknown, as stops hit at one instant need: "clearance" (all times one factor), or a name of
///     ``Scene.replace``.
/// between : pair of float, optional
///     Range in which a free parameter is searched; "clearance" and "`forcing_scale`" need none.
///
/// Returns
/// -------
/// Orbits
///     A sequence: stable and admissible orbits first, then admissible ones, then by depth of violation; with ``verdict``,
///     ``reason``, ``margin``, ``family``. In systems of more than 60 degrees of freedom admissible orbits come first, stable
///     or not: the multipliers, which cost O(n^3), are computed only when asked for.
///
/// Raises
/// ------
/// `ValueError`
///     A nonlinear or unforced scene, a pattern that does not fit it, options that contradict each other.
/// `ConvergenceError`
///     If an eigenvalue iteration fails.
///
/// Notes
/// -----
/// With R the recovery matrix, s the steady response and T the period, ``(I - R e^{AT}) z = (R - I) s(0)`` gives the contact
/// state ``x(0+) = z + s(0)``: eqs. (29) and (38) of [1]_, for any number of modes and any R.
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
    scene: PyRef<'_, PyScene>,
    pattern: &Bound<'_, PyAny>,
    n_periods: i64,
    phase: Option<f64>,
    free: Option<&str>,
    between: Option<(f64, f64)>,
) -> PyResult<PyOrbits> {
    let pattern = self::pattern(pattern)?;
    let n_periods = usize::try_from(n_periods).map_err(|_| {
        PyValueError::new_err(format!(
            "n_periods is {n_periods}, but it must be at least 1"
        ))
    })?;
    let free = match free {
        None => None,
        Some("clearance") => Some(Free::Clearance),
        Some(name) => {
            let parameter = name.parse::<Parameter>().map_err(|e| {
                PyValueError::new_err(format!("free: {}", PyErr::from(e).value(py)))
            })?;
            Some(Free::Parameter(parameter))
        }
    };
    let options = OrbitOptions {
        n_periods,
        phase,
        free,
        between,
    };
    let core = &scene.0;
    let orbits = interrupt::run(py, false, |observe| {
        orbit::periodic_orbits_checked(core, &pattern, &options, &mut || observe(0.0))
    })?;
    PyOrbits::wrap(py, orbits)
}
