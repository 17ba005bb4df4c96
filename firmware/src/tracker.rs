//! Phasors to frequency: keeps the drive at the resonance while it moves.
//!
//! The motional current is taken out of the total ([`Motional`]); the phase of one of the two is driven to zero by
//! [`phase_loop`]; [`lock_detector`] says whether to believe it. In between the tracker decides when there is anything to hear:
//! not while the envelope is at an edge or the stack rings up, and not when it does not ring at all.

pub mod lock_detector;
pub mod observer;
pub mod phase_loop;

use crate::config::{Config, TrackingMode};
use crate::demod::Sensed;
use crate::error::Error;
use crate::identify::Transducer;
use crate::motional::Motional;
use crate::phasor::Phasor;
use crate::tracker::lock_detector::{Lock, LockDetector};
use crate::tracker::phase_loop::PhaseLoop;
use crate::units::Turns;

/// After an edge of the burst, the tracker waits for the stack to ring up, time constants of the resonance. Before that there is
/// more noise than phase.
const RING_UP: f32 = 0.5;
/// The stack rings while the motional current is above this part of what the identified resonance would show.
const RINGS_ABOVE: f32 = 0.2;
/// A phase that neither makes a lock nor loses one.
const UNDECIDED: Turns = Turns(20.0 / 360.0);
/// Longest time the loop may take to lock, blocks and time constants of the resonance.
const LOCK_TIMEOUT: (u32, f32) = (2000, 50.0);
/// Longest time under drive without hearing anything, in the same terms.
const UNHEARD: (u32, f32) = (500, 20.0);

/// Which phase is driven to zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PhaseDetector {
    /// Of the motional current: zero at the series resonance, at any load.
    Motional,
    /// Of the total current: the plain V-I loop. Biased by C0 (76 Hz at Q 65), and without any zero below M = 2.
    Total,
}

/// How the lock is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Not yet.
    Seeking,
    /// Locked.
    Locked,
    /// Locked when it was last heard, which is long ago: the bursts are too short.
    Unheard,
    /// It was locked, and is no more.
    Lost,
    /// It has taken too long.
    TimedOut,
}

/// What was played in the block that is heard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heard {
    /// Peak voltage before the envelope, V.
    pub volts: f32,
    /// The envelope was one throughout.
    pub on: bool,
    /// There was drive at all.
    pub driven: bool,
}

/// The tracker.
#[derive(Clone, Debug)]
pub struct Tracker {
    detector: Option<PhaseDetector>,
    nominal_hz: f32,
    block_s: f32,
    nominal: Motional,
    motional: Motional,
    phase_loop: PhaseLoop,
    lock: LockDetector,
    rm_ohm: f32,
    /// `2 pi tau`: how much a hertz of detuning is of the phase's own scale, 1/Hz.
    turn_per_hz: f32,
    /// Blocks heard since the envelope is one, and how many of them it waits.
    on_blocks: u32,
    ring_up_blocks: u32,
    /// Blocks under drive since anything was heard, and how many that may be.
    unheard_blocks: u32,
    unheard_limit: u32,
    /// Blocks since it was seeded, and how many a lock may take.
    blocks: u32,
    timeout_blocks: u32,
}

