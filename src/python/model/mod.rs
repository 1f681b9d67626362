//! Systems, forcing, stops and scenes in Python.

use crate::model::{
    self, BaseMotion, Change, Constraint, DoublePendulum, Forcing, Harmonic, Kind, LinearSystem,
    Normal, PaperOptions, Parameter, PendulumChain, Reaction, Scene, Side, Stop, System, Wall,
    WallSide,
};
use crate::python::array::{
    coefficient, complex_vector, matrix, number, out_complex, out_matrix, out_vector, vector,
};
use crate::python::pattern::stop_index;
use nalgebra::{DMatrix, DVector};
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

fn bad(message: String) -> PyErr {
    PyValueError::new_err(message)
}

fn shape_of(c: &model::Coefficient) -> String {
    match c {
        model::Coefficient::Diagonal(d) => format!("diagonal ({},)", d.len()),
        model::Coefficient::Dense(m) => format!("({}, {})", m.nrows(), m.ncols()),
    }
}

fn out_coefficient<'py>(py: Python<'py>, c: &model::Coefficient) -> PyResult<Bound<'py, PyAny>> {
    Ok(match c {
        model::Coefficient::Diagonal(d) => out_vector(py, d).into_any(),
        model::Coefficient::Dense(m) => out_matrix(py, m)?.into_any(),
    })
}

/// Linear system ``M q'' + C q' + K q = f0 + forcing`` with n degrees of freedom.
///
/// Parameters
/// ----------
/// mass : `array_like`, shape (n, n) or (n,)
///     Mass matrix M, symmetric positive definite; ``(n,)`` is a diagonal. For n = 1 plain numbers will do.
/// damping : `array_like`, shape (n, n) or (n,)
///     Damping matrix C, any real matrix.
/// stiffness : `array_like`, shape (n, n) or (n,)
///     Stiffness matrix K, any real matrix, singular or zero too.
/// load : `array_like`, shape (n,), optional
///     Constant force f0.
/// influence : `array_like`, shape (n,), optional
///     Influence vector r: a base displacement u adds the force ``-M r u''``.
///
/// Raises
/// ------
/// `ValueError`
///     Shapes that do not fit together, numbers that are not finite, a mass that is not symmetric positive definite.
///
/// Examples
/// --------
/// Modes of a finite-element model: unit masses, 2 zeta w, w**2.
///
/// >>> import numpy as np
/// >>> import vibroimpact as vi
/// >>> w = np.array([1.0, 3.0])
/// >>> vi.LinearSystem(np.ones(2), 2 * 0.01 * w, w**2).n_dof
/// 2
#[pyclass(name = "LinearSystem", module = "vibroimpact", frozen)]
#[derive(Clone)]
pub(crate) struct PyLinearSystem(pub LinearSystem);

#[pymethods]
impl PyLinearSystem {
    #[new]
    #[pyo3(signature = (mass, damping, stiffness, load=None, influence=None))]
    fn new(
        mass: &Bound<'_, PyAny>,
        damping: &Bound<'_, PyAny>,
        stiffness: &Bound<'_, PyAny>,
        load: Option<&Bound<'_, PyAny>>,
        influence: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let mut system = LinearSystem::new(
            coefficient("mass", mass)?,
            coefficient("damping", damping)?,
            coefficient("stiffness", stiffness)?,
        )?;
        if let Some(load) = load {
            system = system.with_load(vector("load", load)?)?;
        }
        if let Some(influence) = influence {
            system = system.with_influence(vector("influence", influence)?)?;
        }
        Ok(Self(system))
    }

    /// Number of degrees of freedom.
    #[getter]
    fn n_dof(&self) -> usize {
        self.0.n_dof()
    }

