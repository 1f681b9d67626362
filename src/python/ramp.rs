//! Ramps in Python.

use crate::model::{Parameter, Ramp, RampLaw, RampProfile};
use crate::python::answered::answered;
use crate::python::argument;
use crate::python::text::shown;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// Number of a scene that drifts along a run: from its value at the start of the run to another, where it stays.
///
/// Give one of: ``over``, ``rate``, or ``levels`` with ``dwell``. The angle of what turns goes on through a change of the frequency, and
/// so do position and velocity. Those of a scene with a moving base are relative to it: where the base changes its speed at once, as it
/// does from level to level, the scene is taken along.
///
/// Parameters
/// ----------
/// parameter : str
///     A number of ``Scene.replace``: "frequency", "phase", "forcing_scale", "damping_scale", "clearance", "restitution", or
///     "clearance[i]", "restitution[i]" of one stop.
/// to : float
///     The last value.
/// over : float, optional
///     Time that it takes [s].
/// rate : float, optional
///     Change in a unit of time, whatever its sign: of the value, or with ``law="log"`` of its logarithm.
/// law : {"linear", "log"}, default "linear"
///     Equal changes, or equal factors, in equal times or from level to level.
/// levels : int, optional
///     Number of values, the first and the last among them, each held for a while; from 2 to 100 000.
/// dwell : float, optional
///     Forcing periods at each of them.
///
/// Raises
/// ------
/// ValueError
///     A number that no scene has, a value that it may not take, a time, rate or dwell that is not positive, none or several of the ways to
///     say how fast.
///
/// Examples
/// --------
/// >>> import vibroimpact as vi
/// >>> scene = vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([0.5], 0.5), vi.Stop(0, 1.0, 0.8))
/// >>> run = vi.simulate(scene, 0.0, 0.0, (0, 400), ramp=vi.Ramp("frequency", 2.0, rate=0.005))
/// >>> run.parameter([0.0, 100.0, 400.0])
/// array([0.5, 1. , 2. ])
#[pyclass(name = "Ramp", module = "vibroimpact", frozen)]
#[derive(Clone)]
pub(crate) struct PyRamp(pub Ramp);

fn law(name: &str) -> PyResult<RampLaw> {
    match name {
        "linear" => Ok(RampLaw::Linear),
        "log" => Ok(RampLaw::Log),
        _ => Err(PyValueError::new_err(format!(
            "law is {name:?}, but it must be \"linear\" or \"log\""
        ))),
    }
}

/// How fast a ramp goes, by the one of the arguments that is given, or the last two.
fn pace(
    over: Option<f64>,
    rate: Option<f64>,
    levels: Option<i64>,
    dwell: Option<f64>,
) -> PyResult<RampProfile> {
    match (over, rate, levels, dwell) {
        (Some(over), None, None, None) => Ok(RampProfile::Over(over)),
        (None, Some(rate), None, None) => Ok(RampProfile::Rate(rate)),
        (None, None, Some(levels), Some(dwell)) => Ok(RampProfile::Steps {
            levels: usize::try_from(levels).unwrap_or(0),
            dwell,
        }),
        (None, None, Some(_), None) => Err(PyValueError::new_err(
            "dwell is None, but with levels= it must be the number of forcing periods at each",
        )),
        (None, None, None, Some(_)) => Err(PyValueError::new_err(
            "levels is None, but with dwell= it must be the number of values",
        )),
        (None, None, None, None) => Err(PyValueError::new_err(
            "how fast the ramp goes is missing: give over=, rate=, or levels= and dwell=",
        )),
        _ => Err(PyValueError::new_err(
            "how fast the ramp goes is given twice: give one of over=, rate=, or levels= and dwell=",
        )),
    }
}

#[pymethods]
impl PyRamp {
    #[new]
    #[pyo3(signature = (*arguments, **named), text_signature = "(parameter, to, *, over=None, rate=None, law=\"linear\", levels=None, dwell=None)")]
    fn new(arguments: &Bound<'_, PyTuple>, named: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        answered(arguments, named)
    }