impl Tracker {
    /// A tracker that knows what a user knows.
    pub fn build(config: &Config, block_s: f32) -> Result<Self, Error> {
        let nominal = Motional::of_capacitance(config.tracking.nominal_c0_f, config.drive.frequency_hz);
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
            lock: LockDetector::default(),
            rm_ohm: 0.0,
            turn_per_hz: 0.0,
            on_blocks: 0,
            ring_up_blocks: 0,
            unheard_blocks: 0,
            unheard_limit: 0,
            blocks: 0,
            timeout_blocks: 0,
        })
    }

    /// Whether anything is tracked.
    pub fn tracks(&self) -> bool {
        self.detector.is_some()
    }

    /// Forgets the transducer.
    pub fn restart(&mut self) {
        self.motional = self.nominal;
        self.lock.restart(0.0);
        self.phase_loop.seed(0.0, f32::INFINITY);
    }

    /// Starts on a transducer that rings at its resonance.
    pub fn seed(&mut self, transducer: &Transducer, branch: Motional) {
        let tau_s = transducer.time_constant_s();
        let tau_blocks = tau_s / self.block_s;
        let limit = |(blocks, time_constants): (u32, f32)| blocks + (time_constants * tau_blocks) as u32;
        self.motional = branch;
        self.phase_loop.seed(transducer.series_resonance_hz - self.nominal_hz, tau_s);
        self.lock.restart(tau_blocks);
        self.rm_ohm = transducer.rm_ohm;
        self.turn_per_hz = core::f32::consts::TAU * tau_s;
        self.ring_up_blocks = (RING_UP * tau_blocks) as u32;
        self.on_blocks = self.ring_up_blocks;
        (self.unheard_blocks, self.unheard_limit) = (0, limit(UNHEARD));
        (self.blocks, self.timeout_blocks) = (0, limit(LOCK_TIMEOUT));
    }

    /// The motional current of a block, A peak.
    pub fn motional_current(&self, sensed: &Sensed, relative: f32) -> Phasor {
        self.motional.current(sensed, relative)
    }

    /// What the motional current would be at the lock point: beside it, a resonance answers with `1 / (1 + j 2 pi tau df)` of that.
    pub fn at_lock_point(&self, motional_current: Phasor, detune_hz: f32) -> Phasor {
        if detune_hz == 0.0 {
            return motional_current;
        }
        motional_current * Phasor::new(1.0, self.turn_per_hz * detune_hz)
    }

    /// Follows one block, whose motional current is given [at the lock point](Self::at_lock_point). Returns the phase that is driven to zero,
    /// which is zero where nothing was heard.
    pub fn follow(&mut self, sensed: &Sensed, motional_current: Phasor, heard: &Heard) -> Turns {
        let Some(detector) = self.detector else { return Turns(0.0) };
        self.blocks = self.blocks.saturating_add(1);
        self.unheard_blocks = self.unheard_blocks.saturating_add(heard.driven.into());
        self.on_blocks = if heard.on { self.on_blocks.saturating_add(1) } else { 0 };
        if self.on_blocks <= self.ring_up_blocks || !heard.on {
            self.phase_loop.hold();
            return Turns(0.0);
        }
        self.unheard_blocks = 0;
        let rings_above = RINGS_ABOVE * heard.volts / self.rm_ohm;
        if motional_current.norm_sqr() > rings_above * rings_above {
            let current = match detector {
                PhaseDetector::Motional => motional_current,
                PhaseDetector::Total => sensed.i,
            };
            let phase = self.phase_loop.update(self.motional.phase_of(current, sensed.v));
            // At the edge of the window a small phase is no lock; nor is a lock lost there that was one.
            self.lock.update(if self.phase_loop.limited() { UNDECIDED } else { phase });
            return phase;
        }
        if self.lock.state() == Lock::Locked {
            // Nothing rings under full drive: the resonance is elsewhere. Counts as half a turn.
            self.lock.update(Turns(0.5));
        }
        Turns(0.0)
    }

    /// How the lock is.
    pub fn state(&self) -> State {
        match self.lock.state() {
            Lock::Locked if self.unheard_blocks > self.unheard_limit => State::Unheard,
            Lock::Locked => State::Locked,
            Lock::Lost => State::Lost,
            Lock::Seeking if self.blocks > self.timeout_blocks => State::TimedOut,
            Lock::Seeking => State::Seeking,
        }
    }

    /// The frequency to drive, as an offset from the nominal one, Hz.
    pub fn offset_hz(&self) -> f32 {
        self.phase_loop.offset_hz()
    }

    /// The largest offset, Hz.
    pub fn window_hz(&self) -> f32 {
        self.phase_loop.window_hz()
    }

    /// The smoothed estimate of the resonance, as an offset from the nominal frequency, Hz.
    pub fn estimate_hz(&self) -> f32 {
        self.phase_loop.estimate_hz()
    }

    /// Whether the frequency window stops it from going where it wants.
    pub fn limited(&self) -> bool {
        self.phase_loop.limited()
    }
}