    /// Mass matrix, shape (n, n), or (n,) where given as a diagonal.
    #[getter]
    fn mass<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        out_coefficient(py, self.0.mass())
    }

    /// Damping matrix, shape (n, n), or (n,) where given as a diagonal.
    #[getter]
    fn damping<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        out_coefficient(py, self.0.damping())
    }

    /// Stiffness matrix, shape (n, n), or (n,) where given as a diagonal.
    #[getter]
    fn stiffness<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        out_coefficient(py, self.0.stiffness())
    }

    /// Constant force, shape (n,).
    #[getter]
    fn load<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        out_vector(py, self.0.load())
    }

    /// Influence vector, shape (n,), or None.
    #[getter]
    fn influence<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.0.influence().map(|r| out_vector(py, r))
    }

    /// The system itself: it is linear already.
    fn linearise(&self) -> Self {
        self.clone()
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __repr__(&self) -> String {
        let s = &self.0;
        let load = if s.load().amax() > 0.0 { ", load" } else { "" };
        let influence = if s.influence().is_some() {
            ", influence"
        } else {
            ""
        };
        format!(
            "LinearSystem(n_dof={}, mass {}, damping {}, stiffness {}{load}{influence})",
            s.n_dof(),
            shape_of(s.mass()),
            shape_of(s.damping()),
            shape_of(s.stiffness())
        )
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(
            py,
            [
                self.mass(py)?,
                self.damping(py)?,
                self.stiffness(py)?,
                self.load(py).into_any(),
                self.influence(py).into_pyobject(py)?.into_any(),
            ],
        )
    }
}

/// Double pendulum of the source paper's eq. (3), nonlinear and dimensionless.
///
/// Time is in units of ``1/(w1 sqrt(1 + m))`` with ``w1**2 = g/l1``, base amplitudes in units of ``l1``; angles are absolute,
/// from the downward vertical, in radians.
///
/// Parameters
/// ----------
/// `mass_ratio` : float
///     ``m2/m1`` > 0.
/// `length_ratio` : float
///     ``l1/l2`` > 0.
/// damping : pair of float or `array_like`, shape (2, 2), default (0, 0)
///     Joint dampers ``(p1, p2)``, or any damping matrix of the symmetric form.
///
/// Raises
/// ------
/// `ValueError`
///     A ratio that is not positive, a damper that is not finite.
#[pyclass(name = "DoublePendulum", module = "vibroimpact", frozen)]
#[derive(Clone)]
pub(crate) struct PyDoublePendulum(pub DoublePendulum);

#[pymethods]
impl PyDoublePendulum {
    #[new]
    #[pyo3(signature = (mass_ratio, length_ratio, damping=None))]
    fn new(
        mass_ratio: f64,
        length_ratio: f64,
        damping: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let Some(damping) = damping else {
            return Ok(Self(DoublePendulum::new(
                mass_ratio,
                length_ratio,
                (0.0, 0.0),
            )?));
        };
        match coefficient("damping", damping)? {
            model::Coefficient::Dense(c) => Ok(Self(DoublePendulum::with_damping_matrix(
                mass_ratio,
                length_ratio,
                c,
            )?)),
            model::Coefficient::Diagonal(p) if p.len() == 2 => Ok(Self(DoublePendulum::new(
                mass_ratio,
                length_ratio,
                (p[0], p[1]),
            )?)),
            model::Coefficient::Diagonal(p) => Err(bad(format!(
                "damping has shape ({},), but (2,) or (2, 2) is needed",
                p.len()
            ))),
        }
    }

    /// Number of degrees of freedom: 2.
    #[getter]
    fn n_dof(&self) -> usize {
        System::from(self.0.clone()).n_dof()
    }

    /// ``m2/m1``.
    #[getter]
    fn mass_ratio(&self) -> f64 {
        self.0.mass_ratio()
    }

    /// ``l1/l2``.
    #[getter]
    fn length_ratio(&self) -> f64 {
        self.0.length_ratio()
    }

