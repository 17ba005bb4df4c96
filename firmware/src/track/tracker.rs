//! Phasors to frequency: keeps the drive at the resonance while it moves.
//!
//! The motional current is taken out of the total ([`Motional`]). The [`observer`] estimates the resonance from how it changes, as far as its estimate is
//! trusted; or the phase of one of the two currents is driven to zero by `phase_loop`, and `lock_detector` decides whether to
//! trust that. The motional phase, which the observer does not use, also verifies the observer. In between the tracker decides
//! when there is a phase to measure: not while the envelope is at an edge or the stack rings up, and not when it does not ring at all.

pub mod identified;
pub(crate) mod lock_detector;
pub(crate) mod observed;
pub mod observer;
pub(crate) mod phase_loop;
pub(crate) mod prior;
pub(crate) mod stray;

use crate::seam::compare::{larger, smaller};
use crate::seam::config::{Config, TrackingMode};
use crate::seam::error::Error;
use crate::seam::phasor::Phasor;
use crate::seam::transducer::Transducer;
use crate::seam::units::Turns;
use crate::sense::demod::Sensed;
use crate::sense::motional::Motional;
use crate::track::tracker::identified::{Known, Learning};
use crate::track::tracker::lock_detector::{Lock, LockDetector};
use crate::track::tracker::observed::{NEARBY, Observed, Retry};
use crate::track::tracker::observer::Prior;
use crate::track::tracker::phase_loop::PhaseLoop;
use crate::track::tracker::stray::Stray;

/// After an edge of the burst, the tracker waits for the stack to ring up, time constants of the resonance. Before that there is
/// more noise than phase.
const RING_UP: f32 = 0.5;
/// The stack rings while the motional current is above this part of what the identified resonance would show.
const RINGS_ABOVE: f32 = 0.2;
/// A phase that neither makes a lock nor loses one.
const UNDECIDED: Turns = Turns(20.0 / 360.0);
/// Longest time the loop may take to lock, blocks and time constants of the resonance.
const LOCK_TIMEOUT: (u32, f32) = (2000, 50.0);
/// A block at the edge of the window, where there is nothing to lock to, counts as so many.
const AT_EDGE: u32 = 32;
/// Where a scan has found the resonance, it is within this part of the bandwidth.
const SCANNED: f32 = 0.1;
/// What other resonances may turn the motional phase at the lock point by: where a scan has found some, rad; and by what part of the conductance a lock had been off.
const COMPANY: f32 = 0.02;
const ADDED: f32 = 0.5;
/// Longest time under drive without hearing anything, in the same terms.
const UNMEASURED: (u32, f32) = (500, 20.0);

/// Which phase is driven to zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PhaseDetector {
    /// Of the motional current: zero at the series resonance, at any load.
    Motional,
    /// Of the total current: the plain V-I loop. Biased by C0 (76 Hz at Q 65), and without any zero below M = 2.
    Total,
}

/// State of the lock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// The lock is being acquired.
    Seeking,
    /// The tracker is locked.
    Locked,
    /// Locked when it was last measured, which is long ago: the bursts are too short.
    Unmeasured,
    /// The lock was lost.
    Lost,
    /// The observer has converged, and the motional phase disagrees.
    Disagree,
    /// The lock was not acquired in time.
    TimedOut,
}

/// What was played in the measured block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlayedBlock {
    /// Frequency, as an offset from the nominal one, Hz.
    pub offset_hz: f32,
    /// Peak voltage before the envelope, V.
    pub volts: f32,
    /// The envelope, where it was the same throughout.
    pub envelope: Option<f32>,
    /// The drive was a sine: harmonics leak into the lock-in, by another part in every block.
    pub pure: bool,
    /// The envelope was one throughout the block.
    pub on: bool,
    /// There was drive at all.
    pub driven: bool,
    /// What is driven has rung up already, by a boost.
    pub rung_up: bool,
}

