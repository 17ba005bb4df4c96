//! How a burst's edges are prepared: the brake of a plain burst, and the strokes of a boosted one.
//!
//! Strokes are planned from what is known in place: the resonance's damping and inductance, which the tracker has identified; what the
//! [source](crate::source) adds to the damping; and what rings, by the motional current that was heard last. The steady current of a drive of one
//! volt is then `S = beta g / a`, `a = alpha + Re(beta z)`, and what rings, as the drive that would hold it, is `R = Re(I_m / S)`.

use super::follow::LEARN_BLOCKS;
use super::{Controller, Played};
use crate::block::{Gate, LATENCY_BLOCKS, Orders};
use crate::burst::Brake;
use crate::burst::stroke::Planner;
use crate::config::{Config, Edge, ShapeKind, Sweep, TrackingMode};
use crate::demod::Sensed;
use crate::error::Error;
use crate::phasor::Phasor;
use crate::source::Source;
use crate::supervisor::Mode;
use crate::tracker::compare::{larger, smaller};

/// How often strokes are made anew, blocks.
const RENEW_BLOCKS: u64 = 64;
/// Of a steady drive, one block of so many is listened to for the source.
const STEADY: u64 = 8;
/// Part of the current limit that an edge may draw: steps of the converter draw more than their fundamental.
const CURRENT: f32 = 0.85;
/// A drive further from the resonance than this part of the half bandwidth is not boosted.
const BESIDE: f32 = 0.1;

/// What a block of a boosted burst tells.
#[derive(Clone, Copy, Debug)]
pub(super) struct Told {
    /// What it drives had rung up before.
    pub(super) rung_up: bool,
    /// It tells the tracker something.
    pub(super) telling: bool,
    /// Nothing was paid back in it.
    even: bool,
}

impl Told {
    /// Of a plain burst.
    const PLAIN: Told = Told { rung_up: false, telling: true, even: true };
}

/// What is known for boosted edges.
#[derive(Clone, Debug)]
pub(super) struct Edges {
    source: Source,
    /// `1 / S`, V/A.
    per_ampere: Option<Phasor>,
    sample_hz: f32,
    planned: u64,
    stage: Stage,
    told: [Told; LATENCY_BLOCKS],
    /// Nothing is owed after the last block.
    even: bool,
}

/// How far the next strokes are planned, a part a block.
#[derive(Clone, Copy, Debug)]
enum Stage {
    Idle,
    /// The rate, 1/s.
    Ceiling(f32),
    Strokes(Planner),
}

impl Edges {
    pub(super) fn build(config: &Config) -> Self {
        Edges {
            source: Source::default(),
            per_ampere: None,
            sample_hz: config.sample_hz,
            planned: 0,
            stage: Stage::Idle,
            told: [Told::PLAIN; LATENCY_BLOCKS],
            even: true,
        }
    }

    /// Whether nothing is being planned.
    pub(super) fn are_idle(&self) -> bool {
        matches!(self.stage, Stage::Idle)
    }

    /// Forgets the transducer. The source is what it was.
    pub(super) fn restart(&mut self) {
        (self.per_ampere, self.stage) = (None, Stage::Idle);
    }
}

/// Whether edges can be what they are asked to be.
pub(super) fn check(config: &Config) -> Result<(), Error> {
    let tracked = matches!(config.tracking.mode, TrackingMode::Observer | TrackingMode::PhaseLock);
    match () {
        () if config.burst.edge != Edge::Boost => Ok(()),
        () if config.drive.shape != ShapeKind::Sine => Err(Error::BoostOfShape),
        () if config.sweep != Sweep::Hold => Err(Error::BoostWithSweep),
        () if !tracked => Err(Error::BoostWithoutTracking),
        () => Ok(()),
    }
}

impl Controller {
    /// What the block that is heard tells.
    #[inline]
    pub(super) fn told(&self, boosts: bool) -> Told {
        if boosts { self.edges.told[(self.block % LATENCY_BLOCKS as u64) as usize] } else { Told::PLAIN }
    }

    /// Notes what the block tells that has been written, of a drive of `volts` and this mean envelope.
    #[inline(never)]
    pub(super) fn note(&mut self, volts: f32, level: f32) {
        let (rung_up, telling) = (self.burst.was_rung_up(volts), self.burst.is_telling());
        let even = core::mem::replace(&mut self.edges.even, self.shaper.is_even()) || level != 0.0;
        self.edges.told[(self.block % LATENCY_BLOCKS as u64) as usize] = Told { rung_up, telling, even };
    }

