//! What cannot change at once: voltage and current of a steady drive, by what the drive was.
//!
//! ```text
//! h = V / u,   y = I / u        of blocks that are a sine of one amplitude throughout; V = g u - z I of an amplifier of gain g and source impedance z
//! ```
//!
//! | watched | because | says |
//! |---|---|---|
//! | `h` is where it was, but for what a source of up to 5 ohm takes under another current, and for what a delay makes of another frequency | an amplifier and its channel do not change | voltage or drive have failed |
//! | `h` is not 1.2 times larger than one, or than it was in the beginning, and `V` not 1.15 times larger than the voltage limit | nothing adds to a drive | it is louder than ordered |
//! | the motional current does not jump from one level to another | it takes a time constant to change | current has failed |
//! | the tone explains nine tenths of the energy of both channels | a sine was played | a channel is offset, has lost a bit, or the drive is no sine |
//!
//! Of a self-test, a scan or a calibration, where the frequency moves and the stack rings at others, only the voltage is watched: by its limit, and by what the tone explains of it. In
//! silence it is none that is beyond its limit.
//!
//! A load that changes bends the motional current for a time constant; a sense chain that fails moves it within two blocks, after which it stays. A clamped capacitance that
//! changes moves it at once, too, but by a susceptance, and by no more than there is of it. A resonance that jumps turns it until the tracker has followed. Where a time constant is shorter than four blocks, the two are alike, and jumps say nothing.

use core::mem;

use crate::seam::compare::larger;
use crate::seam::phasor::Phasor;

/// How far the voltage may be from where it was, relative.
const VOLTAGE_PART: f32 = 0.15;
/// The largest resistance of a source that a change of the current is taken for, ohm.
const SOURCE_OHM: f32 = 5.0;
/// The least that a source leaves of the voltage, relative.
const LEAST_PART: f32 = 0.1;
/// The longest delay between a drive and its voltage that a change of the frequency is taken for, s.
const DELAY_S: f32 = 1e-4;
/// How far from where it was it is in a block that is another one's, relative.
const TORN_PART: f32 = 0.5;
/// How much louder than ordered or than in the beginning a voltage may be, and how much louder than its limit: 1.2 times that much is dangerous.
const LOUDER: f32 = 1.2;
const OVER_LIMIT: f32 = 1.15;
/// Of every second block: for how many a voltage may be where it cannot be, before that counts.
const BROKEN_BLOCKS: u32 = 4;
/// For how many blocks of a tone that measures, or of silence, the voltage may be too much, or what was not played, before that counts.
const MISPLAYED_BLOCKS: u32 = 8;
/// Of every second block: by how many a voltage is known, and the part of one in what it is compared with.
const FIRST_BLOCKS: u32 = 16;
const NEW: f32 = 1.0 / 16.0;
/// Steady blocks by which a jump is known: the fourth of those that it takes is the tenth.
const KNOWN_BLOCKS: u32 = 10;
/// Steady blocks after which nothing rings at another frequency any more.
const CALM_BLOCKS: u32 = 64;
/// A jump of the current, relative to it; and by how much less it moves before and after.
const JUMP_PART: f32 = 0.15;
const STAYS_PART: f32 = 0.3;
/// A jump that is a susceptance to this part is one of the clamped capacitance, unless it takes more than this part of it away.
const UPRIGHT: f32 = 0.2;
const LOST_PART: f32 = 0.8;
/// After so many time constants nothing is left of an earlier vibration; and how much of it so many blocks of a ring-up bring at most.
const PAUSE: f32 = 7.0;
const RISING_BLOCKS: f32 = 2.5;
/// A resonance that has jumped turns the motional current against the drive until the tracker is there: for so many blocks at most.
const FOLLOWED_BLOCKS: f32 = 4.0;
/// A jump is larger than so many standard deviations of a block's noise.
const NOISE: f32 = 8.0;
/// The shortest time constant in which a load is told from a jump, blocks.
const SLOW_BLOCKS: f32 = 4.0;

