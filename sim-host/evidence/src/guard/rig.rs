//! The firmware's guard over a belt, block by block, without the carrier.

use firmware::guard::on_time::OnTime;
use firmware::guard::weld::{Driving, Weld};
use firmware::guard::{Driven, Stage};
use firmware::seam::block::{BeltSense, LATENCY_BLOCKS};
use firmware::seam::config::Config;
use firmware::seam::error::Error;
use firmware::sense::belt::Belt;

use super::build::{RunParameters, part};
use super::cases::{EncoderFault, Event, EventKind, RIPPLE_HZ, slowest_m_per_s};
use super::friction::MeanFriction;
use plant::belt_motion::BeltMotion;
use plant::circuit_of;
use plant::encoder::Encoder;
use plant::force_channel::ForceChannel;
use scene::load::{LoadError, Loaded, load};
use scene::settings;

/// Scene that provides stack, contact and drive.
const SCENE: &str = "belt-stop";
/// Relative tip velocity at which the ring-down ends.
const RING_DOWN_REL: f64 = 0.05;
/// Time before the event, s, in which the guard learns the force.
const LEARNING_S: f64 = 0.06;
/// Time after the event at which it counts as missed, s.
const MISSED_AFTER_S: f64 = 0.2;
/// Time after which an encoder fault counts as never detected, s.
const UNDETECTED_S: f64 = 60.0;

/// Parameters that all runs share.
#[derive(Clone, Debug)]
pub struct Plan {
    config: Config,
    block_s: f64,
    /// Time constant of the tip, s.
    tau_s: f64,
    tip_m_per_s: f64,
    stiffness_n_per_m: f64,
    coulomb_n: f64,
    force_noise_n: f64,
    /// Power into the motional branch at full drive, W.
    pub power_w: f64,
}

impl Plan {
    /// Loads the plan from the scene `belt-stop`.
    pub fn from_scene() -> Result<Self, LoadError> {
        Ok(Plan::from_loaded(&load(SCENE, &[])?).unwrap_or_else(|| unreachable!("{SCENE} slides a contact past a stack")))
    }

    fn from_loaded(loaded: &Loaded) -> Option<Self> {
        let scene = loaded.scene.driven()?;
        let (contact, slider) = scene.sliding()?;
        let circuit = circuit_of(&scene);
        let tip_m_per_s = scene.controller.drive.velocity_m_per_s?;
        let amperes = circuit.force_factor_n_per_v * tip_m_per_s;
        Some(Plan {
            config: settings::config(&scene),
            block_s: f64::from(scene.controller.block_samples) / scene.sensors.sample_hz,
            tau_s: circuit.time_constant_s(),
            tip_m_per_s,
            stiffness_n_per_m: contact.stiffness_n_per_m,
            coulomb_n: contact.mu * (slider.load_n + slider.self_weight_n),
            force_noise_n: scene.sensors.force_noise_n,
            power_w: 0.5 * circuit.rm_ohm * amperes * amperes,
        })
    }
}

/// End of a run.
#[derive(Clone, Copy, Debug)]
pub struct Ended {
    /// Time from the event to the first block without drive, ms; `None` if the drive continued.
    pub off_ms: Option<f64>,
    /// Time from there to 5 % of the tip velocity, ms.
    pub ring_down_ms: Option<f64>,
    /// Energy from the event to the first block without drive, J, all of it into one millimetre of
    /// belt.
    pub exposure_j: f64,
    /// Number of the fault, or zero.
    pub fault: u8,
}

/// Reading of the encoder.
#[derive(Clone, Copy, Debug)]
enum EncoderReading {
    Truth,
    Same,
    Broken,
    /// Counts at the beginning, and counts added since.
    Pace(f64, f64),
}

/// Rig of a belt with its encoder and the firmware's interlock.
pub struct Rig {
    block_s: f64,
    decay: f64,
    full_m_per_s: f64,
    power_w: f64,
    slowest_m_per_s: f64,
    counts_per_m: f64,
    motion: BeltMotion,
    encoder: Encoder,
    last: BeltSense,
    friction: MeanFriction,
    channel: Option<ForceChannel>,
    belt: Belt,
    weld: Weld,
    on_time: OnTime,
    /// `true` if the drive is ON, for each of the next blocks, by block number modulo the latency.
    pending: [bool; LATENCY_BLOCKS],
    was_on: bool,
    tip_m_per_s: f64,
    fault: u8,
    block: u64,
    stretch: f64,
    stretch_j: f64,
    exposure_j: f64,
}