    /// Prepares the boosted edge that may come next.
    #[inline(never)]
    pub(super) fn prepare_boost(&mut self, orders: &Orders, sensed: &Sensed, played: &Played, motional: Phasor) {
        if played.flat && played.pure && self.told(true).even {
            // Silence tells nothing but noise, and a steady drive little.
            if played.envelope > 1.0
                || played.envelope > 0.0 && (self.supervisor.mode() == Mode::Lock || self.block.is_multiple_of(STEADY))
            {
                self.edges.source.hear(played.volts * played.envelope, sensed.v, motional);
            }
            if let Some(per_ampere) = self.edges.per_ampere {
                self.burst.hear(motional.re * per_ampere.re - motional.im * per_ampere.im);
            }
        }
        if self.burst.is_under_way(orders.gate) {
            return;
        }
        self.braked_volts = self.amplitude.volts();
        let fresh = self.block - self.edges.planned < RENEW_BLOCKS && self.burst.fits(self.braked_volts);
        if fresh && matches!(self.edges.stage, Stage::Idle) {
            return;
        }
        // Planning has the blocks in which there is nothing else to do.
        let next = (self.block + LATENCY_BLOCKS as u64) * self.samples as u64;
        let learns = self.block - self.learned >= LEARN_BLOCKS - 1;
        if self.burst.turns_within(orders.gate, next, 2 * self.samples as u64) || learns && self.tracker.is_sure() {
            return;
        }
        match self.edges.stage {
            Stage::Idle => self.plan_rate(orders),
            Stage::Ceiling(rate) => self.plan_ceiling(rate),
            Stage::Strokes(mut planner) => match planner.step() {
                None => self.edges.stage = Stage::Strokes(planner),
                strokes => {
                    self.burst.set_strokes(strokes);
                    self.edges.stage = Stage::Idle;
                }
            },
        }
    }

    /// The rate by which what rings decays, and what a steady drive holds.
    fn plan_rate(&mut self, orders: &Orders) {
        let Some((lm_h, time_constant_s)) = self.transducer_by_now().map(|it| (it.lm_h, it.time_constant_s())) else { return };
        let Some((gain, impedance)) = self.edges.source.seen() else { return };
        let beta = self.tracker.branch().axis * (0.5 / lm_h);
        let rate = 1.0 / time_constant_s + (beta * impedance).re;
        let driven = beta * gain;
        self.edges.planned = self.block;
        let beside = (orders.detune.0 * core::f32::consts::TAU).abs() > BESIDE * rate;
        // No number is no rate.
        if rate > 0.0 && self.braked_volts > 0.0 && !beside {
            self.edges.per_ampere = Some(driven.conj() * (rate / driven.norm_sqr()));
            self.edges.stage = Stage::Ceiling(rate);
        } else {
            self.burst.set_strokes(None);
        }
    }

    /// The most that an edge may drive with: by the voltage limit, and by what the clamped branch draws beside the motional current.
    fn plan_ceiling(&mut self, rate: f32) {
        let resonance_hz = self.transducer_by_now().map(|transducer| transducer.series_resonance_hz);
        let (Some(resonance_hz), Some(per_ampere)) = (resonance_hz, self.edges.per_ampere) else { return };
        self.burst.set_rate(rate / self.edges.sample_hz, self.samples);
        let volts = self.braked_volts;
        let most = CURRENT * self.amplitude.most_amperes();
        let left = most * most - volts * volts / per_ampere.norm_sqr();
        let clamped = libm::sqrtf(larger(left, 0.0) / self.tracker.branch().y0.norm_sqr());
        let ceiling = smaller(clamped, self.amplitude.most_volts());
        let half_cycles = 2.0 * resonance_hz / rate;
        self.edges.stage = Stage::Strokes(Planner::new(half_cycles, volts, ceiling));
    }

    /// The brake for what rings. It is made anew where the drive has changed, because its level counts from the drive.
    pub(super) fn prepare_brake(&mut self, gate: Gate) {
        const SAME: f32 = 0.01;
        let volts = self.amplitude.volts();
        if self.burst.is_under_way(gate) {
            // It brakes what it was made for.
        } else if !self.burst.brakes(gate) || volts == 0.0 {
            self.burst.set_brake(None);
        } else if self.burst.brake().is_none() || (volts - self.braked_volts).abs() > SAME * volts {
            let periods =
                self.transducer_by_now().map_or(self.nominal_periods, |transducer| transducer.q / core::f32::consts::PI);
            self.burst.set_brake(Some(Brake::of(periods, self.amplitude.headroom())));
            self.braked_volts = volts;
        }
    }
}
