//! The tracker: from phasors to the frequency that keeps the drive at a moving resonance.
//!
//! The clamped branch is subtracted from the total current, which leaves the motional current
//! ([`Motional`]). The [`observer`] estimates the resonance from the change of that current, if its
//! estimate is good enough. Otherwise `phase_loop` drives the phase of the motional or the total
//! current to zero, and `lock_detector` decides if it is locked. The motional phase, which the
//! observer does not use, also verifies the observer. The tracker uses a phase only if there is
//! one: not at an edge of the envelope, not during ring-up, and not if the stack does not ring.

pub mod identified;
pub(crate) mod lock_detector;
pub(crate) mod observed;
pub mod observer;
pub(crate) mod phase_loop;
pub(crate) mod prior;
pub(crate) mod stray;

use crate::find::clamped::MIN_OBSERVED_BLOCKS;
use crate::seam::compare::{larger, smaller};
use crate::seam::config::{Config, TrackingMode};
use crate::seam::error::Error;
use crate::seam::phasor::Phasor;
use crate::seam::transducer::Transducer;
use crate::seam::units::Turns;
use crate::sense::demod::Sensed;
use crate::sense::motional::Motional;
use crate::sense::source::LARGEST_OHM;
use crate::track::tracker::identified::{Known, Learning};
use crate::track::tracker::lock_detector::{Lock, LockDetector};
use crate::track::tracker::observed::{NEARBY_REL, Observed, Retry};
use crate::track::tracker::observer::Prior;
use crate::track::tracker::phase_loop::PhaseLoop;
use crate::track::tracker::stray::Stray;

/// Wait for the ring-up after an edge of a burst, time constants of the resonance. Before that the
/// noise exceeds the phase.
const RING_UP_TIME_CONSTANTS: f32 = 0.5;
/// Motional current above which the stack rings, relative to that of the identified resonance in
/// series with the largest source resistance.
const RINGING_REL: f32 = 0.2;
/// A phase that neither makes nor loses a lock.
const UNDECIDED_PHASE: Turns = Turns(20.0 / 360.0);
/// Longest time until the loop has locked: the sum of blocks and time constants of the resonance.
const LOCK_TIMEOUT: (u32, f32) = (2000, 50.0);
/// Number of blocks by which a block at the edge of the window counts against [`LOCK_TIMEOUT`].
const EDGE_BLOCK_WEIGHT: u32 = 32;
/// Standard deviation of a resonance found by a scan, bandwidths.
const SCAN_DEVIATION_BANDWIDTHS: f32 = 0.1;
/// Turn of the motional phase at the lock point by other resonances, if a scan has found some, rad.
const OTHER_MODES_RAD: f32 = 0.02;
/// Turn of the motional phase by other resonances, rad, for a first clamped branch that was wrong
/// by the motional conductance.
const WRONG_BRANCH_RAD: f32 = 0.5;
/// Time constant, blocks, above which a resonance is no longer fast: its load has been released,
/// and the loop no longer fits.
const MAX_FAST_BLOCKS: f32 = 1.0;
/// Blocks above that time constant after which the resonance is sought again.
const SLOW_BLOCKS: u32 = 32;
/// Shortest duration of a fast lock, blocks, after which it is sought once more.
const LASTED_BLOCKS: u32 = 3000;
/// Longest time under drive without a measured phase: the sum of blocks and time constants.
const UNMEASURED_TIMEOUT: (u32, f32) = (500, 20.0);

/// Current whose phase is driven to zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PhaseDetector {
    /// Motional current: its phase is zero at the series resonance, at any load.
    Motional,
    /// Total current, the plain V-I loop: biased by C0 (76 Hz at Q 65), and without a zero below
    /// `M = 2`.
    Total,
}

/// State of the lock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// The lock is being acquired.
    Seeking,
    /// The tracker is locked.
    Locked,
    /// Locked at the last measurement, but that is long ago: the bursts are too short.
    Unmeasured,
    /// The lock was lost.
    Lost,
    /// The observer has converged, but the motional phase disagrees.
    Disagree,
    /// The lock was not acquired in time.
    TimedOut,
}

/// Drive played in the measured block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlayedBlock {
    /// Frequency, as an offset from the nominal one, Hz.
    pub offset_hz: f32,
    /// Peak voltage before the envelope, V.
    pub volts: f32,
    /// Envelope, if it was constant throughout the block.
    pub envelope: Option<f32>,
    /// `true` if the drive was a sine. Harmonics leak into the lock-in, differently in every block.
    pub pure: bool,
    /// `true` if the envelope was one throughout the block.
    pub on: bool,
    /// `true` if there was any drive.
    pub driven: bool,
    /// `true` if a boost has already completed the ring-up.
    pub rung_up: bool,
}

