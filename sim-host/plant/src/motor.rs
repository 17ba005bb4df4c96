//! The four-phase travelling-wave motor (thesis appendix B).
//!
//! ```text
//! DAC holds -> amplifiers (lane errors) -> electrode tabs <-> sine and cosine mode <-> friction of the crests <-> rotor
//!                                              |-> multiplexer -> sensors -> ADC
//! ```
//!
//! | states | part |
//! |---|---|
//! | 12 | four amplifiers of two, and the voltages of their electrodes |
//! | 4 | the two modes |
//! | 1 | the rotor |
//! | 2 | the load cell, which measures the friction on the rotor |
//!
//! The linear part advances by its exact flow; only the outputs of the converters are held. The
//! friction is a closed form of the instantaneous state; a step uses the mean of its two ends
//! ([`rotor`]). Second order in the coupling, exact without it.

mod account;
pub mod crest;
mod lane_fault;
pub mod lanes;
pub mod linear;
pub mod model;
pub mod network;
pub mod participation;
pub mod rotor;
pub mod seat;
pub mod steady;
pub mod tones;
pub mod wave;

#[cfg(test)]
pub(crate) mod tests;

use firmware::seam::block::{DriveBlock, MAX_LANES, SenseBlock, SlowSense};
use hal_mock::analog::Analog;

use crate::circuit::Circuit;
use crate::converter::{Adc, Dac};
use crate::disturbance::Change;
use crate::energy::Energy;
use crate::load_cell::LoadCell;
use crate::motor::lane_fault::{LaneFault, lane_faults};
use crate::motor::lanes::{Lanes, Played};
use crate::motor::linear::Linear;
use crate::motor::model::Model;
use crate::motor::rotor::{Rotor, RotorFriction};
use crate::motor::wave::Tone;
use crate::quad::{Kernel, Registers, run_widest};
use crate::sums::Sums;
use crate::timing::Timing;
use crate::truth::{MotorTruth, Sample, Truth};
use scene::{Amplifier, Direction, DisturbedKey, Driven, Stator};

/// Default number of steps in a period. Two in a sample at 40 kHz and 1 MHz, so that the
/// converter's first images do not fold into the energy budget.
const STEPS_PER_PERIOD: u32 = 32;
/// Relative change of the resonance below which the flow is not recomputed, as a new flow costs as
/// much as a block.
const MIN_CHANGE_REL: f64 = 1e-6;

/// The plant around the stator of a motor.
#[derive(Clone, Debug)]
pub struct Motor {
    dac: Dac,
    lanes: Lanes,
    adc: Adc,
    timing: Timing,
    amplifier: Amplifier,
    model: Model,
    linear: Linear,
    rotor: Option<Rotor>,
    load_cell: LoadCell,
    /// Nominal frequency of the controller, for comparison with the truth, Hz.
    nominal_hz: f64,
    /// Nominal direction of the controller.
    direction: Direction,
    played_lanes: u8,
    changes: Vec<Change>,
    /// Future faults of lanes, each with its block.
    lane_faults: Vec<(u64, LaneFault)>,
    block: u64,
    /// Resonance including all disturbances, Hz; the model follows in steps of at least
    /// `MIN_CHANGE_REL`.
    disturbed_hz: f64,
    time_s: f64,
    energy: Energy,
    truth: Truth,
    motor_truth: MotorTruth,
    /// The samples of the last block, if they are recorded.
    samples: Option<Vec<Sample>>,
}

/// Sums over a block in addition to [`Sums`].
#[derive(Clone, Debug)]
pub(crate) struct Block {
    sums: Sums,
    tone: Tone,
    normal: f64,
    rotor_work: f64,
}

impl Motor {
    /// Creates the motor of a scene, at rest.
    pub fn new(scene: &Driven, stator: &Stator, rotor: Option<&scene::Rotor>) -> Self {
        let sensors = scene.sensors;
        let model = Model::from_stator(stator);
        let per_period = f64::from(scene.integrator.steps_per_period.unwrap_or(STEPS_PER_PERIOD));
        let timing = Timing {
            sample_s: 1.0 / sensors.sample_hz,
            steps: (per_period * model.series_resonance_hz / sensors.sample_hz).ceil() as u32,
            conversions: sensors.oversample.into(),
            skew_s: sensors.skew_s,
        };
        let drive = &scene.controller.drive;
        let lanes = Lanes::new(scene.amplifier, drive.frequency_hz, sensors.sample_hz);
        let block_s = f64::from(scene.controller.block_samples) / sensors.sample_hz;
        Motor {
            dac: Dac::new(sensors, scene.amplifier),
            adc: Adc::new(sensors, scene.seed),
            timing,
            amplifier: scene.amplifier.clone(),
            linear: Linear::new(&model, scene.amplifier, timing, lanes.rest()),
            rotor: rotor.map(|rotor| Rotor::new(rotor, &model)),
            lanes,
            load_cell: LoadCell::new(sensors.load_cell_hz, block_s),
            nominal_hz: drive.frequency_hz,
            direction: scene.controller.phasing.direction,
            played_lanes: drive.lanes,
            changes: scene.disturbance.iter().cloned().map(Change::new).collect(),
            lane_faults: lane_faults(scene, block_s),
            block: 0,
            disturbed_hz: model.series_resonance_hz,
            model,
            time_s: 0.0,
            energy: Energy::default(),
            truth: Truth::default(),
            motor_truth: MotorTruth::default(),
            samples: None,
        }
    }

