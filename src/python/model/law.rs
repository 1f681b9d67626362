//! Laws of contact in Python.

use crate::law::{ContactRelease, Hertz, IntoLaw, Law, Newton, Spring};
use crate::python::answered::answered;
use crate::python::argument;
use crate::python::model::bad;
use crate::quantity::Restitution;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// Newton's law of a rigid stop: the normal speed after an impact is minus the restitution times that before it.
///
/// Parameters
/// ----------
/// restitution : float
///     Minus the ratio of the normal velocity after an impact to the one before [-], in [0, 1].
///
/// Raises
/// ------
/// ValueError
///     A restitution outside [0, 1].
///
/// Examples
/// --------
/// >>> import vibroimpact as vi
/// >>> vi.Stop(0, 1.0, contact=vi.Newton(0.8)) == vi.Stop(0, 1.0, 0.8)
/// True
#[pyclass(name = "Newton", module = "vibroimpact", frozen, eq)]
#[derive(Clone, PartialEq)]
pub(crate) struct PyNewton(Newton);

#[pymethods]
impl PyNewton {
    #[new]
    #[pyo3(signature = (*arguments, **named), text_signature = "(restitution)")]
    fn new(arguments: &Bound<'_, PyTuple>, named: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        answered(arguments, named)
    }

    #[staticmethod]
    #[pyo3(name = "_made")]
    fn made(#[pyo3(from_py_with = argument::restitution)] restitution: f64) -> PyResult<Self> {
        Ok(Self(Newton::new(restitution)?))
    }

    /// Restitution coefficient [-].
    #[getter]
    fn restitution(&self) -> f64 {
        self.0.restitution()
    }

    /// The restitution of a free body: that of the law, whatever its mass [kg] and speed [m/s].
    #[pyo3(signature = (mass, speed=None))]
    fn equivalent_restitution(
        &self,
        #[pyo3(from_py_with = argument::mass)] mass: f64,
        #[pyo3(from_py_with = argument::speed)] speed: Option<f64>,
    ) -> PyResult<f64> {
        Ok(self.0.equivalent_restitution(mass, speed)?)
    }

    fn __repr__(&self) -> String {
        format!("Newton({})", self.restitution())
    }

    fn __getnewargs__(&self) -> (f64,) {
        (self.restitution(),)
    }
}

/// Law of a stop that gives way: a force k p + c p' pushes against the approach p = -gap while that is positive.
///
/// Parameters
/// ----------
/// stiffness : float
///     k [N/m], greater than zero.
/// damping : float, default 0
///     c [N s/m].
/// release : {"gap", "force", "clipped"}, optional
///     Where a contact ends: "gap": where the gap opens, p = 0; the dashpot pulls before that. "force": where the force is zero; the
///     stop goes back by itself, at the rate k/c, and is met again where it is. "clipped": the force is ``max(0, k p + c p')``, of a stop
///     without a place of its own. Required with damping: papers differ in it, and a free body is given back more of its speed by the
///     last two, by 9 % at a damping ratio of 0.2 and 83 % at 0.5. Without damping all are one.
/// preload : float, default 0
///     F0 [N], the force at which the stop begins to give way. Under less a body rests at its seat, p = 0 ("seated").
///
/// Raises
/// ------
/// ValueError
///     A stiffness that is not positive, a damping or a preload that is negative or not finite, an unknown release, damping without a
///     release.
///
/// Notes
/// -----
/// Linear scenes stay exact: one linear flow for each combination of stops that are pressed, every beginning and end of a contact certified
/// as impacts are.
///
/// Examples
/// --------
/// >>> import vibroimpact as vi
/// >>> law = vi.Spring(50.0, 1.0, release="gap")
/// >>> vi.Stop(0, 1.0, contact=law).contact
/// Spring(stiffness=50, damping=1, release='gap')
/// >>> round(law.equivalent_restitution(2.0), 3)
/// 0.854
#[pyclass(name = "Spring", module = "vibroimpact", frozen, eq)]
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct PySpring(Spring);

/// A release by its name.
fn release(name: Option<&str>) -> PyResult<Option<ContactRelease>> {
    let Some(name) = name else {
        return Ok(None);
    };
    let known = ContactRelease::ALL.iter().find(|own| own.1 == name);
    known.map(|own| Some(own.0)).ok_or_else(|| {
        bad(format!(
            "release is {name:?}, but it must be \"gap\", \"force\" or \"clipped\""
        ))
    })
}

