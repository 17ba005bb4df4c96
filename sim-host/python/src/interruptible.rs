//! Work that Python waits for: on a thread of its own, without the interpreter's lock, and ended by a signal.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// How often Python is asked for signals. A result that is there is not waited for.
const LOOK: Duration = Duration::from_millis(20);

/// Does some work beside Python. A signal whose handler raises, as that of Ctrl-C does, sets `stop`; the work then has to come to its end, and what
/// the handler has raised is the error.
pub fn run<T: Send>(py: Python<'_>, stop: &AtomicBool, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    thread::scope(|threads| {
        let (sender, receiver) = channel();
        // Nobody has left who would not hear of it: this scope waits for the thread.
        let thread = threads.spawn(move || sender.send(work()).is_ok());
        let received = wait(py, stop, &Mutex::new(receiver));
        match py.detach(|| thread.join()) {
            Ok(_) => received,
            Err(panic) => std::panic::resume_unwind(panic),
        }
    })
}

/// Waits for a result of another thread. With a signal it sets `stop`, waits for the end, and gives what the signal's handler has raised.
pub fn wait<T: Send>(py: Python<'_>, stop: &AtomicBool, results: &Mutex<Receiver<T>>) -> PyResult<T> {
    let next = || results.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(LOOK);
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
