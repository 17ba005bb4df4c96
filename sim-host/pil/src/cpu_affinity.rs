//! Pinning of two processes that take turns to one core.

use std::marker::PhantomData;

use rustix::thread::{CpuSet, sched_getaffinity, sched_getcpu, sched_setaffinity};

/// Keeps this thread, and the processes that it starts, on its present core until dropped. Must
/// stay on its thread.
///
/// If the system does not let a thread choose its core, it has no effect, at a cost in speed only.
pub struct CpuAffinity {
    before: Option<CpuSet>,
    thread: PhantomData<*const ()>,
}

impl CpuAffinity {
    /// Pins the calling thread to its present core.
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
            // The thread had these cores before; if they no longer exist, the system has chosen
            // others.
            let _ = sched_setaffinity(None, before);
        }
    }
}