    /// Returns the part of the truth about the last block that only a motor has.
    pub fn motor_truth(&self) -> &MotorTruth {
        &self.motor_truth
    }

    /// Returns the truth about the last block.
    pub fn truth(&self) -> &Truth {
        &self.truth
    }

    /// Returns the present circuit at lane 0, with all lanes playing.
    pub fn circuit(&self) -> Circuit {
        self.model.circuit(self.played_lanes, self.direction)
    }

    /// Returns the energy budget since the beginning.
    pub fn energy(&self) -> Energy {
        self.energy
    }

    /// Returns the duration of one sample, s.
    pub fn sample_s(&self) -> f64 {
        self.timing.sample_s
    }

    /// Returns the number of states that are integrated in time.
    pub fn states(&self) -> usize {
        network::STATES + 2 + usize::from(self.rotor.is_some())
    }

    /// Starts or stops recording blocks sample by sample.
    pub fn keep_samples(&mut self, keep: bool) {
        if keep != self.samples.is_some() {
            self.samples = keep.then(Vec::new);
        }
    }

    /// Returns the samples of the last block, if they are recorded.
    pub fn samples(&self) -> &[Sample] {
        self.samples.as_deref().unwrap_or(&[])
    }

    /// Applies the scene's disturbances for the block that begins now.
    fn disturb(&mut self) {
        let mut changes = std::mem::take(&mut self.changes);
        for change in &mut changes {
            if let Some(value) = change.next(self.time_s, self.value(change.key())) {
                self.set(change.key(), value);
            }
        }
        changes.retain(|change| !change.is_over());
        self.changes = changes;
    }

    /// Applies the faults of lanes that are due in the block that begins now.
    fn break_lanes(&mut self) {
        let block = self.block;
        let due: Vec<_> = self.lane_faults.extract_if(.., |(at_block, _)| *at_block <= block).map(|(_, fault)| fault).collect();
        for fault in due {
            match fault {
                LaneFault::Open { lane } => {
                    self.model.connected[lane] = false;
                    self.linear.remake(&self.model, &self.amplifier, self.timing, self.lanes.rest());
                }
                LaneFault::Weak { lane, part } => self.lanes.weaken(lane, part),
                LaneFault::Exchanged { one, other } => self.lanes.exchange(one, other),
            }
        }
    }

    fn value(&self, key: DisturbedKey) -> f64 {
        match (key, &self.rotor) {
            (DisturbedKey::StatorResonance, _) => self.disturbed_hz,
            (DisturbedKey::Torque, Some(rotor)) => rotor.torque_nm(),
            (DisturbedKey::Preload, Some(rotor)) => rotor.preload_n(),
            // Keys of scenes with a stack or an excitation.
            _ => 0.0,
        }
    }

    fn set(&mut self, key: DisturbedKey, value: f64) {
        match (key, &mut self.rotor) {
            (DisturbedKey::StatorResonance, _) => {
                self.disturbed_hz = value;
                if (value / self.model.series_resonance_hz - 1.0).abs() > MIN_CHANGE_REL {
                    let stored = self.stored_j();
                    self.model.series_resonance_hz = value;
                    self.linear.remake(&self.model, &self.amplifier, self.timing, self.lanes.rest());
                    self.energy.disturbed_j += self.stored_j() - stored;
                }
            }
            (DisturbedKey::Torque, Some(rotor)) => rotor.set_torque(value),
            (DisturbedKey::Preload, Some(rotor)) => rotor.set_preload(value),
            _ => {}
        }
    }

    /// Returns the energy in the two modes, J.
    fn stored_j(&self) -> f64 {
        let (q, s) = (self.linear.amplitudes(), self.linear.velocities());
        let of_mode = |mode: usize| self.model.mass_kg * s[mode].powi(2) + self.model.stiffness_n_per_m(mode) * q[mode].powi(2);
        0.5 * (of_mode(0) + of_mode(1))
    }

