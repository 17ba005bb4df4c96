//! The check of the voltage: its ratio to the drive changes only as a source and a delay explain.

use super::{Continuity, REFERENCE_CHECKS, Steady};
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
/// Largest voltage, relative to the command or to the first reference if that is larger.
const MAX_VOLTAGE_RATIO: f32 = 1.2;
/// Decay factor of the largest recent drive per check.
const RECENT_REL: f32 = 0.99;
/// Number of consecutive checks with an impossible voltage that raise a fault; every second block
/// is checked.
const BROKEN_CHECKS: u32 = 4;
/// Smoothing factor of the reference per check, after the first reference.
const REFERENCE_SMOOTHING: f32 = 1.0 / 16.0;

/// Judgement of a voltage.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Verdict {
    Good,
    /// Too small because of the current of a ringing stack: it teaches nothing.
    Taken,
    Broken,
}

impl Continuity {
    /// Returns `true` if the voltage has been impossible for too long.
    #[inline]
    pub(super) fn check_voltage(&mut self, block: &Steady) -> bool {
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
            || block.v.norm_sqr() > self.most_v * self.most_v;
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
        if elsewhere || block.tracked && block.unexplained && !taken || square > most_square || square > self.most_v * self.most_v
        {
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
}

#[cfg(test)]
mod tests;
