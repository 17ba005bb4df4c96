//! Interruption of a solution. A method calls its watcher after every step but has no return
//! channel, so that a watcher interrupts it by unwinding, without a panic message.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};

struct Stopped;

/// Interrupts the work of [`unless_stopped`] if the flag is set.
#[inline]
pub(super) fn interrupt_if(stop: &AtomicBool) {
    if stop.load(Ordering::Relaxed) {
        resume_unwind(Box::new(Stopped));
    }
}

/// Returns the result of `work`; `None` if [`interrupt_if`] has interrupted it.
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
    fn work_is_interrupted_only_after_the_flag_is_set() {
        let stop = AtomicBool::new(false);
        let mut steps = 0;
        let done = unless_stopped(|| {
            for step in 0..10 {
                interrupt_if(&stop);
                steps += 1;
                stop.store(step == 4, Ordering::Relaxed);
            }
        });
        assert_eq!((done, steps), (None, 5));
        assert_eq!(unless_stopped(|| 3), Some(3));
    }
}
