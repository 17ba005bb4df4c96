//! Whether the phase loop has left the resonance it was given.
//!
//! A scan says where the resonance is to a small part of its bandwidth, so a lock that is found far from there is of another phase than the scan's: of a channel
//! that has become late since then. And a resonance drifts to the edge of the frequency window; a loop that leaps there follows something else.

use core::f32::consts::PI;

/// How far from the resonance that a scan has just found a lock may be, bandwidths.
const REACH: f32 = 0.3;
/// For so many blocks a lock that is sought may be further.
const ASTRAY_BLOCKS: u32 = 8;
/// Part by which where the loop has been of late follows it in a block, and for how many blocks it may stand at the edge without having drifted there.
const LATELY: f32 = 1.0 / 1024.0;
const LEAPT_BLOCKS: u32 = 16;

/// What watches the loop.
#[derive(Clone, Debug)]
pub(crate) struct Stray {
    /// Where the loop was seeded, and how far from there a lock may be, Hz.
    seeded_hz: f32,
    reach_hz: f32,
    /// Blocks in which it was further.
    astray_blocks: u32,
    /// A lock that went astray has been left to another scan.
    scanned_again: bool,
    /// Where it has been of late, Hz, and blocks at the edge of the window since it was elsewhere.
    lately_hz: f32,
    leapt_blocks: u32,
}

impl Default for Stray {
    fn default() -> Self {
        Stray { seeded_hz: 0.0, reach_hz: f32::INFINITY, astray_blocks: 0, scanned_again: false, lately_hz: 0.0, leapt_blocks: 0 }
    }
}

impl Stray {
    /// A loop begins on a resonance: its offset from the nominal frequency, Hz, and its time constant, s.
    pub(crate) fn seed(&mut self, offset_hz: f32, time_constant_s: f32) {
        let scanned_again = self.scanned_again;
        *self = Stray {
            seeded_hz: offset_hz,
            reach_hz: REACH / (PI * time_constant_s),
            lately_hz: offset_hz,
            scanned_again,
            ..Stray::default()
        };
    }

    /// Takes where the loop holds the resonance, Hz, in every block.
    pub(crate) fn seek(&mut self, estimate_hz: f32) {
        let astray = (estimate_hz - self.seeded_hz).abs() > self.reach_hz;
        self.astray_blocks = if astray { self.astray_blocks.saturating_add(1) } else { 0 };
    }

    /// Takes where the loop has gone in a block that it measured, Hz, and whether that is the edge of the window.
    pub(crate) fn go(&mut self, offset_hz: f32, limited: bool) {
        self.lately_hz += LATELY * (offset_hz - self.lately_hz);
        let leapt = limited && (offset_hz - self.lately_hz).abs() > self.reach_hz;
        self.leapt_blocks = if leapt { self.leapt_blocks.saturating_add(1) } else { 0 };
    }

    /// Whether a lock that is sought is elsewhere than where the scan has found it.
    pub(crate) fn is_astray(&self) -> bool {
        self.astray_blocks >= ASTRAY_BLOCKS
    }

    /// Whether the loop has leapt to the edge of the window.
    pub(crate) fn has_leapt(&self) -> bool {
        self.leapt_blocks > LEAPT_BLOCKS
    }

    /// Whether another scan is worth it: once.
    pub(crate) fn scan_again(&mut self) -> bool {
        !core::mem::replace(&mut self.scanned_again, true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seam::config::Tracking;
    use crate::seam::phasor::Phasor;
    use crate::track::tracker::phase_loop::PhaseLoop;

    const TAU_S: f32 = 65.0 / (PI * 40e3);

    #[test]
    fn a_lock_is_where_the_scan_was_to_a_third_of_the_bandwidth() {
        for (hz, astray) in [(0.0, false), (180.0, false), (-180.0, false), (190.0, true), (-190.0, true)] {
            let mut stray = Stray::default();
            stray.seed(300.0, TAU_S);
            for n in 1..2 * ASTRAY_BLOCKS {
                stray.seek(300.0 + hz);
                assert_eq!(stray.is_astray(), astray && n >= ASTRAY_BLOCKS, "{hz} Hz of a bandwidth of 615 Hz, block {n}");
            }
            stray.seek(300.0);
            assert!(!stray.is_astray());
        }
    }

    #[test]
    fn a_seed_forgets_all_but_the_second_scan() {
        let mut stray = Stray::default();
        stray.seed(0.0, TAU_S);
        (0..100).for_each(|_| {
            stray.seek(1000.0);
            stray.go(1000.0, true);
        });
        assert!(stray.is_astray() && stray.has_leapt() && stray.scan_again());
        stray.seed(1000.0, TAU_S);
        assert!(!stray.is_astray() && !stray.has_leapt() && !stray.scan_again());
        // It begins where it is seeded: a resonance at the edge has not leapt there.
        (0..100).for_each(|_| stray.go(1000.0, true));
        assert!(!stray.has_leapt());
    }

    /// A phase that is suddenly another one takes the loop to the edge within some blocks; a resonance that drifts takes thousands.
    #[test]
    fn what_leaps_to_the_edge_of_the_window_is_no_drift() {
        let tracking = Tracking { bandwidth_hz: 200.0, span: 0.025, ..Tracking::new(65.0) };
        let leaps = |turns: f32| {
            let (mut pll, mut stray) = (PhaseLoop::build(&tracking, 40e3, 32e-6).unwrap(), Stray::default());
            pll.seed(0.0, TAU_S);
            stray.seed(0.0, TAU_S);
            let angle = core::f32::consts::TAU * turns;
            let error = Phasor::new(libm::cosf(angle), libm::sinf(angle));
            let mut step = || {
                pll.update(error);
                stray.go(pll.offset_hz(), pll.limited());
                (pll.limited(), stray.has_leapt())
            };
            let arrives = (0..20_000).position(|_| step().0).unwrap();
            (arrives, (1..200).find(|_| step().1))
        };
        let (sudden, known) = leaps(0.16);
        assert!(sudden < 200 && known == Some(LEAPT_BLOCKS), "{sudden}: {known:?}");
        let (slow, known) = leaps(0.002);
        assert!(slow > 6000 && known.is_none(), "{slow}: {known:?}");
    }
}
