//! Detuning observer: the resonance from how the motional current changes, block by block. It does not wait for the ring-up.
//!
//! In the frame of the drive (`w`), the envelope of the motional current of a resonance at `w0` obeys
//!
//! ```text
//! Im' = -(alpha + j (w - w0)) Im + beta V,    alpha = Rm / (2 Lm),    beta = 1 / (2 Lm)
//! ```
//!
//! which over a block of `T`, from the middle of one to the middle of the next, is
//!
//! ```text
//! Im[k + 1] = a Im[k] + sqrt(a) b V,    a = exp((-alpha + j (w0 - w)) T),    b = beta T
//! ```
//!
//! to second order in `(w0 - w) T`. A Kalman filter (R. E. Kalman 1960; extended, because `a` multiplies `Im`) follows three unknowns: `Im`,
//! `p = (-alpha + j (w0 - wn)) T` about the nominal frequency, and, as long as it is not known well, how `b` compares with its nominal value. `Im` and
//! `p` are complex, and everything is analytic in them, so that each has one complex row of the covariance; `b` is real up to the axis of the sensing
//! chain, and takes the real part of its correction. While the current builds up, its curvature shows the detuning; once it is steady, its phase does: the filter's weights
//! go from one to the other by themselves.
//!
//! * Noise is that of the converters, which is measured beforehand, with what an envelope that changes within a block leaks into its phasor, and
//!   with what the model may err by.
//! * An innovation of more than five deviations is no noise: the load has jumped. The **gate** opens: frequency and damping may be anything
//!   nearby again, and the rate is forgotten.
//! * A second integrator follows a resonance that moves steadily, but not before the frequency has settled.
//! * Without drive the ring-down is measured while there is any, and then only the deviation grows.
//!
//! The same equation gives detuning and half bandwidth of superconducting cavities.

mod readings;

use crate::generate::shape::sine;
use crate::seam::compare::{larger, smaller};
use crate::seam::phasor::Phasor;
pub use crate::track::tracker::observer::readings::Spread;
pub use crate::track::tracker::prior::Prior;

const TAU: f32 = core::f32::consts::TAU;
/// 2^32 as a number.
const STEPS_PER_TURN: f32 = 4_294_967_296.0;
/// How the resonance may wander: after a second its deviation is this part of the frequency. The damping likewise.
const WANDER: f32 = 6e-4;
/// A change of the envelope within a block leaks into its phasor; this part of it counts as noise.
const LEAK: f32 = 0.03;
/// Innovation, in deviations, beyond which it is no noise.
const GATE: f32 = 5.0;
/// Blocks after a start or a jump before the gate is armed.
const ARMED: u32 = 16;
/// What the gate opens to, Hz at a nominal frequency of 40 kHz.
const OPENS: f32 = 300.0 / 40e3;
/// How well the inductance is known at best, relative.
const KNOWN_AT_BEST: f32 = 2e-3;
/// Deviation of the inductance, relative, from which on there is nothing to learn of it: its row of the covariance is half of the work.
const KNOWN: f32 = 5e-3;
/// The model holds to this part of the current.
const MODEL: f32 = 5e-4;
/// A current below so many deviations of its noise is none.
const SILENT: f32 = 8.0;
/// The drive is the same as long as its voltage changes by no more than this part a block.
const SAME: f32 = 0.02;
/// By how much the estimate may pass the bounds of the prior, on its way.
const WINDOW: f32 = 1.5;
/// Range of the damping, `-alpha T`: from Q = 2 to a resonance that drives itself.
const DAMPING: (f32, f32) = (-1.5, 0.02);
/// The frequency has settled when the information of a block is no more than this times what a block forgets.
const SETTLED: f32 = 2.0;
/// Damping of the second integrator: critical.
const RATE: f32 = 0.25;
/// From the measured block to the one that is decided on.
const AHEAD_BLOCKS: f32 = crate::seam::block::LATENCY_BLOCKS as f32;

/// What was played in a block, as the observer needs it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Played {
    /// Frequency, as an offset from the nominal one, Hz.
    pub offset_hz: f32,
    /// Peak voltage times envelope, V, where the envelope was the same throughout.
    pub steady_v: Option<f32>,
}

/// The observer of the resonance: an extended Kalman filter of the motional current.
#[derive(Clone, Debug)]
pub struct Observer {
    nominal_hz: f32,
    block_s: f32,
    /// Half a block's phase of a hertz, 2^32 a turn.
    half_block_per_hz: f32,
    /// What a block's radian is, and one over it, Hz.
    hz_per_radian: f32,
    radian_per_hz: f32,
    wander: f32,
    /// How far the pole may be from the nominal frequency.
    window: f32,
    /// Variance of a block's phasor by noise alone, A².
    noise: f32,
    /// Nominal inductance, H; and twice that by the block, ohm.
    lm_h: f32,
    ohm_per_pole: f32,
    /// Nominal `beta T`, along the axis of the sensing chain, A/V.
    nominal_strength: Phasor,
    current: Phasor,
    /// `(-alpha + j (w0 - wn)) T`.
    pole: Phasor,
    /// `beta`, relative to its nominal value.
    strength: f32,
    /// How far the pole moves in a block.
    rate: f32,
    covariance: Covariance,
    voltage: Phasor,
    played: Played,
    /// Blocks since a start, a jump of the drive, or the gate.
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
    /// An observer about `nominal_hz`, with a block every `block_s` seconds.
    pub fn new(nominal_hz: f32, block_s: f32) -> Self {
        let wander = TAU * WANDER * nominal_hz * block_s;
        Observer {
            nominal_hz,
            block_s,
            half_block_per_hz: 0.5 * block_s * STEPS_PER_TURN,
            hz_per_radian: 1.0 / (TAU * block_s),
            radian_per_hz: TAU * block_s,
            wander: 2.0 * wander * wander * block_s,
            window: 0.0,
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
            calm: 0,
        }
    }

