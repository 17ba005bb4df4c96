//! The watch on the lanes of a motor: does each play what it should beside lane 0, and does it have a load?
//!
//! The sense channels are connected to lane 0, but for short visits to the others. In the frame of the drive, with `V` and `I` of the visited lane, `V0` and
//! `I0` those of lane 0 before, each for a volt of drive, and `offset` the nominal phase of the lane for the ordered quadrature:
//!
//! ```text
//! E = V / V0 exp(-j offset)      |arg E| < 45 degrees, and |E| within 3 dB of one or of what the trims make it: else fault 24
//! |I / V| > 1/4 of the smaller of |I0 / V0| and w C0:                                                   else fault 29
//! ```
//!
//! The first bound is that of the calibration: what is further off, no trim can be for. Trims correct the voltage at the terminals, so that it ought to be
//! equal in all lanes; a gain may also have been trimmed on purpose.
//!
//! The second bound has to tell electrodes from their absence. What is left without them is the cable, some 100 pF for each metre, beside some nanofarads. Two
//! phases may differ in resonance and load: what both have is the clamped capacitance, and one that is driven above its resonance has less of
//! a susceptance than that. By the equivalent circuit, with `M` for the ratio of its conductance at resonance to `w C0`, the least is `1 / M` of it, at the
//! antiresonance, M / 2 bandwidths away: the other phase of such a motor hardly moves.
//!
//! A lane is judged by its first block after the multiplexer has switched, and accused where four blocks in a row say the same: then no order of another
//! quadrature that was on its way can be the cause. A visit takes ten blocks, six of the other lane and four of the way back. It is made
//!
//! * in each self-test to all lanes, one after the other, while its tone settles: a reversed rotation is never driven, and a lane that
//!   would hide the resonance from the scan is called by its name;
//! * in a run first to all lanes, and then to one after the other, each every 36 ms of steady drive: ON for 32 blocks, without a chirp and not with a noise;
//! * in a run to all lanes when the lock is lost or uncertain, before a fault or another scan follows: a lane that has failed looks like that, or like
//!   another mode.
//!
//! What it cannot see is behind the multiplexer: two wires to the electrodes that are exchanged make both lanes draw what they would otherwise.

use crate::generate::phasing::{PLAUSIBLE, Phasing, SWITCH_BLOCKS};
use crate::generate::shape::sine;
use crate::generate::signal_generator::Played;
use crate::generate::step::Progress;
use crate::seam::block::LATENCY_BLOCKS;
use crate::seam::compare::{larger, smaller};
use crate::seam::config::Config;
use crate::seam::fault::Fault;
use crate::sense::demod::Sensed;

/// How often each lane is visited in a run, s of steady drive.
const ROUND_S: f32 = 36e-3;
/// Blocks of steady drive before the first visit in turn after an edge.
const STEADY_BLOCKS: u8 = 32;
/// Blocks of the self-test's tone before its visits: it looks at lane 0 itself then.
const TONE_BLOCKS: u8 = 6;
/// Blocks in a row that accuse a lane.
const ACCUSED_BLOCKS: u8 = 4;
/// The longest time that a fault of the resonance waits for the lanes to be judged, blocks.
const POSTPONED_BLOCKS: u8 = 64;
/// Least admittance of a lane that has a load, relative to lane 0 and to its clamped capacitance.
const OPEN_PART: f32 = 0.25;
/// Voltages below so many codes are not judged; nor is a current of which a quarter is less than so many.
const JUDGED_CODES: (f32, f32) = (16.0, 2.0);

// An order of another quadrature acts after so many blocks.
const _: () = assert!(ACCUSED_BLOCKS as usize > LATENCY_BLOCKS);

/// When lanes are visited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rule {
    /// Not at all: this block is not steady.
    Rest,
    /// All of them, once.
    Once,
    /// One after the other.
    InTurn,
}

/// So many blocks of steady drive since the last visit are none before it.
const NEVER: u16 = u16::MAX;

/// What is expected of a lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Expected {
    /// How far lanes 1 and 3 lead lanes 0 and 2, turns.
    pub(crate) quadrature: f32,
    /// Gain of the visited lane relative to that of lane 0, by the trims.
    pub(crate) gain: f32,
    /// Susceptance of the clamped capacitance of lane 0, S.
    pub(crate) clamped_siemens: f32,
}

