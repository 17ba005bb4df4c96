//! Monitor of the lanes of a motor: checks amplitude and phase of each lane relative to lane 0, and
//! that it has a load.
//!
//! The sense channels are connected to lane 0, except for short visits to the others. In the frame
//! of the drive, `V` and `I` belong to the visited lane, and `V0` and `I0` to lane 0 before the
//! visit, each per volt of drive. `offset` is the nominal phase of the lane for the commanded
//! quadrature:
//!
//! ```text
//! E = V / V0 exp(-j offset)      |arg E| < 45 degrees, and |E| within 3 dB of one or of the trimmed gain: else fault 24
//! |I / V| > 1/4 of the smaller of |I0 / V0| and w C0:                                                  else fault 29
//! ```
//!
//! The first bound is also the bound of the calibration: a larger error cannot be trimmed. Trims
//! correct the voltage at the terminals, so that it should be equal in all lanes; a gain may also
//! be trimmed on purpose.
//!
//! The second bound detects missing electrodes. Without them only the cable remains, about 100 pF
//! per metre, compared with several nanofarads. The two phases may differ in resonance and load,
//! but share the clamped capacitance. Above its resonance, a phase has a smaller susceptance than
//! that. By the equivalent circuit the minimum is `1 / M` of it, with `M` the ratio of the
//! conductance at resonance to `w C0`. The minimum is at the antiresonance, M / 2 bandwidths away,
//! where the other phase of such a motor hardly moves.
//!
//! A lane is judged from its first block after the multiplexer has switched. A fault is reported
//! when four consecutive blocks agree, so that a pending change of the quadrature cannot cause it.
//! A visit takes ten blocks: six of the other lane and four for the way back. Visits take place
//!
//! * in each self-test, to all lanes in turn, while its tone settles. A reversed rotation is thus
//!   never driven, and a lane that would hide the resonance from the scan is reported as such;
//! * at the start of a run to all lanes, then to one lane at a time, each every 36 ms of steady
//!   drive: ON for 32 blocks, without a chirp or noise;
//! * in a run, to all lanes when the lock is lost or uncertain, before a fault or another scan. A
//!   failed lane looks like that, or like another mode.
//!
//! Errors after the multiplexer are not detected: with the wires of two electrodes exchanged, both
//! lanes draw the same current as before.

use crate::generate::phasing::{PLAUSIBLE, Phasing, SWITCH_BLOCKS};
use crate::generate::shape::sine;
use crate::generate::signal_generator::Played;
use crate::generate::step::Progress;
use crate::seam::block::LATENCY_BLOCKS;
use crate::seam::compare::{larger, smaller};
use crate::seam::config::Config;
use crate::seam::fault::Fault;
use crate::sense::demod::Sensed;

/// Interval between visits to the same lane in a run, s of steady drive.
const VISIT_INTERVAL_S: f32 = 36e-3;
/// Blocks of steady drive after an edge before the next regular visit.
const STEADY_BLOCKS: u8 = 32;
/// Blocks of the tone of the self-test before its visits, in which it measures lane 0.
const TONE_BLOCKS: u8 = 6;
/// Consecutive bad blocks after which a lane is faulty.
const FAULTY_BLOCKS: u8 = 4;
/// Maximum delay of a fault of the resonance until the lanes are judged, blocks.
const MAX_POSTPONED_BLOCKS: u8 = 64;
/// Minimum admittance of a lane with a load, relative to lane 0 and to its clamped capacitance.
const OPEN_ADMITTANCE_REL: f32 = 0.25;
/// Minimum voltage to be judged, codes.
const JUDGED_VOLTAGE_CODES: f32 = 16.0;
/// Minimum of a quarter of the current to be judged, codes.
const JUDGED_CURRENT_CODES: f32 = 2.0;

// A change of the quadrature takes effect within the latency.
const _: () = assert!(FAULTY_BLOCKS as usize > LATENCY_BLOCKS);

/// Rule for visits to the lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rule {
    /// No visits: this block is not steady.
    Rest,
    /// All lanes, once.
    Once,
    /// One lane at a time, in rotation.
    InTurn,
}

/// Value of `since` before the first visit.
const NEVER_VISITED: u16 = u16::MAX;

/// Expected values of a lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Expected {
    /// Phase by which lanes 1 and 3 lead lanes 0 and 2, turns.
    pub(crate) quadrature: f32,
    /// Gain of the visited lane relative to lane 0, by the trims.
    pub(crate) gain: f32,
    /// Susceptance of the clamped capacitance of lane 0, S.
    pub(crate) clamped_siemens: f32,
}