    /// Damping matrix, shape (2, 2).
    #[getter]
    fn damping<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        out_matrix(py, self.0.damping())
    }

    /// The linear system about the hanging equilibrium, influence vector filled in.
    fn linearise(&self) -> PyResult<PyLinearSystem> {
        Ok(PyLinearSystem(self.0.linearise()?))
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __repr__(&self) -> String {
        format!(
            "DoublePendulum(mass_ratio={}, length_ratio={})",
            self.0.mass_ratio(),
            self.0.length_ratio()
        )
    }

    fn __getnewargs__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(f64, f64, Bound<'py, PyArray2<f64>>)> {
        Ok((
            self.0.mass_ratio(),
            self.0.length_ratio(),
            self.damping(py)?,
        ))
    }
}

/// Chain of N pendulum links in physical units, nonlinear.
///
/// Parameters
/// ----------
/// masses : `array_like`, shape (N,)
///     Point masses, > 0.
/// lengths : `array_like`, shape (N,)
///     Link lengths, > 0.
/// damping : float or `array_like`, shape (N,) or (N, N), default 0.0
///     Joint dampers, one for all or one each, or any damping matrix.
/// gravity : float, default 9.81
///     Gravity.
///
/// Raises
/// ------
/// `ValueError`
///     Arrays of different lengths, masses or lengths that are not positive, numbers that are not finite.
#[pyclass(name = "PendulumChain", module = "vibroimpact", frozen)]
#[derive(Clone)]
pub(crate) struct PyPendulumChain(pub PendulumChain);

#[pymethods]
impl PyPendulumChain {
    #[new]
    #[pyo3(signature = (masses, lengths, damping=None, gravity=9.81))]
    fn new(
        masses: &Bound<'_, PyAny>,
        lengths: &Bound<'_, PyAny>,
        damping: Option<&Bound<'_, PyAny>>,
        gravity: f64,
    ) -> PyResult<Self> {
        let (masses, lengths) = (vector("masses", masses)?, vector("lengths", lengths)?);
        let n = masses.len();
        let damping = match damping {
            None => model::Coefficient::Diagonal(DVector::zeros(n)),
            Some(damping) => coefficient("damping", damping)?,
        };
        Ok(Self(match damping {
            model::Coefficient::Dense(c) => {
                PendulumChain::with_damping_matrix(masses, lengths, c, gravity)?
            }
            model::Coefficient::Diagonal(c) if c.len() == 1 => {
                PendulumChain::new(masses, lengths, &DVector::from_element(n, c[0]), gravity)?
            }
            model::Coefficient::Diagonal(c) => PendulumChain::new(masses, lengths, &c, gravity)?,
        }))
    }

    /// Number of links.
    #[getter]
    fn n_dof(&self) -> usize {
        self.0.n_dof()
    }

    /// Point masses, shape (N,).
    #[getter]
    fn masses<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        out_vector(py, self.0.masses())
    }

    /// Link lengths, shape (N,).
    #[getter]
    fn lengths<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        out_vector(py, self.0.lengths())
    }

    /// Damping matrix, shape (N, N).
    #[getter]
    fn damping<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        out_matrix(py, self.0.damping())
    }

    /// Gravity.
    #[getter]
    fn gravity(&self) -> f64 {
        self.0.gravity()
    }

    /// The linear system about the hanging equilibrium, influence vector filled in.
    fn linearise(&self) -> PyResult<PyLinearSystem> {
        Ok(PyLinearSystem(self.0.linearise()?))
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __repr__(&self) -> String {
        format!(
            "PendulumChain(n_dof={}, gravity={})",
            self.0.n_dof(),
            self.0.gravity()
        )
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let gravity = self.0.gravity().into_pyobject(py)?.into_any();
        PyTuple::new(
            py,
            [
                self.masses(py).into_any(),
                self.lengths(py).into_any(),
                self.damping(py)?.into_any(),
                gravity,
            ],
        )
    }
}

/// Harmonic force ``Re(amplitude exp(i (frequency t + phase)))`` on the coordinates.
///
/// Parameters
/// ----------
/// amplitude : `array_like`, shape (n,), real or complex
///     Force amplitude; a real one is a cosine.
/// frequency : float
///     Circular frequency [rad/s], > 0.
/// phase : float, default 0.0
///     Phase [rad]; a sine has -pi/2.
///
/// Raises
/// ------
/// `ValueError`
///     Numbers that are not finite, a frequency that is not positive.
#[pyclass(name = "Harmonic", module = "vibroimpact", frozen)]
#[derive(Clone)]
pub(crate) struct PyHarmonic(pub Harmonic);

