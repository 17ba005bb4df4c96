//! The check of the current: it neither jumps within a burst nor begins one at another level.

use core::mem;

use super::{Continuity, Load, PAUSE_TIME_CONSTANTS, Steady};
use crate::seam::compare::{is_step, larger, smaller};
use crate::seam::phasor::Phasor;

/// Number of steady blocks before jumps are judged: the four readings compared are complete in the
/// tenth.
const JUMP_ARM_BLOCKS: u32 = 10;
/// Smallest jump of the motional current that is judged, relative to the current.
const JUMP_REL: f32 = 0.15;
/// Largest deviation of a jump from that of a current that becomes one sample late, relative to it.
const LATE_REL: f32 = 0.25;
/// Largest change of the motional current just before and just after a jump, relative to the jump.
const LEVEL_REL: f32 = 0.3;
/// Largest ratio of conductance to susceptance of a jump that the clamped capacitance can make.
const MAX_CONDUCTANCE_RATIO: f32 = 0.2;
/// The same if the jump is also that of a late current, for which the ratio is that of the clamped
/// susceptance to the motional conductance.
const MAX_LATE_CONDUCTANCE_RATIO: f32 = 0.05;
/// Largest loss of clamped capacitance that is not a failure, relative.
const MAX_CAPACITANCE_LOSS_REL: f32 = 0.8;
/// Largest motional current in the second block of a burst without a comparable earlier one, in
/// units of the current's rise since the first block.
const START_RISE_BLOCKS: f32 = 2.5;
/// Smallest jump that is judged, standard deviations of a block's noise.
const JUMP_SIGMAS: f32 = 8.0;
/// Shortest time constant at which a load can be distinguished from a jump, blocks.
const MIN_TIME_CONSTANT_BLOCKS: f32 = 4.0;

impl Continuity {
    /// Returns `true` if the motional current jumped between four and two blocks ago, from one
    /// level to another, and nothing explains it.
    #[inline]
    pub(super) fn check_jump(&mut self, block: &Steady, load: impl FnOnce() -> Load) -> bool {
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
        let least_rel = smaller(JUMP_REL, (1.0 - LATE_REL) * self.late_rad);
        self.steady >= JUMP_ARM_BLOCKS
            && size > least_rel * least_rel * least
            && goes_on.norm_sqr() < stays
            && came.norm_sqr() < stays
            // The error of the motional current changes with the drive.
            && !is_step(before_v, after_v)
            && self.is_failure([before, after], block, &load())
    }

    /// Returns `true` if nothing explains the jump of the motional current between these, A peak: a
    /// large one, or the turn of a current that becomes one sample late.
    #[cold]
    #[inline(never)]
    fn is_failure(&self, [before, after]: [Phasor; 2], block: &Steady, load: &Load) -> bool {
        let jump = after - before;
        // The whole current turns, with the part of the clamped branch.
        let current = before + block.i - block.motional;
        let late = current * Phasor::new(-0.5 * self.late_rad * self.late_rad, -self.late_rad);
        let is_late = (jump - late).norm_sqr() < LATE_REL * LATE_REL * late.norm_sqr();
        let most_ratio = if is_late { MAX_LATE_CONDUCTANCE_RATIO } else { MAX_CONDUCTANCE_RATIO };
        let is_large = jump.norm_sqr() > JUMP_REL * JUMP_REL * larger(block.i.norm_sqr(), before.norm_sqr());
        (is_large || is_late) && self.is_impossible(jump * (1.0 / block.volts), block, load, most_ratio)
    }

    /// Returns `true` if a burst starts with another current than the one before, by more than a
    /// block's ring-up.
    #[cold]
    #[inline(never)]
    pub(super) fn check_start(&mut self, block: &Steady, load: &Load) -> bool {
        let y = block.i * (1.0 / block.volts);
        let starts = [self.past[0], y];
        let paused = self.pause as f32 * self.periods_per_block > PAUSE_TIME_CONSTANTS * load.periods;
        let comparable = paused && block.hard;
        let before = mem::replace(&mut self.starts, comparable.then_some(starts));
        let Some(before) = before.filter(|_| comparable) else {
            // Without a comparable earlier burst, the reference is the current of the clamped
            // branch.
            let (extra, rise) = (block.motional * (1.0 / block.volts), START_RISE_BLOCKS * (starts[1] - starts[0]));
            return comparable && exceeds(extra, y, rise) && self.is_impossible(extra, block, load, MAX_CONDUCTANCE_RATIO);
        };
        let rise = before[1] - before[0];
        starts.iter().zip(before).all(|(&now, then)| {
            exceeds(now - then, then, rise) && self.is_impossible(now - then, block, load, MAX_CONDUCTANCE_RATIO)
        })
    }

    /// Returns `true` if no cause explains the jump of `I / u`, S: neither a load, the clamped
    /// capacitance, whose jump has at most this ratio of conductance to susceptance, noise, nor a
    /// jump of the resonance that the tracker follows.
    #[cold]
    #[inline(never)]
    fn is_impossible(&self, jump: Phasor, block: &Steady, load: &Load, most_ratio: f32) -> bool {
        let admittance = jump * block.v.conj() * (block.volts / block.v.norm_sqr());
        let upright = admittance.re.abs() < most_ratio * admittance.im.abs()
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
