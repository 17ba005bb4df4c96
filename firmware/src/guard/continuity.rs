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
//! | the motional current does not jump from one level to another | it needs a time constant to change | current channel has failed |
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

use core::mem;

use crate::seam::compare::{is_step, larger};
use crate::seam::phasor::Phasor;

/// Largest deviation of the voltage from its mean, relative.
const VOLTAGE_TOLERANCE_REL: f32 = 0.15;
/// Largest source resistance by which a change of the current may explain a voltage, ohm.
const MAX_SOURCE_OHM: f32 = 5.0;
/// Smallest voltage that a source may leave, relative to the mean, under a current that has risen.
const MIN_VOLTAGE_REL: f32 = 0.1;
/// Smallest ratio of squared currents that indicates a short.
const MIN_RISE: f32 = 1.2;
/// Voltage, relative to the mean, below which a distorted block is attributed to ringing.
const TAKEN_REL: f32 = 0.5;
/// Smallest voltage to which tolerances relate, relative to the drive.
const LEAST_VOLTAGE_REL: f32 = 0.15;
/// Longest delay between drive and voltage by which a change of the frequency may explain a
/// voltage, s.
const MAX_DELAY_S: f32 = 1e-4;
/// Relative deviation of the voltage from its mean above which a block is treated as out of
/// sequence.
const OUT_OF_SEQUENCE_REL: f32 = 0.5;
/// Largest voltage, relative to the command or to the first reference if that is larger.
const MAX_VOLTAGE_RATIO: f32 = 1.2;
/// Largest voltage relative to the voltage limit: 1.2 times the limit is dangerous.
const MAX_LIMIT_RATIO: f32 = 1.15;
/// Decay factor of the largest recent drive per check.
const RECENT_REL: f32 = 0.99;
/// Number of consecutive checks with an impossible voltage that raise a fault; every second block
/// is checked.
const BROKEN_CHECKS: u32 = 4;
/// Number of consecutive blocks of a measuring tone or of silence, with too high a voltage or one
/// that was not played, that raise a fault.
const MISPLAYED_BLOCKS: u32 = 8;
/// Number of checks whose mean is the first reference; every second block is checked.
const REFERENCE_CHECKS: u32 = 16;
/// Smoothing factor of the reference per check, after the first reference.
const REFERENCE_SMOOTHING: f32 = 1.0 / 16.0;
/// Number of steady blocks before jumps are judged: the four readings compared are complete in the
/// tenth.
const JUMP_ARM_BLOCKS: u32 = 10;
/// Number of steady blocks after which vibration at other frequencies has decayed.
const CALM_BLOCKS: u32 = 64;
/// Smallest jump of the motional current that is judged, relative to the current.
const JUMP_REL: f32 = 0.15;
/// Largest change of the motional current just before and just after a jump, relative to the jump.
const LEVEL_REL: f32 = 0.3;
/// Largest ratio of conductance to susceptance of a jump that the clamped capacitance can make.
const MAX_CONDUCTANCE_RATIO: f32 = 0.2;
/// Largest loss of clamped capacitance that is not a failure, relative.
const MAX_CAPACITANCE_LOSS_REL: f32 = 0.8;
/// Time after which an earlier vibration has decayed, time constants.
const PAUSE_TIME_CONSTANTS: f32 = 7.0;
/// Largest motional current in the second block of a burst without a comparable earlier one, in
/// units of the current's rise since the first block.
const START_RISE_BLOCKS: f32 = 2.5;
/// Longest time, blocks, for which the motional current turns against the drive after a jump of the
/// resonance; then the tracker has followed.
const FOLLOW_BLOCKS: f32 = 4.0;
/// Smallest jump that is judged, standard deviations of a block's noise.
const JUMP_SIGMAS: f32 = 8.0;
/// Shortest time constant at which a load can be distinguished from a jump, blocks.
const MIN_TIME_CONSTANT_BLOCKS: f32 = 4.0;

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

/// Judgement of a voltage.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Verdict {
    Good,
    /// Too small because of the current of a ringing stack: it teaches nothing.
    Taken,
    Broken,
}

