//! Detection of changes that a healthy drive cannot make, in voltage and current of a steady drive.
//!
//! ```text
//! h = V / u,   y = I / u
//! ```
//!
//! for blocks in which a sine of constant amplitude `u` was played. An amplifier of gain `g` and
//! source impedance `z` gives `V = g u - z I`.
//!
//! | check | reason | failure otherwise |
//! |---|---|---|
//! | `h` is constant, except for a source of up to 5 ohm under a changed current and a delay under a changed frequency | an amplifier and its channel do not change | voltage channel or drive has failed |
//! | `V` is at most 1.2 times the larger of one and the first `h`, relative to the largest recent drive, and `V` at most 1.15 times the voltage limit | nothing adds to the drive | the voltage exceeds the command |
//! | the motional current does not jump from one level to another, and the current does not turn by one sample, as far as nothing else explains it | it needs a time constant to change | current channel has failed |
//! | the tone explains nine tenths of the energy of both channels | a sine was played | a channel has an offset or has lost a bit, or the drive is not a sine |
//!
//! In self-test, scan and calibration the frequency moves and the stack rings at other
//! frequencies. There only the voltage is checked: against its limit, and by the part that the tone
//! explains. In silence only a voltage beyond the limit is a failure.
//!
//! A change of the load bends the motional current over a time constant; a failed sense chain moves
//! it within two blocks, after which it stays. A change of the clamped capacitance also moves it at
//! once, but by a susceptance, and by no more than the capacitance itself. A jump of the resonance
//! turns it until the tracker has followed. If the time constant with the source is shorter than
//! four blocks, a jump and a load change are indistinguishable, and jumps are ignored.

mod jumps;
mod voltage;

use crate::seam::phasor::Phasor;

/// Relative deviation of the voltage from its mean above which a block is treated as out of
/// sequence.
const OUT_OF_SEQUENCE_REL: f32 = 0.5;
/// Largest voltage relative to the voltage limit: 1.2 times the limit is dangerous.
const MAX_LIMIT_RATIO: f32 = 1.15;
/// Number of consecutive blocks of a measuring tone or of silence, with too high a voltage or one
/// that was not played, that raise a fault.
const MISPLAYED_BLOCKS: u32 = 8;
/// Number of checks whose mean is the first reference; every second block is checked.
const REFERENCE_CHECKS: u32 = 16;
/// Number of steady blocks after which vibration at other frequencies has decayed.
const CALM_BLOCKS: u32 = 64;
/// Time after which an earlier vibration has decayed, time constants.
const PAUSE_TIME_CONSTANTS: f32 = 7.0;
/// Longest time, blocks, for which the motional current turns against the drive after a jump of the
/// resonance; then the tracker has followed.
const FOLLOW_BLOCKS: f32 = 4.0;

/// Measured values of a block of a steady sine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Steady {
    /// Fundamental of the drive, V peak.
    pub(crate) volts: f32,
    /// Offset of the drive from the nominal frequency, Hz.
    pub(crate) offset_hz: f32,
    /// Voltage, V peak.
    pub(crate) v: Phasor,
    /// Current, A peak.
    pub(crate) i: Phasor,
    /// Motional current, A peak.
    pub(crate) motional: Phasor,
    /// `true` if a resonance is tracked; otherwise the stack may ring at another frequency for
    /// long.
    pub(crate) tracked: bool,
    /// `true` in a burst with a hard edge: after a ramp or a boost the ring-up is already over.
    pub(crate) hard: bool,
    /// `true` if the tone leaves more than a tenth of a channel's energy unexplained.
    pub(crate) unexplained: bool,
}

/// Properties of the transducer that decide if a jump is possible.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Load {
    /// Time constant, periods of the drive.
    pub(crate) periods: f32,
    /// Susceptance of the clamped capacitance, S.
    pub(crate) susceptance: f32,
    /// Noise variance of a block's current, A².
    pub(crate) noise: f32,
}

