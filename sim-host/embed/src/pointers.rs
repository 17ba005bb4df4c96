//! Access to the memory of the caller.

use std::ffi::{CStr, c_char};
use std::slice;

/// Mistake of the caller.
#[derive(Debug)]
pub(crate) struct Misuse(pub(crate) &'static str);

impl std::fmt::Display for Misuse {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.0)
    }
}

/// Returns a text.
///
/// # Safety
/// `text` is null or ends with a zero byte, and nobody changes it meanwhile.
pub(crate) unsafe fn text<'a>(text: *const c_char) -> Result<&'a str, Misuse> {
    if text.is_null() {
        return Err(Misuse("a text is null"));
    }
    // SAFETY: not null, and the caller guarantees the rest.
    unsafe { CStr::from_ptr(text) }.to_str().map_err(|_| Misuse("a text is not UTF-8"))
}

/// Returns values to read.
///
/// # Safety
/// `values` is null or has `count` values, and nobody changes them meanwhile.
pub(crate) unsafe fn read<'a, T>(values: *const T, count: usize) -> Result<&'a [T], Misuse> {
    match (values.is_null(), count) {
        (_, 0) => Ok(&[]),
        (true, _) => Err(Misuse("an array is null")),
        // SAFETY: not null, and the caller guarantees the rest.
        (false, _) => Ok(unsafe { slice::from_raw_parts(values, count) }),
    }
}

/// Returns values to write.
///
/// # Safety
/// `values` is null or has room for `count` values, which nobody else uses meanwhile.
pub(crate) unsafe fn write<'a, T>(values: *mut T, count: usize) -> Result<&'a mut [T], Misuse> {
    match (values.is_null(), count) {
        (_, 0) => Ok(&mut []),
        (true, _) => Err(Misuse("an array is null")),
        // SAFETY: not null, and the caller guarantees the rest.
        (false, _) => Ok(unsafe { slice::from_raw_parts_mut(values, count) }),
    }
}

/// Returns an object.
///
/// # Safety
/// `object` is null, or it was returned by its constructor and is not freed, and nobody else uses
/// it meanwhile.
pub(crate) unsafe fn object<'a, T>(object: *mut T) -> Result<&'a mut T, Misuse> {
    // SAFETY: guaranteed by the caller.
    unsafe { object.as_mut() }.ok_or(Misuse("the object is null"))
}

/// Frees an object.
///
/// # Safety
/// As of [`object`]; it is not used any more.
pub(crate) unsafe fn free<T>(object: *mut T) {
    if !object.is_null() {
        // SAFETY: `Box::into_raw` made it, and the caller gives it up.
        drop(unsafe { Box::from_raw(object) });
    }
}
