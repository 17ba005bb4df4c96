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
//! `p = (-alpha + j (w0 - wn)) T` about the nominal frequency, and how `b` compares with what was told. `Im` and `p` are complex, and everything is
//! analytic in them, so that each has one complex row of the covariance; `b` is real up to the axis of the sensing chain, and takes the real
//! part of its correction. While the current builds up, its curvature tells the detuning; once it stands, its phase does: the filter's weights
//! go from one to the other by themselves.
//!
//! * Noise is that of the converters, which is measured beforehand, with what an envelope that changes within a block leaks into its phasor, and
//!   with what the model may err by.
//! * An innovation of more than five deviations is no noise: the load has jumped. The **gate** opens: frequency and damping may be anything
//!   nearby again, and the rate is forgotten.
//! * A second integrator follows a resonance that moves steadily, but not before the frequency has settled.
//! * Without drive nothing special happens: the ring-down is heard while there is any, and then only the deviation grows.
//!
//! The same idea tells the detuning of superconducting cavities, with exponential forgetting in place of the filter (e.g. R. Rybaniec et al.
//! 2017); the study behind this controller took 0.5 ms that way.

use crate::phasor::Phasor;
use crate::shape::sine;

const TAU: f32 = core::f32::consts::TAU;
/// 2^32 as a number.
const STEPS_PER_TURN: f32 = 4_294_967_296.0;
/// How the resonance may wander: after a second its deviation is this part of the frequency. The damping likewise.
const WANDER: f32 = 5e-4;
/// A change of the envelope within a block leaks into its phasor; this part of it counts as noise.
const LEAK: f32 = 0.03;
/// Innovation, in deviations, beyond which it is no noise.
const GATE: f32 = 5.0;
/// Blocks after a start or a jump before the gate is armed.
const ARMED: u32 = 16;
/// What the gate opens to, Hz at a nominal frequency of 40 kHz.
const OPENS: f32 = 300.0 / 40e3;
/// How well the inductance is known that was told.
const TOLD: f32 = 0.1;
/// Smallest variance of what has been learned of it, so that its row stays regular.
const LEARNED: f32 = 1e-8;
/// The model holds to this part of the current.
const MODEL: f32 = 5e-4;
/// The drive is the same as long as its voltage changes by no more than this part a block.
const SAME: f32 = 0.02;
/// The estimate may pass what was told by so much, on its way.
const WINDOW: f32 = 1.5;
/// Range of the damping, `-alpha T`: from Q = 2 to a resonance that drives itself.
const DAMPING: (f32, f32) = (-1.5, 0.02);
/// The frequency has settled when a block tells no more than this times what a block forgets.
const SETTLED: f32 = 2.0;
/// Damping of the second integrator: critical.
const RATE: f32 = 0.25;
/// From the block that is heard to the one that is decided on.
const AHEAD_BLOCKS: f32 = crate::block::LATENCY_BLOCKS as f32;

/// What was played in a block, as the observer needs it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Played {
    /// Frequency, as an offset from the nominal one, Hz.
    pub offset_hz: f32,
    /// Peak voltage times envelope, V, where the envelope was the same throughout.
    pub steady_v: Option<f32>,
}

/// The observer.
#[derive(Clone, Debug)]
pub struct Observer {
    nominal_hz: f32,
    block_s: f32,
    /// Half a block's phase of a hertz, 2^32 a turn.
    half_block_per_hz: f32,
    wander: f32,
    /// How far the pole may be from the nominal frequency.
    window: f32,
    /// Variance of a block's phasor by noise alone, A².
    noise: f32,
    /// Inductance as told, H.
    lm_h: f32,
    /// `beta T` as told, along the axis of the sensing chain, A/V.
    told: Phasor,
    current: Phasor,
    /// `(-alpha + j (w0 - wn)) T`.
    pole: Phasor,
    /// `beta`, relative to what was told.
    strength: f32,
    /// How far the pole moves in a block.
    rate: f32,
    covariance: Covariance,
    voltage: Phasor,
    played: Played,
    /// Blocks since a start, a jump of the drive, or the gate.
    calm: u32,
    /// Times the gate has opened.
    opened: u32,
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

/// What is known before the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior {
    /// Offset from the nominal frequency, Hz, and how far off that may be.
    pub offset_hz: (f32, f32),
    /// Quality factor, within a factor of two.
    pub q: f32,
    /// Motional inductance, H.
    pub lm_h: f32,
    /// Direction of the motional admittance at resonance.
    pub axis: Phasor,
    /// Rms of a block's motional current by noise, A, both components.
    pub noise_a: f32,
}