/// State of the continuity checks.
#[derive(Clone, Debug)]
pub(crate) struct Continuity {
    periods_per_block: f32,
    /// Turn of a phasor that is one sample late, rad.
    late_rad: f32,
    /// Largest turn of the motional current before the tracker has followed a jump of the
    /// resonance, rad/Hz.
    turned_per_hz: f32,
    /// Largest accepted voltage, V peak.
    most_v: f32,
    /// Mean of `h`.
    voltage: Phasor,
    /// Mean of `y`, S.
    current: Phasor,
    /// Mean of the frequency offset, Hz.
    offset_hz: f32,
    /// Square of the current in the last good check, A².
    current_square: f32,
    /// Largest drive, V, which decays with each check.
    recent_v: f32,
    /// Drive four and two blocks ago, V.
    past_v: [f32; 2],
    /// Last ordered offset, Hz, if nothing is tracked.
    ordered_hz: f32,
    /// Largest accepted square of `h`.
    most_h_square: f32,
    /// Number of checks in the means, up to `REFERENCE_CHECKS`.
    checks: u32,
    /// Consecutive checks with an impossible voltage.
    broken: u32,
    /// Consecutive blocks of a measuring tone or of silence with a voltage that was not played, or
    /// of a small drive with energy that it does not explain.
    misplayed: u32,
    /// Consecutive steady blocks.
    steady: u32,
    /// Motional current six, four and two blocks ago, A peak. In the first two blocks of a burst,
    /// `[0]` is `y` of the first block, S.
    past: [Phasor; 3],
    /// Blocks without drive before the present burst.
    pause: u32,
    /// `y` of the first two blocks of the last burst, S, if it came after a pause.
    starts: Option<[Phasor; 2]>,
    /// `true` if a check has failed in this attempt.
    failed: bool,
    /// `true` if the last block of a long steady drive was out of sequence or not a sine. Never
    /// `true` for two consecutive blocks.
    out_of_sequence: bool,
}

impl Continuity {
    /// Builds the checks for a nominal frequency, blocks and a voltage limit.
    pub(crate) fn build(frequency_hz: f32, block_s: f32, samples: u16, limit_v: f32) -> Self {
        let periods_per_block = frequency_hz * block_s;
        Continuity {
            periods_per_block,
            late_rad: core::f32::consts::TAU * periods_per_block / f32::from(samples),
            turned_per_hz: core::f32::consts::TAU * FOLLOW_BLOCKS * block_s,
            most_v: MAX_LIMIT_RATIO * limit_v,
            voltage: Phasor::default(),
            current: Phasor::default(),
            offset_hz: 0.0,
            current_square: 0.0,
            recent_v: 0.0,
            past_v: [0.0; 2],
            ordered_hz: 0.0,
            most_h_square: f32::INFINITY,
            checks: 0,
            broken: 0,
            misplayed: 0,
            steady: 0,
            past: [Phasor::default(); 3],
            pause: 0,
            starts: None,
            failed: false,
            out_of_sequence: false,
        }
    }

    /// Resets the checks for a new attempt.
    pub(crate) fn restart(&mut self) {
        (self.checks, self.most_h_square, self.starts, self.failed) = (0, f32::INFINITY, None, false);
        (self.misplayed, self.recent_v) = (0, 0.0);
        self.rest(true);
        self.pause = 0;
    }

    /// Takes a block that is not of a steady sine. `silent` is `true` if it had no drive.
    #[inline]
    pub(crate) fn rest(&mut self, silent: bool) {
        self.pause = if self.steady > 0 { 0 } else { self.pause.saturating_add(silent.into()) };
        (self.broken, self.steady, self.out_of_sequence) = (0, 0, false);
    }

    /// Takes a block whose drive is too small or otherwise unfit to be judged. The stack may ring
    /// after it, so that a pause before it no longer counts.
    #[inline]
    pub(crate) fn mark_ringing(&mut self) {
        self.rest(false);
        self.pause = 0;
    }