/// The name of a release.
fn name_of(release: Option<ContactRelease>) -> Option<&'static str> {
    let known = ContactRelease::ALL
        .iter()
        .find(|own| Some(own.0) == release);
    known.map(|own| own.1)
}

#[pymethods]
impl PySpring {
    #[new]
    #[pyo3(signature = (*arguments, **named), text_signature = "(stiffness, damping=0.0, *, release=None, preload=0.0)")]
    fn new(arguments: &Bound<'_, PyTuple>, named: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        answered(arguments, named)
    }

    #[staticmethod]
    #[pyo3(name = "_made", signature = (stiffness, damping=0.0, *, release=None, preload=0.0))]
    fn made(
        #[pyo3(from_py_with = argument::stiffness)] stiffness: f64,
        #[pyo3(from_py_with = argument::damping)] damping: f64,
        #[pyo3(from_py_with = argument::release)] release: Option<&str>,
        #[pyo3(from_py_with = argument::preload)] preload: f64,
    ) -> PyResult<Self> {
        let spring = Spring::new(stiffness, damping, self::release(release)?)?;
        Ok(Self(spring.with_preload(preload)?))
    }

    /// The law that gives a free body of some mass [kg] back so much of its speed.
    ///
    /// Parameters
    /// ----------
    /// restitution : float
    ///     What is left of the speed [-], in [0, 1]; above zero unless the release is "gap".
    /// stiffness, mass : float
    ///     k [N/m], greater than zero, and the mass [kg].
    /// release : {"gap", "force", "clipped"}
    ///     Where a contact ends.
    #[staticmethod]
    #[pyo3(signature = (restitution, stiffness, mass, *, release))]
    fn from_restitution(
        #[pyo3(from_py_with = argument::restitution)] restitution: f64,
        #[pyo3(from_py_with = argument::stiffness)] stiffness: f64,
        #[pyo3(from_py_with = argument::mass)] mass: f64,
        #[pyo3(from_py_with = argument::release)] release: &str,
    ) -> PyResult<Self> {
        let release = self::release(Some(release))?.unwrap_or(ContactRelease::Gap);
        Ok(Self(Spring::from_restitution(
            restitution,
            stiffness,
            mass,
            release,
        )?))
    }

    /// The restitution [-] of a free body of some mass [kg] that meets the stop at some speed [m/s] with nothing else acting; with a
    /// preload it depends on the speed, else on none.
    #[pyo3(signature = (mass, speed=None))]
    fn equivalent_restitution(
        &self,
        #[pyo3(from_py_with = argument::mass)] mass: f64,
        #[pyo3(from_py_with = argument::speed)] speed: Option<f64>,
    ) -> PyResult<f64> {
        Ok(self.0.equivalent_restitution(mass, speed)?)
    }

    /// Stiffness k [N/m].
    #[getter]
    fn stiffness(&self) -> f64 {
        self.0.stiffness()
    }

    /// Damping c [N s/m].
    #[getter]
    fn damping(&self) -> f64 {
        self.0.damping()
    }

    /// Preload F0 [N].
    #[getter]
    fn preload(&self) -> f64 {
        self.0.preload()
    }

    /// Where a contact ends: "gap", "force", "clipped", or None where that was not said.
    #[getter]
    fn release(&self) -> Option<&'static str> {
        name_of(self.0.release())
    }

    fn __repr__(&self) -> String {
        let release = self.release();
        let release = release.map_or_else(String::new, |own| format!(", release='{own}'"));
        let preload = match self.preload() {
            0.0 => String::new(),
            own => format!(", preload={own}"),
        };
        format!(
            "Spring(stiffness={}, damping={}{release}{preload})",
            self.stiffness(),
            self.damping(),
        )
    }

    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<((f64, f64), Bound<'py, PyDict>)> {
        let options = PyDict::new(py);
        options.set_item("release", self.release())?;
        options.set_item("preload", self.preload())?;
        Ok(((self.stiffness(), self.damping()), options))
    }
}

