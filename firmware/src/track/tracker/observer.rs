//! Detuning observer: estimates the resonance from the change of the motional current from block to
//! block, without waiting for the ring-up.
//!
//! In the frame of the drive (`w`), the envelope of the motional current of a resonance at `w0`
//! obeys
//!
//! ```text
//! Im' = -(alpha + j (w - w0)) Im + beta V,    alpha = Rm / (2 Lm),    beta = 1 / (2 Lm)
//! ```
//!
//! Over a block of `T`, from the middle of one to the middle of the next, this is
//!
//! ```text
//! Im[k + 1] = a Im[k] + sqrt(a) b V,    a = exp((-alpha + j (w0 - w)) T),    b = beta T
//! ```
//!
//! to second order in `(w0 - w) T`. A Kalman filter (R. E. Kalman 1960; extended, because `a`
//! multiplies `Im`) estimates three unknowns: `Im`; the pole `p = (-alpha + j (w0 - wn)) T`
//! relative to the nominal frequency `wn`; and the strength, the ratio of `b` to its nominal value,
//! as long as it is uncertain.
//!
//! `Im` and `p` are complex and the model is analytic in them, so that each has one complex row of
//! the covariance. The strength is real along the axis of the sensing chain, and uses the real part
//! of its correction. While the current builds up, its curvature shows the detuning; in steady
//! state its phase does. The weights of the filter change from one to the other by themselves.
//!
//! * The noise is that of the converters, measured beforehand, plus the leakage of an envelope that
//!   changes within a block, plus the error of the model.
//! * An innovation above five standard deviations means that the load has jumped. The **gate**
//!   opens: frequency and damping become uncertain again, and the rate is reset.
//! * A step of the drive also excites resonances that the observer does not know, which count as
//!   noise (`ringing`).
//! * A second integrator follows a steadily moving resonance, after the frequency has settled.
//! * Without drive the ring-down is measured as long as it lasts; then only the deviation grows.
//!
//! The same equation gives detuning and half bandwidth of superconducting cavities.

mod readings;
mod restart;
mod ringing;

use crate::generate::shape::sine;
use crate::seam::compare::{larger, smaller};
use crate::seam::phasor::Phasor;
pub use crate::track::tracker::observer::readings::Spread;
use crate::track::tracker::observer::ringing::Ringing;
pub use crate::track::tracker::prior::Prior;

const TAU: f32 = core::f32::consts::TAU;
/// 2^32 as a float: steps of the sine table's phase in one turn.
const STEPS_PER_TURN: f32 = 4_294_967_296.0;
/// Random walk of the resonance: deviation after one second, relative to the frequency. The damping
/// likewise.
const WANDER_REL: f32 = 6e-4;
/// Part of the change of the current within a block that counts as noise: it leaks into the phasor.
const LEAK_REL: f32 = 0.03;
/// Number of blocks after a start or an opening of the gate until the gate is armed.
const ARM_BLOCKS: u32 = 16;
/// Smallest relative deviation of the inductance at the start.
const MIN_LM_DEVIATION_REL: f32 = 2e-3;
/// Relative deviation of the inductance below which it is no longer learned: its row of the
/// covariance is half of the work.
const LM_KNOWN_REL: f32 = 5e-3;
/// Error of the model, relative to the current.
const MODEL_ERROR_REL: f32 = 5e-4;
/// Current below which a block without drive is silent, standard deviations of its noise.
const SILENT_SIGMAS: f32 = 8.0;
/// Largest relative change of the voltage per block for which the drive counts as steady.
const STEADY_VOLTAGE_REL: f32 = 0.02;
/// Factor by which the estimate may exceed the bounds of the prior, and later the window.
const WINDOW_FACTOR: f32 = 1.5;
/// Smallest real part of the pole, `-alpha T`: Q = 2.
const MIN_POLE_RE: f32 = -1.5;
/// Largest real part of the pole, `-alpha T`: a slightly unstable resonance.
const MAX_POLE_RE: f32 = 0.02;
/// Information of a block, relative to the loss by [`WANDER_REL`], below which the frequency has
/// settled.
const SETTLED_INFORMATION: f32 = 2.0;
/// Gain of the second integrator: critical damping.
const RATE_GAIN: f32 = 0.25;
/// Number of blocks from the measured block to the one that is decided now.
const AHEAD_BLOCKS: f32 = crate::seam::block::LATENCY_BLOCKS as f32;

/// Drive played in a block, as the observer needs it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Played {
    /// Frequency, as an offset from the nominal one, Hz.
    pub offset_hz: f32,
    /// Peak voltage times envelope, V, if the envelope was constant throughout the block.
    pub steady_v: Option<f32>,
}