/// The watch on the lanes.
#[derive(Clone, Debug)]
pub(crate) struct Lanes {
    /// Last phasors of lane 0, and the peak voltage that was played then, V.
    home: Sensed,
    home_volts: f32,
    judged_volts: f32,
    judged_amperes: f32,
    /// Blocks between two visits in turn, and those of steady drive since the last one.
    period: u16,
    since: u16,
    /// Blocks of steady drive since an edge.
    steady: u8,
    count: u8,
    /// The lane that the sense channels are ordered to, the one that was visited last, and how many more of this pass are to be visited.
    ordered: u8,
    visited: u8,
    left: u8,
    /// The lane of the last measured block, and how many blocks in a row it was.
    measured: u8,
    same: u8,
    /// Blocks in a row that accuse the visited lane.
    accused: u8,
    /// The resonance looks as if it were lost, and blocks for which a fault of it has waited.
    doubted: bool,
    waited: u8,
    /// The last measured block was not of lane 0, or not yet again.
    away: bool,
    /// All lanes have been visited since the tone of a self-test began, or since the resonance was doubted.
    complete: bool,
    found: Option<Fault>,
}

impl Lanes {
    /// A watch on the configured lanes, with a block every `block_s` seconds.
    pub(crate) fn build(config: &Config, block_s: f32) -> Self {
        let others = larger(f32::from(config.lanes) - 1.0, 1.0);
        let (volt_codes, ampere_codes) = JUDGED_CODES;
        Lanes {
            home: Sensed::default(),
            home_volts: 0.0,
            judged_volts: volt_codes * config.front_end.volt_per_lsb,
            judged_amperes: ampere_codes * config.front_end.ampere_per_lsb,
            period: smaller(ROUND_S / (others * block_s), f32::from(u16::MAX)) as u16,
            since: NEVER,
            steady: 0,
            count: if config.phasing.watch { config.lanes } else { 1 },
            ordered: 0,
            visited: 0,
            left: 0,
            measured: 0,
            same: u8::MAX,
            accused: 0,
            doubted: false,
            waited: 0,
            away: false,
            complete: false,
            found: None,
        }
    }

    /// A new attempt begins.
    pub(crate) fn begin(&mut self) {
        self.found = None;
        (self.doubted, self.since) = (false, NEVER);
    }

    /// Whether there is anything to watch.
    #[inline]
    pub(crate) fn are_several(&self) -> bool {
        self.count > 1
    }

    /// Whether the sense channels are at lane 0, and nothing else was ordered.
    #[inline]
    pub(crate) fn are_at_home(&self) -> bool {
        self.ordered == 0 && !self.away
    }

    /// Whether the phasors of the last measured block are not its own, but the last ones of lane 0.
    #[inline]
    pub(crate) fn are_heard(&self) -> bool {
        self.away
    }

    /// The lane that the sense channels are to be connected to in the block that is planned.
    #[inline]
    pub(crate) fn ordered(&self) -> u8 {
        self.ordered
    }

    /// What is wrong with a lane, as it was found since the attempt began. In a run that is in a block of another lane.
    pub(crate) fn found(&self) -> Option<Fault> {
        self.found
    }

    /// Takes whether the resonance looks in a run as if it were lost, or another one: all lanes are judged once then.
    pub(crate) fn doubt(&mut self, doubted: bool) {
        if doubted && !self.doubted {
            (self.complete, self.waited) = (false, 0);
        }
        self.doubted = doubted;
    }

    /// Whether something that is wrong with the resonance has to wait until all lanes have been judged, as it has in a run.
    #[cold]
    #[inline(never)]
    pub(crate) fn postpone(&mut self, locking: bool) -> bool {
        if locking || self.count == 1 {
            return false;
        }
        self.doubt(true);
        self.waited = self.waited.saturating_add(1);
        !self.complete && self.waited < POSTPONED_BLOCKS
    }

    /// A fault of the resonance, if it does not have to wait.
    pub(crate) fn judged(&mut self, locking: bool, fault: Fault) -> Progress {
        if self.postpone(locking) { Progress::Busy } else { Progress::Failed(fault) }
    }