impl Observer {
    /// An observer about `nominal_hz`, told a block every `block_s` seconds.
    pub fn new(nominal_hz: f32, block_s: f32) -> Self {
        let wander = TAU * WANDER * nominal_hz * block_s;
        Observer {
            nominal_hz,
            block_s,
            half_block_per_hz: 0.5 * block_s * STEPS_PER_TURN,
            wander: 2.0 * wander * wander * block_s,
            window: 0.0,
            noise: 1.0,
            lm_h: 1.0,
            told: Phasor::new(0.0, 0.0),
            current: Phasor::new(0.0, 0.0),
            pole: Phasor::new(0.0, 0.0),
            strength: 1.0,
            rate: 0.0,
            covariance: Covariance::default(),
            voltage: Phasor::new(0.0, 0.0),
            played: Played { offset_hz: 0.0, steady_v: None },
            calm: 0,
            opened: 0,
        }
    }
    /// Begins with what is known. The next blocks are of a resonance whose current may be anything.
    pub fn start(&mut self, prior: &Prior) {
        let (offset_hz, spread_hz) = prior.offset_hz;
        let spread = TAU * spread_hz * self.block_s;
        self.window = self.window.max(offset_hz.abs() * TAU * self.block_s + WINDOW * spread);
        self.noise = prior.noise_a * prior.noise_a;
        self.lm_h = prior.lm_h;
        self.told = prior.axis * (self.block_s / (2.0 * prior.lm_h));
        let damping = -core::f32::consts::PI * self.nominal_hz / prior.q * self.block_s;
        self.pole = Phasor::new(damping.max(DAMPING.0), TAU * offset_hz * self.block_s);
        self.strength = 1.0;
        self.rate = 0.0;
        self.covariance = Covariance { pole: spread * spread, strength: TOLD * TOLD, ..Covariance::default() };
        self.played = Played { offset_hz, steady_v: None };
        self.calm = 0;
    }

    /// Takes the motional current and the voltage of a block, both peak and against the drive's own phase, and what was played in it.
    pub fn follow(&mut self, current: Phasor, voltage: Phasor, played: Played) {
        let before = core::mem::replace(&mut self.played, played);
        let mean_v = (core::mem::replace(&mut self.voltage, voltage) + voltage) * 0.5;
        let same = |(now, then): (f32, f32)| (now - then).abs() <= SAME * now.max(then);
        self.calm = self.calm.saturating_add(1);
        if !played.steady_v.zip(before.steady_v).is_some_and(same) {
            // An edge of the drive: nothing follows from the block before.
            let grows = (self.told * voltage).norm_sqr();
            return self.jump(current, self.noise + LEAK * LEAK * grows);
        }

        // Where the model says the current is now.
        let half = self.half_block(0.5 * (before.offset_hz + played.offset_hz));
        let a = half * half;
        let per_strength = half * mean_v * self.told;
        let driven = per_strength * self.strength;
        let per_pole = a * self.current + driven * 0.5;
        let expected = a * self.current + driven;

        // How well it says so: the rows of `F P`, then `F P F^H`.
        let p = self.covariance;
        let row_current = a * p.current + per_pole * p.current_pole.conj() + per_strength * p.current_strength.conj();
        let row_pole = a * p.current_pole + per_pole * p.pole + per_strength * p.pole_strength.conj();
        let row_strength = a * p.current_strength + per_pole * p.pole_strength + per_strength * p.strength;
        let variance = dot(row_current, a) + dot(row_pole, per_pole) + dot(row_strength, per_strength);

        let moved = (current - self.current).norm_sqr();
        let noise = self.noise + LEAK * LEAK * moved + MODEL * MODEL * current.norm_sqr();
        let total = variance + noise;
        let innovation = current - expected;
        let surprise = innovation.norm_sqr() / total;
        if surprise > GATE * GATE && self.calm > ARMED {
            return self.open(current, noise);
        }

        let gain_pole = row_pole.conj() * (1.0 / total);
        let correction = gain_pole * innovation;
        let told = row_pole.norm_sqr() / total;
        self.current = expected + innovation * (variance / total);
        self.pole += correction;
        self.strength += dot(innovation, row_strength) / total;
        self.covariance = Covariance {
            current: variance * (noise / total),
            current_pole: row_pole * (noise / total),
            current_strength: row_strength * (noise / total),
            pole: (p.pole - told).max(0.0) + self.wander,
            pole_strength: p.pole_strength - row_pole.conj() * row_strength * (1.0 / total),
            strength: (p.strength - row_strength.norm_sqr() / total).max(LEARNED),
        };
        if self.calm > ARMED && told < SETTLED * self.wander {
            let weight = dot(gain_pole.conj(), per_pole).clamp(0.0, 1.0);
            self.rate += RATE * weight * correction.im;
        }
        self.pole =
            Phasor::new(self.pole.re.clamp(DAMPING.0, DAMPING.1), (self.pole.im + self.rate).clamp(-self.window, self.window));
    }