/// Observer of the resonance: an extended Kalman filter of the motional current.
#[derive(Clone, Debug)]
pub struct Observer {
    nominal_hz: f32,
    block_s: f32,
    /// Phase of 1 Hz in half a block, 2^32 per turn.
    half_block_per_hz: f32,
    /// Frequency of one radian per block, Hz.
    hz_per_radian: f32,
    /// Radians per block of 1 Hz.
    radian_per_hz: f32,
    wander: f32,
    /// Largest distance of the pole from the nominal frequency, rad per block: of the prior until
    /// the frequency has settled, then of the drive.
    window: f32,
    widest: f32,
    /// Noise variance of a block's phasor, A².
    noise: f32,
    /// Nominal inductance, H.
    lm_h: f32,
    /// `2 Lm / T`, ohm.
    ohm_per_pole: f32,
    /// Nominal `beta T`, along the axis of the sensing chain, A/V.
    nominal_strength: Phasor,
    current: Phasor,
    /// `(-alpha + j (w0 - wn)) T`.
    pole: Phasor,
    /// `beta`, relative to its nominal value.
    strength: f32,
    /// Drift of the pole, rad per block².
    rate: f32,
    covariance: Covariance,
    voltage: Phasor,
    played: Played,
    ringing: Ringing,
    /// Blocks since a start or since the gate opened.
    calm: u32,
}

/// Covariance of current, pole and strength: upper triangle.
#[derive(Clone, Copy, Debug, Default)]
struct Covariance {
    current: f32,
    current_pole: Phasor,
    current_strength: Phasor,
    pole: f32,
    pole_strength: Phasor,
    strength: f32,
}

impl Observer {
    /// Creates an observer within ± `window_hz` of `nominal_hz`, with a block every `block_s`
    /// seconds.
    pub fn new(nominal_hz: f32, block_s: f32, window_hz: f32) -> Self {
        let wander = TAU * WANDER_REL * nominal_hz * block_s;
        Observer {
            nominal_hz,
            block_s,
            half_block_per_hz: 0.5 * block_s * STEPS_PER_TURN,
            hz_per_radian: 1.0 / (TAU * block_s),
            radian_per_hz: TAU * block_s,
            wander: 2.0 * wander * wander * block_s,
            window: 0.0,
            widest: WINDOW_FACTOR * TAU * window_hz * block_s,
            noise: 1.0,
            lm_h: 1.0,
            ohm_per_pole: 0.0,
            nominal_strength: Phasor::new(0.0, 0.0),
            current: Phasor::new(0.0, 0.0),
            pole: Phasor::new(0.0, 0.0),
            strength: 1.0,
            rate: 0.0,
            covariance: Covariance::default(),
            voltage: Phasor::new(0.0, 0.0),
            played: Played { offset_hz: 0.0, steady_v: None },
            ringing: Ringing::default(),
            calm: 0,
        }
    }

    /// Starts from a prior. The current of the resonance is unknown.
    pub fn start(&mut self, prior: &Prior) {
        let (offset_hz, spread_hz) = prior.offset_hz;
        let spread = TAU * spread_hz * self.block_s;
        self.window = self.window.max(offset_hz.abs() * TAU * self.block_s + WINDOW_FACTOR * spread);
        self.noise = prior.noise_a * prior.noise_a;
        let (lm_h, deviation) = prior.lm_h;
        let spread_of_strength = larger(deviation / lm_h, MIN_LM_DEVIATION_REL);
        self.lm_h = lm_h;
        self.ohm_per_pole = 2.0 * lm_h / self.block_s;
        self.nominal_strength = prior.axis * (self.block_s / (2.0 * lm_h));
        self.pole = Phasor::new((-self.decay_of(prior.q)).max(MIN_POLE_RE), TAU * offset_hz * self.block_s);
        self.strength = 1.0;
        self.rate = 0.0;
        self.covariance =
            Covariance { pole: spread * spread, strength: spread_of_strength * spread_of_strength, ..Covariance::default() };
        self.played = Played { offset_hz, steady_v: None };
        self.voltage = Phasor::new(0.0, 0.0);
        self.ringing.rest();
        self.calm = 0;
    }

    /// Discards the ringing of another transducer.
    pub(crate) fn restart(&mut self) {
        self.ringing = Ringing::default();
    }