#[pymethods]
impl PyHarmonic {
    #[new]
    #[pyo3(signature = (amplitude, frequency, phase=0.0))]
    fn new(amplitude: &Bound<'_, PyAny>, frequency: f64, phase: f64) -> PyResult<Self> {
        Ok(Self(Harmonic::new(
            complex_vector("amplitude", amplitude)?,
            frequency,
            phase,
        )?))
    }

    /// Force amplitude, shape (n,), real where it has no imaginary part.
    #[getter]
    fn amplitude<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        let amplitude = self.0.amplitude();
        if amplitude.iter().all(|z| z.im == 0.0) {
            out_vector(py, &amplitude.map(|z| z.re)).into_any()
        } else {
            out_complex(py, amplitude).into_any()
        }
    }

    /// Circular frequency [rad/s].
    #[getter]
    fn frequency(&self) -> f64 {
        self.0.frequency()
    }

    /// Phase [rad].
    #[getter]
    fn phase(&self) -> f64 {
        self.0.phase()
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let amplitude = self.amplitude(py).repr()?;
        Ok(format!(
            "Harmonic({amplitude}, frequency={}, phase={})",
            self.0.frequency(),
            self.0.phase()
        ))
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> (Bound<'py, PyAny>, f64, f64) {
        (self.amplitude(py), self.0.frequency(), self.0.phase())
    }
}

/// Base displacement ``amplitude cos(frequency t + phase)`` of a pendulum, or of a linear system with an influence vector.
///
/// The force it makes grows with ``frequency**2``.
///
/// Parameters
/// ----------
/// amplitude : float
///     Displacement amplitude (in units of ``l1`` for ``DoublePendulum`` and ``paper_system``).
/// frequency : float
///     Circular frequency [rad/s], > 0.
/// phase : float, default 0.0
///     Phase [rad].
///
/// Raises
/// ------
/// `ValueError`
///     Numbers that are not finite, a frequency that is not positive.
#[pyclass(name = "BaseMotion", module = "vibroimpact", frozen)]
#[derive(Clone, Copy)]
pub(crate) struct PyBaseMotion(pub BaseMotion);

#[pymethods]
impl PyBaseMotion {
    #[new]
    #[pyo3(signature = (amplitude, frequency, phase=0.0))]
    fn new(amplitude: f64, frequency: f64, phase: f64) -> PyResult<Self> {
        Ok(Self(BaseMotion::new(amplitude, frequency, phase)?))
    }

    /// Displacement amplitude.
    #[getter]
    fn amplitude(&self) -> f64 {
        self.0.amplitude()
    }

    /// Circular frequency [rad/s].
    #[getter]
    fn frequency(&self) -> f64 {
        self.0.frequency()
    }