    #[staticmethod]
    #[pyo3(name = "_made", signature = (parameter, to, *, over=None, rate=None, law="linear", levels=None, dwell=None))]
    fn made(
        #[pyo3(from_py_with = argument::parameter)] parameter: &str,
        #[pyo3(from_py_with = argument::to)] to: f64,
        #[pyo3(from_py_with = argument::over)] over: Option<f64>,
        #[pyo3(from_py_with = argument::rate)] rate: Option<f64>,
        #[pyo3(from_py_with = argument::law)] law: &str,
        #[pyo3(from_py_with = argument::levels)] levels: Option<i64>,
        #[pyo3(from_py_with = argument::dwell)] dwell: Option<f64>,
    ) -> PyResult<Self> {
        let parameter: Parameter = parameter.parse()?;
        let course = pace(over, rate, levels, dwell)?;
        Ok(Self(
            Ramp::new(parameter, to, course)?.with_law(self::law(law)?),
        ))
    }

    /// The number that drifts.
    #[getter]
    fn parameter(&self) -> String {
        self.0.parameter().to_string()
    }

    /// The last value.
    #[getter]
    fn to(&self) -> f64 {
        self.0.to()
    }

    /// Time that it takes [s], if that is how it was given.
    #[getter]
    fn over(&self) -> Option<f64> {
        match self.0.profile() {
            RampProfile::Over(time) => Some(time),
            _ => None,
        }
    }

    /// Change in a unit of time, if that is how it was given.
    #[getter]
    fn rate(&self) -> Option<f64> {
        match self.0.profile() {
            RampProfile::Rate(rate) => Some(rate),
            _ => None,
        }
    }

    /// "linear" or "log".
    #[getter]
    fn law(&self) -> &'static str {
        match self.0.law() {
            RampLaw::Linear => "linear",
            RampLaw::Log => "log",
        }
    }

    /// Number of values, if it goes in steps.
    #[getter]
    fn levels(&self) -> Option<usize> {
        match self.0.profile() {
            RampProfile::Steps { levels, .. } => Some(levels),
            _ => None,
        }
    }

    /// Forcing periods at each, if it goes in steps.
    #[getter]
    fn dwell(&self) -> Option<f64> {
        match self.0.profile() {
            RampProfile::Steps { dwell, .. } => Some(dwell),
            _ => None,
        }
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __repr__(&self) -> String {
        let how = match self.0.profile() {
            RampProfile::Over(time) => format!("over={time}"),
            RampProfile::Rate(rate) => format!("rate={rate}"),
            RampProfile::Steps { levels, dwell } => format!("levels={levels}, dwell={dwell}"),
        };
        let law = match self.0.law() {
            RampLaw::Linear => "",
            RampLaw::Log => ", law=\"log\"",
        };
        format!(
            "Ramp(\"{}\", {}, {how}{law})",
            self.0.parameter(),
            self.0.to()
        )
    }

    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyTuple>, Bound<'py, PyDict>)> {
        let named = PyDict::new(py);
        named.set_item("over", self.over())?;
        named.set_item("rate", self.rate())?;
        named.set_item("law", self.law())?;
        named.set_item("levels", self.levels())?;
        named.set_item("dwell", self.dwell())?;
        Ok(((self.parameter(), self.to()).into_pyobject(py)?, named))
    }
}

/// Ramps as given: none, one, or a sequence.
pub(crate) fn ramps(value: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<Ramp>> {
    let Some(value) = value else {
        return Ok(Vec::new());
    };
    if let Ok(one) = value.extract::<PyRef<'_, PyRamp>>() {
        return Ok(vec![one.0]);
    }
    let wrong = || {
        let found = shown(value);
        PyTypeError::new_err(format!(
            "ramp is {found}, but a Ramp or a sequence of them is needed"
        ))
    };
    let each = value.try_iter().map_err(|_| wrong())?;
    let each = each.map(|item| Ok(item?.extract::<PyRef<'_, PyRamp>>().map_err(|_| wrong())?.0));
    each.collect()
}