/// A block of a steady sine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Steady {
    /// What was played, V peak.
    pub(crate) volts: f32,
    /// At which offset from the nominal frequency, Hz.
    pub(crate) offset_hz: f32,
    /// Voltage, current and motional current, V and A peak.
    pub(crate) v: Phasor,
    pub(crate) i: Phasor,
    pub(crate) motional: Phasor,
    /// At a resonance that is tracked; elsewhere the stack may ring at another frequency for long.
    pub(crate) tracked: bool,
    /// A burst of a run that begins at once: at the end of a ramp or a boost the stack has rung up already.
    pub(crate) hard: bool,
    /// More than a tenth of a channel's energy is not of the tone.
    pub(crate) unexplained: bool,
}

/// What is known of the transducer, for a jump to be judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Load {
    /// Time constant, periods of the drive.
    pub(crate) periods: f32,
    /// Susceptance of the clamped capacitance, S.
    pub(crate) susceptance: f32,
    /// Variance of a block's current by noise, A².
    pub(crate) noise: f32,
}

/// What is remembered of the blocks before.
#[derive(Clone, Debug)]
pub(crate) struct Continuity {
    periods_per_block: f32,
    /// How far a resonance that has jumped may turn the motional current before it is followed, rad/Hz.
    turned_per_hz: f32,
    /// The most that a voltage may be, V, and its square.
    most_v: f32,
    limit: f32,
    /// Means of `h`, `y`, S, and of the frequency's offset, Hz.
    voltage: Phasor,
    current: Phasor,
    offset_hz: f32,
    /// The offset that was ordered last, Hz, where nothing is tracked.
    ordered_hz: f32,
    /// The most that the square of `h` may be.
    loudest: f32,
    /// Blocks by which they are known.
    known: u32,
    /// Blocks running in which the voltage was not where it can be.
    broken: u32,
    /// Blocks running of a tone that measures, or of silence, in which it was too much, or what was not played.
    misplayed: u32,
    /// Steady blocks running, and the motional current six, four and two blocks ago, A.
    steady: u32,
    past: [Phasor; 3],
    /// Blocks without drive before the burst that is under way, and `y` of the first two blocks of the last one, S, if that came after a pause.
    pause: u32,
    starts: Option<[Phasor; 2]>,
    /// It was broken in this attempt.
    failed: bool,
    /// The last block, of a drive that has long been steady, was no sine, or another one: one at a time.
    torn: bool,
}

impl Continuity {
    /// Nothing is known, but the limit of the voltage.
    pub(crate) fn build(frequency_hz: f32, block_s: f32, limit_v: f32) -> Self {
        Continuity {
            periods_per_block: frequency_hz * block_s,
            turned_per_hz: core::f32::consts::TAU * FOLLOWED_BLOCKS * block_s,
            most_v: OVER_LIMIT * limit_v,
            limit: OVER_LIMIT * OVER_LIMIT * limit_v * limit_v,
            voltage: Phasor::default(),
            current: Phasor::default(),
            offset_hz: 0.0,
            ordered_hz: 0.0,
            loudest: f32::INFINITY,
            known: 0,
            broken: 0,
            misplayed: 0,
            steady: 0,
            past: [Phasor::default(); 3],
            pause: 0,
            starts: None,
            failed: false,
            torn: false,
        }
    }

    /// A new attempt begins.
    pub(crate) fn restart(&mut self) {
        (self.known, self.loudest, self.starts, self.failed) = (0, f32::INFINITY, None, false);
        self.misplayed = 0;
        self.rest(true);
        self.pause = 0;
    }

    /// The block was none of a steady sine; whether it was silent.
    #[inline]
    pub(crate) fn rest(&mut self, silent: bool) {
        self.pause = if self.steady > 0 { 0 } else { self.pause.saturating_add(silent.into()) };
        (self.broken, self.steady, self.torn) = (0, 0, false);
    }

    /// The block was of a drive that is too faint, or otherwise not fit, to be judged: a pause before it says nothing of what rings by now.
    #[inline]
    pub(crate) fn rings(&mut self) {
        self.rest(false);
        self.pause = 0;
    }

    /// Where nothing is tracked, the frequency is an order, and with another one, however far away, everything is new.
    #[inline]
    pub(crate) fn follow_order(&mut self, offset_hz: f32) {
        if !self.failed && self.ordered_hz != offset_hz {
            self.ordered_hz = offset_hz;
            self.restart();
        }
    }

