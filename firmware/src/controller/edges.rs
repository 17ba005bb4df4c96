//! How a burst's edges are prepared: the brake of a plain burst, and the strokes of a boosted one.
//!
//! Strokes are planned from what is known in place: the resonance's damping and inductance, which the tracker has identified; what the
//! [source](crate::source) adds to the damping; and what rings, by the motional current that was heard last. The steady current of a drive of one
//! volt is then `S = beta g / a`, `a = alpha + Re(beta z)`, and what rings, as the drive that would hold it, is `R = Re(I_m / S)`.

use super::{Controller, Played};
use crate::block::{Gate, Orders};
use crate::burst::Brake;
use crate::burst::stroke::Strokes;
use crate::config::{Config, Edge, ShapeKind, Sweep, TrackingMode};
use crate::demod::Sensed;
use crate::error::Error;
use crate::phasor::{Phasor, magnitude};
use crate::source::Source;

/// How often strokes are made anew, blocks.
const RENEW_BLOCKS: u64 = 64;
/// Part of the current limit that an edge may draw: steps of the converter draw more than their fundamental.
const CURRENT: f32 = 0.85;
/// A drive further from the resonance than this part of the half bandwidth is not boosted.
const BESIDE: f32 = 0.1;

/// What is known for boosted edges.
#[derive(Clone, Debug, Default)]
pub(super) struct Edges {
    source: Source,
    /// `1 / S`, V/A.
    per_ampere: Option<Phasor>,
    sample_hz: f32,
    planned: u64,
}

impl Edges {
    pub(super) fn build(config: &Config) -> Self {
        Edges { sample_hz: config.sample_hz, ..Edges::default() }
    }

    /// Forgets the transducer. The source is what it was.
    pub(super) fn restart(&mut self) {
        self.per_ampere = None;
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
    /// Prepares the edge that may come next.
    pub(super) fn prepare_edges(&mut self, orders: &Orders, sensed: &Sensed, played: &Played, motional: Phasor) {
        if !self.burst.boosts() {
            return self.prepare_brake(orders.gate);
        }
        if played.flat && played.pure && played.even {
            // Silence tells nothing but noise.
            if played.envelope != 0.0 {
                self.edges.source.hear(played.volts * played.envelope, sensed.v, motional);
            }
            if let Some(per_ampere) = self.edges.per_ampere {
                self.burst.hear((motional * per_ampere).re, self.samples);
            }
        }
        if self.burst.is_under_way(orders.gate) {
            return;
        }
        self.braked_volts = self.amplitude.volts();
        let ceiling = self.ceiling_volts();
        if self.block - self.edges.planned >= RENEW_BLOCKS || !self.burst.fits(self.braked_volts, ceiling) {
            self.plan_strokes(orders, ceiling);
        }
    }

    /// The most that an edge may drive with, V: by the voltage limit, and by what the clamped branch draws beside the motional current.
    fn ceiling_volts(&self) -> f32 {
        let most = CURRENT * self.amplitude.most_amperes();
        let motional = self.edges.per_ampere.map_or(0.0, |per_ampere| self.braked_volts / magnitude(per_ampere));
        let clamped = libm::sqrtf((most * most - motional * motional).max(0.0)) / magnitude(self.tracker.branch().y0);
        clamped.min(self.amplitude.most_volts())
    }

    /// Plans the strokes of the next burst.
    fn plan_strokes(&mut self, orders: &Orders, ceiling: f32) {
        let Some(transducer) = self.transducer else { return };
        let Some((gain, impedance)) = self.edges.source.seen() else { return };
        let beta = self.tracker.branch().axis * (0.5 / transducer.lm_h);
        let rate = 1.0 / transducer.time_constant_s() + (beta * impedance).re;
        let volts = self.braked_volts;
        self.edges.planned = self.block;
        let beside = (orders.detune.0 * core::f32::consts::TAU).abs() > BESIDE * rate;
        if rate <= 0.0 || volts <= 0.0 || beside {
            return self.burst.set_strokes(None, rate.max(0.0) / self.edges.sample_hz);
        }
        let driven = beta * gain;
        self.edges.per_ampere = Some(driven.conj() * (rate / driven.norm_sqr()));
        let half_cycles = 2.0 * transducer.series_resonance_hz / rate;
        self.burst.set_strokes(Some(Strokes::of(half_cycles, volts, ceiling)), rate / self.edges.sample_hz);
    }

    /// The brake for what rings. It is made anew where the drive has changed, because its level counts from the drive.
    fn prepare_brake(&mut self, gate: Gate) {
        const SAME: f32 = 0.01;
        let volts = self.amplitude.volts();
        if self.burst.is_under_way(gate) {
            // It brakes what it was made for.
        } else if !self.burst.brakes(gate) || volts == 0.0 {
            self.burst.set_brake(None);
        } else if self.burst.brake().is_none() || (volts - self.braked_volts).abs() > SAME * volts {
            let periods = self.transducer.map_or(self.nominal_periods, |transducer| transducer.q / core::f32::consts::PI);
            self.burst.set_brake(Some(Brake::of(periods, self.amplitude.headroom())));
            self.braked_volts = volts;
        }
    }
}