/// Monitor of the lanes.
#[derive(Clone, Debug)]
pub(crate) struct Lanes {
    /// Last phasors of lane 0.
    home: Sensed,
    /// Peak drive voltage at that time, V.
    home_volts: f32,
    /// Minimum voltage that is judged, V.
    judged_volts: f32,
    /// Minimum of a quarter of the current that is judged, A.
    judged_amperes: f32,
    /// Blocks between two regular visits.
    period: u16,
    /// Blocks of steady drive since the last visit.
    since: u16,
    /// Blocks of steady drive since an edge.
    steady: u8,
    count: u8,
    /// Lane to which the sense channels are ordered.
    ordered: u8,
    /// Lane visited last.
    visited: u8,
    /// Number of lanes still to be visited in this round.
    left: u8,
    /// Lane of the last measured block.
    measured: u8,
    /// Consecutive measured blocks of that lane.
    same: u8,
    /// Consecutive bad blocks of the visited lane.
    bad_blocks: u8,
    /// `true` if the resonance appears to be lost.
    doubted: bool,
    /// Blocks for which a fault of the resonance has been postponed.
    waited: u8,
    /// `true` if the last measured block was not a settled block of lane 0.
    away: bool,
    /// `true` if all lanes have been visited since the tone of a self-test began, or since the
    /// resonance was doubted.
    complete: bool,
    found: Option<Fault>,
}

impl Lanes {
    /// Creates a monitor of the configured lanes, for blocks of duration `block_s`, s.
    pub(crate) fn build(config: &Config, block_s: f32) -> Self {
        let others = larger(f32::from(config.lanes) - 1.0, 1.0);
        Lanes {
            home: Sensed::default(),
            home_volts: 0.0,
            judged_volts: JUDGED_VOLTAGE_CODES * config.front_end.volt_per_lsb,
            judged_amperes: JUDGED_CURRENT_CODES * config.front_end.ampere_per_lsb,
            period: smaller(VISIT_INTERVAL_S / (others * block_s), f32::from(u16::MAX)) as u16,
            since: NEVER_VISITED,
            steady: 0,
            count: if config.phasing.watch { config.lanes } else { 1 },
            ordered: 0,
            visited: 0,
            left: 0,
            measured: 0,
            same: u8::MAX,
            bad_blocks: 0,
            doubted: false,
            waited: 0,
            away: false,
            complete: false,
            found: None,
        }
    }

    /// Starts a new attempt.
    pub(crate) fn begin(&mut self) {
        self.found = None;
        (self.doubted, self.since) = (false, NEVER_VISITED);
    }

    /// Returns `true` if there are lanes to monitor in addition to lane 0.
    #[inline]
    pub(crate) fn are_several(&self) -> bool {
        self.count > 1
    }

    /// Returns `true` if the sense channels are at lane 0 and no visit is ordered.
    #[inline]
    pub(crate) fn are_at_home(&self) -> bool {
        self.ordered == 0 && !self.away
    }

    /// Returns `true` if the phasors of the last measured block were replaced by earlier ones of
    /// lane 0.
    #[inline]
    pub(crate) fn are_heard(&self) -> bool {
        self.away
    }

    /// Returns the lane to which the sense channels must be connected in the planned block.
    #[inline]
    pub(crate) fn ordered(&self) -> u8 {
        self.ordered
    }

    /// Returns the fault found since the attempt began. In a run, it is found in a block of another
    /// lane.
    pub(crate) fn found(&self) -> Option<Fault> {
        self.found
    }

    /// Records, in a run, that the resonance appears to be lost or another one. All lanes are then
    /// judged once.
    pub(crate) fn doubt(&mut self, doubted: bool) {
        if doubted && !self.doubted {
            (self.complete, self.waited) = (false, 0);
        }
        self.doubted = doubted;
    }

    /// Returns `true` if a fault of the resonance must wait until all lanes have been judged, as in
    /// a run.
    #[cold]
    #[inline(never)]
    pub(crate) fn postpone(&mut self, locking: bool) -> bool {
        if locking || self.count == 1 {
            return false;
        }
        self.doubt(true);
        self.waited = self.waited.saturating_add(1);
        !self.complete && self.waited < MAX_POSTPONED_BLOCKS
    }