/// Law of elastic bodies that touch: a force k p^m pushes against the approach p = -gap while that is positive.
///
/// Parameters
/// ----------
/// stiffness : float
///     k [N/m^m], greater than zero.
/// exponent : float, default 1.5
///     m [-], at least 1; 3/2 of spheres.
/// damping : float, default 0
///     Of Hunt and Crossley d [s/m], of Tsuji c [N s/m^((m+1)/2)].
/// dissipation : {"hunt-crossley", "tsuji"}, optional
///     What the damping is of: "hunt-crossley", the default: the force is ``max(0, k p^m (1 + d p'))``. "tsuji":
///     ``k p^m + c p^((m-1)/2) p'``, by which a free body is given back the same part of any speed.
/// release : {"gap", "clipped"}, optional
///     Where a contact ends, by "tsuji", required there with damping: "gap": where the gap opens; the dashpot pulls before that.
///     "clipped": the force is none where it would pull. By "hunt-crossley" it never pulls, but where the body is drawn away faster than 1/d.
///
/// Raises
/// ------
/// ValueError
///     A stiffness that is not positive, an exponent below 1, a damping that is negative or not finite, an unknown dissipation, a release
///     that it does not take, damping by "tsuji" without one.
///
/// Notes
/// -----
/// A contact has no closed form: linear scenes with such a stop take steps, with an event at each beginning and end of a contact; what needs
/// exact flights says so.
///
/// References
/// ----------
/// .. [1] K. H. Hunt and F. R. E. Crossley, "Coefficient of restitution interpreted as damping in vibroimpact", J. Appl. Mech. 42 (1975) 440.
/// .. [2] Y. Tsuji, T. Tanaka and T. Ishida, "Lagrangian numerical simulation of plug flow of cohesionless particles in a horizontal pipe",
///    Powder Technol. 71 (1992) 239.
///
/// Examples
/// --------
/// >>> import vibroimpact as vi
/// >>> law = vi.Hertz(50.0, damping=0.4)
/// >>> law
/// Hertz(stiffness=50, exponent=1.5, damping=0.4)
/// >>> round(law.equivalent_restitution(2.0, speed=1.5), 3)
/// 0.712
#[pyclass(name = "Hertz", module = "vibroimpact", frozen, eq)]
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct PyHertz(Hertz);

/// The names of dissipations.
const HUNT_CROSSLEY: &str = "hunt-crossley";
const TSUJI: &str = "tsuji";

#[pymethods]
impl PyHertz {
    #[new]
    #[pyo3(signature = (*arguments, **named), text_signature = "(stiffness, exponent=1.5, *, damping=0.0, dissipation=\"hunt-crossley\", release=None)")]
    fn new(arguments: &Bound<'_, PyTuple>, named: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        answered(arguments, named)
    }

    #[staticmethod]
    #[pyo3(name = "_made", signature = (stiffness, exponent=1.5, *, damping=0.0, dissipation=HUNT_CROSSLEY, release=None))]
    fn made(
        #[pyo3(from_py_with = argument::stiffness)] stiffness: f64,
        #[pyo3(from_py_with = argument::exponent)] exponent: f64,
        #[pyo3(from_py_with = argument::damping)] damping: f64,
        #[pyo3(from_py_with = argument::dissipation)] dissipation: &str,
        #[pyo3(from_py_with = argument::release)] release: Option<&str>,
    ) -> PyResult<Self> {
        let elastic = Hertz::new(stiffness)?.with_exponent(exponent)?;
        let release = self::release(release)?;
        match (dissipation, release) {
            (TSUJI, release) => Ok(Self(elastic.with_tsuji(damping, release)?)),
            (HUNT_CROSSLEY, None) => Ok(Self(elastic.with_hunt_crossley(damping)?)),
            (HUNT_CROSSLEY, Some(_)) => Err(bad(
                "release is given, but by \"hunt-crossley\" a contact ends where the gap opens: the force does not pull".to_owned(),
            )),
            (given, _) => Err(bad(format!(
                "dissipation is {given:?}, but it must be \"hunt-crossley\" or \"tsuji\""
            ))),
        }
    }

    /// The restitution [-] of a free body of some mass [kg] that meets the stop at some speed [m/s] with nothing else acting; by Hunt and
    /// Crossley it depends on the speed.
    #[pyo3(signature = (mass, speed=None))]
    fn equivalent_restitution(
        &self,
        #[pyo3(from_py_with = argument::mass)] mass: f64,
        #[pyo3(from_py_with = argument::speed)] speed: Option<f64>,
    ) -> PyResult<f64> {
        Ok(self.0.equivalent_restitution(mass, speed)?)
    }