    /// Begins with what is known. The next blocks are of a resonance whose current may be anything.
    pub fn start(&mut self, prior: &Prior) {
        let (offset_hz, spread_hz) = prior.offset_hz;
        let spread = TAU * spread_hz * self.block_s;
        self.window = self.window.max(offset_hz.abs() * TAU * self.block_s + WINDOW * spread);
        self.noise = prior.noise_a * prior.noise_a;
        let (lm_h, deviation) = prior.lm_h;
        let spread_of_strength = larger(deviation / lm_h, KNOWN_AT_BEST);
        self.lm_h = lm_h;
        self.ohm_per_pole = 2.0 * lm_h / self.block_s;
        self.nominal_strength = prior.axis * (self.block_s / (2.0 * lm_h));
        self.pole = Phasor::new((-self.decay_of(prior.q)).max(DAMPING.0), TAU * offset_hz * self.block_s);
        self.strength = 1.0;
        self.rate = 0.0;
        self.covariance =
            Covariance { pole: spread * spread, strength: spread_of_strength * spread_of_strength, ..Covariance::default() };
        self.played = Played { offset_hz, steady_v: None };
        self.calm = 0;
    }

    /// Takes the motional current and the voltage of a block, both peak and against the drive's own phase, and what was played in it.
    #[inline]
    pub fn follow(&mut self, current: Phasor, voltage: Phasor, played: Played) {
        let before = core::mem::replace(&mut self.played, played);
        let mean_v = (core::mem::replace(&mut self.voltage, voltage) + voltage) * 0.5;
        let same = |(now, then): (f32, f32)| (now - then).abs() <= SAME * larger(now, then);
        self.calm = self.calm.saturating_add(1);
        let silent = played.steady_v == Some(0.0) && current.norm_sqr() < SILENT * SILENT * self.noise;
        if silent || !played.steady_v.zip(before.steady_v).is_some_and(same) {
            // Noise, whose turns would be taken for those of a current; or an edge of the drive, where nothing follows from the block before.
            let grows = (self.nominal_strength * voltage).norm_sqr();
            return self.jump(current, self.noise + LEAK * LEAK * grows);
        }

        // Where the model says the current is now.
        let half = self.half_block(0.5 * (before.offset_hz + played.offset_hz));
        let a = half * half;
        let per_strength = half * mean_v * self.nominal_strength;
        let driven = per_strength * self.strength;
        let per_pole = a * self.current + driven * 0.5;
        let expected = a * self.current + driven;

        // How well it says so: the rows of `F P` (of the first, only what all of it adds), then `F P F^H`.
        let p = self.covariance;
        let turned_pole = a * p.current_pole;
        let mut row_pole = turned_pole + per_pole * p.pole;
        let mut variance = a.norm_sqr() * p.current;
        let learns = p.strength > KNOWN * KNOWN;
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
        let noise = self.noise + LEAK * LEAK * moved + MODEL * MODEL * current.norm_sqr();
        let total = variance + noise;
        let innovation = current - expected;
        if self.is_surprised(innovation, total) {
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
        // A ring-down has too little information for a rate that would go on when nothing is measured any more.
        let driven = played.steady_v.is_some_and(|volts| volts > 0.0);
        if driven && self.calm > ARMED && learned < SETTLED * self.wander {
            let weight = dot(gain_pole.conj(), per_pole).clamp(0.0, 1.0);
            self.rate += RATE * weight * correction.im;
        }
        // What is no number goes to the lower end.
        let within = |x: f32, least: f32, most: f32| smaller(larger(x, least), most);
        self.pole =
            Phasor::new(within(self.pole.re, DAMPING.0, DAMPING.1), within(self.pole.im + self.rate, -self.window, self.window));
    }

    /// `exp((-alpha + j (w0 - w)) T / 2)` at a drive `offset_hz` beside the nominal frequency.
    fn half_block(&self, offset_hz: f32) -> Phasor {
        let steps = (self.offset_hz() - offset_hz) * self.half_block_per_hz;
        let x = 0.5 * self.pole.re;
        let size = 1.0 + x * (1.0 + x * (0.5 + x * (1.0 / 6.0 + x * (1.0 / 24.0 + x * (1.0 / 120.0)))));
        sine::rotation(u64::from(steps as i32 as u32) << 32) * size
    }

    /// Forgets how the current has come about.
    #[inline(never)]
    fn jump(&mut self, current: Phasor, variance: f32) {
        self.current = current;
        self.covariance = Covariance {
            current: variance,
            current_pole: Phasor::new(0.0, 0.0),
            current_strength: Phasor::new(0.0, 0.0),
            pole: self.covariance.pole + self.wander,
            ..self.covariance
        };
        self.rate = 0.0;
    }

    /// Whether an innovation with this variance is no noise: the gate opens, where it is armed.
    #[inline]
    fn is_surprised(&self, innovation: Phasor, variance: f32) -> bool {
        self.calm > ARMED && innovation.norm_sqr() > GATE * GATE * variance
    }

    /// The gate opens.
    #[inline(never)]
    fn open(&mut self, current: Phasor, noise: f32) {
        self.jump(current, 4.0 * noise);
        let spread = TAU * OPENS * self.nominal_hz * self.block_s;
        self.covariance.pole = self.covariance.pole.max(spread * spread);
        self.covariance.pole_strength = Phasor::new(0.0, 0.0);
        self.calm = 0;
    }
}

/// Real part of `x` times the conjugate of `y`.
#[inline]
fn dot(x: Phasor, y: Phasor) -> f32 {
    x.re * y.re + x.im * y.im
}

#[cfg(test)]
mod tests;