    /// Returns a fault of the resonance, or `Busy` if it must wait.
    pub(crate) fn judged(&mut self, locking: bool, fault: Fault) -> Progress {
        if self.postpone(locking) { Progress::Busy } else { Progress::Failed(fault) }
    }

    /// Connects the sense channels to lane 0 and ends the visit, because another procedure orders
    /// them.
    pub(crate) fn return_home(&mut self) {
        (self.ordered, self.measured, self.same, self.away) = (0, 0, u8::MAX, false);
        self.rest();
    }

    fn rest(&mut self) {
        (self.ordered, self.left, self.bad_blocks, self.steady) = (0, 0, 0, 0);
    }

    /// Processes a measured block and the played values, and orders the next visits by this rule.
    /// Replaces the phasors of another lane with the last ones of lane 0.
    pub(crate) fn update(&mut self, played: &Played, sensed: &mut Sensed, rule: Rule, expected: &Expected) {
        self.same = if played.lane == self.measured { self.same.saturating_add(1) } else { 1 };
        self.measured = played.lane;
        let settled = u32::from(self.same) > SWITCH_BLOCKS;
        let phasors = *sensed;
        self.away = self.measured != 0 || !settled;
        if self.away {
            *sensed = self.home;
        } else {
            (self.home, self.home_volts) = (phasors, played.volts);
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
                let all = rule == Rule::Once || self.since == NEVER_VISITED || self.doubted && !self.complete;
                self.visit(if all { self.count - 1 } else { 1 });
            }
        } else if settled && self.measured == self.ordered {
            match self.judge(&phasors, played, expected) {
                Some(fault) if self.bad_blocks + 1 == FAULTY_BLOCKS => {
                    self.found = Some(fault);
                    self.rest();
                }
                Some(_) => self.bad_blocks += 1,
                None => self.visit(self.left),
            }
        }
    }

    /// Returns `true` if a visit is due.
    fn is_due(&self, rule: Rule) -> bool {
        match rule {
            Rule::Rest => false,
            Rule::Once => !self.complete && self.found.is_none() && self.steady >= TONE_BLOCKS,
            Rule::InTurn if self.doubted && !self.complete => true,
            Rule::InTurn => self.since >= self.period && self.steady >= STEADY_BLOCKS,
        }
    }

    /// Switches to the next lane if `lanes` remain to be visited, or back to lane 0 if none does.
    fn visit(&mut self, lanes: u8) {
        self.bad_blocks = 0;
        if lanes == 0 {
            (self.ordered, self.since, self.complete) = (0, 0, true);
            return;
        }
        self.left = lanes - 1;
        self.visited = if self.visited + 1 < self.count { self.visited + 1 } else { 1 };
        self.ordered = self.visited;
    }

    /// Judges a block of the visited lane and returns its fault, if any.
    fn judge(&self, phasors: &Sensed, played: &Played, expected: &Expected) -> Option<Fault> {
        let home = self.home.v.norm_sqr();
        if home < self.judged_volts * self.judged_volts || self.home_volts <= 0.0 {
            return None;
        }
        let offset = Phasing::offsets(expected.quadrature)[usize::from(played.lane) % 4];
        let ideal = sine::rotation(u64::from(offset) << 32);
        let error = phasors.v * self.home.v.conj() * ideal.conj() * (self.home_volts / (played.volts * home));
        let (size, gain) = (error.norm_sqr(), expected.gain * expected.gain);
        let factor = PLAUSIBLE.1 * PLAUSIBLE.1;
        // At an eighth of a turn, real and imaginary part are equal. NaN is not within.
        let within = error.re >= error.im.abs() && size * factor >= smaller(gain, 1.0) && size <= factor * larger(gain, 1.0);
        if !within {
            return Some(Fault::LaneImplausible);
        }
        let clamped = expected.clamped_siemens * expected.clamped_siemens;
        let least =
            OPEN_ADMITTANCE_REL * OPEN_ADMITTANCE_REL * phasors.v.norm_sqr() * smaller(self.home.i.norm_sqr() / home, clamped);
        let judged = least > self.judged_amperes * self.judged_amperes;
        (judged && phasors.i.norm_sqr() < least).then_some(Fault::LaneOpen)
    }
}

// `judge` assumes a phase bound of an eighth of a turn.
const _: () = assert!(PLAUSIBLE.0 == 0.125);

#[cfg(test)]
mod tests;
