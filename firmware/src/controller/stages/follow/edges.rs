//! Preparation of a burst's edges: the brake of a plain burst, and the strokes of a boosted one.
//!
//! Strokes are planned from values known on the board: damping and inductance of the resonance,
//! identified by the tracker; the additional damping by the [source](crate::sense::source); and the
//! residual vibration, from the last measured motional current. The steady current per volt of
//! drive is then `S = beta g / a`, `a = alpha + Re(beta z)`. The residual vibration, as the drive
//! that would hold it, is `R = Re(I_m / S)`.

use crate::controller::chain::{Chain, Measured};
use crate::generate::amplitude::AmplitudeLoop;
use crate::generate::burst::Brake;
use crate::generate::burst::stroke::{CurrentRoom, OtherMode, Planner};
use crate::generate::signal_generator::SignalGenerator;
use crate::seam::block::{Gate, LATENCY_BLOCKS, Orders};
use crate::seam::compare::{larger, smaller};
use crate::seam::config::{Config, Edge, ShapeKind, Sweep, TrackingMode};
use crate::seam::error::Error;
use crate::seam::mode::Mode;
use crate::seam::phasor::Phasor;
use crate::sense::source::Source;
use crate::track::tracked_transducer::LEARN_BLOCKS;

/// Interval at which strokes are planned again, blocks.
const RENEW_BLOCKS: u64 = 64;
/// Interval at which blocks of a steady drive are used for the source, blocks.
const STEADY_INTERVAL_BLOCKS: u64 = 8;
/// Largest fundamental current of an edge, relative to the current limit: the steps of the
/// converter draw more than their fundamental.
const MAX_CURRENT_REL: f32 = 0.85;
/// Largest detuning of a drive that is boosted, half bandwidths.
const MAX_DETUNING_REL: f32 = 0.1;

/// Use of a block of a boosted burst for the tracker.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BlockInfo {
    /// `true` if the ring-up was complete before the block.
    pub(crate) rung_up: bool,
    /// `true` if the tracker can use the block.
    pub(crate) informative: bool,
    /// `true` if no volt-seconds of a burst were compensated in the block.
    even: bool,
}
impl BlockInfo {
    /// Use of a block of a plain burst.
    const PLAIN: BlockInfo = BlockInfo { rung_up: false, informative: true, even: true };
}

/// State of the planning of edges.
#[derive(Clone, Debug)]
pub(crate) struct Edges {
    source: Source,
    /// `1 / S`, V/A.
    per_ampere: Option<Phasor>,
    sample_hz: f32,
    planned: u64,
    stage: Stage,
    infos: [BlockInfo; LATENCY_BLOCKS],
    /// `true` if no volt-seconds remain to be compensated after the last block.
    even: bool,
    /// Drive for which the present brake or boost was planned, V peak.
    braked_volts: f32,
}

/// Progress of the planning of strokes, one part a block.
#[derive(Clone, Copy, Debug)]
enum Stage {
    Idle,
    /// The next part computes the largest drive, at this decay rate, 1/s.
    Ceiling(f32),
    Strokes(Planner),
}

impl Edges {
    pub(crate) fn build(config: &Config) -> Self {
        Edges {
            source: Source::default(),
            per_ampere: None,
            sample_hz: config.sample_hz,
            planned: 0,
            stage: Stage::Idle,
            infos: [BlockInfo::PLAIN; LATENCY_BLOCKS],
            even: true,
            braked_volts: 0.0,
        }
    }

    /// Returns the drive for which the present brake or boost was planned, V peak.
    pub(crate) fn volts(&self) -> f32 {
        self.braked_volts
    }

    /// Returns `true` if no planning is in progress.
    pub(crate) fn are_idle(&self) -> bool {
        matches!(self.stage, Stage::Idle)
    }

    /// Resets the transducer; the source is kept.
    pub(crate) fn restart(&mut self) {
        (self.per_ampere, self.stage) = (None, Stage::Idle);
    }
}