    /// Phase [rad].
    #[getter]
    fn phase(&self) -> f64 {
        self.0.phase()
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __repr__(&self) -> String {
        let f = &self.0;
        format!(
            "BaseMotion({}, frequency={}, phase={})",
            f.amplitude(),
            f.frequency(),
            f.phase()
        )
    }

    fn __getnewargs__(&self) -> (f64, f64, f64) {
        (self.0.amplitude(), self.0.frequency(), self.0.phase())
    }
}

fn side(value: &str) -> PyResult<Side> {
    match value {
        "upper" => Ok(Side::Upper),
        "lower" => Ok(Side::Lower),
        _ => Err(bad(format!(
            "side is {value:?}, but it must be \"upper\" or \"lower\""
        ))),
    }
}

fn is_whole_number(value: &Bound<'_, PyAny>) -> bool {
    value.hasattr("__index__").unwrap_or(false)
        && value
            .getattr("shape")
            .map_or(true, |s| s.len().unwrap_or(0) == 0)
}

fn normal(value: &Bound<'_, PyAny>) -> PyResult<Normal> {
    if is_whole_number(value) {
        Ok(Normal::Coordinate(stop_index("normal", value)?))
    } else {
        Ok(vector("normal", value)?.into())
    }
}

fn reaction(value: Option<&Bound<'_, PyAny>>) -> PyResult<Reaction> {
    let Some(value) = value else {
        return Ok(Reaction::Inertia);
    };
    match value.extract::<String>() {
        Ok(name) if name == "inertia" => Ok(Reaction::Inertia),
        Ok(name) if name == "coordinate" => Ok(Reaction::Coordinate),
        Ok(name) => Err(bad(format!(
            "reaction is {name:?}, but it must be \"inertia\", \"coordinate\" or a direction of shape (n,)"
        ))),
        Err(_) => Ok(Reaction::Direction(vector("reaction", value)?)),
    }
}

/// Plane stop with gap ``clearance - n.q >= 0`` (upper side) or ``clearance + n.q >= 0`` (lower side).
///
/// Parameters
/// ----------
/// normal : int or `array_like`, shape (n,)
///     Index of a coordinate, counted from 0, or the normal n itself, of any length but zero.
/// clearance : float
///     Gap at q = 0; negative: preloaded.
/// restitution : float
///     Minus the ratio of the normal velocity after an impact to the one before [-], in [0, 1].
/// side : {"upper", "lower"}, default "upper"
///     On which side of the motion the stop stands.
/// reaction : {"inertia", "coordinate"} or `array_like`, shape (n,), default "inertia"
///     Direction in which an impact changes the velocity: ``M^-1 n`` (Newton's law), ``n`` (each coordinate reset alone, the
///     source paper's law, which can gain energy: see ``audit_recovery``), or b itself with ``n.b > 0``.
///
/// Raises
/// ------
/// `ValueError`
///     A zero normal, a negative index, a restitution outside [0, 1], an unknown side or reaction.
///
/// Examples
/// --------
/// >>> import vibroimpact as vi
/// >>> vi.Stop(1, 0.15, 0.9, reaction="coordinate")
/// Stop(1, clearance=0.15, restitution=0.9, side='upper', reaction='coordinate')
#[pyclass(name = "Stop", module = "vibroimpact", frozen)]
#[derive(Clone)]
pub(crate) struct PyStop(pub Stop);

#[pymethods]
impl PyStop {
    #[new]
    #[pyo3(signature = (normal, clearance, restitution, *, side="upper", reaction=None))]
    fn new(
        normal: &Bound<'_, PyAny>,
        clearance: f64,
        restitution: f64,
        side: &str,
        reaction: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let stop = Stop::new(self::normal(normal)?, clearance, restitution)?;
        Ok(Self(
            stop.on_side(self::side(side)?)
                .with_reaction(self::reaction(reaction)?)?,
        ))
    }

    /// The normal as given: index of a coordinate, or shape (n,).
    #[getter]
    fn normal<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(match self.0.normal() {
            Normal::Coordinate(i) => i.into_pyobject(py)?.into_any(),
            Normal::Vector(n) => out_vector(py, n).into_any(),
        })
    }

    /// Gap at q = 0.
    #[getter]
    fn clearance(&self) -> f64 {
        self.0.clearance()
    }

    /// Restitution coefficient [-].
    #[getter]
    fn restitution(&self) -> f64 {
        self.0.restitution().value()
    }

    /// "upper" or "lower".
    #[getter]
    fn side(&self) -> &'static str {
        match self.0.side() {
            Side::Upper => "upper",
            Side::Lower => "lower",
        }
    }

    /// "inertia", "coordinate", or a direction of shape (n,).
    #[getter]
    fn reaction<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(match self.0.reaction() {
            Reaction::Inertia => "inertia".into_pyobject(py)?.into_any(),
            Reaction::Coordinate => "coordinate".into_pyobject(py)?.into_any(),
            Reaction::Direction(b) => out_vector(py, b).into_any(),
        })
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!(
            "Stop({}, clearance={}, restitution={}, side='{}', reaction={})",
            self.normal(py)?.repr()?,
            self.clearance(),
            self.restitution(),
            self.side(),
            self.reaction(py)?.repr()?
        ))
    }

    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<((Bound<'py, PyAny>, f64, f64), Bound<'py, PyDict>)> {
        let options = PyDict::new(py);
        options.set_item("side", self.side())?;
        options.set_item("reaction", self.reaction(py)?)?;
        Ok((
            (self.normal(py)?, self.clearance(), self.restitution()),
            options,
        ))
    }
}

