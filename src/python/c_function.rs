//! C functions as accelerations: `void f(double t, const double *q, const double *v, double *a, const double *parameters)`.
//! The one file with `unsafe`: the call itself, and the number behind a pointer that Python holds.

#![expect(
    unsafe_code,
    reason = "a C function given by address can be called in no other way"
)]

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyCapsuleMethods, PyTuple};
use std::ffi::{CString, c_void};

/// The signature, as `scipy.LowLevelCallable` writes it, without spaces and `const`.
const SIGNATURE: &str = "void(double,double*,double*,double*,double*)";

type Pointer = unsafe extern "C" fn(f64, *const f64, *const f64, *mut f64, *const f64);

/// A C function, with the Python object that keeps it alive.
pub(crate) struct CFunction {
    pointer: Pointer,
    parameters: Vec<f64>,
    _owner: Py<PyAny>,
}

fn wrong_signature(found: &str) -> PyErr {
    PyValueError::new_err(format!(
        "acceleration is a C function of signature {found}, but void (double t, const double *q, const double *v, \
         double *a, const double *parameters) is needed"
    ))
}

impl CFunction {
    /// The C function that a Python object stands for: a numba `@cfunc`, a ctypes function or a `scipy.LowLevelCallable`;
    /// `None` for any other object.
    ///
    /// # Errors
    /// A signature that is known and another one; user data, which belong in `parameters`.
    pub fn find(
        object: &Bound<'_, PyAny>,
        parameters: impl FnOnce() -> PyResult<Vec<f64>>,
    ) -> PyResult<Option<Self>> {
        let Some(address) = address(object)? else {
            return Ok(None);
        };
        if address == 0 {
            return Err(PyValueError::new_err(
                "acceleration is a null pointer, but a C function is needed",
            ));
        }
        // SAFETY: the address is not null and that of a function, which the ctypes or numba object or the capsule vouches
        // for; its signature is checked where the object knows it and is the caller's promise where not. Function and data
        // pointers have the same size and form wherever Python runs.
        let pointer =
            unsafe { std::mem::transmute::<*const c_void, Pointer>(address as *const c_void) };
        Ok(Some(Self {
            pointer,
            parameters: parameters()?,
            _owner: object.clone().unbind(),
        }))
    }

    /// Calls the function. The parameters are a null pointer where there are none.
    pub fn call(&self, t: f64, q: &[f64], v: &[f64], a: &mut [f64]) {
        let parameters = if self.parameters.is_empty() {
            std::ptr::null()
        } else {
            self.parameters.as_ptr()
        };
        // SAFETY: q, v and a are n numbers each and live through the call, as do the parameters; a overlaps none of the
        // others. That the function reads and writes no further is the promise of whoever gave it.
        unsafe { (self.pointer)(t, q.as_ptr(), v.as_ptr(), a.as_mut_ptr(), parameters) }
    }
}

fn address(object: &Bound<'_, PyAny>) -> PyResult<Option<usize>> {
    if let Some(address) = address_of_ctypes(object)? {
        return Ok(Some(address));
    }
    // scipy.LowLevelCallable is a tuple of a capsule and what it was made of; its module need not be imported for this.
    let class = object.get_type();
    if class.name()? == "LowLevelCallable" && class.module()?.to_string().starts_with("scipy") {
        return low_level(object).map(Some);
    }
    // A numba @cfunc: `ctypes` carries the signature that `address` does not. Other objects may have any attribute.
    match (object.getattr("address"), object.getattr("ctypes")) {
        (Ok(_), Ok(function)) => address_of_ctypes(&function),
        _ => Ok(None),
    }
}

/// The address of a ctypes function; `None` for any other object.
fn address_of_ctypes(object: &Bound<'_, PyAny>) -> PyResult<Option<usize>> {
    let ctypes = object.py().import("ctypes")?;
    if !object.is_instance(&ctypes.getattr("_CFuncPtr")?)? {
        return Ok(None);
    }
    check_ctypes(object, &ctypes)?;
    let cast = ctypes.call_method1("cast", (object, ctypes.getattr("c_void_p")?))?;
    let value: Option<usize> = cast.getattr("value")?.extract()?;
    Ok(Some(value.unwrap_or(0)))
}

/// The types that a ctypes function declares, if it declares any.
fn check_ctypes(function: &Bound<'_, PyAny>, ctypes: &Bound<'_, PyModule>) -> PyResult<()> {
    let declared = function.getattr("argtypes")?;
    if declared.is_none() {
        return Ok(());
    }
    let declared: Vec<Bound<'_, PyAny>> = declared.extract()?;
    let (double, void) = (ctypes.getattr("c_double")?, ctypes.getattr("c_void_p")?);
    let to_double = ctypes.call_method1("POINTER", (&double,))?;
    let is_pointer = |t: &Bound<'_, PyAny>| t.is(&to_double) || t.is(&void);
    let fits = declared.len() == 5
        && declared[0].is(&double)
        && declared[1..].iter().all(is_pointer)
        && function.getattr("restype")?.is_none();
    if fits {
        return Ok(());
    }
    let shown = PyTuple::new(function.py(), declared)?.repr()?.to_string();
    Err(wrong_signature(&shown))
}

/// The address in the capsule of a `scipy.LowLevelCallable`.
fn low_level(callable: &Bound<'_, PyAny>) -> PyResult<usize> {
    let user_data = callable.getattr("user_data")?;
    if !user_data.is_none() {
        return Err(PyValueError::new_err(
            "acceleration is a LowLevelCallable with user data; give them as parameters",
        ));
    }
    let signature: String = callable.getattr("signature")?.extract()?;
    let bare = signature
        .replace("const", "")
        .replace(char::is_whitespace, "");
    if bare != SIGNATURE {
        return Err(wrong_signature(&format!("{signature:?}")));
    }
    let capsule = callable
        .cast::<PyTuple>()
        .map_err(PyErr::from)?
        .get_item(0)?
        .cast_into::<PyCapsule>()
        .map_err(|_| PyTypeError::new_err("the LowLevelCallable holds no pointer"))?;
    let name = CString::new(signature)?;
    Ok(capsule.pointer_checked(Some(&name))?.as_ptr() as usize)
}