    /// Stiffness k [N/m^m].
    #[getter]
    fn stiffness(&self) -> f64 {
        self.0.stiffness()
    }

    /// Exponent m [-].
    #[getter]
    fn exponent(&self) -> f64 {
        self.0.exponent()
    }

    /// Damping: of Hunt and Crossley d [s/m], of Tsuji c [N s/m^((m+1)/2)].
    #[getter]
    fn damping(&self) -> f64 {
        self.0.damping()
    }

    /// What the damping is of: "hunt-crossley" or "tsuji".
    #[getter]
    fn dissipation(&self) -> &'static str {
        if self.0.is_by_tsuji() {
            TSUJI
        } else {
            HUNT_CROSSLEY
        }
    }

    /// Where a contact ends: "gap", "clipped", or None where that was not said.
    #[getter]
    fn release(&self) -> Option<&'static str> {
        name_of(self.0.release())
    }

    fn __repr__(&self) -> String {
        let dissipation = match self.dissipation() {
            HUNT_CROSSLEY => String::new(),
            own => format!(", dissipation='{own}'"),
        };
        let release = self.release();
        let release = release.map_or_else(String::new, |own| format!(", release='{own}'"));
        format!(
            "Hertz(stiffness={}, exponent={}, damping={}{dissipation}{release})",
            self.stiffness(),
            self.exponent(),
            self.damping(),
        )
    }

    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<((f64, f64), Bound<'py, PyDict>)> {
        let options = PyDict::new(py);
        options.set_item("damping", self.damping())?;
        options.set_item("dissipation", self.dissipation())?;
        options.set_item("release", self.release())?;
        Ok(((self.stiffness(), self.exponent()), options))
    }
}

/// The law of a stop that is given a restitution or a law.
pub(super) fn law(restitution: Option<f64>, contact: Option<&Bound<'_, PyAny>>) -> PyResult<Law> {
    let contact = contact.filter(|own| !own.is_none());
    let contact = match (restitution, contact) {
        (Some(restitution), None) => return Ok(restitution.into_law()?),
        (None, Some(contact)) => contact,
        (Some(_), Some(_)) => {
            let message = "restitution and contact are both given, but one of them says what happens at the stop: restitution=e is contact=vi.Newton(e)";
            return Err(PyTypeError::new_err(message));
        }
        (None, None) => {
            let message = "one of restitution and contact is needed: restitution=e is contact=vi.Newton(e), a stop that gives way contact=vi.Spring(...)";
            return Err(PyTypeError::new_err(message));
        }
    };
    if let Ok(own) = contact.cast::<PyNewton>() {
        return Ok(own.get().0.into_law()?);
    }
    if let Ok(own) = contact.cast::<PySpring>() {
        return Ok(own.get().0.into_law()?);
    }
    if let Ok(own) = contact.cast::<PyHertz>() {
        return Ok(own.get().0.into_law()?);
    }
    Err(PyTypeError::new_err(format!(
        "contact is {}, but a law of contact is needed: Newton, Spring or Hertz",
        contact.get_type().name()?
    )))
}

/// A law as Python has it.
pub(super) fn out_law(py: Python<'_>, law: &Law) -> PyResult<Py<PyAny>> {
    Ok(match law {
        Law::Newton(own) => Py::new(py, PyNewton(*own))?.into_any(),
        Law::Spring(own) => Py::new(py, PySpring(*own))?.into_any(),
        Law::Hertz(own) => Py::new(py, PyHertz(*own))?.into_any(),
        #[cfg(test)]
        Law::OfTest(_) => py.None(),
    })
}

/// The restitution of a rigid stop [-].
pub(super) fn restitution_of(law: &Law) -> Option<f64> {
    law.restitution().map(Restitution::value)
}

/// What of a stop's text says what happens at it.
pub(super) fn shown_law(py: Python<'_>, law: &Law) -> PyResult<String> {
    Ok(match restitution_of(law) {
        Some(restitution) => format!("restitution={restitution}"),
        None => format!("contact={}", out_law(py, law)?.bind(py).repr()?),
    })
}

/// The law among the arguments of a stop: a restitution by place, another by name.
pub(super) fn named_law(law: &Law, options: &Bound<'_, PyDict>) -> PyResult<Option<f64>> {
    let restitution = restitution_of(law);
    if restitution.is_none() {
        options.set_item("contact", out_law(options.py(), law)?)?;
    }
    Ok(restitution)
}