impl Rig {
    /// Builds the firmware's and the belt's parts.
    pub fn new(plan: &Plan, build: &RunParameters) -> Result<Self, Error> {
        let mut config = plan.config.clone();
        config.front_end.metre_per_count = Some((1e-3 / build.counts_per_mm) as f32);
        config.front_end.force_hz = build.force_hz.map(|hz| hz as f32);
        config.limits.belt_stop_ms = build.stop_ms as f32;
        config.limits.energy_j_per_m = build.energy_j_per_m.map(|joule| joule as f32);
        config.limits.on_time_s = build.on_time_s.map(|seconds| seconds as f32);
        let block_s = plan.block_s as f32;
        let channel = |hz| ForceChannel::new(hz, plan.block_s, plan.force_noise_n, build.seed ^ (1 << 62));
        Ok(Rig {
            block_s: plan.block_s,
            decay: libm::exp(-plan.block_s / plan.tau_s),
            full_m_per_s: plan.tip_m_per_s,
            power_w: plan.power_w,
            slowest_m_per_s: slowest_m_per_s(build.counts_per_mm, build.stop_ms),
            counts_per_m: 1e3 * build.counts_per_mm,
            motion: BeltMotion::new(build.speed_m_per_s).with_ripple(build.ripple_rms, RIPPLE_HZ, build.seed),
            encoder: Encoder::new(build.counts_per_mm, build.phase),
            last: BeltSense::default(),
            friction: MeanFriction::new(plan.stiffness_n_per_m, plan.coulomb_n),
            channel: build.force_hz.map(channel),
            belt: Belt::build(&config, block_s),
            weld: Weld::build(&config, block_s)?,
            on_time: OnTime::build(&config, block_s),
            pending: [true; LATENCY_BLOCKS],
            was_on: false,
            tip_m_per_s: 0.0,
            fault: 0,
            block: 0,
            stretch: 0.0,
            stretch_j: 0.0,
            exposure_j: 0.0,
        })
    }

    fn time_s(&self) -> f64 {
        self.block as f64 * self.block_s
    }

    /// Runs one block, and returns `true` if it had drive.
    fn step(&mut self, encoder: EncoderReading) -> bool {
        let slot = (self.block % LATENCY_BLOCKS as u64) as usize;
        let on = self.pending[slot];
        let speed = self.motion.advance(self.block_s);
        let aim = if on { self.full_m_per_s } else { 0.0 };
        self.tip_m_per_s = aim + self.decay * (self.tip_m_per_s - aim);
        let force = self.friction.slide(speed, self.tip_m_per_s, self.block_s);
        let reading = self.channel.as_mut().map(|channel| channel.measure(force));
        self.last = match encoder {
            EncoderReading::Truth => self.encoder.read(self.motion.position_m()),
            EncoderReading::Same => self.last,
            EncoderReading::Broken => BeltSense { broken: true, ..self.last },
            EncoderReading::Pace(from, counts) => BeltSense { counts: (from + counts) as i64 as i32, broken: false },
        };
        self.belt.update(Some(self.last));
        let power_w = if on { self.power_w } else { 0.0 };
        let driven = Driven {
            volts: Some(if on { 1.0 } else { 0.0 }),
            stage: Stage::Following,
            requested: true,
            full: on && self.was_on,
            asked: 1.0,
        };
        let driving = Driving { driving: on, power_w: power_w as f32, driven: &driven };
        let found = self.weld.inspect(&self.belt, reading, &driving).or(self.on_time.inspect(on));
        if let (0, Some(fault)) = (self.fault, found) {
            self.fault = fault.code();
        }
        self.pending[slot] = self.fault == 0 && !self.weld.is_muted();
        self.was_on = on;
        self.account(power_w);
        self.block += 1;
        on
    }

    fn account(&mut self, power_w: f64) {
        let here = (1e3 * self.motion.position_m()).floor();
        if here != self.stretch {
            (self.stretch, self.stretch_j) = (here, 0.0);
        }
        self.stretch_j += power_w * self.block_s;
        self.exposure_j = self.exposure_j.max(self.stretch_j);
    }

