//! When the observer is trusted: from when on, and when no longer.
//!
//! It leads as soon as its deviation is small enough to be worth following, and is locked when that has been within 5 degrees of motional phase for
//! 8 blocks. Wherever the drive is no sine, the [phase loop](super::phase_loop) leads.
//!
//! A lock that is lost, or not found in time, is sought again: nearby, then in the whole window, then from the self-test on, which names what
//! has broken, and then by a scan.

use crate::seam::phasor::Phasor;
use crate::track::tracker::PlayedBlock;
use crate::track::tracker::lock_detector::LOCK_BLOCKS;
use crate::track::tracker::observer::{Observer, Played, Prior};

/// Deviation, relative to the nominal frequency, below which the estimate is worth following.
const WORTH: f32 = 5e-3;
/// A lock is within 5 degrees of motional phase, rad, or within this part of the frequency if that is more.
const INNER: (f32, f32) = (0.087_488_66, 1e-4);
/// So many times below the nominal Q, which may be wrong by two and loaded by a few, there is nothing left to lock to.
const LEAST_Q: f32 = 10.0;
/// Blocks that the observer may take to lock.
const TIMEOUT: u32 = 128;
/// Blocks for which a lock may stand at the edge of the window that has gone there before it could have timed out.
const AT_EDGE: u32 = 256;
/// A lock that was lost sooner than this, in blocks, is not sought the same way again.
const LASTED: u32 = 3000;
/// How far from where it was a resonance is sought first that was lost, or that is driven again, relative to the frequency.
pub(crate) const NEARBY: f32 = 5e-3;

/// Where a lock is sought.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Retry {
    /// Where the lock was lost.
    Nearby,
    /// In the whole window.
    Window,
    /// In the whole window, after another self-test and another measurement of the clamped branch.
    Calibrate,
    /// At a resonance that a scan finds.
    Scan,
}

/// The observer, and how far it is trusted.
#[derive(Clone, Debug)]
pub(crate) struct Observed {
    observer: Observer,
    nominal_hz: f32,
    window_hz: f32,
    /// [`WORTH`] and [`INNER`] of it, Hz.
    worth_hz: f32,
    inner_hz: f32,
    prior: Prior,
    seek: Retry,
    shown_hz: f32,
    /// Blocks since it began, those at the end of which it was within the bound of a lock, and those at the edge of the window.
    blocks: u32,
    inside: u32,
    at_edge: u32,
    locked: bool,
    confident: bool,
    /// The last block was of a sine.
    pure: bool,
    /// What the least Q that may be locked to decays by in a block.
    most_decay: f32,
}

impl Observed {
    /// For a nominal frequency and a window of `window_hz` to each side, with a block every `block_s` seconds.
    pub(crate) fn new(nominal_hz: f32, block_s: f32, window_hz: f32) -> Self {
        let prior = Prior { offset_hz: (0.0, 0.0), q: 1.0, lm_h: (1.0, 0.1), axis: Phasor::new(1.0, 0.0), noise_a: 1.0 };
        Observed {
            observer: Observer::new(nominal_hz, block_s),
            nominal_hz,
            window_hz,
            worth_hz: WORTH * nominal_hz,
            inner_hz: INNER.1 * nominal_hz,
            prior,
            seek: Retry::Scan,
            shown_hz: 0.0,
            blocks: 0,
            inside: 0,
            at_edge: 0,
            locked: false,
            confident: false,
            pure: true,
            most_decay: f32::INFINITY,
        }
    }

    /// Begins with what is known; `seek` says how that has come about.
    pub(crate) fn start(&mut self, prior: &Prior, seek: Retry) {
        self.observer.start(prior);
        (self.seek, self.shown_hz) = (seek, prior.offset_hz.0);
        self.most_decay = LEAST_Q * self.observer.decay_of(prior.q);
        if seek != Retry::Nearby {
            // For the next time: the same, anywhere in the window.
            self.prior = Prior { offset_hz: (0.0, self.window_hz), ..*prior };
        }
        (self.blocks, self.inside, self.at_edge, self.locked) = (0, 0, 0, false);
    }