/// The tracker of the resonance.
#[derive(Clone, Debug)]
pub struct Tracker {
    detector: Option<PhaseDetector>,
    nominal_hz: f32,
    block_s: f32,
    nominal: Motional,
    motional: Motional,
    phase_loop: PhaseLoop,
    stray: Stray,
    observed: Option<Observed>,
    known: Known,
    lock: LockDetector,
    rm_ohm: f32,
    /// `2 pi tau`: how much a hertz of detuning is of the phase's own scale, 1/Hz.
    turn_per_hz: f32,
    /// Blocks measured since the envelope is one, and how many of them it waits.
    on_blocks: u32,
    ring_up_blocks: u32,
    /// Blocks under drive since the phase was measured last, and how many that may be.
    unmeasured_blocks: u32,
    unmeasured_limit: u32,
    /// Blocks since it was seeded, and how many a lock may take; without an observer, which counts for itself.
    blocks: u32,
    timeout_blocks: u32,
}

impl Tracker {
    /// A tracker that knows what a user knows.
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
            observed: (config.tracking.mode == TrackingMode::Observer)
                .then(|| Observed::new(config.drive.frequency_hz, block_s, config.tracking.span * config.drive.frequency_hz)),
            known: Known::default(),
            lock: LockDetector::default(),
            rm_ohm: 0.0,
            turn_per_hz: 0.0,
            on_blocks: 0,
            ring_up_blocks: 0,
            unmeasured_blocks: 0,
            unmeasured_limit: 0,
            blocks: 0,
            timeout_blocks: 0,
        })
    }

    /// Whether anything is tracked.
    pub(crate) fn tracks(&self) -> bool {
        self.detector.is_some()
    }

    /// Forgets the transducer.
    pub(crate) fn restart(&mut self) {
        self.motional = self.nominal;
        self.lock.restart(0.0);
        self.phase_loop.seed(0.0, f32::INFINITY);
        self.rm_ohm = 0.0;
        self.stray = Stray::default();
        self.observed.iter_mut().for_each(Observed::restart);
    }

    /// Takes a clamped capacitance to begin with, F, where there is no nominal one.
    pub(crate) fn reckon_with(&mut self, c0_f: f32) {
        self.nominal = Motional::of_capacitance(c0_f, self.nominal_hz);
        self.motional = self.nominal;
    }

    /// Whether an observer tracks.
    pub(crate) fn observes(&self) -> bool {
        self.observed.is_some()
    }

    /// Where a resonance is sought first that was tracked at `hz`, Hz: as an offset from the nominal frequency, and the standard deviation of that.
    pub(crate) fn near(&self, hz: f32) -> (f32, f32) {
        (hz - self.nominal_hz, NEARBY * self.nominal_hz)
    }

    /// Lets the observer begin on a transducer that rings nowhere yet: in the whole window, or nearby, if the prior is narrower than that.
    pub fn observe(&mut self, branch: Motional, known: Known, prior: &Prior) {
        (self.motional, self.known) = (branch, known);
        self.restart_clock(prior.q / (core::f32::consts::PI * self.nominal_hz * self.block_s));
        if let Some(observed) = &mut self.observed {
            observed.start_cold(prior);
        }
    }

    /// Begins again where there is more hope, and says where; without an observer, or after the last, nowhere.
    pub(crate) fn retry_lock(&mut self, was_locked: bool) -> Option<Retry> {
        let next = self.observed.as_mut()?.retry_lock(was_locked);
        self.restart_clock(0.0);
        next
    }

    /// Whether an observer is sure of its resonance, and nothing speaks against it.
    pub fn has_converged(&self) -> bool {
        self.observed.as_ref().is_some_and(Observed::has_converged)
    }

    /// Begins to learn the same in parts, where there is an observer.
    pub(crate) fn learn(&self, learning: &mut Learning) {
        if let Some(observed) = &self.observed {
            learning.begin(observed.observer(), self.nominal_hz, &self.known);
        }
    }

    /// What the observer knows of the transducer by now.
    pub fn identify(&self) -> Option<Transducer> {
        self.observed.as_ref().map(|observed| identified::circuit(observed.observer(), self.nominal_hz, &self.known))
    }

    /// Starts on a transducer that a scan has found, and that rings at its resonance. `noise_a` is the rms noise of a block's current.
    pub fn seed(&mut self, transducer: &Transducer, branch: Motional, noise_a: f32) {
        self.motional = branch;
        self.known = Known {
            c0_f: (transducer.c0_f, transducer.deviations.c0_f),
            modes: (transducer.modes, transducer.chosen),
            phase_rad: if transducer.modes > 1 { COMPANY } else { 0.0 },
            closely: true,
        };
        let offset_hz = transducer.series_resonance_hz - self.nominal_hz;
        self.phase_loop.seed(offset_hz, transducer.time_constant_s());
        self.stray.seed(offset_hz, transducer.time_constant_s());
        self.set_resonance(transducer);
        self.restart_clock(transducer.time_constant_s() / self.block_s);
        self.on_blocks = self.ring_up_blocks;
        if let Some(observed) = &mut self.observed {
            let spread_hz = SCANNED * transducer.series_resonance_hz / transducer.q;
            let (q, axis) = (transducer.q, branch.axis);
            let lm_h = (transducer.lm_h, transducer.deviations.lm_h);
            observed.start(&Prior { offset_hz: (offset_hz, spread_hz), q, lm_h, axis, noise_a }, Retry::Scan);
        }
    }

    /// Takes a quality factor that was measured at the lock point, and its standard deviation.
    pub(crate) fn take_q(&mut self, q: (f32, f32)) {
        if let Some(observed) = &mut self.observed {
            observed.take_q(q);
            self.known.closely = true;
        }
    }

    /// Takes a clamped branch that was measured at the lock point, and the standard deviation of its susceptance, relative; `was_off`: by what part of the
    /// motional conductance the branch was off that a lock had begun with, because other resonances add to it there. Without that C0 has drifted.
    pub(crate) fn set_branch(&mut self, branch: Motional, deviation: f32, was_off: Option<f32>) {
        if let Some(was_off) = was_off {
            self.known.phase_rad = larger(self.known.phase_rad, ADDED * was_off);
        } else {
            let (c0_f, deviation_f) = self.known.c0_f;
            let now_f = c0_f + (branch.y0.im - self.motional.y0.im) / (core::f32::consts::TAU * self.nominal_hz);
            self.known.c0_f = (now_f, larger(deviation_f, deviation * now_f));
        }
        self.motional = branch;
    }

    /// Whether the observer's gate has opened in the last block: load or resonance have changed abruptly.
    pub(crate) fn has_been_surprised(&self) -> bool {
        self.observed.as_ref().is_some_and(|observed| observed.observer().has_opened())
    }

    /// Whether there is an observer whose lock has not come from a scan.
    pub(crate) fn has_a_scan_left(&self) -> bool {
        self.observed.as_ref().is_some_and(Observed::has_a_scan_left)
    }

    /// Leaves the lock to a scan, unless it has come from one. Returns whether it does.
    pub(crate) fn leave_to_a_scan(&mut self) -> bool {
        self.observed.as_mut().is_some_and(Observed::leave_to_a_scan)
    }

    /// Whether the lock that is sought by the phase of the motional current is elsewhere than where a scan has just found the resonance.
    pub(crate) fn is_astray(&self) -> bool {
        self.stray.is_astray() && self.detector == Some(PhaseDetector::Motional)
    }

    /// Leaves a lock that went astray to another scan. Returns whether it does: once.
    pub(crate) fn scan_again(&mut self) -> bool {
        self.stray.scan_again()
    }

    /// Takes what is known of the resonance.
    pub fn set_resonance(&mut self, transducer: &Transducer) {
        let tau_s = transducer.time_constant_s();
        self.rm_ohm = transducer.rm_ohm;
        self.turn_per_hz = core::f32::consts::TAU * tau_s;
        self.ring_up_blocks = (RING_UP * tau_s / self.block_s) as u32;
        self.phase_loop.set_time_constant(tau_s);
    }

    fn restart_clock(&mut self, tau_blocks: f32) {
        let limit = |(blocks, time_constants): (u32, f32)| blocks + (time_constants * tau_blocks) as u32;
        self.lock.restart(tau_blocks);
        (self.unmeasured_blocks, self.unmeasured_limit) = (0, limit(UNMEASURED));
        (self.blocks, self.timeout_blocks) = (0, limit(LOCK_TIMEOUT));
    }

    /// The motional current of a block, A peak.
    pub fn motional_current(&self, sensed: &Sensed, relative: f32) -> Phasor {
        self.motional.current(sensed, relative)
    }

    /// The clamped branch, and the axis of the sensing chain.
    pub(crate) fn branch(&self) -> &Motional {
        &self.motional
    }

    /// What the motional current would be at the lock point: beside it, a resonance answers with `1 / (1 + j 2 pi tau df)` of that.
    pub(crate) fn at_lock_point(&self, motional_current: Phasor, detune_hz: f32) -> Phasor {
        if detune_hz == 0.0 {
            return motional_current;
        }
        motional_current * Phasor::new(1.0, self.turn_per_hz * detune_hz)
    }

    /// Follows one block. `at_lock_point` is its motional current at the lock point. Returns the phase that is driven to
    /// zero, which is zero where nothing was measured.
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
            self.blocks = self.blocks.saturating_add(if self.phase_loop.limited() { AT_EDGE } else { 1 });
            self.stray.seek(self.phase_loop.estimate_hz());
        }
        if self.on_blocks <= self.ring_up_blocks || !played.on {
            self.phase_loop.hold();
            return Turns(0.0);
        }
        self.unmeasured_blocks = 0;
        let rings = match self.observed.as_ref().filter(|observed| observed.is_confident()) {
            // A load that comes down leaves less of the current than what it was identified by.
            Some(observed) => observed.observer().rings(at_lock_point, RINGS_ABOVE, played.volts),
            None => {
                let above = RINGS_ABOVE * played.volts / self.rm_ohm;
                at_lock_point.norm_sqr() > above * above
            }
        };
        if self.rm_ohm > 0.0 && rings {
            let current = match detector {
                PhaseDetector::Motional => at_lock_point,
                PhaseDetector::Total => sensed.i,
            };
            let error = self.motional.phase_of(current, sensed.v);
            let phase = match self.observed.as_ref().and_then(Observed::offset_hz) {
                Some(offset_hz) => self.phase_loop.accompany(error, offset_hz),
                None => self.lead(error),
            };
            // At the edge of the window a small phase is no lock.
            let undecided = self.phase_loop.limited() && phase.0.abs() < UNDECIDED.0;
            self.lock.update(if undecided { UNDECIDED } else { phase });
            return phase;
        }
        if self.lock.state() == Lock::Locked {
            // Nothing rings under full drive: the resonance is elsewhere. Counts as half a turn.
            self.lock.update(Turns(0.5));
        }
        Turns(0.0)
    }

    /// Goes where one block's phase error tells the loop to, and returns it.
    // Not inlined: the fast memory of a board has no room for it.
    #[inline(never)]
    fn lead(&mut self, error: Phasor) -> Turns {
        let phase = self.phase_loop.update(error);
        self.stray.go(self.phase_loop.offset_hz(), self.phase_loop.limited());
        phase
    }

    /// How the lock is.
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

    /// The frequency to drive, as an offset from the nominal one, Hz.
    pub fn offset_hz(&self) -> f32 {
        let window = self.window_hz();
        match self.observed.as_ref().and_then(Observed::offset_hz) {
            Some(offset_hz) => smaller(larger(offset_hz, -window), window),
            None => self.phase_loop.offset_hz(),
        }
    }

    /// The largest offset, Hz.
    pub(crate) fn window_hz(&self) -> f32 {
        self.phase_loop.window_hz()
    }

    /// The estimate of the resonance, as an offset from the nominal frequency, Hz.
    pub(crate) fn estimate_hz(&self) -> f32 {
        self.observed.as_ref().map_or_else(|| self.phase_loop.estimate_hz(), |observed| observed.observer().offset_hz())
    }

    /// Whether the frequency window stops it from going where it wants.
    pub(crate) fn limited(&self) -> bool {
        match self.observed.as_ref().and_then(Observed::offset_hz) {
            Some(offset_hz) => offset_hz.abs() >= self.window_hz(),
            None => self.phase_loop.limited(),
        }
    }
}
