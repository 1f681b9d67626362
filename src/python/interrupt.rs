//! Long calls: the interpreter is released, and taken back every 50 ms to look for Ctrl-C and to show progress.

use crate::error::{Error, Result};
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// Time between two looks.
const SLICE: Duration = Duration::from_millis(45);

/// A tqdm bar over the fraction done, or nothing.
pub(crate) fn progress_bar(py: Python<'_>, wanted: bool) -> PyResult<Option<Py<PyAny>>> {
    if !wanted {
        return Ok(None);
    }
    let tqdm = py.import("tqdm.auto").map_err(|_| {
        pyo3::exceptions::PyImportError::new_err(
            "progress=True needs tqdm: pip install \"vibroimpact[progress]\"",
        )
    })?;
    let options = pyo3::types::PyDict::new(py);
    options.set_item("total", 1.0)?;
    options.set_item("bar_format", "{l_bar}{bar}| {elapsed}<{remaining}")?;
    Ok(Some(
        tqdm.getattr("tqdm")?.call((), Some(&options))?.unbind(),
    ))
}

/// Runs `work` with the interpreter released. The observer it is given takes the fraction done and says whether to go on;
/// an exception raised by a signal handler comes back as itself.
pub(crate) fn run<T: Send>(
    py: Python<'_>,
    progress: bool,
    work: impl FnOnce(&mut dyn FnMut(f64) -> ControlFlow<()>) -> Result<T> + Send,
) -> PyResult<T> {
    let bar = progress_bar(py, progress)?;
    let shown = bar.as_ref().map(|b| b.clone_ref(py));
    let (result, raised) = py.detach(move || {
        let mut raised: Option<PyErr> = None;
        let mut last = Instant::now();
        let mut observe = |fraction: f64| {
            if last.elapsed() < SLICE {
                return ControlFlow::Continue(());
            }
            last = Instant::now();
            let looked = Python::attach(|py| -> PyResult<()> {
                if let Some(bar) = &shown {
                    bar.setattr(py, "n", fraction.clamp(0.0, 1.0))?;
                    bar.call_method0(py, "refresh")?;
                }
                py.check_signals()
            });
            match looked {
                Ok(()) => ControlFlow::Continue(()),
                Err(error) => {
                    raised = Some(error);
                    ControlFlow::Break(())
                }
            }
        };
        let result = work(&mut observe);
        (result, raised)
    });
    if let Some(bar) = bar {
        if result.is_ok() {
            bar.setattr(py, "n", 1.0)?;
            bar.call_method0(py, "refresh")?;
        }
        bar.call_method0(py, "close")?;
    }
    match (result, raised) {
        (Err(Error::Interrupted), Some(error)) => Err(error),
        (result, _) => Ok(result?),
    }
}
