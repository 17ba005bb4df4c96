//! Use of the observer: from its start to a lock, and the next attempts after a lost lock.
//!
//! The observer sets the frequency as soon as its deviation is small enough. It is locked when the
//! deviation has been below 5 degrees of motional phase for 8 blocks. If the drive is not a sine,
//! the [phase loop](super::phase_loop) sets the frequency.
//!
//! A lock that is lost, or not found in time, is sought again: nearby, then in the whole window,
//! then after another self-test, which identifies the broken part, and at last by a scan.

use crate::seam::phasor::Phasor;
use crate::track::tracker::PlayedBlock;
use crate::track::tracker::lock_detector::LOCK_BLOCKS;
use crate::track::tracker::observer::{Observer, Played, Prior};

/// Deviation below which the drive follows the estimate, relative to the nominal frequency.
const FOLLOW_DEVIATION_REL: f32 = 5e-3;
/// Largest deviation of a lock, rad of motional phase: 5 degrees.
const LOCK_DEVIATION_RAD: f32 = 0.087_488_66;
/// Largest deviation of a lock relative to the nominal frequency, if that is more.
const LOCK_DEVIATION_REL: f32 = 1e-4;
/// Factor below the nominal Q at which there is nothing to lock to: the nominal Q may be wrong by
/// two, and the load may lower it a few times.
const MAX_Q_RATIO: f32 = 10.0;
/// Longest time until a lock, driven blocks.
const TIMEOUT_BLOCKS: u32 = 128;
/// Longest time at the edge of the window of a lock that has gone there within its timeout, blocks.
const EDGE_BLOCKS: u32 = 256;
/// Shortest duration of a lock, blocks, after which it is sought nearby again.
pub(crate) const LASTED_BLOCKS: u32 = 3000;
/// Standard deviation of a resonance that was lost or is driven again, relative to the frequency.
pub(crate) const NEARBY_REL: f32 = 5e-3;

/// Kind of an attempt to lock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Retry {
    /// Near the lost lock.
    Nearby,
    /// In the whole window.
    Window,
    /// In the whole window, after another self-test and another measurement of the clamped branch.
    Calibrate,
    /// At a resonance that a scan finds.
    Scan,
}

/// Observer, with the state of its lock.
#[derive(Clone, Debug)]
pub(crate) struct Observed {
    observer: Observer,
    nominal_hz: f32,
    window_hz: f32,
    /// [`FOLLOW_DEVIATION_REL`] of the nominal frequency, Hz.
    follow_hz: f32,
    /// [`LOCK_DEVIATION_REL`] of the nominal frequency, Hz.
    lock_hz: f32,
    prior: Prior,
    seek: Retry,
    followed_hz: f32,
    /// Driven blocks since the start.
    blocks: u32,
    /// Consecutive driven blocks within the bound of a lock.
    inside: u32,
    /// Consecutive driven blocks at the edge of the window.
    at_edge: u32,
    locked: bool,
    confident: bool,
    /// `true` if the last block was a sine.
    pure: bool,
    /// Decay per block of the smallest Q that may be locked to.
    most_decay: f32,
}

impl Observed {
    /// Creates the observer for a nominal frequency, a window of ± `window_hz` and blocks of
    /// `block_s`, s.
    pub(crate) fn new(nominal_hz: f32, block_s: f32, window_hz: f32) -> Self {
        let prior = Prior { offset_hz: (0.0, 0.0), q: 1.0, lm_h: (1.0, 0.1), axis: Phasor::new(1.0, 0.0), noise_a: 1.0 };
        Observed {
            observer: Observer::new(nominal_hz, block_s, window_hz),
            nominal_hz,
            window_hz,
            follow_hz: FOLLOW_DEVIATION_REL * nominal_hz,
            lock_hz: LOCK_DEVIATION_REL * nominal_hz,
            prior,
            seek: Retry::Scan,
            followed_hz: 0.0,
            blocks: 0,
            inside: 0,
            at_edge: 0,
            locked: false,
            confident: false,
            pure: true,
            most_decay: f32::INFINITY,
        }
    }

    /// Starts from a prior; `seek` is the kind of the attempt.
    pub(crate) fn start(&mut self, prior: &Prior, seek: Retry) {
        self.observer.start(prior);
        (self.seek, self.followed_hz) = (seek, prior.offset_hz.0);
        self.most_decay = MAX_Q_RATIO * self.observer.decay_of(prior.q);
        if seek != Retry::Nearby {
            // The next attempt uses the same prior in the whole window.
            self.prior = Prior { offset_hz: (0.0, self.window_hz), ..*prior };
        }
        (self.blocks, self.inside, self.at_edge, self.locked) = (0, 0, 0, false);
    }