    /// Updates the filter with one block: motional current and voltage, both peak and relative to
    /// the drive's phase, and the drive played in it.
    #[inline]
    pub fn follow(&mut self, current: Phasor, voltage: Phasor, played: Played) {
        let before = core::mem::replace(&mut self.played, played);
        let before_v = core::mem::replace(&mut self.voltage, voltage);
        let mean_v = (before_v + voltage) * 0.5;
        let same = |(now, then): (f32, f32)| (now - then).abs() <= STEADY_VOLTAGE_REL * larger(now, then);
        self.calm = self.calm.saturating_add(1);
        let silent = played.steady_v == Some(0.0) && self.is_silent(current);
        if silent || !played.steady_v.zip(before.steady_v).is_some_and(same) {
            // In silence the phase is only noise; at an edge the block before does not predict this
            // one.
            return self.begin(current, before_v);
        }

        // Predicted current.
        let half = self.half_block(0.5 * (before.offset_hz + played.offset_hz));
        let a = half * half;
        let per_strength = half * mean_v * self.nominal_strength;
        let driven = per_strength * self.strength;
        let per_pole = a * self.current + driven * 0.5;
        let expected = a * self.current + driven;

        // Variance of the prediction: the rows of `F P` (of the first, only its part of the sum),
        // then `F P F^H`.
        let p = self.covariance;
        let turned_pole = a * p.current_pole;
        let mut row_pole = turned_pole + per_pole * p.pole;
        let mut variance = a.norm_sqr() * p.current;
        let learns = p.strength > LM_KNOWN_REL * LM_KNOWN_REL;
        let row_strength = if learns {
            let turned_strength = a * p.current_strength;
            row_pole += per_strength * p.pole_strength.conj();
            let row = turned_strength + per_pole * p.pole_strength + per_strength * p.strength;
            variance += dot(turned_strength + row, per_strength);
            row
        } else {
            Phasor::new(0.0, 0.0)
        };
        variance += dot(turned_pole + row_pole, per_pole);

        let moved = (current - self.current).norm_sqr();
        let noise = self.noise + LEAK_REL * LEAK_REL * moved + MODEL_ERROR_REL * MODEL_ERROR_REL * current.norm_sqr();
        let innovation = current - expected;
        let noise = noise + self.ringing.variance();
        let total = variance + noise;
        if self.exceeds_gate(innovation, total) {
            self.ringing.take(innovation.norm_sqr(), total, a.norm_sqr(), self.calm);
            return self.open(current, noise);
        }

        let part = 1.0 / total;
        let retained = noise * part;
        let gain_pole = row_pole.conj() * part;
        let correction = gain_pole * innovation;
        let learned = row_pole.norm_sqr() * part;
        self.current = current - innovation * retained;
        self.pole += correction;
        self.covariance = Covariance {
            current: variance * retained,
            current_pole: row_pole * retained,
            pole: larger(p.pole - learned, 0.0) + self.wander,
            ..p
        };
        if learns {
            self.strength += dot(innovation, row_strength) * part;
            self.covariance.current_strength = row_strength * retained;
            self.covariance.pole_strength -= gain_pole * row_strength;
            self.covariance.strength = larger(p.strength - row_strength.norm_sqr() * part, 0.0);
        }
        // A ring-down has too little information for a rate, which would keep moving the estimate
        // in the silence after it.
        let driven = played.steady_v.is_some_and(|volts| volts > 0.0);
        if driven && self.calm > ARM_BLOCKS && learned < SETTLED_INFORMATION * self.wander {
            let weight = dot(gain_pole.conj(), per_pole).clamp(0.0, 1.0);
            self.rate += RATE_GAIN * weight * correction.im;
            self.window = self.widest;
        }
        // A value that is not a number becomes the lower bound.
        let within = |x: f32, least: f32, most: f32| smaller(larger(x, least), most);
        self.pole = Phasor::new(within(self.pole.re, MIN_POLE_RE, MAX_POLE_RE), self.pole.im + self.rate);
        let inside = self.pole.im.abs() <= self.window;
        if !inside {
            self.pole.im = within(self.pole.im, -self.window, self.window);
            self.rate = 0.0;
        }
        if self.ringing.listens() {
            self.ringing.take(innovation.norm_sqr(), total, a.norm_sqr(), self.calm);
        }
    }

    /// Returns `exp((-alpha + j (w0 - w)) T / 2)` for a drive at `offset_hz` from the nominal
    /// frequency.
    fn half_block(&self, offset_hz: f32) -> Phasor {
        let steps = (self.offset_hz() - offset_hz) * self.half_block_per_hz;
        let x = 0.5 * self.pole.re;
        let size = 1.0 + x * (1.0 + x * (0.5 + x * (1.0 / 6.0 + x * (1.0 / 24.0 + x * (1.0 / 120.0)))));
        sine::rotation(u64::from(steps as i32 as u32) << 32) * size
    }
}

/// Returns the real part of `x` times the conjugate of `y`.
#[inline]
fn dot(x: Phasor, y: Phasor) -> f32 {
    x.re * y.re + x.im * y.im
}

#[cfg(test)]
mod tests;