/// Tracker of the resonance.
#[derive(Clone, Debug)]
pub struct Tracker {
    detector: Option<PhaseDetector>,
    nominal_hz: f32,
    block_s: f32,
    nominal: Motional,
    motional: Motional,
    phase_loop: PhaseLoop,
    stray: Stray,
    observed: Observed,
    /// `true` if the observer is configured.
    has_observer: bool,
    /// `true` if the observer tracks: it is configured, and the resonance does not decay too fast for
    /// it.
    observes: bool,
    /// Largest admittance of a fast resonance at the lock point, S: one with a larger admittance
    /// decays more slowly.
    most_siemens: f32,
    /// Consecutive blocks above that admittance.
    slow_blocks: u32,
    /// `true` if a fast resonance was sought again after its loss.
    sought_again: bool,
    known: Known,
    lock: LockDetector,
    rm_ohm: f32,
    /// Admittance above which the stack rings, S.
    ringing_siemens: f32,
    /// `2 pi tau`: phase of the resonance per detuning, rad/Hz near the resonance.
    turn_per_hz: f32,
    /// Consecutive blocks with an envelope of one.
    on_blocks: u32,
    /// Blocks of the ring-up, in which no phase is used.
    ring_up_blocks: u32,
    /// Blocks under drive since the last measured phase.
    unmeasured_blocks: u32,
    /// Largest `unmeasured_blocks` of a lock.
    unmeasured_limit: u32,
    /// Blocks since the start, for the timeout without an observer; the observer counts its own.
    blocks: u32,
    /// Largest `blocks` before a lock.
    timeout_blocks: u32,
}

impl Tracker {
    /// Builds a tracker that knows only the configured values.
    pub fn build(config: &Config, block_s: f32) -> Result<Self, Error> {
        let nominal = Motional::of_capacitance(config.tracking.c0_f(), config.drive.frequency_hz);
        Ok(Tracker {
            detector: match config.tracking.mode {
                TrackingMode::Observer | TrackingMode::PhaseLock => Some(PhaseDetector::Motional),
                TrackingMode::ZeroPhase => Some(PhaseDetector::Total),
                TrackingMode::Off => None,
            },
            nominal_hz: config.drive.frequency_hz,
            block_s,
            nominal,
            motional: nominal,
            phase_loop: PhaseLoop::build(&config.tracking, config.drive.frequency_hz, block_s)?,
            stray: Stray::default(),
            observed: Observed::new(config.drive.frequency_hz, block_s, config.tracking.span * config.drive.frequency_hz),
            has_observer: config.tracking.mode == TrackingMode::Observer,
            observes: config.tracking.mode == TrackingMode::Observer,
            most_siemens: f32::INFINITY,
            slow_blocks: 0,
            sought_again: false,
            known: Known::default(),
            lock: LockDetector::default(),
            rm_ohm: 0.0,
            ringing_siemens: 0.0,
            turn_per_hz: 0.0,
            on_blocks: 0,
            ring_up_blocks: 0,
            unmeasured_blocks: 0,
            unmeasured_limit: 0,
            blocks: 0,
            timeout_blocks: 0,
        })
    }

    /// Returns `true` if a resonance is tracked.
    pub(crate) fn tracks(&self) -> bool {
        self.detector.is_some()
    }

    /// Resets the tracker to the nominal transducer.
    pub(crate) fn restart(&mut self) {
        self.motional = self.nominal;
        self.lock.restart(0.0);
        self.phase_loop.seed(0.0, f32::INFINITY);
        self.rm_ohm = 0.0;
        self.stray = Stray::default();
        (self.observes, self.sought_again) = (self.has_observer, false);
        self.observed.restart();
    }

    /// Returns the observer if it tracks.
    #[inline]
    fn observed(&self) -> Option<&Observed> {
        self.observes.then_some(&self.observed)
    }

    /// Returns `true` if the phase loop tracks a resonance that decays too fast for the observer.
    fn is_fast(&self) -> bool {
        self.has_observer && !self.observes
    }