    /// Makes step `step` of a sample with the lanes as played. Returns the friction in it.
    #[inline(always)]
    fn step<F: Registers>(&mut self, four: F, step: usize, played: &Played, step_s: f64, block: &mut Block) -> RotorFriction {
        let before = self.linear.amplitudes();
        self.linear.advance(four, step, played);
        let mut dragged = RotorFriction::default();
        if let Some(rotor) = &mut self.rotor {
            let slow = rotor.speed();
            dragged = rotor.drag(four, &mut self.linear, step_s);
            let after = self.linear.amplitudes();
            let RotorFriction { force_n, modes_n, normal_n } = dragged;
            let sums = &mut block.sums;
            sums.friction += force_n;
            sums.friction_on_tip -= modes_n[0] * (after[0] - before[0]) + modes_n[1] * (after[1] - before[1]);
            sums.friction_min = if force_n < sums.friction_min { force_n } else { sums.friction_min };
            sums.friction_max = if force_n > sums.friction_max { force_n } else { sums.friction_max };
            block.normal += normal_n;
            block.rotor_work += force_n * 0.5 * (slow + rotor.speed()) * step_s;
        }
        let (s, q) = (self.linear.velocities(), self.linear.amplitudes());
        let force = self.model.drive_force_n(&self.linear.voltages());
        block.sums.in_phase += force[0] * s[0] + force[1] * s[1];
        block.sums.quadrature += force[0] * q[0] + force[1] * q[1];
        block.sums.lost += s[0] * s[0] + s[1] * s[1];
        dragged
    }
}

impl Motor {
    /// Begins a block. The parameters of the plant change only between two blocks.
    pub(crate) fn begin(&mut self) -> Block {
        self.disturb();
        self.break_lanes();
        self.block += 1;
        if let Some(samples) = &mut self.samples {
            samples.clear();
        }
        Block { sums: Sums::new(), tone: Tone::default(), normal: 0.0, rotor_work: 0.0 }
    }

    /// Plays one code on each lane. Returns the codes of voltage and current that were sampled
    /// meanwhile at the lane `listen`. A lane without a code is held at zero volts.
    pub(crate) fn play(&mut self, codes: &[Option<u16>; MAX_LANES], listen: usize, block: &mut Block) -> (u16, u16) {
        run_widest(Play { motor: self, codes, listen, block })
    }

    #[inline(always)]
    fn play_in<F: Registers>(
        &mut self,
        four: F,
        codes: &[Option<u16>; MAX_LANES],
        listen: usize,
        block: &mut Block,
    ) -> (u16, u16) {
        let (steps, step_s) = (self.timing.steps as usize, self.timing.step_s());
        let volts: [f64; MAX_LANES] = codes.map(|code| code.map_or(0.0, |code| self.dac.volts(code)));
        let played = self.lanes.play(&volts);
        let (mut v, mut i, mut friction) = (0, 0, 0.0);
        let mut last = RotorFriction::default();
        for step in 0..steps {
            last = self.step(four, step, &played, step_s, block);
            friction += last.force_n;
            let [voltage, current] = self.linear.sample(four, (step, listen), &played, last.modes_n, &mut self.adc);
            (v, i) = (v + voltage, i + current);
        }
        let force = self.model.drive_force_n(&self.linear.voltages());
        let acting = [force[0] + last.modes_n[0], force[1] + last.modes_n[1]];
        block.tone.update(&self.model, self.linear.amplitudes(), self.linear.velocities(), acting);
        let sample = self.samples.is_some().then(|| self.sample(friction / steps as f64));
        if let (Some(samples), Some(sample)) = (&mut self.samples, sample) {
            samples.push(sample);
        }
        (v, i)
    }

    /// Ends the block that played `drive`.
    pub(crate) fn end(&mut self, drive: &DriveBlock, block: &Block) {
        let samples = drive.lanes.first().map_or(0, |lane| lane.len());
        self.account(drive, block, (samples * self.timing.steps as usize) as f64);
    }
}

/// A sample on all lanes.
struct Play<'a> {
    motor: &'a mut Motor,
    codes: &'a [Option<u16>; MAX_LANES],
    listen: usize,
    block: &'a mut Block,
}

impl Kernel for Play<'_> {
    type Output = (u16, u16);

    #[inline(always)]
    fn with<F: Registers>(self, four: F) -> (u16, u16) {
        self.motor.play_in(four, self.codes, self.listen, self.block)
    }
}

impl Analog for Motor {
    fn exchange(&mut self, drive: &DriveBlock, sense: &mut SenseBlock) {
        let count = drive.lanes.first().map_or(0, |lane| lane.len());
        // The position of the board's multiplexer while these codes play.
        let listen = usize::from(drive.listen).min(MAX_LANES - 1);
        let mut block = self.begin();
        sense.v.clear();
        sense.i.clear();
        sense.slow = SlowSense::default();
        for n in 0..count {
            let codes = std::array::from_fn(|lane| drive.lanes.get(lane).and_then(|codes| codes.get(n)).copied());
            let (v, i) = self.play(&codes, listen, &mut block);
            // A sense block holds as many samples as the longest drive block.
            let _ = (sense.v.push(v), sense.i.push(i));
        }
        self.end(drive, &block);
    }
}
