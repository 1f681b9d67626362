//! Long calls: the interpreter is released, and taken back every 50 ms to look for Ctrl-C and to show progress.

use crate::error::Result;
use crate::observer::with_observer;
use pyo3::prelude::*;
use std::cell::{Cell, RefCell};
use std::ops::ControlFlow;
use std::rc::Rc;
use std::time::{Duration, Instant};

/// Time between two polls.
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

/// Runs `work` with the interpreter released, and observed: an exception raised by a signal handler comes back as itself.
pub(crate) fn run<T: Send>(
    py: Python<'_>,
    progress: bool,
    work: impl FnOnce() -> Result<T> + Send,
) -> PyResult<T> {
    run_asking(py, progress, None, work)
}

/// [`run`] in which Python is asked too, by a function that raises to break off: on a thread that no signal reaches.
pub(crate) fn run_asking<T: Send>(
    py: Python<'_>,
    progress: bool,
    ask: Option<&Py<PyAny>>,
    work: impl FnOnce() -> Result<T> + Send,
) -> PyResult<T> {
    match run_keeping(py, progress, ask, work)? {
        (_, Some(raised)) => Err(raised),
        (result, None) => Ok(result?),
    }
}

/// [`run_asking`] that also returns the result reached before an exception broke the work off, beside that exception.
pub(crate) fn run_keeping<T: Send>(
    py: Python<'_>,
    progress: bool,
    ask: Option<&Py<PyAny>>,
    work: impl FnOnce() -> Result<T> + Send,
) -> PyResult<(Result<T>, Option<PyErr>)> {
    let bar = progress_bar(py, progress)?;
    let shown = bar.as_ref().map(|b| b.clone_ref(py));
    let ask = ask.map(|ask| ask.clone_ref(py));
    let (result, raised) = py.detach(move || {
        let polled = Rc::new(InterruptPoll {
            shown,
            ask,
            last: Cell::new(Instant::now()),
            raised: RefCell::new(None),
        });
        let asked = Rc::clone(&polled);
        let result = with_observer(move |fraction| asked.poll(fraction), work);
        (result, polled.raised.take())
    });
    if let Some(bar) = bar {
        if result.is_ok() {
            bar.setattr(py, "n", 1.0)?;
            bar.call_method0(py, "refresh")?;
        }
        bar.call_method0(py, "close")?;
    }
    Ok((result, raised))
}

/// What a long computation polls while it runs: signals of Python, a function of the caller, and the progress bar to be drawn.
struct InterruptPoll {
    shown: Option<Py<PyAny>>,
    ask: Option<Py<PyAny>>,
    last: Cell<Instant>,
    /// The exception for which it is broken off.
    raised: RefCell<Option<PyErr>>,
}

impl InterruptPoll {
    /// Polls if it is time, and says whether to go on.
    fn poll(&self, fraction: f64) -> ControlFlow<()> {
        if self.raised.borrow().is_some() {
            return ControlFlow::Break(());
        }
        if self.last.get().elapsed() < SLICE {
            return ControlFlow::Continue(());
        }
        self.last.set(Instant::now());
        let answer = Python::attach(|py| -> PyResult<()> {
            if let Some(bar) = &self.shown {
                bar.setattr(py, "n", fraction)?;
                bar.call_method0(py, "refresh")?;
            }
            if let Some(ask) = &self.ask {
                ask.call0(py)?;
            }
            py.check_signals()
        });
        match answer {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                self.raised.replace(Some(error));
                ControlFlow::Break(())
            }
        }
    }
}