    /// Takes a steady block with a drive too small to be judged, and the time constant in periods
    /// of the drive. Returns `true` if a channel has had energy that the drive does not explain for
    /// longer than a vibration rings.
    #[inline]
    pub(crate) fn check_small_block(&mut self, unexplained: bool, periods: f32) -> bool {
        self.mark_ringing();
        self.misplayed = if unexplained { self.misplayed.saturating_add(1) } else { 0 };
        let rings = PAUSE_TIME_CONSTANTS * periods;
        self.misplayed >= CALM_BLOCKS && self.misplayed as f32 * self.periods_per_block > rings
    }

    /// Takes the ordered frequency offset if nothing is tracked. A new one resets the checks.
    #[inline]
    pub(crate) fn follow_order(&mut self, offset_hz: f32) {
        if !self.failed && self.ordered_hz != offset_hz {
            self.ordered_hz = offset_hz;
            self.restart();
        }
    }

    /// Returns `true` if a check of voltage or current has failed since the attempt began.
    #[inline]
    pub(crate) fn has_failed(&self) -> bool {
        self.failed
    }

    /// Returns `true` if the last block of a long steady drive was out of sequence or not a sine.
    /// It contains no information about the resonance.
    #[inline]
    pub(crate) fn is_out_of_sequence(&self) -> bool {
        self.out_of_sequence
    }

    /// Returns the largest accepted voltage, V peak.
    pub(crate) fn most_volts(&self) -> f32 {
        self.most_v
    }

    /// Takes a block of a measuring tone or of silence. Returns `true` if its voltage has been
    /// beyond the limit, or one that was not played, for too long.
    ///
    /// Blocks of a moving frequency cannot be compared, because the vibration does not follow it at
    /// once.
    #[inline]
    pub(crate) fn check_measuring_block(&mut self, v: Phasor, distorted: bool, silent: bool) -> bool {
        self.rest(silent);
        let misplayed = distorted || v.norm_sqr() > self.most_v * self.most_v;
        self.misplayed = if misplayed { self.misplayed.saturating_add(1) } else { 0 };
        self.misplayed >= MISPLAYED_BLOCKS
    }

    /// Takes a steady block. Returns `true` if a check has failed in this block or before.
    pub(crate) fn check_steady_block(&mut self, block: &Steady, load: impl FnOnce() -> Load) -> bool {
        self.steady = self.steady.wrapping_add(1);
        self.misplayed = 0;
        // Voltage and current take turns: a block has no time for both.
        if self.steady & 1 != 0 {
            self.failed |= self.check_voltage(block);
            return self.failed;
        }
        let off = block.v - self.voltage * block.volts;
        self.mark_out_of_sequence(block, block.unexplained || self.is_of_another_block(off, block.volts));
        self.failed |= match self.steady {
            _ if !block.tracked => false,
            2 => self.check_start(block, &load()),
            _ => self.check_jump(block, load),
        };
        self.failed
    }

    /// Takes a steady block whose voltage or current is implausible by itself.
    pub(crate) fn mark_implausible(&mut self, block: &Steady) {
        self.mark_out_of_sequence(block, true);
    }

    #[inline]
    fn mark_out_of_sequence(&mut self, block: &Steady, out_of_sequence: bool) {
        self.out_of_sequence = out_of_sequence && block.tracked && self.steady > CALM_BLOCKS && !self.out_of_sequence;
    }

    /// Returns `true` if the voltage at a drive is so far from its mean, by `off`, that the codes
    /// are those of another block.
    #[inline]
    fn is_of_another_block(&self, off: Phasor, volts: f32) -> bool {
        let mean = self.voltage * volts;
        off.norm_sqr() > OUT_OF_SEQUENCE_REL * OUT_OF_SEQUENCE_REL * mean.norm_sqr() && self.checks >= REFERENCE_CHECKS
    }
}

#[cfg(test)]
mod tests;