    /// Starts the next attempt to lock, and returns its kind; `None` after a scan.
    pub(crate) fn retry_lock(&mut self, was_locked: bool) -> Option<Retry> {
        let next = match self.seek {
            _ if was_locked && self.blocks > LASTED_BLOCKS => Retry::Nearby,
            Retry::Nearby => Retry::Window,
            Retry::Window => Retry::Calibrate,
            Retry::Calibrate => Retry::Scan,
            Retry::Scan => return None,
        };
        match next {
            Retry::Nearby => self.start(&self.nearby(), next),
            Retry::Window => self.start(&{ self.prior }, next),
            Retry::Calibrate | Retry::Scan => self.seek = next,
        }
        Some(next)
    }

    /// Returns `true` if the lock does not come from a scan.
    pub(crate) fn can_scan(&self) -> bool {
        self.seek != Retry::Scan
    }

    /// Hands the lock over to a scan, unless it comes from one. Returns `true` if a scan must
    /// follow.
    pub(crate) fn hand_over_to_scan(&mut self) -> bool {
        core::mem::replace(&mut self.seek, Retry::Scan) != Retry::Scan
    }

    /// Returns the prior for a resonance near its last frequency.
    fn nearby(&self) -> Prior {
        Prior { offset_hz: (self.observer.offset_hz(), NEARBY_REL * self.nominal_hz), ..self.prior }
    }

    /// Starts from the prior of the clamped branch, in the whole window or nearby.
    pub(crate) fn start_cold(&mut self, prior: &Prior) {
        let seek = match self.seek {
            // The second attempt after a lost lock.
            Retry::Calibrate => Retry::Calibrate,
            _ if prior.offset_hz.1 < self.window_hz => Retry::Nearby,
            _ => Retry::Window,
        };
        self.prior = Prior { offset_hz: (0.0, self.window_hz), ..*prior };
        self.start(prior, seek);
    }

    /// Resets the attempts, and discards the ringing of another transducer.
    pub(crate) fn restart(&mut self) {
        (self.seek, self.locked, self.inside) = (Retry::Scan, false, 0);
        self.observer.restart();
    }

    /// Follows one block. `fits` is `false` if the measured motional phase contradicts a lock.
    #[inline]
    pub(crate) fn follow(&mut self, motional_current: Phasor, v: Phasor, played: &PlayedBlock, fits: bool) {
        self.pure = played.pure;
        let steady_v = played.envelope.filter(|_| played.pure).map(|envelope| played.volts * envelope);
        self.observer.follow(motional_current, v, Played { offset_hz: played.offset_hz, steady_v });
        self.blocks = self.blocks.saturating_add(played.driven.into());
        if self.observer.is_within(self.follow_hz) {
            self.followed_hz = self.observer.ahead_hz();
        }
        self.confident = self.pure && self.observer.is_within_phase(LOCK_DEVIATION_RAD, self.lock_hz);
        let within =
            self.confident && fits && self.observer.decays_by() < self.most_decay && self.followed_hz.abs() < self.window_hz;
        self.at_edge =
            if self.followed_hz.abs() < self.window_hz { 0 } else { self.at_edge.saturating_add(played.driven.into()) };
        self.inside = if within { self.inside.saturating_add(played.driven.into()) } else { 0 };
        self.locked |= self.inside >= LOCK_BLOCKS;
    }

    /// Returns the frequency to drive, as an offset from the nominal one, Hz; `None` if the phase
    /// loop must set it.
    pub(crate) fn offset_hz(&self) -> Option<f32> {
        self.pure.then_some(self.followed_hz)
    }

    /// Returns `true` if the observer has locked.
    pub(crate) fn locked(&self) -> bool {
        self.locked
    }

    /// Returns `true` if the deviation is small enough for a lock, even if the motional phase
    /// disagrees.
    pub(crate) fn is_confident(&self) -> bool {
        self.confident
    }

    /// Returns `true` if the last blocks, enough for a lock, were within its bound and not
    /// contradicted.
    pub(crate) fn has_converged(&self) -> bool {
        self.inside >= LOCK_BLOCKS
    }

    /// Returns `true` for a false lock: it went to the edge of the window soon after the start.
    pub(crate) fn is_astray(&self) -> bool {
        self.at_edge > EDGE_BLOCKS && self.blocks < TIMEOUT_BLOCKS + EDGE_BLOCKS
    }

    /// Returns `true` if the attempt has taken too long.
    pub(crate) fn timed_out(&self) -> bool {
        self.blocks > TIMEOUT_BLOCKS
    }

    /// Applies a quality factor measured at the resonance, with its standard deviation.
    pub(crate) fn take_q(&mut self, q: (f32, f32)) {
        self.observer.take_q(q);
    }

    /// Returns the observer.
    pub(crate) fn observer(&self) -> &Observer {
        &self.observer
    }
}

#[cfg(test)]
mod tests;