    /// Sets the clamped capacitance to start with, F, if there is no nominal one.
    pub(crate) fn set_clamped_capacitance(&mut self, c0_f: f32) {
        self.nominal = Motional::of_capacitance(c0_f, self.nominal_hz);
        self.motional = self.nominal;
    }

    /// Returns `true` if an observer tracks.
    pub(crate) fn observes(&self) -> bool {
        self.observes
    }

    /// Returns the prior for a resonance that was tracked at `hz`: offset from the nominal
    /// frequency and its standard deviation, Hz.
    pub(crate) fn prior_near(&self, hz: f32) -> (f32, f32) {
        (hz - self.nominal_hz, NEARBY_REL * self.nominal_hz)
    }

    /// Starts the observer without vibration, in the whole window, or nearby if the prior is
    /// narrower.
    pub fn observe(&mut self, branch: Motional, known: Known, prior: &Prior) {
        (self.motional, self.known) = (branch, known);
        self.restart_clock(prior.q / (core::f32::consts::PI * self.nominal_hz * self.block_s));
        self.observes = self.has_observer;
        if self.observes {
            self.observed.start_cold(prior);
        }
    }

    /// Starts the next attempt to lock, and returns its kind; `None` without an observer or after
    /// the last attempt. The only one of a fast resonance begins with the self-test.
    pub(crate) fn retry_lock(&mut self, was_locked: bool) -> Option<Retry> {
        if self.is_fast() {
            let again = !self.sought_again || was_locked && self.blocks > LASTED_BLOCKS;
            self.sought_again = true;
            self.restart_clock(0.0);
            return again.then_some(Retry::Calibrate);
        }
        let next = if self.observes { self.observed.retry_lock(was_locked) } else { return None };
        self.restart_clock(0.0);
        next
    }

    /// Returns `true` if the observer has converged and the motional phase agrees.
    pub fn has_converged(&self) -> bool {
        self.observed().is_some_and(Observed::has_converged)
    }

    /// Begins to identify the transducer in parts, if there is an observer.
    pub(crate) fn learn(&self, learning: &mut Learning) {
        if let Some(observed) = self.observed() {
            learning.begin(observed.observer(), self.nominal_hz, &self.known);
        }
    }

    /// Returns the transducer as the observer has identified it so far.
    pub fn identify(&self) -> Option<Transducer> {
        self.observed().map(|observed| identified::circuit(observed.observer(), self.nominal_hz, &self.known))
    }

    /// Starts on a transducer that a scan has found and that rings at its resonance. `noise_a` is
    /// the rms noise of a block's current, A.
    pub fn seed(&mut self, transducer: &Transducer, branch: Motional, noise_a: f32) {
        self.motional = branch;
        self.known = Known {
            c0_f: (transducer.c0_f, transducer.deviations.c0_f),
            modes: (transducer.modes, transducer.chosen),
            phase_rad: if transducer.modes > 1 { OTHER_MODES_RAD } else { 0.0 },
            closely: true,
        };
        let offset_hz = transducer.series_resonance_hz - self.nominal_hz;
        self.phase_loop.seed(offset_hz, transducer.time_constant_s());
        self.stray.seed(offset_hz, transducer.time_constant_s());
        self.set_resonance(transducer);
        self.restart_clock(transducer.time_constant_s() / self.block_s);
        self.on_blocks = self.ring_up_blocks;
        let blocks = transducer.time_constant_s() / self.block_s;
        self.observes = self.has_observer && blocks >= MIN_OBSERVED_BLOCKS;
        (self.most_siemens, self.slow_blocks) = (MAX_FAST_BLOCKS / (blocks * transducer.rm_ohm), 0);
        if self.observes {
            let spread_hz = SCAN_DEVIATION_BANDWIDTHS * transducer.series_resonance_hz / transducer.q;
            let (q, axis) = (transducer.q, branch.axis);
            let lm_h = (transducer.lm_h, transducer.deviations.lm_h);
            self.observed.start(&Prior { offset_hz: (offset_hz, spread_hz), q, lm_h, axis, noise_a }, Retry::Scan);
        }
    }

    /// Applies a quality factor measured at the lock point, with its standard deviation.
    pub(crate) fn take_q(&mut self, q: (f32, f32)) {
        if self.observes {
            self.observed.take_q(q);
            self.known.closely = true;
        }
    }