/// Vertical plane wall that one bob of a pendulum may not cross; it moves with the base.
///
/// Parameters
/// ----------
/// bob : int
///     The bob, counted from 0.
/// position : float
///     Horizontal position of the wall (in units of ``l1`` for ``DoublePendulum``).
/// restitution : float
///     Restitution coefficient [-], in [0, 1].
/// side : {"right", "left"}, default "right"
///     On which side of the bob the wall stands.
///
/// Raises
/// ------
/// `ValueError`
///     A negative bob, a restitution outside [0, 1], an unknown side.
#[pyclass(name = "Wall", module = "vibroimpact", frozen)]
#[derive(Clone)]
pub(crate) struct PyWall(pub Wall);

#[pymethods]
impl PyWall {
    #[new]
    #[pyo3(signature = (bob, position, restitution, *, side="right"))]
    fn new(bob: &Bound<'_, PyAny>, position: f64, restitution: f64, side: &str) -> PyResult<Self> {
        let side = match side {
            "right" => WallSide::Right,
            "left" => WallSide::Left,
            _ => {
                return Err(bad(format!(
                    "side is {side:?}, but it must be \"right\" or \"left\""
                )));
            }
        };
        Ok(Self(Wall::new(
            stop_index("bob", bob)?,
            position,
            restitution,
            side,
        )?))
    }

    /// The bob, counted from 0.
    #[getter]
    fn bob(&self) -> usize {
        self.0.bob()
    }

    /// Horizontal position.
    #[getter]
    fn position(&self) -> f64 {
        self.0.position()
    }

    /// Restitution coefficient [-].
    #[getter]
    fn restitution(&self) -> f64 {
        self.0.restitution().value()
    }

    /// "right" or "left".
    #[getter]
    fn side(&self) -> &'static str {
        match self.0.side() {
            WallSide::Right => "right",
            WallSide::Left => "left",
        }
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __repr__(&self) -> String {
        format!(
            "Wall(bob={}, position={}, restitution={}, side='{}')",
            self.bob(),
            self.position(),
            self.restitution(),
            self.side()
        )
    }

    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<((usize, f64, f64), Bound<'py, PyDict>)> {
        let options = PyDict::new(py);
        options.set_item("side", self.side())?;
        Ok(((self.bob(), self.position(), self.restitution()), options))
    }
}

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
    Err(PyTypeError::new_err(format!(
        "system is {}, but a LinearSystem, DoublePendulum or PendulumChain is needed",
        value.get_type().name()?
    )))
}

fn forcing(value: Option<&Bound<'_, PyAny>>) -> PyResult<Forcing> {
    let Some(value) = value.filter(|v| !v.is_none()) else {
        return Ok(Forcing::Unforced);
    };
    if let Ok(f) = value.cast::<PyHarmonic>() {
        return Ok(f.get().0.clone().into());
    }
    if let Ok(f) = value.cast::<PyBaseMotion>() {
        return Ok(f.get().0.into());
    }
    Err(PyTypeError::new_err(format!(
        "forcing is {}, but a Harmonic, a BaseMotion or None is needed",
        value.get_type().name()?
    )))
}

fn constraint(value: &Bound<'_, PyAny>) -> PyResult<Constraint> {
    if let Ok(s) = value.cast::<PyStop>() {
        return Ok(s.get().0.clone().into());
    }
    if let Ok(s) = value.cast::<PyWall>() {
        return Ok(s.get().0.clone().into());
    }
    Err(PyTypeError::new_err(format!(
        "stops holds {}, but a Stop or Wall is needed",
        value.get_type().name()?
    )))
}

