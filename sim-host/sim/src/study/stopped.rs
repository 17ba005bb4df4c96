//! Stopping a solution on its way. A method calls its watcher after every step and asks it nothing, so a watcher that wants no more
//! leaves by unwinding, without the message of a panic.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};

struct Stopped;

/// Leaves what [`unless_stopped`] called, if it is to stop.
#[inline]
pub(super) fn leave_if(stop: &AtomicBool) {
    if stop.load(Ordering::Relaxed) {
        resume_unwind(Box::new(Stopped));
    }
}

/// What `work` returns; nothing if it was left.
pub(super) fn unless_stopped<T>(work: impl FnOnce() -> T) -> Option<T> {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(done) => Some(done),
        Err(cause) if cause.is::<Stopped>() => None,
        Err(cause) => resume_unwind(cause),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_is_left_when_it_is_to_stop_and_not_before() {
        let stop = AtomicBool::new(false);
        let mut steps = 0;
        let done = unless_stopped(|| {
            for step in 0..10 {
                leave_if(&stop);
                steps += 1;
                stop.store(step == 4, Ordering::Relaxed);
            }
        });
        assert_eq!((done, steps), (None, 5));
        assert_eq!(unless_stopped(|| 3), Some(3));
    }
}