    /// Applies a clamped branch measured at the lock point. `deviation` is the relative standard
    /// deviation of its susceptance.
    ///
    /// `was_off` is the deviation of the branch at the start of the lock, relative to the motional
    /// conductance: other resonances contribute to it. `None` means that C0 has drifted.
    pub(crate) fn set_branch(&mut self, branch: Motional, deviation: f32, was_off: Option<f32>) {
        if let Some(was_off) = was_off {
            self.known.phase_rad = larger(self.known.phase_rad, WRONG_BRANCH_RAD * was_off);
        } else {
            let (c0_f, deviation_f) = self.known.c0_f;
            let now_f = c0_f + (branch.y0.im - self.motional.y0.im) / (core::f32::consts::TAU * self.nominal_hz);
            self.known.c0_f = (now_f, larger(deviation_f, deviation * now_f));
        }
        self.motional = branch;
    }

    /// Returns `true` if the observer's gate has opened in the last block: an abrupt change of load
    /// or resonance.
    pub(crate) fn has_gate_opened(&self) -> bool {
        self.observed().is_some_and(|observed| observed.observer().has_opened())
    }

    /// Returns `true` if there is an observer whose lock does not come from a scan.
    pub(crate) fn can_scan(&self) -> bool {
        self.observed().is_some_and(Observed::can_scan)
    }

    /// Hands the lock over to a scan, unless it comes from one. Returns `true` if a scan must
    /// follow.
    pub(crate) fn hand_over_to_scan(&mut self) -> bool {
        self.observes && self.observed.hand_over_to_scan()
    }

    /// Returns `true` if the phase loop seeks the lock away from the resonance just found by a
    /// scan.
    pub(crate) fn is_astray(&self) -> bool {
        self.stray.is_astray() && self.detector == Some(PhaseDetector::Motional)
    }

    /// Returns `true` if another scan may replace a lock that went astray: once.
    pub(crate) fn take_second_scan(&mut self) -> bool {
        self.stray.take_second_scan()
    }

    /// Applies the properties of the identified resonance.
    pub fn set_resonance(&mut self, transducer: &Transducer) {
        let tau_s = transducer.time_constant_s();
        self.rm_ohm = transducer.rm_ohm;
        self.ringing_siemens = RINGING_REL / (transducer.rm_ohm + LARGEST_OHM);
        self.turn_per_hz = core::f32::consts::TAU * tau_s;
        self.ring_up_blocks = (RING_UP_TIME_CONSTANTS * tau_s / self.block_s) as u32;
        self.phase_loop.set_time_constant(tau_s);
    }

    fn restart_clock(&mut self, tau_blocks: f32) {
        let limit = |(blocks, time_constants): (u32, f32)| blocks + (time_constants * tau_blocks) as u32;
        self.lock.restart(tau_blocks);
        (self.unmeasured_blocks, self.unmeasured_limit) = (0, limit(UNMEASURED_TIMEOUT));
        (self.blocks, self.timeout_blocks) = (0, limit(LOCK_TIMEOUT));
    }

    /// Returns the motional current of a block, A peak.
    pub fn motional_current(&self, sensed: &Sensed, relative: f32) -> Phasor {
        self.motional.current(sensed, relative)
    }

    /// Returns the clamped branch, with the axis of the sensing chain.
    pub(crate) fn branch(&self) -> &Motional {
        &self.motional
    }

    /// Returns the motional current at the lock point: at a detuning `df` the resonance answers
    /// with `1 / (1 + j 2 pi tau df)` of it.
    pub(crate) fn at_lock_point(&self, motional_current: Phasor, detune_hz: f32) -> Phasor {
        if detune_hz == 0.0 {
            return motional_current;
        }
        motional_current * Phasor::new(1.0, self.turn_per_hz * detune_hz)
    }

