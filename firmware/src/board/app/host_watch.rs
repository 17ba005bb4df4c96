//! Whether the host is still there while the drive is on. Time is the number of blocks: the same run is the same run.

/// The host timeout: it ends a drive whose host has vanished.
#[derive(Clone, Debug)]
pub(super) struct HostWatch {
    block_s: f32,
    /// Blocks that the host may be silent for; zero is for ever.
    patience: u32,
    /// The block in which the last frame of the host was received.
    last_received: u32,
    lost: bool,
}

impl HostWatch {
    /// A host timeout of so many seconds, in blocks of this length, s.
    pub(super) fn new(patience_s: f32, block_s: f32) -> Self {
        let mut watch = HostWatch { block_s, patience: 0, last_received: 0, lost: false };
        watch.set(patience_s);
        watch
    }

    /// Sets the host timeout, s; zero is for ever.
    pub(super) fn set(&mut self, patience_s: f32) {
        self.patience = if patience_s > 0.0 { ((patience_s / self.block_s) as u32).max(1) } else { 0 };
    }

    /// Records that a frame of the host was received in this block.
    pub(super) fn update(&mut self, block: u32) {
        (self.last_received, self.lost) = (block, false);
    }

    /// Whether the host is lost, at this block: it has been silent for too long under drive, and no frame was received since.
    pub(super) fn is_lost(&mut self, block: u32, drives: bool) -> bool {
        // A block that is under way when the host orders a drive is older than the frame received last.
        let silent = block.wrapping_sub(self.last_received);
        self.lost |= drives && self.patience > 0 && silent > self.patience;
        self.lost
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_host_is_lost_after_its_timeout_and_under_drive_only() {
        let mut watch = HostWatch::new(1.0, 32e-6);
        watch.update(u32::MAX - 10);
        let after = |blocks: u32| (u32::MAX - 10).wrapping_add(blocks);
        assert!(!watch.is_lost(after(31_250), true));
        assert!(!watch.is_lost(after(50_000), false));
        assert!(watch.is_lost(after(31_251), true));
        // And stays so, whatever becomes of the drive.
        assert!(watch.is_lost(after(31_252), false));
        watch.update(after(31_253));
        assert!(!watch.is_lost(after(31_254), true));
    }

    #[test]
    fn without_a_timeout_it_never_ends_and_the_shortest_is_a_block() {
        let mut watch = HostWatch::new(0.0, 32e-6);
        assert!(!watch.is_lost(u32::MAX, true));
        watch.set(1e-9);
        assert!(!watch.is_lost(1, true) && watch.is_lost(2, true));
        watch.set(0.0);
        watch.update(2);
        assert!(!watch.is_lost(1 << 31, true));
    }
}
