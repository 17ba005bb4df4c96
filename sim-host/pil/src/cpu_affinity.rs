//! One core for two processes that take turns.

use std::marker::PhantomData;

use rustix::thread::{CpuSet, sched_getaffinity, sched_getcpu, sched_setaffinity};

/// Keeps this thread, and what it starts, on the core where it runs now, until dropped. Stays on its thread.
///
/// Where the system does not let a thread choose its core, it does nothing: that costs speed only.
pub struct CpuAffinity {
    before: Option<CpuSet>,
    thread: PhantomData<*const ()>,
}

impl CpuAffinity {
    /// Pins the calling thread to the core where it runs.
    pub fn pin() -> Self {
        let before = sched_getaffinity(None).ok();
        let mut here = CpuSet::new();
        here.set(sched_getcpu());
        let pinned = before.is_some() && sched_setaffinity(None, &here).is_ok();
        CpuAffinity { before: before.filter(|_| pinned), thread: PhantomData }
    }
}

impl Drop for CpuAffinity {
    fn drop(&mut self) {
        if let Some(before) = &self.before {
            // The thread had these cores before; if they are gone, the system has chosen others.
            let _ = sched_setaffinity(None, before);
        }
    }
}