    /// Connects the sense channels to lane 0 and forgets the visit: somebody else orders them now.
    pub(crate) fn return_home(&mut self) {
        (self.ordered, self.measured, self.same, self.away) = (0, 0, u8::MAX, false);
        self.rest();
    }

    fn rest(&mut self) {
        (self.ordered, self.left, self.accused, self.steady) = (0, 0, 0, 0);
    }

    /// Takes a measured block and what was played in it, and orders the next visits by this rule. Puts the last phasors of lane 0 in the place of those of
    /// another lane.
    pub(crate) fn update(&mut self, played: &Played, sensed: &mut Sensed, rule: Rule, expected: &Expected) {
        self.same = if played.lane == self.measured { self.same.saturating_add(1) } else { 1 };
        self.measured = played.lane;
        let settled = u32::from(self.same) > SWITCH_BLOCKS;
        let heard = *sensed;
        self.away = self.measured != 0 || !settled;
        if self.away {
            *sensed = self.home;
        } else {
            (self.home, self.home_volts) = (heard, played.volts);
        }
        if rule == Rule::Rest {
            self.rest();
            self.complete &= self.doubted;
            return;
        }
        self.steady = self.steady.saturating_add(1);
        self.since = self.since.saturating_add(1);
        if self.ordered == 0 {
            if !self.away && self.is_due(rule) {
                let all = rule == Rule::Once || self.since == NEVER || self.doubted && !self.complete;
                self.visit(if all { self.count - 1 } else { 1 });
            }
        } else if settled && self.measured == self.ordered {
            match self.judge(&heard, played, expected) {
                Some(fault) if self.accused + 1 == ACCUSED_BLOCKS => {
                    self.found = Some(fault);
                    self.rest();
                }
                Some(_) => self.accused += 1,
                None => self.visit(self.left),
            }
        }
    }

    /// Whether it is time for a visit.
    fn is_due(&self, rule: Rule) -> bool {
        match rule {
            Rule::Rest => false,
            Rule::Once => !self.complete && self.found.is_none() && self.steady >= TONE_BLOCKS,
            Rule::InTurn if self.doubted && !self.complete => true,
            Rule::InTurn => self.since >= self.period && self.steady >= STEADY_BLOCKS,
        }
    }

    /// Goes on to the next lane, where there are so many to visit; home, where there are none.
    fn visit(&mut self, lanes: u8) {
        self.accused = 0;
        if lanes == 0 {
            (self.ordered, self.since, self.complete) = (0, 0, true);
            return;
        }
        self.left = lanes - 1;
        self.visited = if self.visited + 1 < self.count { self.visited + 1 } else { 1 };
        self.ordered = self.visited;
    }

    /// What a block says is wrong with its lane, if anything.
    fn judge(&self, heard: &Sensed, played: &Played, expected: &Expected) -> Option<Fault> {
        let home = self.home.v.norm_sqr();
        if home < self.judged_volts * self.judged_volts || self.home_volts <= 0.0 {
            return None;
        }
        let offset = Phasing::offsets(expected.quadrature)[usize::from(played.lane) % 4];
        let ideal = sine::rotation(u64::from(offset) << 32);
        let error = heard.v * self.home.v.conj() * ideal.conj() * (self.home_volts / (played.volts * home));
        let (size, gain) = (error.norm_sqr(), expected.gain * expected.gain);
        let factor = PLAUSIBLE.1 * PLAUSIBLE.1;
        // An eighth of a turn is where both parts are the same. What is no number is not within.
        let within = error.re >= error.im.abs() && size * factor >= smaller(gain, 1.0) && size <= factor * larger(gain, 1.0);
        if !within {
            return Some(Fault::LaneImplausible);
        }
        let clamped = expected.clamped_siemens * expected.clamped_siemens;
        let least = OPEN_PART * OPEN_PART * heard.v.norm_sqr() * smaller(self.home.i.norm_sqr() / home, clamped);
        let judged = least > self.judged_amperes * self.judged_amperes;
        (judged && heard.i.norm_sqr() < least).then_some(Fault::LaneOpen)
    }
}

/// An eighth of a turn is the bound on the phase, by the parts of the phasor.
const _: () = assert!(PLAUSIBLE.0 == 0.125);

#[cfg(test)]
mod tests;
