//! Pass of the scan: range, speed and number of sweeps.
//!
//! ```text
//! f(block) = centre + width (x / 0.75 - 1/2)              x = (n + 1/2) / period < 0.75,    n = block modulo period
//!            centre + width ((1 - x) / 0.25 - 1/2)        otherwise
//! ```
//!
//! The frequency rises during three quarters of the period and falls during one, so that a
//! resonance at the upper end has time to decay within the pass. The offsets of a period from its
//! centre add up to zero, so that the period repeats relative to a reference at the centre.

use crate::find::scan::spectrum::{MOST_LINES, Spectrum};
use crate::seam::compare::within;

/// Minimum number of lines of a spectrum; there are five unknowns.
const FEWEST_LINES: f32 = 14.0;
/// Minimum number of blocks in a period.
const FEWEST_BLOCKS: u32 = 64;
/// Maximum width of a sweep relative to the block rate; the filter is too narrow for more.
const MAX_WIDTH_REL: f32 = 0.3;

/// Minimum and maximum duration of a sweep of the fine pass, s.
const FINE_S: (f32, f32) = (4e-3, 20e-3);
/// Duration of the fine pass above which no further period follows, s; and with a neighbour, whose
/// distance limits the accuracy more than the noise does.
const MAX_FINE_S: (f32, f32) = (0.04, 0.024);
/// Width of the fine pass in bandwidths of the resonance, and with a neighbour, which it must show.
const FINE_BANDWIDTHS: (f32, f32) = (2.0, 6.0);
/// Target standard deviation of the resonance, in bandwidths.
const TARGET_BANDWIDTHS: f32 = 1e-4;
/// Minimum target standard deviation of the resonance, relative to the frequency.
const TARGET_REL: f32 = 5e-7;

/// Resonance as measured in a pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MeasuredResonance {
    /// Series resonance frequency, Hz.
    pub(crate) hz: f32,
    /// Series resonance frequency, as an offset from the nominal frequency, Hz.
    pub offset_hz: f32,
    /// Quality factor of the resonance.
    pub q: f32,
    /// Standard deviation of the series resonance frequency, Hz.
    pub(crate) deviation_hz: f32,
    /// `true` if another resonance is near.
    pub(crate) has_neighbour: bool,
}

/// Range and timing of a sweep, and its number of periods.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pass {
    /// Centre, as an offset from the nominal frequency, Hz.
    pub(crate) centre_hz: f32,
    /// Width from end to end, Hz.
    pub(crate) width_hz: f32,
    /// Blocks in a period.
    pub(crate) period_blocks: u32,
    /// Number of periods.
    pub(crate) repeats: u32,
}

impl Pass {
    /// Creates a pass from `low_hz` to `high_hz`, offsets from the nominal frequency. Its duration
    /// is the shortest between `shortest_s` and `longest_s` that yields enough lines. A range too
    /// narrow for enough lines in the longest time is widened; a range above the maximum is cut.
    pub(crate) fn between(low_hz: f32, high_hz: f32, (shortest_s, longest_s): (f32, f32), block_s: f32) -> Self {
        let width_hz = (high_hz - low_hz).max(FEWEST_LINES / longest_s);
        let period_s = within(FEWEST_LINES / width_hz, shortest_s, longest_s);
        // A range too wide for the lines of that time is swept up to twice as fast.
        let whole_s = (MOST_LINES - 2) as f32 / width_hz.min(MAX_WIDTH_REL / block_s);
        let period_s = within(whole_s, 0.5 * shortest_s, period_s);
        let period_blocks = ((period_s / block_s) as u32 + 1).max(FEWEST_BLOCKS);
        let width_hz = width_hz.min(Pass::widest_hz(period_blocks, block_s));
        Pass { centre_hz: 0.5 * (low_hz + high_hz), width_hz, period_blocks, repeats: 1 }
    }