fn constraints(value: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<Constraint>> {
    let Some(value) = value.filter(|v| !v.is_none()) else {
        return Ok(Vec::new());
    };
    match value.try_iter() {
        Ok(items) => items.map(|item| constraint(&item?)).collect(),
        Err(_) => Ok(vec![constraint(value)?]),
    }
}

/// System, forcing and stops: what is analysed or simulated.
///
/// Parameters
/// ----------
/// system : `LinearSystem`, `DoublePendulum` or `PendulumChain`
///     The system.
/// forcing : Harmonic, `BaseMotion` or None, optional
///     What drives it.
/// stops : Stop, Wall or a sequence of them, default ()
///     One stop or several.
///
/// Raises
/// ------
/// `ValueError`
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
    })
}

fn list_of_numbers(argument: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    Ok(vector(argument, value)?.as_slice().to_vec())
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
                BaseMotion::new(number("amplitude", value)?, frequency, phase)?.into()
            }
        }))
    }

    fn change(&self, name: &str, value: &Bound<'_, PyAny>) -> PyResult<Change> {
        Ok(match name {
            "amplitude" => self.with_amplitude(value)?,
            "clearance" => Change::Clearance(list_of_numbers(name, value)?),
            "restitution" => Change::Restitution(list_of_numbers(name, value)?),
            _ => name
                .parse::<Parameter>()
                .map_err(|_| {
                    bad(format!(
                        "{name} is not something a scene has; it must be one of system, forcing, stops, frequency, phase, \
                         amplitude, clearance, restitution, forcing_scale, damping_scale"
                    ))
                })?
                .change(number(name, value)?),
        })
    }
}