    /// `exp((-alpha + j (w0 - w)) T / 2)` at a drive `offset_hz` beside the nominal frequency.
    fn half_block(&self, offset_hz: f32) -> Phasor {
        let steps = (self.offset_hz() - offset_hz) * self.half_block_per_hz;
        let x = 0.5 * self.pole.re;
        let size = 1.0 + x * (1.0 + x * (0.5 + x * (1.0 / 6.0 + x * (1.0 / 24.0 + x * (1.0 / 120.0)))));
        sine::rotation(u64::from(steps as i32 as u32) << 32) * size
    }

    /// Forgets how the current has come about.
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

    /// The gate opens.
    fn open(&mut self, current: Phasor, noise: f32) {
        self.jump(current, 4.0 * noise);
        let spread = TAU * OPENS * self.nominal_hz * self.block_s;
        self.covariance.pole = self.covariance.pole.max(spread * spread);
        self.covariance.pole_strength = Phasor::new(0.0, 0.0);
        self.calm = 0;
        self.opened = self.opened.wrapping_add(1);
    }

    /// The resonance, as an offset from the nominal frequency, Hz.
    pub fn offset_hz(&self) -> f32 {
        self.pole.im / (TAU * self.block_s)
    }

    /// Where the resonance will be when the block plays that is decided on now, as an offset from the nominal frequency, Hz.
    pub fn ahead_hz(&self) -> f32 {
        (self.pole.im + AHEAD_BLOCKS * self.rate) / (TAU * self.block_s)
    }

    /// Standard deviation of the resonance, Hz.
    pub fn deviation_hz(&self) -> f32 {
        libm::sqrtf(0.5 * self.covariance.pole) / (TAU * self.block_s)
    }

    /// Whether the deviation of the resonance is below `hz`.
    pub fn is_within(&self, hz: f32) -> bool {
        let bound = TAU * self.block_s * hz;
        self.covariance.pole < 2.0 * bound * bound
    }

    /// Damping `alpha`, 1/s.
    pub fn damping(&self) -> f32 {
        -self.pole.re / self.block_s
    }

    /// Motional inductance, H.
    pub fn lm_h(&self) -> f32 {
        self.lm_h / self.strength.max(1e-3)
    }

    /// Standard deviation of the inductance, relative.
    pub fn strength_deviation(&self) -> f32 {
        libm::sqrtf(self.covariance.strength)
    }

    /// Forgets that the resonance moves. After every block of a study this shows what the second integrator is good for.
    pub fn forget_rate(&mut self) {
        self.rate = 0.0;
    }

    /// Times the gate has opened; wraps.
    pub fn opened(&self) -> u32 {
        self.opened
    }
}

/// Real part of `x` times the conjugate of `y`.
#[inline]
fn dot(x: Phasor, y: Phasor) -> f32 {
    x.re * y.re + x.im * y.im
}
