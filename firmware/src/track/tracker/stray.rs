//! Detection of a phase loop that has left the resonance it was given.
//!
//! A scan finds the resonance to a small part of its bandwidth. A lock far from this resonance
//! shows that a channel has become late since the scan, which changes the phase that the loop locks
//! to. A resonance may drift to the edge of the frequency window, but cannot jump to it: a loop
//! that jumps to the edge follows something else.

use core::f32::consts::PI;

/// Largest distance of a lock from the resonance just found by a scan, bandwidths.
const REACH_BANDWIDTHS: f32 = 0.3;
/// Number of consecutive blocks beyond [`REACH_BANDWIDTHS`] after which the loop is astray.
const ASTRAY_BLOCKS: u32 = 8;
/// Smoothing factor of the recent frequency, per block.
const RECENT_SMOOTHING: f32 = 1.0 / 1024.0;
/// Largest number of blocks at the edge of the window without a drift to it.
const LEAPT_BLOCKS: u32 = 16;

/// State of the detection.
#[derive(Clone, Debug)]
pub(crate) struct Stray {
    /// Offset at which the loop was seeded, Hz.
    seeded_hz: f32,
    /// Largest distance of a lock from `seeded_hz`, Hz.
    reach_hz: f32,
    /// Consecutive blocks beyond `reach_hz`.
    astray_blocks: u32,
    /// `true` if another scan has replaced a lock that went astray.
    scanned_again: bool,
    /// Smoothed offset, Hz.
    recent_hz: f32,
    /// Consecutive blocks at the edge of the window, far from `recent_hz`.
    leapt_blocks: u32,
}

impl Default for Stray {
    fn default() -> Self {
        Stray { seeded_hz: 0.0, reach_hz: f32::INFINITY, astray_blocks: 0, scanned_again: false, recent_hz: 0.0, leapt_blocks: 0 }
    }
}

impl Stray {
    /// Starts on a resonance: its offset from the nominal frequency, Hz, and its time constant, s.
    pub(crate) fn seed(&mut self, offset_hz: f32, time_constant_s: f32) {
        let scanned_again = self.scanned_again;
        *self = Stray {
            seeded_hz: offset_hz,
            reach_hz: REACH_BANDWIDTHS / (PI * time_constant_s),
            recent_hz: offset_hz,
            scanned_again,
            ..Stray::default()
        };
    }

    /// Takes the loop's estimate of the resonance, Hz, in every block.
    pub(crate) fn take_estimate(&mut self, estimate_hz: f32) {
        let astray = (estimate_hz - self.seeded_hz).abs() > self.reach_hz;
        self.astray_blocks = if astray { self.astray_blocks.saturating_add(1) } else { 0 };
    }

    /// Takes the loop's output after a measured block, Hz. `limited` is `true` at the edge of the
    /// window.
    pub(crate) fn take_output(&mut self, offset_hz: f32, limited: bool) {
        self.recent_hz += RECENT_SMOOTHING * (offset_hz - self.recent_hz);
        let leapt = limited && (offset_hz - self.recent_hz).abs() > self.reach_hz;
        self.leapt_blocks = if leapt { self.leapt_blocks.saturating_add(1) } else { 0 };
    }

    /// Returns `true` if the loop seeks the lock away from the resonance found by the scan.
    pub(crate) fn is_astray(&self) -> bool {
        self.astray_blocks >= ASTRAY_BLOCKS
    }

    /// Returns `true` if the loop has leapt to the edge of the window.
    pub(crate) fn has_leapt(&self) -> bool {
        self.leapt_blocks > LEAPT_BLOCKS
    }

    /// Returns `true` on the first call: one more scan is allowed.
    pub(crate) fn take_second_scan(&mut self) -> bool {
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
    fn a_lock_is_within_0_3_bandwidths_of_the_scan() {
        for (hz, astray) in [(0.0, false), (180.0, false), (-180.0, false), (190.0, true), (-190.0, true)] {
            let mut stray = Stray::default();
            stray.seed(300.0, TAU_S);
            for n in 1..2 * ASTRAY_BLOCKS {
                stray.take_estimate(300.0 + hz);
                assert_eq!(stray.is_astray(), astray && n >= ASTRAY_BLOCKS, "{hz} Hz at a bandwidth of 615 Hz, block {n}");
            }
            stray.take_estimate(300.0);
            assert!(!stray.is_astray());
        }
    }

    #[test]
    fn a_seed_resets_all_but_the_second_scan() {
        let mut stray = Stray::default();
        stray.seed(0.0, TAU_S);
        (0..100).for_each(|_| {
            stray.take_estimate(1000.0);
            stray.take_output(1000.0, true);
        });
        assert!(stray.is_astray() && stray.has_leapt() && stray.take_second_scan());
        stray.seed(1000.0, TAU_S);
        assert!(!stray.is_astray() && !stray.has_leapt() && !stray.take_second_scan());
        // A resonance that starts at the edge has not jumped to it.
        (0..100).for_each(|_| stray.take_output(1000.0, true));
        assert!(!stray.has_leapt());
    }

    /// After a sudden change of phase the loop reaches the edge within some blocks; a drift takes
    /// thousands.
    #[test]
    fn a_leap_to_the_edge_is_distinguished_from_a_drift() {
        let tracking = Tracking { bandwidth_hz: 200.0, span: 0.025, ..Tracking::new(65.0) };
        let leaps = |turns: f32| {
            let (mut pll, mut stray) = (PhaseLoop::build(&tracking, 40e3, 32e-6).unwrap(), Stray::default());
            pll.seed(0.0, TAU_S);
            stray.seed(0.0, TAU_S);
            let angle = core::f32::consts::TAU * turns;
            let error = Phasor::new(libm::cosf(angle), libm::sinf(angle));
            let mut step = || {
                pll.update(error);
                stray.take_output(pll.offset_hz(), pll.limited());
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