    /// Follows one block. `at_lock_point` is its motional current at the lock point. Returns the
    /// phase that is driven to zero; zero if none was measured.
    pub fn follow(&mut self, sensed: &Sensed, motional_current: Phasor, at_lock_point: Phasor, played: &PlayedBlock) -> Turns {
        let Some(detector) = self.detector else { return Turns(0.0) };
        self.unmeasured_blocks = self.unmeasured_blocks.saturating_add(played.driven.into());
        self.on_blocks = if played.on { self.on_blocks.saturating_add(1) } else { 0 };
        if played.rung_up && played.on {
            self.on_blocks = self.on_blocks.max(self.ring_up_blocks + 1);
        }
        let fits = self.lock.agrees();
        if self.observes {
            self.observed.follow(motional_current, sensed.v, played, fits);
        } else {
            self.blocks = self.blocks.saturating_add(if self.phase_loop.limited() { EDGE_BLOCK_WEIGHT } else { 1 });
            self.stray.take_estimate(self.phase_loop.estimate_hz());
        }
        if self.on_blocks <= self.ring_up_blocks || !played.on {
            self.phase_loop.hold();
            return Turns(0.0);
        }
        self.unmeasured_blocks = 0;
        let rings = match self.observed().filter(|observed| observed.is_confident()) {
            // A drop of the load lowers the current below that of the identified resonance.
            Some(observed) => observed.observer().rings(at_lock_point, RINGING_REL, played.volts, LARGEST_OHM),
            None => {
                let above = self.ringing_siemens * played.volts;
                at_lock_point.norm_sqr() > above * above
            }
        };
        if self.rm_ohm > 0.0 && rings {
            let current = match detector {
                PhaseDetector::Motional => at_lock_point,
                PhaseDetector::Total => sensed.i,
            };
            let error = self.motional.phase_of(current, sensed.v);
            let phase = match self.observed().and_then(Observed::offset_hz) {
                Some(offset_hz) => self.phase_loop.accompany(error, offset_hz),
                None => self.update_phase_loop(error, sensed),
            };
            // At the edge of the window a small phase is not a lock.
            let undecided = self.phase_loop.limited() && phase.0.abs() < UNDECIDED_PHASE.0;
            self.lock.update(if undecided { UNDECIDED_PHASE } else { phase });
            return phase;
        }
        if self.lock.state() == Lock::Locked {
            // Nothing rings under full drive: the resonance is elsewhere. This counts as half a
            // turn.
            self.lock.update(Turns(0.5));
        }
        Turns(0.0)
    }

    /// Updates the phase loop with one block's phase error, and returns the phase.
    // Not inlined: the fast memory of a board has no room for it.
    #[inline(never)]
    fn update_phase_loop(&mut self, error: Phasor, sensed: &Sensed) -> Turns {
        // The size of the error is that of the current times that of the voltage.
        let most = self.most_siemens * sensed.v.norm_sqr();
        let slow = error.norm_sqr() > most * most;
        self.slow_blocks = if slow && self.has_observer { self.slow_blocks.saturating_add(1) } else { 0 };
        let phase = self.phase_loop.update(error);
        self.stray.take_output(self.phase_loop.offset_hz(), self.phase_loop.limited());
        if self.slow_blocks > SLOW_BLOCKS {
            self.stray.give_up();
        }
        phase
    }

    /// Returns the state of the lock.
    pub fn state(&self) -> State {
        let locked = if self.unmeasured_blocks > self.unmeasured_limit { State::Unmeasured } else { State::Locked };
        match (self.observed(), self.lock.state()) {
            (Some(observed), Lock::Lost) if observed.is_confident() && !self.limited() => State::Disagree,
            (Some(_), Lock::Lost) | (None, Lock::Lost) => State::Lost,
            (Some(observed), _) if observed.is_astray() => State::Lost,
            (None, _) if self.stray.has_leapt() => State::Lost,
            (Some(observed), _) if observed.locked() => locked,
            (Some(observed), _) if observed.timed_out() => State::TimedOut,
            (None, Lock::Locked) => locked,
            (None, Lock::Seeking) if self.blocks > self.timeout_blocks => State::TimedOut,
            _ => State::Seeking,
        }
    }

    /// Returns the frequency to drive, as an offset from the nominal one, Hz.
    pub fn offset_hz(&self) -> f32 {
        let window = self.window_hz();
        match self.observed().and_then(Observed::offset_hz) {
            Some(offset_hz) => smaller(larger(offset_hz, -window), window),
            None => self.phase_loop.offset_hz(),
        }
    }

    /// Returns the largest offset, Hz.
    pub(crate) fn window_hz(&self) -> f32 {
        self.phase_loop.window_hz()
    }

    /// Returns the estimate of the resonance, as an offset from the nominal frequency, Hz.
    pub(crate) fn estimate_hz(&self) -> f32 {
        self.observed().map_or_else(|| self.phase_loop.estimate_hz(), |observed| observed.observer().offset_hz())
    }

    /// Returns `true` if the frequency window limits the tracker.
    pub(crate) fn limited(&self) -> bool {
        match self.observed().and_then(Observed::offset_hz) {
            Some(offset_hz) => offset_hz.abs() >= self.window_hz(),
            None => self.phase_loop.limited(),
        }
    }
}
