//! Work that Python waits for: on a separate thread, without the interpreter's lock, and ended by a
//! signal.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// Interval of the checks for Python signals. A result is returned without waiting for the next
/// check.
const SIGNAL_CHECK_INTERVAL: Duration = Duration::from_millis(20);

/// Does some work in parallel with Python. A signal whose handler raises, such as Ctrl-C, sets
/// `stop`. The work must then end, and the exception of the handler is the error.
pub fn run<T: Send>(py: Python<'_>, stop: &AtomicBool, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    thread::scope(|threads| {
        let (sender, receiver) = channel();
        // The receiver exists as long as the thread: this scope waits for it.
        let thread = threads.spawn(move || sender.send(work()).is_ok());
        let received = wait(py, stop, &Mutex::new(receiver));
        match py.detach(|| thread.join()) {
            Ok(_) => received,
            Err(panic) => std::panic::resume_unwind(panic),
        }
    })
}

/// Waits for a result of another thread. On a signal it sets `stop`, waits for the end, and returns
/// the exception of the signal's handler.
pub fn wait<T: Send>(py: Python<'_>, stop: &AtomicBool, results: &Mutex<Receiver<T>>) -> PyResult<T> {
    let next = || results.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(SIGNAL_CHECK_INTERVAL);
    let mut raised = None;
    loop {
        match (py.detach(next), &mut raised) {
            (Err(RecvTimeoutError::Timeout), Some(_)) => {}
            (Err(RecvTimeoutError::Timeout), none) => {
                if let Err(error) = py.check_signals() {
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
