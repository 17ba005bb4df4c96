//! Work that Python waits for: on a separate thread, without the interpreter's lock, and ended by a
//! signal.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::Duration;
use std::{process, thread};

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::errors::{RunError, run_error};

/// Interval of the checks for Python signals. A result is returned without waiting for the next
/// check.
const SIGNAL_CHECK_INTERVAL: Duration = Duration::from_millis(20);

/// Does some work in parallel with Python. A signal whose handler raises, such as Ctrl-C, sets
/// `stop`. The work must then end, and the exception of the handler is the error.
pub fn run<T: Send>(py: Python<'_>, stop: &AtomicBool, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    thread::scope(|threads| {
        let (sender, receiver) = channel();
        // The receiver exists as long as the thread: this scope waits for it.
        threads.spawn(move || sender.send(guarded(work)).is_ok());
        wait(py, Some(stop), &Mutex::new(receiver))?
    })
}

/// Does some work in parallel with Python that cannot be stopped. A signal whose handler raises
/// ends the call at once; the work then ends on its own, and its result is lost.
pub fn run_detached<T: Send + 'static>(py: Python<'_>, work: impl FnOnce() -> T + Send + 'static) -> PyResult<T> {
    let (sender, receiver) = channel();
    thread::spawn(move || sender.send(guarded(work)).is_ok());
    wait(py, None, &Mutex::new(receiver))?
}

/// Does some work, with a panic as an error. A forked child lacks the threads of the pool that its
/// parent has used, and gets a pool of its own.
pub fn guarded<T: Send>(work: impl FnOnce() -> T + Send) -> PyResult<T> {
    /// Process that owns the common pool.
    static OWNER: OnceLock<u32> = OnceLock::new();
    let pooled = || {
        if *OWNER.get_or_init(process::id) == process::id() {
            return Ok(work());
        }
        let pool = rayon::ThreadPoolBuilder::new().build().map_err(|error| run_error(&error))?;
        Ok(pool.install(work))
    };
    catch_unwind(AssertUnwindSafe(pooled)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let why = text.or(panic.downcast_ref::<&str>().copied()).unwrap_or("no reason is known");
        Err(RunError::new_err(format!(
            "internal error: {why}; report it with the scene or the file, and `sonoglide.__version__`"
        )))
    })
}

/// Waits for a result of another thread. On a signal it sets `stop`, waits for the end, and returns
/// the exception of the signal's handler; without `stop` it does not wait.
pub fn wait<T: Send>(py: Python<'_>, stop: Option<&AtomicBool>, results: &Mutex<Receiver<T>>) -> PyResult<T> {
    let next = || results.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(SIGNAL_CHECK_INTERVAL);
    let mut raised = None;
    loop {
        match (py.detach(next), &mut raised) {
            (Err(RecvTimeoutError::Timeout), Some(_)) => {}
            (Err(RecvTimeoutError::Timeout), none) => {
                if let Err(error) = py.check_signals() {
                    let Some(stop) = stop else { return Err(error) };
                    stop.store(true, Ordering::Relaxed);
                    *none = Some(error);
                }
            }
            (_, Some(_)) => break,
            (Ok(result), None) => return Ok(result),
            (Err(RecvTimeoutError::Disconnected), None) => break,
        }
    }
    Err(raised.unwrap_or_else(|| PyRuntimeError::new_err("the work ended without a result")))
}