    /// Whether voltage or current have changed as they cannot since the attempt began.
    #[inline]
    pub(crate) fn has_failed(&self) -> bool {
        self.failed
    }

    /// Whether the last block, of a drive that has long been steady, was no sine: a sample of it has failed, and it says nothing of the resonance.
    #[inline]
    pub(crate) fn is_torn(&self) -> bool {
        self.torn
    }

    /// The most that a voltage may be, V.
    pub(crate) fn most_volts(&self) -> f32 {
        self.most_v
    }

    /// Takes a block of a tone that measures, or of silence, and returns whether its voltage has been more than the limit allows, or what was not played, for
    /// too long. Where the frequency moves and what rings does not follow, nothing else is known of two blocks.
    #[inline]
    pub(crate) fn is_misplayed(&mut self, v: Phasor, distorted: bool, silent: bool) -> bool {
        self.rest(silent);
        let misplayed = distorted || v.norm_sqr() > self.limit;
        self.misplayed = if misplayed { self.misplayed.saturating_add(1) } else { 0 };
        self.misplayed >= MISPLAYED_BLOCKS
    }

    /// Takes a block, and returns whether voltage or current have changed as they cannot, in it or before.
    pub(crate) fn is_broken(&mut self, block: &Steady, load: impl FnOnce() -> Load) -> bool {
        self.steady = self.steady.wrapping_add(1);
        self.tear(block, block.unexplained || self.is_far(block));
        self.failed |= match self.steady {
            // Voltage and current by turns: no block has time for both.
            steady if steady & 1 != 0 => self.is_elsewhere(block),
            _ if !block.tracked => false,
            2 => self.starts_otherwise(block, &load()),
            _ => self.jumps(block, load),
        };
        self.failed
    }

    /// Takes a block whose voltage or current are implausible by themselves.
    pub(crate) fn doubt(&mut self, block: &Steady) {
        self.tear(block, true);
    }

    #[inline]
    fn tear(&mut self, block: &Steady, torn: bool) {
        self.torn = torn && block.tracked && self.steady > CALM_BLOCKS && !self.torn;
    }

    /// Whether the voltage is so far from where it was that the codes are those of another block.
    #[inline]
    fn is_far(&self, block: &Steady) -> bool {
        let off = block.v - self.voltage * block.volts;
        off.norm_sqr() > TORN_PART * TORN_PART * self.voltage.norm_sqr() * block.volts * block.volts && self.known >= FIRST_BLOCKS
    }

    /// Whether the voltage has not been where it can be for too long.
    #[inline]
    fn is_elsewhere(&mut self, block: &Steady) -> bool {
        let part = 1.0 / block.volts;
        let (h, y) = (block.v * part, block.i * part);
        if self.steady == 1 {
            self.past[0] = y;
        }
        let off = h - self.voltage;
        let tolerated = VOLTAGE_PART * VOLTAGE_PART * self.voltage.norm_sqr();
        let elsewhere = self.known >= FIRST_BLOCKS && off.norm_sqr() > tolerated && !self.explains(off, y, block.offset_hz);
        if elsewhere || block.tracked && block.unexplained || h.norm_sqr() > self.loudest || block.v.norm_sqr() > self.limit {
            self.broken += 1;
        } else {
            self.broken = 0;
            self.learn(h, y, block.offset_hz);
        }
        self.broken >= BROKEN_BLOCKS
    }

    /// Moves the means towards what a good block has shown.
    #[inline]
    fn learn(&mut self, h: Phasor, y: Phasor, offset_hz: f32) {
        let new = if self.known < FIRST_BLOCKS {
            self.known += 1;
            1.0 / self.known as f32
        } else {
            NEW
        };
        self.voltage += (h - self.voltage) * new;
        self.current += (y - self.current) * new;
        self.offset_hz += (offset_hz - self.offset_hz) * new;
        if self.known == FIRST_BLOCKS && self.loudest == f32::INFINITY {
            let first = self.voltage.norm_sqr();
            self.loudest = LOUDER * LOUDER * if first > 1.0 { first } else { 1.0 };
        }
    }