    /// Begins again where there is more hope, and says where; nowhere after a scan.
    pub(crate) fn retry_lock(&mut self, was_locked: bool) -> Option<Retry> {
        let next = match self.seek {
            _ if was_locked && self.blocks > LASTED => Retry::Nearby,
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

    /// Whether its lock has not come from a scan.
    pub(crate) fn has_a_scan_left(&self) -> bool {
        self.seek != Retry::Scan
    }

    /// Leaves the lock to a scan, unless it has come from one. Returns whether it does.
    pub(crate) fn leave_to_a_scan(&mut self) -> bool {
        core::mem::replace(&mut self.seek, Retry::Scan) != Retry::Scan
    }

    /// The prior for a resonance that is near where it was.
    fn nearby(&self) -> Prior {
        Prior { offset_hz: (self.observer.offset_hz(), NEARBY * self.nominal_hz), ..self.prior }
    }

    /// Begins with the prior that the clamped branch gives, in the whole window or nearby.
    pub(crate) fn start_cold(&mut self, prior: &Prior) {
        let seek = match self.seek {
            // The second time after a lock was lost.
            Retry::Calibrate => Retry::Calibrate,
            _ if prior.offset_hz.1 < self.window_hz => Retry::Nearby,
            _ => Retry::Window,
        };
        self.prior = Prior { offset_hz: (0.0, self.window_hz), ..*prior };
        self.start(prior, seek);
    }

    /// Forgets what it was seeking.
    pub(crate) fn restart(&mut self) {
        (self.seek, self.locked, self.inside) = (Retry::Scan, false, 0);
    }

    /// Follows one block. `fits`: the motional phase, as far as it was measured, does not speak against a lock.
    #[inline]
    pub(crate) fn follow(&mut self, motional_current: Phasor, v: Phasor, played: &PlayedBlock, fits: bool) {
        self.pure = played.pure;
        let steady_v = played.envelope.filter(|_| played.pure).map(|envelope| played.volts * envelope);
        self.observer.follow(motional_current, v, Played { offset_hz: played.offset_hz, steady_v });
        self.blocks = self.blocks.saturating_add(played.driven.into());
        if self.observer.is_within(self.worth_hz) {
            self.shown_hz = self.observer.ahead_hz();
        }
        self.confident = self.pure && self.observer.is_as_good_as(INNER.0, self.inner_hz);
        let within =
            self.confident && fits && self.observer.decays_by() < self.most_decay && self.shown_hz.abs() < self.window_hz;
        self.at_edge = if self.shown_hz.abs() < self.window_hz { 0 } else { self.at_edge.saturating_add(played.driven.into()) };
        self.inside = if within { self.inside.saturating_add(played.driven.into()) } else { 0 };
        self.locked |= self.inside >= LOCK_BLOCKS;
    }

    /// The frequency to drive, as an offset from the nominal one, Hz; `None` where the phase loop is to lead.
    pub(crate) fn offset_hz(&self) -> Option<f32> {
        self.pure.then_some(self.shown_hz)
    }

    /// It has locked.
    pub(crate) fn locked(&self) -> bool {
        self.locked
    }

    /// It is sure of itself, whatever else speaks against it.
    pub(crate) fn is_confident(&self) -> bool {
        self.confident
    }

    /// It is sure of itself, and has been for some blocks in which nothing spoke against it.
    pub(crate) fn has_converged(&self) -> bool {
        self.inside >= LOCK_BLOCKS
    }

    /// A lock that has gone to the edge of the window so soon was none.
    pub(crate) fn is_astray(&self) -> bool {
        self.at_edge > AT_EDGE && self.blocks < TIMEOUT + AT_EDGE
    }

    /// It has taken too long.
    pub(crate) fn timed_out(&self) -> bool {
        self.blocks > TIMEOUT
    }

    /// Takes a quality factor that was measured at the resonance, and its standard deviation.
    pub(crate) fn take_q(&mut self, q: (f32, f32)) {
        self.observer.take_q(q);
    }

    /// The observer.
    pub(crate) fn observer(&self) -> &Observer {
        &self.observer
    }
}

#[cfg(test)]
mod tests;