    /// Returns the fine pass around a resonance that this pass has measured, within `reach_hz` of
    /// the nominal frequency. Its length follows from the target deviation; it has no periods if
    /// this pass has reached the target.
    pub(crate) fn fine(&self, seen: &MeasuredResonance, reach_hz: f32, block_s: f32) -> Self {
        let bandwidth_hz = seen.hz / seen.q;
        let (bandwidths, longest_s) =
            if seen.has_neighbour { (FINE_BANDWIDTHS.1, MAX_FINE_S.1) } else { (FINE_BANDWIDTHS.0, MAX_FINE_S.0) };
        // A resonance near the edge of the window is measured from one side.
        let end_hz = |bandwidths: f32| within(seen.offset_hz + bandwidths * bandwidth_hz, -reach_hz, reach_hz);
        let fine = Pass::between(end_hz(-0.5 * bandwidths), end_hz(0.5 * bandwidths), FINE_S, block_s);
        // Slow, so that a load that depends on amplitude is measured in its settled state.
        let slow_s = ((MOST_LINES - 4) as f32 / fine.width_hz).min(40e-3);
        let fine = Pass { period_blocks: fine.period_blocks.max((slow_s / block_s) as u32), ..fine };
        let excess = seen.deviation_hz / (TARGET_BANDWIDTHS * bandwidth_hz).max(TARGET_REL * seen.hz);
        // Time that this pass has spent within the range of the fine pass. The deviation falls with
        // the square root of the measuring time.
        let there_s = self.blocks() as f32 * block_s * (fine.width_hz / self.width_hz).min(1.0);
        let target_s = (there_s * excess * excess).min(longest_s);
        let repeats = if excess > 1.0 { (target_s / (fine.period_blocks as f32 * block_s)) as u32 + 1 } else { 0 };
        Pass { repeats, ..fine }
    }

    /// Returns the maximum width of a sweep of `period_blocks`, limited by the number of lines, Hz.
    pub(crate) fn widest_hz(period_blocks: u32, block_s: f32) -> f32 {
        ((MOST_LINES - 2) as f32 / (period_blocks as f32 * block_s)).min(MAX_WIDTH_REL / block_s)
    }

    /// Returns the offset from the nominal frequency in a block, Hz.
    pub(crate) fn offset_hz(&self, block: u32) -> f32 {
        let up_blocks = self.period_blocks - self.period_blocks / 4;
        let n = block % self.period_blocks;
        let (done, of) = if n < up_blocks { (n, up_blocks) } else { (self.period_blocks - 1 - n, self.period_blocks / 4) };
        self.centre_hz + self.width_hz * ((done as f32 + 0.5) / of as f32 - 0.5)
    }

    /// Returns the total number of blocks.
    pub(crate) fn blocks(&self) -> u32 {
        self.period_blocks * self.repeats
    }

    /// Returns an empty spectrum for this pass.
    pub(crate) fn spectrum(&self, block_s: f32) -> Spectrum {
        Spectrum::new(self.centre_hz, self.width_hz, self.period_blocks, block_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn period_offsets_add_up_to_zero_within_the_range() {
        let pass = Pass::between(-1100.0, 1100.0, (8e-3, 16e-3), 32e-6);
        assert_eq!(pass.period_blocks, 251);
        let offsets = (0..251).map(|block| pass.offset_hz(block));
        assert!(offsets.clone().sum::<f32>().abs() < 0.1);
        assert!(offsets.clone().all(|hz| hz.abs() < 1100.0) && offsets.fold(0.0, f32::max) > 1090.0);
    }

    #[test]
    fn the_fine_pass_is_as_long_as_the_deviation_requires() {
        let window = Pass::between(-1100.0, 1100.0, (8e-3, 16e-3), 32e-6);
        let repeats = |deviation_hz: f32| {
            window
                .fine(&MeasuredResonance { hz: 40e3, offset_hz: 0.0, q: 65.0, deviation_hz, has_neighbour: false }, 1100.0, 32e-6)
                .repeats
        };
        // The target deviation is 0.0615 Hz. A period of the fine pass takes 30 ms.
        assert_eq!([0.05, 0.07, 0.1, 0.2].map(repeats), [0, 1, 1, 2]);
    }

    #[test]
    fn narrow_range_is_widened_and_wide_range_is_cut() {
        let narrow = Pass::between(-4.0, 4.0, (8e-3, 16e-3), 32e-6);
        assert!((narrow.width_hz - 875.0).abs() < 1.0, "{narrow:?}");
        let wide = Pass::between(-20e3, 20e3, (8e-3, 16e-3), 32e-6);
        assert!(wide.width_hz < 9.4e3 && wide.spectrum(32e-6).lines() <= MOST_LINES, "{wide:?}");
        assert_eq!(wide.period_blocks, 131, "{wide:?}");
    }
}