/// State of the continuity checks.
#[derive(Clone, Debug)]
pub(crate) struct Continuity {
    periods_per_block: f32,
    /// Largest turn of the motional current before the tracker has followed a jump of the
    /// resonance, rad/Hz.
    turned_per_hz: f32,
    /// Largest accepted voltage, V peak.
    most_v: f32,
    /// Square of `most_v`, V².
    limit: f32,
    /// Mean of `h`.
    voltage: Phasor,
    /// Mean of `y`, S.
    current: Phasor,
    /// Mean of the frequency offset, Hz.
    offset_hz: f32,
    /// Square of the current in the last good check, A².
    current_square: f32,
    /// Largest drive, V, which decays by [`RECENT_REL`] per check.
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
    /// Builds the checks for a nominal frequency and a voltage limit.
    pub(crate) fn build(frequency_hz: f32, block_s: f32, limit_v: f32) -> Self {
        Continuity {
            periods_per_block: frequency_hz * block_s,
            turned_per_hz: core::f32::consts::TAU * FOLLOW_BLOCKS * block_s,
            most_v: MAX_LIMIT_RATIO * limit_v,
            limit: MAX_LIMIT_RATIO * MAX_LIMIT_RATIO * limit_v * limit_v,
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
        let misplayed = distorted || v.norm_sqr() > self.limit;
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

    /// Returns `true` if the voltage has been impossible for too long.
    #[inline]
    fn check_voltage(&mut self, block: &Steady) -> bool {
        let part = 1.0 / block.volts;
        let (h, y) = (block.v * part, block.i * part);
        if self.steady == 1 {
            self.past[0] = y;
        }
        // A ringing stack also returns the voltage of an earlier, larger drive.
        self.recent_v = larger(block.volts, RECENT_REL * self.recent_v);
        let off = h - self.voltage;
        let suspicious = off.norm_sqr() > VOLTAGE_TOLERANCE_REL * VOLTAGE_TOLERANCE_REL * self.voltage.norm_sqr()
            || h.norm_sqr() > self.most_h_square
            || block.unexplained
            || block.v.norm_sqr() > self.limit;
        self.mark_out_of_sequence(block, block.unexplained || suspicious && self.is_of_another_block(off, 1.0));
        let verdict = if suspicious { self.judge_voltage(h, off, block) } else { Verdict::Good };
        if verdict == Verdict::Good {
            self.current_square = block.i.norm_sqr();
            self.learn(h, y, block.offset_hz);
        }
        self.broken = if verdict == Verdict::Broken { self.broken + 1 } else { 0 };
        self.broken >= BROKEN_CHECKS
    }

    /// Judges a voltage that is not near its mean, or not that of a sine. `h` deviates from its
    /// mean by `off`.
    #[cold]
    #[inline(never)]
    fn judge_voltage(&self, h: Phasor, off: Phasor, block: &Steady) -> Verdict {
        let tolerated = VOLTAGE_TOLERANCE_REL * VOLTAGE_TOLERANCE_REL * self.tolerance_square();
        let elsewhere = self.checks >= REFERENCE_CHECKS && off.norm_sqr() > tolerated && !self.explains(off, block);
        // Near zero, the amplitude of the voltage changes within a block.
        let taken = self.is_taken_by_ringing(h, block, TAKEN_REL);
        let most_square = self.most_h_square * self.recent_v * self.recent_v;
        let square = block.v.norm_sqr();
        if elsewhere || block.tracked && block.unexplained && !taken || square > most_square || square > self.limit {
            Verdict::Broken
        } else if taken {
            Verdict::Taken
        } else {
            Verdict::Good
        }
    }

    /// Updates the means with a good block.
    #[inline]
    fn learn(&mut self, h: Phasor, y: Phasor, offset_hz: f32) {
        let new = if self.checks < REFERENCE_CHECKS {
            self.checks += 1;
            1.0 / self.checks as f32
        } else {
            REFERENCE_SMOOTHING
        };
        self.voltage += (h - self.voltage) * new;
        self.current += (y - self.current) * new;
        self.offset_hz += (offset_hz - self.offset_hz) * new;
        if self.checks == REFERENCE_CHECKS && self.most_h_square == f32::INFINITY {
            let first = self.voltage.norm_sqr();
            self.most_h_square = MAX_VOLTAGE_RATIO * MAX_VOLTAGE_RATIO * if first > 1.0 { first } else { 1.0 };
        }
    }

    /// Returns the square of the voltage to which tolerances relate, relative to the drive: that of
    /// a stack which takes most of it from the source can pass zero.
    fn tolerance_square(&self) -> f32 {
        larger(self.voltage.norm_sqr(), LEAST_VOLTAGE_REL * LEAST_VOLTAGE_REL)
    }

    /// Returns `true` if `h` is below this part of its mean, soon after the amplitude has been
    /// lowered, under a current that has not risen: the current of the ringing stack causes the
    /// voltage drop in the source.
    fn is_taken_by_ringing(&self, h: Phasor, block: &Steady, part: f32) -> bool {
        is_step(self.recent_v, block.volts)
            && h.norm_sqr() < part * part * self.voltage.norm_sqr()
            && block.i.norm_sqr() < MIN_RISE * self.current_square
    }

    /// Returns `true` if a changed current or frequency explains the deviation `off` of `h`.
    #[cold]
    #[inline(never)]
    fn explains(&self, off: Phasor, block: &Steady) -> bool {
        let more = block.i * (1.0 / block.volts) - self.current;
        let along = -(off * more.conj()).re;
        let most = MAX_SOURCE_OHM * more.norm_sqr();
        let left = if along >= most {
            off + more * MAX_SOURCE_OHM
        } else if along > 0.0 {
            off + more * (along / more.norm_sqr())
        } else {
            off
        };
        let h = self.voltage + off;
        let collapsed = h.norm_sqr() < MIN_VOLTAGE_REL * MIN_VOLTAGE_REL * self.voltage.norm_sqr()
            && !self.is_taken_by_ringing(h, block, 1.0);
        let turned = core::f32::consts::TAU * MAX_DELAY_S * (block.offset_hz - self.offset_hz).abs();
        let tolerated = VOLTAGE_TOLERANCE_REL + turned;
        !collapsed && left.norm_sqr() <= tolerated * tolerated * self.tolerance_square()
    }

    /// Returns `true` if the motional current jumped between four and two blocks ago, from one
    /// level to another, and nothing explains it.
    #[inline]
    fn check_jump(&mut self, block: &Steady, load: impl FnOnce() -> Load) -> bool {
        if block.unexplained {
            // The block may span a failure; its intermediate level would hide the jump.
            return false;
        }
        let [first, before, after] = self.past;
        let [before_v, after_v] = self.past_v;
        (self.past, self.past_v) = ([before, after, block.motional], [after_v, block.volts]);
        let (jump, came, goes_on) = (after - before, before - first, block.motional - after);
        let (size, least) = (jump.norm_sqr(), larger(block.i.norm_sqr(), before.norm_sqr()));
        let stays = LEVEL_REL * LEVEL_REL * size;
        self.steady >= JUMP_ARM_BLOCKS
            && size > JUMP_REL * JUMP_REL * least
            && goes_on.norm_sqr() < stays
            && came.norm_sqr() < stays
            // The error of the motional current changes with the drive.
            && !is_step(before_v, after_v)
            && self.is_impossible(jump * (1.0 / block.volts), block, &load())
    }

    /// Returns `true` if a burst starts with another current than the one before, by more than a
    /// block's ring-up.
    #[cold]
    #[inline(never)]
    fn check_start(&mut self, block: &Steady, load: &Load) -> bool {
        let y = block.i * (1.0 / block.volts);
        let starts = [self.past[0], y];
        let paused = self.pause as f32 * self.periods_per_block > PAUSE_TIME_CONSTANTS * load.periods;
        let comparable = paused && block.hard;
        let before = mem::replace(&mut self.starts, comparable.then_some(starts));
        let Some(before) = before.filter(|_| comparable) else {
            // Without a comparable earlier burst, the reference is the current of the clamped
            // branch.
            let (extra, rise) = (block.motional * (1.0 / block.volts), START_RISE_BLOCKS * (starts[1] - starts[0]));
            return comparable && exceeds(extra, y, rise) && self.is_impossible(extra, block, load);
        };
        let rise = before[1] - before[0];
        starts
            .iter()
            .zip(before)
            .all(|(&now, then)| exceeds(now - then, then, rise) && self.is_impossible(now - then, block, load))
    }

    /// Returns `true` if no cause explains the jump of `I / u`, S: neither a load, the clamped
    /// capacitance, noise, nor a jump of the resonance that the tracker follows.
    #[cold]
    #[inline(never)]
    fn is_impossible(&self, jump: Phasor, block: &Steady, load: &Load) -> bool {
        let admittance = jump * block.v.conj() * (block.volts / block.v.norm_sqr());
        let upright = admittance.re.abs() < MAX_CONDUCTANCE_RATIO * admittance.im.abs()
            && admittance.im > -MAX_CAPACITANCE_LOSS_REL * load.susceptance;
        // A source resistance shortens the time constant, at the resonance by the part of the
        // voltage that it takes.
        let (shortest, left) = (MIN_TIME_CONSTANT_BLOCKS * self.periods_per_block, self.voltage.norm_sqr());
        let left = if left < 1.0 { left } else { 1.0 };
        let slow = load.periods * load.periods * left > shortest * shortest;
        let turned = self.turned_per_hz * (block.offset_hz - self.offset_hz);
        let least = larger(JUMP_SIGMAS * JUMP_SIGMAS * 2.0 * load.noise, turned * turned * block.motional.norm_sqr());
        !upright && slow && jump.norm_sqr() * block.volts * block.volts > least
    }
}

/// Returns `true` if a change exceeds `JUMP_REL` of a current and its rise, added as squares.
fn exceeds(change: Phasor, of: Phasor, rise: Phasor) -> bool {
    change.norm_sqr() > 2.0 * (JUMP_REL * JUMP_REL * of.norm_sqr() + rise.norm_sqr())
}

#[cfg(test)]
mod tests;
