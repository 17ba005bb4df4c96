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
pub(crate) mod start;
pub(crate) mod stray;

use crate::seam::compare::{larger, smaller};
use crate::seam::phasor::Phasor;
use crate::seam::transducer::Transducer;
use crate::seam::units::Turns;
use crate::sense::demod::Sensed;
use crate::sense::motional::Motional;
use crate::sense::source::LARGEST_OHM;
use crate::track::tracker::identified::{Known, Learning};
use crate::track::tracker::lock_detector::{Lock, LockDetector};
use crate::track::tracker::observed::Observed;
use crate::track::tracker::phase_loop::PhaseLoop;
use crate::track::tracker::stray::Stray;

/// Motional current above which the stack rings, relative to that of the identified resonance in
/// series with the largest source resistance.
const RINGING_REL: f32 = 0.2;
/// A phase that loses a lock.
const HALF_TURN: Turns = Turns(0.5);
/// A phase that neither makes nor loses a lock.
const UNDECIDED_PHASE: Turns = Turns(20.0 / 360.0);
/// Number of blocks by which a block at the edge of the window counts against the timeout.
const EDGE_BLOCK_WEIGHT: u32 = 32;
/// Time constant, blocks, above which a resonance is no longer fast: its load has been released,
/// and the loop no longer fits.
const MAX_FAST_BLOCKS: f32 = 1.0;

/// Current whose phase is driven to zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PhaseDetector {
    /// Motional current: its phase is zero at the series resonance, at any load.
    Motional,
    /// Total current, the plain V-I loop: biased by C0 (76 Hz at Q 65), and without a zero below
    /// `M = 2`.
    Total,
}

/// Reason why the phase loop tracks after a scan, and not the observer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unobserved {
    /// The resonance decays too fast for an observer.
    Fast,
    /// Another resonance is so near that the current of both does not build up as that of one.
    Crowded,
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
    /// Observer; `None` also while the phase loop tracks after a scan.
    observed: Option<Observed>,
    /// Reason why the phase loop tracks, and not the observer.
    unobserved: Option<Unobserved>,
    known: Known,
    lock: LockDetector,
    /// Admittance above which the stack rings, S; infinite before a resonance is known.
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
    /// Returns `true` if a resonance is tracked.
    pub(crate) fn tracks(&self) -> bool {
        self.detector.is_some()
    }

    /// Returns `true` if an observer tracks.
    pub(crate) fn observes(&self) -> bool {
        self.observed.is_some()
    }

    /// Returns `true` if the observer has converged and the motional phase agrees.
    pub fn has_converged(&self) -> bool {
        self.observed.as_ref().is_some_and(Observed::has_converged)
    }

    /// Begins to identify the transducer in parts, if there is an observer.
    pub(crate) fn learn(&self, learning: &mut Learning) {
        if let Some(observed) = &self.observed {
            learning.begin(observed.observer(), self.nominal_hz, &self.known);
        }
    }

    /// Returns the transducer as the observer has identified it so far.
    pub fn identify(&self) -> Option<Transducer> {
        self.observed.as_ref().map(|observed| identified::circuit(observed.observer(), self.nominal_hz, &self.known))
    }

    /// Returns `true` if the observer's gate has opened in the last block: an abrupt change of load
    /// or resonance.
    pub(crate) fn has_gate_opened(&self) -> bool {
        self.observed.as_ref().is_some_and(|observed| observed.observer().has_opened())
    }

    /// Returns `true` if there is an observer whose lock does not come from a scan.
    pub(crate) fn can_scan(&self) -> bool {
        self.observed.as_ref().is_some_and(Observed::can_scan)
    }

    /// Hands the lock over to a scan, unless it comes from one. Returns `true` if a scan must
    /// follow.
    pub(crate) fn hand_over_to_scan(&mut self) -> bool {
        self.observed.as_mut().is_some_and(Observed::hand_over_to_scan)
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
        if let Some(observed) = &mut self.observed {
            observed.follow(motional_current, sensed.v, played, fits);
        } else {
            self.blocks = self.blocks.saturating_add(if self.phase_loop.limited() { EDGE_BLOCK_WEIGHT } else { 1 });
            self.stray.take_estimate(self.phase_loop.estimate_hz());
        }
        if self.on_blocks <= self.ring_up_blocks || !played.on {
            self.phase_loop.hold();
            return Turns(0.0);
        }
        self.unmeasured_blocks = 0;
        let rings = match self.observed.as_ref().filter(|observed| observed.is_confident()) {
            // A drop of the load lowers the current below that of the identified resonance.
            Some(observed) => {
                self.ringing_siemens < f32::INFINITY
                    && observed.observer().rings(at_lock_point, RINGING_REL, played.volts, LARGEST_OHM)
            }
            None => {
                let above = self.ringing_siemens * played.volts;
                at_lock_point.norm_sqr() > above * above
            }
        };
        if rings {
            let current = match detector {
                PhaseDetector::Motional => at_lock_point,
                PhaseDetector::Total => sensed.i,
            };
            let error = self.motional.phase_of(current, sensed.v);
            let phase = match self.observed.as_ref().and_then(Observed::offset_hz) {
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
            self.lock.update(HALF_TURN);
        }
        Turns(0.0)
    }

    /// Updates the phase loop with one block's phase error, and returns the phase.
    // Not inlined: the fast memory of a board has no room for it.
    #[inline(never)]
    fn update_phase_loop(&mut self, error: Phasor, sensed: &Sensed) -> Turns {
        if self.unobserved == Some(Unobserved::Fast) && self.is_released(error, sensed.v) {
            return HALF_TURN;
        }
        let phase = self.phase_loop.update(error);
        self.stray.take_output(self.phase_loop.offset_hz(), self.phase_loop.limited());
        phase
    }

    /// Returns `true` if the load of a fast resonance has been released, so that the loop does not
    /// fit: the time constant, which is proportional to the conductance, exceeds
    /// [`MAX_FAST_BLOCKS`]. The size of the phase error is that of the current times that of the
    /// voltage.
    #[cold]
    #[inline(never)]
    fn is_released(&self, error: Phasor, v: Phasor) -> bool {
        let rm_ohm = RINGING_REL / self.ringing_siemens - LARGEST_OHM;
        let least = MAX_FAST_BLOCKS * self.block_s * core::f32::consts::TAU / (self.turn_per_hz * rm_ohm) * v.norm_sqr();
        error.norm_sqr() > least * least
    }

    /// Returns the state of the lock.
    pub fn state(&self) -> State {
        let locked = if self.unmeasured_blocks > self.unmeasured_limit { State::Unmeasured } else { State::Locked };
        match (&self.observed, self.lock.state()) {
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
        match self.observed.as_ref().and_then(Observed::offset_hz) {
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
        self.observed.as_ref().map_or_else(|| self.phase_loop.estimate_hz(), |observed| observed.observer().offset_hz())
    }

    /// Returns `true` if the frequency window limits the tracker.
    pub(crate) fn limited(&self) -> bool {
        match self.observed.as_ref().and_then(Observed::offset_hz) {
            Some(offset_hz) => offset_hz.abs() >= self.window_hz(),
            None => self.phase_loop.limited(),
        }
    }
}
