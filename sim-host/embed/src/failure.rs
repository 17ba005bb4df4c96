//! Failures of the C interface: a text for each thread.

use std::cell::RefCell;
use std::ffi::{CString, c_char};
use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;

thread_local! {
    static LAST: RefCell<CString> = RefCell::default();
}

/// Keeps the text of a failure.
pub(crate) fn keep(error: &dyn Display) {
    let text = CString::new(error.to_string().replace('\0', " ")).unwrap_or_default();
    LAST.with(|last| *last.borrow_mut() = text);
}

/// Returns what some work returns; on a failure or a panic it keeps the text, and returns `None`.
pub(crate) fn kept<T, E: Display>(work: impl FnOnce() -> Result<T, E>) -> Option<T> {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(value)) => Some(value),
        Ok(Err(error)) => {
            keep(&error);
            None
        }
        Err(_) => {
            keep(&"internal error");
            None
        }
    }
}

/// Text of the last failure in this thread. It is valid until the next call.
#[unsafe(no_mangle)]
pub extern "C" fn sonoglide_failure() -> *const c_char {
    LAST.with(|last| last.try_borrow().map_or(ptr::null(), |last| last.as_ptr()))
}