/// Checks that a boosted edge is compatible with the rest of the configuration.
pub(crate) fn check(config: &Config) -> Result<(), Error> {
    let tracked = matches!(config.tracking.mode, TrackingMode::Observer | TrackingMode::PhaseLock);
    if config.burst.edge != Edge::Boost {
        Ok(())
    } else if config.drive.shape != ShapeKind::Sine {
        Err(Error::BoostOfShape)
    } else if config.sweep != Sweep::Hold {
        Err(Error::BoostWithSweep)
    } else if !tracked {
        Err(Error::BoostWithoutTracking)
    } else {
        Ok(())
    }
}

impl Edges {
    /// Returns the use of the measured block for the tracker.
    #[inline]
    pub(crate) fn block_info(&self, block: u64, boosts: bool) -> BlockInfo {
        if boosts { self.infos[(block % LATENCY_BLOCKS as u64) as usize] } else { BlockInfo::PLAIN }
    }

    /// Records the use of the block that has been written, with its drive, V, and its mean
    /// envelope.
    #[inline(never)]
    pub(crate) fn record(&mut self, block: u64, generator: &SignalGenerator, volts: f32, level: f32) {
        let (rung_up, informative) = (generator.burst.was_rung_up(volts), generator.burst.is_telling());
        let even = core::mem::replace(&mut self.even, generator.shaper.is_even()) || level != 0.0;
        self.infos[(block % LATENCY_BLOCKS as u64) as usize] = BlockInfo { rung_up, informative, even };
    }

    /// Prepares the next boosted edge under this gate.
    #[inline(never)]
    pub(crate) fn prepare_boost(&mut self, chain: &mut Chain, measured: &Measured, gate: Gate) {
        let Measured { orders, sensed, motional, played, .. } = *measured;
        let (block, burst) = (chain.block, &mut chain.generator.burst);
        if played.flat && played.pure && self.block_info(block, true).even {
            // Silence contains only noise, and a steady drive little information.
            if played.envelope > 1.0
                || played.envelope > 0.0
                    && (chain.supervisor.mode() == Mode::Lock || block.is_multiple_of(STEADY_INTERVAL_BLOCKS))
            {
                self.source.update(played.volts * played.envelope, sensed.v, motional);
            }
            if let Some(per_ampere) = self.per_ampere {
                burst.update(motional.re * per_ampere.re - motional.im * per_ampere.im);
            }
        }
        if burst.is_under_way(gate) {
            return;
        }
        self.braked_volts = chain.generator.amplitude.volts();
        let fresh = block - self.planned < RENEW_BLOCKS && burst.fits(self.braked_volts);
        if fresh && matches!(self.stage, Stage::Idle) {
            return;
        }
        // Planning uses blocks without other work.
        let samples = chain.generator.samples as u64;
        let next = (block + LATENCY_BLOCKS as u64) * samples;
        let learns = chain.track.since_learned(block) >= LEARN_BLOCKS - 1;
        if learns && chain.track.tracker.has_converged() || burst.turns_within(gate, next, 2 * samples) {
            return;
        }
        match self.stage {
            Stage::Idle => self.plan_rate(chain, orders),
            Stage::Ceiling(rate) => self.plan_ceiling(chain, rate),
            Stage::Strokes(mut planner) => match planner.step() {
                None => self.stage = Stage::Strokes(planner),
                strokes => {
                    burst.set_strokes(strokes);
                    self.stage = Stage::Idle;
                }
            },
        }
    }

    /// Computes the decay rate of the vibration, and its level under a steady drive.
    fn plan_rate(&mut self, chain: &mut Chain, orders: &Orders) {
        let transducer = chain.track.latest_transducer();
        let Some((lm_h, time_constant_s)) = transducer.map(|it| (it.lm_h, it.time_constant_s())) else { return };
        let Some((gain, impedance)) = self.source.seen() else { return };
        let beta = chain.track.tracker.branch().axis * (0.5 / lm_h);
        let rate = 1.0 / time_constant_s + (beta * impedance).re;
        let driven = beta * gain;
        self.planned = chain.block;
        let detuned = (orders.detune.0 * core::f32::consts::TAU).abs() > MAX_DETUNING_REL * rate;
        // Also rejects a rate that is not a number.
        if rate > 0.0 && self.braked_volts > 0.0 && !detuned {
            self.per_ampere = Some(driven.conj() * (rate / driven.norm_sqr()));
            self.stage = Stage::Ceiling(rate);
        } else {
            chain.generator.burst.set_strokes(None);
        }
    }