    /// Whether another current or another frequency explain that `h` is off by so much.
    #[cold]
    #[inline(never)]
    fn explains(&self, off: Phasor, y: Phasor, offset_hz: f32) -> bool {
        let more = y - self.current;
        let along = -(off * more.conj()).re;
        let most = SOURCE_OHM * more.norm_sqr();
        let left = if along >= most {
            off + more * SOURCE_OHM
        } else if along > 0.0 {
            off + more * (along / more.norm_sqr())
        } else {
            off
        };
        let collapsed = (self.voltage + off).norm_sqr() < LEAST_PART * LEAST_PART * self.voltage.norm_sqr();
        let turned = core::f32::consts::TAU * DELAY_S * (offset_hz - self.offset_hz).abs();
        let tolerated = VOLTAGE_PART + turned;
        !collapsed && left.norm_sqr() <= tolerated * tolerated * self.voltage.norm_sqr()
    }

    /// Whether the motional current has jumped between two and four blocks ago, from a level to another one.
    #[inline]
    fn jumps(&mut self, block: &Steady, load: impl FnOnce() -> Load) -> bool {
        if block.unexplained {
            // Partly of what was before a failure and partly of what is after it: a level between the two would hide the jump.
            return false;
        }
        let [first, before, after] = self.past;
        self.past = [before, after, block.motional];
        let (jump, came, goes_on) = (after - before, before - first, block.motional - after);
        let (size, least) = (jump.norm_sqr(), larger(block.i.norm_sqr(), before.norm_sqr()));
        let stays = STAYS_PART * STAYS_PART * size;
        self.steady >= KNOWN_BLOCKS
            && size > JUMP_PART * JUMP_PART * least
            && goes_on.norm_sqr() < stays
            && came.norm_sqr() < stays
            && self.is_impossible(jump * (1.0 / block.volts), block, &load())
    }

    /// Whether a burst begins with another current than the one before, by more than a block's ring-up.
    #[cold]
    #[inline(never)]
    fn starts_otherwise(&mut self, block: &Steady, load: &Load) -> bool {
        let y = block.i * (1.0 / block.volts);
        let starts = [self.past[0], y];
        let paused = self.pause as f32 * self.periods_per_block > PAUSE * load.periods;
        let comparable = paused && block.hard;
        let before = mem::replace(&mut self.starts, comparable.then_some(starts));
        let Some(before) = before.filter(|_| comparable) else {
            // Without a burst before, the current is that of the clamped branch.
            let (extra, rise) = (block.motional * (1.0 / block.volts), RISING_BLOCKS * (starts[1] - starts[0]));
            return comparable && exceeds(extra, y, rise) && self.is_impossible(extra, block, load);
        };
        let rise = before[1] - before[0];
        starts
            .iter()
            .zip(before)
            .all(|(&now, then)| exceeds(now - then, then, rise) && self.is_impossible(now - then, block, load))
    }

    /// Whether neither a load nor a clamped capacitance nor noise nor a resonance that the tracker follows make such a jump of current by drive, S.
    #[cold]
    #[inline(never)]
    fn is_impossible(&self, jump: Phasor, block: &Steady, load: &Load) -> bool {
        let admittance = jump * block.v.conj() * (block.volts / block.v.norm_sqr());
        let upright = admittance.re.abs() < UPRIGHT * admittance.im.abs() && admittance.im > -LOST_PART * load.susceptance;
        let slow = load.periods > SLOW_BLOCKS * self.periods_per_block;
        let turned = self.turned_per_hz * (block.offset_hz - self.offset_hz);
        let least = larger(NOISE * NOISE * 2.0 * load.noise, turned * turned * block.motional.norm_sqr());
        !upright && slow && jump.norm_sqr() * block.volts * block.volts > least
    }
}

/// Whether a change is more than a jump may be of this current and than it rises by, both together; without roots.
fn exceeds(change: Phasor, of: Phasor, rise: Phasor) -> bool {
    change.norm_sqr() > 2.0 * (JUMP_PART * JUMP_PART * of.norm_sqr() + rise.norm_sqr())
}

#[cfg(test)]
mod tests;