    /// Runs until an event, injects it, and returns how the run ended.
    pub fn stop(mut self, event: &Event, run: u32) -> Result<Ended, Error> {
        let seed = u64::from(run) + 1;
        let at = ((LEARNING_S + 0.03 * part(seed, 3)) / self.block_s) as u64;
        while self.block < at {
            self.step(EncoderReading::Truth);
        }
        let stopping_s = if part(seed, 4) < 0.5 { 0.0 } else { 0.02 * part(seed, 5) };
        match event.what {
            EventKind::Stops => self.motion.halt(self.time_s() - 0.5 * self.block_s, stopping_s),
            EventKind::Lies => self.motion.halt(self.time_s() - 0.5 * self.block_s, 0.0),
            EventKind::Slows | EventKind::Sticks | EventKind::Breaks => {}
        }
        let (from_speed, slow) = (self.motion.nominal_m_per_s(), 0.7 * part(seed, 6) * self.slowest_m_per_s);
        let slowing_s = 0.25 * stopping_s;
        let pace = self.motion.speed_m_per_s().max(from_speed) * self.counts_per_m * self.block_s;
        let counts = f64::from(self.last.counts);
        let (mut since, mut off, mut quiet, mut before_off, mut spent_j) = (None, None, None, 0.0, 0.0);
        let until = at + (MISSED_AFTER_S / self.block_s) as u64;
        while self.block < until && quiet.is_none() {
            let begins_s = self.time_s();
            let passed_s = begins_s - at as f64 * self.block_s;
            if event.what == EventKind::Slows {
                let left = if slowing_s > 0.0 { (1.0 - passed_s / slowing_s).max(0.0) } else { 0.0 };
                self.motion.set_nominal(slow + left * (from_speed - slow));
            }
            let before_m_per_s = self.tip_m_per_s;
            let on = self.step(match event.what {
                EventKind::Stops | EventKind::Slows => EncoderReading::Truth,
                EventKind::Sticks => EncoderReading::Same,
                EventKind::Breaks => EncoderReading::Broken,
                EventKind::Lies => EncoderReading::Pace(counts, pace * (self.block - at + 1) as f64),
            });
            let slow_now =
                matches!(event.what, EventKind::Sticks | EventKind::Breaks) || self.motion.speed_m_per_s() < self.slowest_m_per_s;
            if slow_now && since.is_none() {
                since = Some(begins_s);
            }
            if since.is_some() && on {
                spent_j += self.power_w * self.block_s;
            }
            if off.is_none() && !on {
                (off, before_off) = (Some(begins_s), before_m_per_s);
            }
            if off.is_some() && self.tip_m_per_s <= RING_DOWN_REL * before_off {
                quiet = Some(self.time_s());
            }
        }
        let ms = |from: Option<f64>, to: Option<f64>| from.zip(to).map(|(from, to)| 1e3 * (to - from));
        Ok(Ended {
            // A ripple may have muted the drive before the event; then it was OFF in time.
            off_ms: ms(since.or(off), off).map(|ms| ms.max(0.0)),
            ring_down_ms: ms(off, quiet),
            exposure_j: spent_j,
            fault: self.fault,
        })
    }

    /// Lets the encoder of a stopped belt count until a fault. Returns the time, s, the fault, and
    /// the energy into the millimetre, J.
    pub fn run_encoder_fault(mut self, encoder: &EncoderFault) -> Result<(Option<f64>, u8, f64), Error> {
        let pace = encoder.pace_m_per_s * self.counts_per_m * self.block_s;
        while self.fault == 0 && self.time_s() < UNDETECTED_S {
            self.step(EncoderReading::Pace(0.0, pace * self.block as f64));
        }
        Ok(((self.fault != 0).then(|| self.time_s()), self.fault, self.exposure_j))
    }

    /// Moves the belt for `seconds` or until a fault. Returns the number of mutes, with a fault as
    /// one more, and the simulated time, s.
    pub fn pass(mut self, seconds: f64) -> (u32, f64) {
        let blocks = (seconds / self.block_s) as u64;
        let (mut trips, mut muted) = (0, false);
        while self.block < blocks && self.fault == 0 {
            self.step(EncoderReading::Truth);
            trips += u32::from(!muted && self.weld.is_muted());
            muted = self.weld.is_muted();
        }
        (trips + u32::from(self.fault != 0), self.time_s())
    }
}