    /// Computes the largest drive of an edge: from the voltage limit, and from the current limit
    /// less the motional current; at least the drive itself, reduced to the current limit.
    // Not inlined: it runs in one block of 64, and the fast memory of a board has no room for it.
    #[inline(never)]
    fn plan_ceiling(&mut self, chain: &mut Chain, rate: f32) {
        let resonance_hz = chain.track.latest_transducer().map(|transducer| transducer.series_resonance_hz);
        let (Some(resonance_hz), Some(per_ampere)) = (resonance_hz, self.per_ampere) else { return };
        let SignalGenerator { burst, amplitude, samples, .. } = &mut chain.generator;
        let volts = self.braked_volts;
        let room = current_room(amplitude, 1.0 / per_ampere.norm_sqr(), chain.track.tracker.branch().y0);
        burst.set_rate(rate / self.sample_hz, *samples);
        burst.set_room(room);
        let driven = smaller(volts, fpu::sqrtf(room.most / (room.motional + room.clamped)));
        let ceiling = smaller(larger(room.volts(volts), driven), amplitude.most_volts());
        let half_cycles = 2.0 * resonance_hz / rate;
        let other_mode = chain.track.other_mode;
        let other_mode =
            other_mode.map(|(hz, strength)| OtherMode { beat: 2.0 * resonance_hz / (hz - resonance_hz).abs(), strength });
        self.stage = Stage::Strokes(Planner::new(half_cycles, volts, ceiling, other_mode));
    }

    /// Prepares the brake for the residual vibration. A changed drive needs a new brake, because
    /// the brake's level is relative to the drive.
    #[inline(never)]
    pub(crate) fn prepare_brake(&mut self, chain: &mut Chain, gate: Gate) {
        /// Relative change of the drive after which the brake is planned again.
        const REPLAN_REL: f32 = 0.01;
        let SignalGenerator { burst, amplitude, .. } = &mut chain.generator;
        let volts = amplitude.volts();
        if burst.is_under_way(gate) {
            // A brake in progress is kept.
        } else if !burst.brakes(gate) || volts == 0.0 {
            burst.set_brake(None);
        } else if burst.brake().is_none() || (volts - self.braked_volts).abs() > REPLAN_REL * volts {
            plan_brake(chain, volts);
            self.braked_volts = volts;
        }
    }
}

/// Sets the shortest brake after a complete ring-up to this drive, V, within the limits of voltage
/// and current; none if the transducer is tracked, but not known yet.
// Not inlined: the fast memory of a board has no room for it.
#[cold]
#[inline(never)]
fn plan_brake(chain: &mut Chain, volts: f32) {
    let (SignalGenerator { burst, amplitude, .. }, track) = (&mut chain.generator, &chain.track);
    let resistance = match track.latest_transducer() {
        Some(transducer) => transducer.rm_ohm,
        None if track.tracker.observes() => return burst.set_brake(None),
        None => f32::INFINITY,
    };
    let room = current_room(amplitude, 1.0 / (resistance * resistance), track.tracker.branch().y0);
    // The brake of the drive itself takes no more current than the drive.
    let level = larger(room.volts(volts) / volts, 1.0);
    burst.set_brake(Some(Brake::of(track.periods(), smaller(level, amplitude.headroom()))));
}

/// Returns the room within the current limit, from the squared motional current per volt, S², and
/// the admittance of the clamped branch, S.
fn current_room(amplitude: &AmplitudeLoop, motional: f32, clamped: Phasor) -> CurrentRoom {
    let most = MAX_CURRENT_REL * amplitude.most_amperes();
    CurrentRoom { most: most * most, motional, clamped: clamped.norm_sqr() }
}
