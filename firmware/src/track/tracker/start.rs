//! Start of the tracker: on nominal values, on those of a scan, and again after a lost lock.

use crate::find::clamped::MIN_OBSERVED_BLOCKS;
use crate::find::scan::ring_down::OTHER_MODES_RAD;
use crate::seam::compare::larger;
use crate::seam::config::{Config, TrackingMode};
use crate::seam::error::Error;
use crate::seam::transducer::Transducer;
use crate::sense::motional::Motional;
use crate::sense::source::LARGEST_OHM;
use crate::track::tracker::identified::Known;
use crate::track::tracker::lock_detector::LockDetector;
use crate::track::tracker::observed::{LASTED_BLOCKS, NEARBY_REL, Observed, Retry};
use crate::track::tracker::observer::Prior;
use crate::track::tracker::phase_loop::PhaseLoop;
use crate::track::tracker::stray::Stray;
use crate::track::tracker::{PhaseDetector, RINGING_REL, Tracker, Unobserved};

/// Wait for the ring-up after an edge of a burst, time constants of the resonance. Before that the
/// noise exceeds the phase.
const RING_UP_TIME_CONSTANTS: f32 = 0.5;
/// Longest time until the loop has locked: the sum of blocks and time constants of the resonance.
const LOCK_TIMEOUT: (u32, f32) = (2000, 50.0);
/// Standard deviation of a resonance found by a scan, bandwidths.
const SCAN_DEVIATION_BANDWIDTHS: f32 = 0.1;
/// Turn of the motional phase by other resonances, rad, for a first clamped branch that was wrong
/// by the motional conductance.
const WRONG_BRANCH_RAD: f32 = 0.5;
/// Longest time under drive without a measured phase: the sum of blocks and time constants.
const UNMEASURED_TIMEOUT: (u32, f32) = (500, 20.0);

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
            observed: (config.tracking.mode == TrackingMode::Observer)
                .then(|| Observed::new(config.drive.frequency_hz, block_s, config.tracking.span * config.drive.frequency_hz)),
            unobserved: None,
            known: Known::default(),
            lock: LockDetector::default(),
            ringing_siemens: f32::INFINITY,
            turn_per_hz: 0.0,
            on_blocks: 0,
            ring_up_blocks: 0,
            unmeasured_blocks: 0,
            unmeasured_limit: 0,
            blocks: 0,
            timeout_blocks: 0,
        })
    }

    /// Resets the tracker to the nominal transducer.
    pub(crate) fn restart(&mut self) {
        self.motional = self.nominal;
        self.lock.restart(0.0);
        self.phase_loop.seed(0.0, f32::INFINITY);
        self.ringing_siemens = f32::INFINITY;
        self.stray = Stray::default();
        self.bring_back_observer();
        self.observed.iter_mut().for_each(Observed::restart);
    }

    /// Creates the observer again after a resonance that the phase loop tracked.
    fn bring_back_observer(&mut self) {
        if self.unobserved.take().is_some() {
            self.observed = Some(Observed::new(self.nominal_hz, self.block_s, self.window_hz()));
        }
    }

    /// Sets the clamped capacitance to start with, F, if there is no nominal one.
    pub(crate) fn set_clamped_capacitance(&mut self, c0_f: f32) {
        self.nominal = Motional::of_capacitance(c0_f, self.nominal_hz);
        self.motional = self.nominal;
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
        self.bring_back_observer();
        if let Some(observed) = &mut self.observed {
            observed.start_cold(prior);
        }
    }

    /// Starts the next attempt to lock, and returns its kind; `None` without an observer or after
    /// the last attempt. The only one of an unobserved resonance begins with the self-test.
    pub(crate) fn retry_lock(&mut self, was_locked: bool) -> Option<Retry> {
        if self.unobserved.is_some() {
            let again = was_locked && self.blocks > LASTED_BLOCKS || self.stray.take_second_scan();
            self.restart_clock(0.0);
            return again.then_some(Retry::Calibrate);
        }
        let next = self.observed.as_mut()?.retry_lock(was_locked);
        self.restart_clock(0.0);
        next
    }

    /// Starts on a transducer that a scan has found and that rings at its resonance. `noise_a` is
    /// the rms noise of a block's current, A; `crowded`: another resonance is within about a
    /// bandwidth.
    pub fn seed(&mut self, transducer: &Transducer, branch: Motional, noise_a: f32, crowded: bool) {
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
        self.bring_back_observer();
        let fast = transducer.time_constant_s() < MIN_OBSERVED_BLOCKS * self.block_s;
        if fast || crowded {
            let reason = if fast { Unobserved::Fast } else { Unobserved::Crowded };
            self.unobserved = self.observed.take().map(|_| reason);
        }
        if let Some(observed) = &mut self.observed {
            let spread_hz = SCAN_DEVIATION_BANDWIDTHS * transducer.series_resonance_hz / transducer.q;
            let (q, axis) = (transducer.q, branch.axis);
            let lm_h = (transducer.lm_h, transducer.deviations.lm_h);
            observed.start(&Prior { offset_hz: (offset_hz, spread_hz), q, lm_h, axis, noise_a }, Retry::Scan);
        }
    }

    /// Applies a quality factor measured at the lock point, with its standard deviation.
    pub(crate) fn take_q(&mut self, q: (f32, f32)) {
        if let Some(observed) = &mut self.observed {
            observed.take_q(q);
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

    /// Applies the properties of the identified resonance.
    pub fn set_resonance(&mut self, transducer: &Transducer) {
        let tau_s = transducer.time_constant_s();
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
}
