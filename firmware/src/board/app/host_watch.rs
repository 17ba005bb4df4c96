//! Detection of a lost host while the drive is on. Time is counted in blocks, so that a run can be
//! repeated exactly.

/// Host timeout, which ends a drive whose host has vanished.
#[derive(Clone, Debug)]
pub(super) struct HostWatch {
    block_s: f32,
    /// Longest silence of the host, blocks; zero disables the timeout.
    patience: u32,
    /// Block in which the last frame of the host was received.
    last_received: u32,
    lost: bool,
}

impl HostWatch {
    /// Creates a host timeout, s, for blocks of this length, s.
    pub(super) fn new(patience_s: f32, block_s: f32) -> Self {
        let mut watch = HostWatch { block_s, patience: 0, last_received: 0, lost: false };
        watch.set(patience_s);
        watch
    }

    /// Sets the host timeout, s; zero disables it.
    pub(super) fn set(&mut self, patience_s: f32) {
        self.patience = if patience_s > 0.0 { ((patience_s / self.block_s) as u32).max(1) } else { 0 };
    }

    /// Records that a frame of the host was received in this block.
    pub(super) fn update(&mut self, block: u32) {
        (self.last_received, self.lost) = (block, false);
    }

    /// Returns `true` if the host is lost at this block: it was silent for too long under drive,
    /// and no frame has been received since.
    pub(super) fn detect_loss(&mut self, block: u32, drives: bool) -> bool {
        // A block already under way when the host orders a drive is older than that order.
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
        assert!(!watch.detect_loss(after(31_250), true));
        assert!(!watch.detect_loss(after(50_000), false));
        assert!(watch.detect_loss(after(31_251), true));
        // The host stays lost when the drive stops.
        assert!(watch.detect_loss(after(31_252), false));
        watch.update(after(31_253));
        assert!(!watch.detect_loss(after(31_254), true));
    }

    #[test]
    fn zero_disables_the_timeout_and_the_shortest_is_a_block() {
        let mut watch = HostWatch::new(0.0, 32e-6);
        assert!(!watch.detect_loss(u32::MAX, true));
        watch.set(1e-9);
        assert!(!watch.detect_loss(1, true) && watch.detect_loss(2, true));
        watch.set(0.0);
        watch.update(2);
        assert!(!watch.detect_loss(1 << 31, true));
    }
}