#[pymethods]
impl PyScene {
    #[new]
    #[pyo3(signature = (system, forcing=None, stops=None))]
    fn new(
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

    /// The forcing, or None.
    #[getter]
    fn forcing(&self, py: Python<'_>) -> PyResult<Option<Py<PyAny>>> {
        Ok(match self.0.forcing() {
            Forcing::Unforced => None,
            Forcing::Harmonic(f) => Some(Py::new(py, PyHarmonic(f.clone()))?.into_any()),
            Forcing::BaseMotion(f) => Some(Py::new(py, PyBaseMotion(*f))?.into_any()),
        })
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
            })
            .collect::<PyResult<Vec<_>>>()?;
        PyTuple::new(py, stops)
    }

    /// Number of degrees of freedom.
    #[getter]
    fn n_dof(&self) -> usize {
        self.0.n_dof()
    }

    /// Forcing period [s], None without forcing.
    #[getter]
    fn period(&self) -> Option<f64> {
        self.0.period()
    }

    /// The gap of every stop at positions q.
    ///
    /// Parameters
    /// ----------
    /// q : `array_like`, shape (..., n)
    ///     Positions.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (..., `n_stops`)
    ///     Gaps; negative inside a stop.
    fn gaps<'py>(&self, py: Python<'py>, q: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let numpy = py.import("numpy")?;
        let array = numpy
            .getattr("asarray")?
            .call1((q, "float64"))
            .map_err(|_| {
                let shown = q
                    .repr()
                    .map_or_else(|_| "this value".to_owned(), |r| r.to_string());
                bad(format!("q is {shown}, but an array of numbers is needed"))
            })?;
        let mut shape: Vec<usize> = array.getattr("shape")?.extract()?;
        let n = self.0.n_dof();
        if shape.is_empty() && n == 1 {
            shape.push(1);
        }
        if shape.last() != Some(&n) {
            let shown: Vec<String> = shape.iter().map(ToString::to_string).collect();
            return Err(bad(format!(
                "q has shape ({}), but (..., {n}) is needed",
                shown.join(", ")
            )));
        }
        let flat = vector("q", &array.call_method1("reshape", (-1,))?)?;
        let gaps: Vec<f64> = flat
            .as_slice()
            .chunks(n)
            .flat_map(|q| {
                self.0
                    .gaps(&DVector::from_row_slice(q))
                    .iter()
                    .copied()
                    .collect::<Vec<_>>()
            })
            .collect();
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
    ///     Any of ``system``, ``forcing``, ``stops``; ``frequency``, ``phase``, ``amplitude`` of the forcing; ``clearance``,
    ///     ``restitution`` (a number for every stop, or one each); ``forcing_scale``, ``damping_scale`` (factors on what is
    ///     there).
    ///
    /// Returns
    /// -------
    /// Scene
    ///
    /// Raises
    /// ------
    /// `ValueError`
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

    /// The linear scene of small angles: linear system, walls as plane stops, the same forcing.
    fn linearise(&self) -> PyResult<Self> {
        Ok(Self(model::linearise(&self.0)?))
    }

    /// What will run for this scene, in words.
    fn plan(&self) -> PyResult<String> {
        Ok(crate::simulate::plan(&self.0)?)
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
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

/// The source paper's system (7) in symmetric form, with damping ``C = 2 damping K``.
///
/// Parameters
/// ----------
/// `mass_ratio` : float
///     ``m2/m1`` > 0.
/// `length_ratio` : float
///     ``l1/l2`` > 0.
/// damping : float
///     zeta; the modal damping ratios are ``damping * w_j``.
///
/// Returns
/// -------
/// `LinearSystem`
///
/// Raises
/// ------
/// `ValueError`
///     A ratio that is not positive, a damping that is not finite.
#[pyfunction]
pub(crate) fn paper_system(
    mass_ratio: f64,
    length_ratio: f64,
    damping: f64,
) -> PyResult<PyLinearSystem> {
    Ok(PyLinearSystem(model::paper_system(
        mass_ratio,
        length_ratio,
        damping,
    )?))
}

/// The source paper's numerical case of the given kind: base motion, and a stop for each pendulum.
///
/// Parameters
/// ----------
/// kind : {1, 2, 3}
///     1: both pendulums hit together (3 forcing periods); 2: the upper one (2 periods); 3: the lower one (2 periods).
/// damping : float, optional
///     zeta, not printed in the paper; default: a value with an admissible orbit.
/// clearance : float, optional
///     theta0, not printed in the paper; default: a value with an admissible orbit.
/// linear : bool, default True
///     The small-angle system (7), or the full eq. (3) with the same damping.
///
/// Returns
/// -------
/// Scene
///
/// Raises
/// ------
/// `ValueError`
///     An unknown kind, a number that is not finite.
#[pyfunction]
#[pyo3(signature = (kind, damping=None, clearance=None, linear=true))]
pub(crate) fn paper_scene(
    kind: i64,
    damping: Option<f64>,
    clearance: Option<f64>,
    linear: bool,
) -> PyResult<PyScene> {
    let options = PaperOptions {
        damping,
        clearance,
        linear,
    };
    Ok(PyScene(model::paper_scene(
        Kind::try_from(kind)?,
        &options,
    )?))
}

/// Normals given one after the other, as columns.
pub(crate) fn normals(value: &Bound<'_, PyAny>, n: usize) -> PyResult<DMatrix<f64>> {
    if let Ok(m) = matrix("normals", value) {
        return if m.ncols() == n {
            Ok(m.transpose())
        } else {
            Err(bad(format!(
                "normals has shape ({}, {}), but (k, {n}) is needed",
                m.nrows(),
                m.ncols()
            )))
        };
    }
    let items = value
        .try_iter()
        .map_err(|_| bad("normals must be a list of indices or vectors".to_owned()))?;
    let columns = items
        .enumerate()
        .map(|(i, item)| {
            Ok(Stop::new(normal(&item?)?, 0.0, 0.0)?.normal_vector(n, &format!("normals[{i}]"))?)
        })
        .collect::<PyResult<Vec<DVector<f64>>>>()?;
    Ok(if columns.is_empty() {
        DMatrix::zeros(n, 0)
    } else {
        DMatrix::from_columns(&columns)
    })
}
