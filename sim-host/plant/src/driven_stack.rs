//! A stack and the surface on which its tip slides.
//!
//! ```text
//! DAC hold -> amplifier -> stack <-> tip motion <-> friction contact <-> slider -> sensors -> ADC
//! ```
//!
//! A horn on a belt has no contact along its vibration: the belt ([`Webbing`]) damps it, and its
//! pull is computed once a block.
//!
//! Plant states: five of amplifier and stack, two of each further mode, one of the contact or of
//! the belt, two of the load cell, one of a stack that heats itself, three of a [`Carriage`]
//! (position, speed, end of its spring), none of a rigid slider. The friction at the tip acts back
//! on the stack's motional branch. A sample is one step or several, as the contact requires. The
//! linear part advances by its exact flow with the friction held at its last value, then the
//! contact exactly in the resulting slip. Finally the stack is corrected by the difference between
//! the mean friction over the step and the held value. Second order in the coupling, exact without
//! it.

pub mod abreast;
mod changes;
mod playing;

use firmware::seam::block::{DriveBlock, SenseBlock, SlowSense};
use hal_mock::analog::Analog;

use crate::belt_motion::BeltMotion;
use crate::carriage::Carriage;
use crate::circuit::Circuit;
use crate::converter::{Adc, Dac};
use crate::delay::Delay;
use crate::disturbance::Change;
use crate::elements::Elements;
use crate::encoder::Encoder;
use crate::energy::Energy;
use crate::force_channel::ForceChannel;
use crate::load_cell::LoadCell;
use crate::quad::{Portable, Quad, Registers};
use crate::sliding::{Sliding, steps_per_sample};
use crate::stack::{HeldDrive, Stack};
use crate::sums::{Step, StepFriction, Sums};
use crate::timing::Timing;
use crate::truth::{Sample, TipMotion, Truth};
use crate::webbing::Webbing;
use scene::{Dahl, Driven, Slider};

/// The plant around a stack.
#[derive(Clone, Debug)]
pub struct DrivenStack {
    dac: Dac,
    adc: Adc,
    delay: Option<Delay>,
    timing: Timing,
    stack: Stack,
    elements: Elements,
    block_s: f64,
    sliding: Option<Sliding>,
    webbing: Option<Webbing>,
    load_cell: LoadCell,
    encoder: Option<Encoder>,
    force_channel: Option<ForceChannel>,
    board_c: Option<f32>,
    changes: Vec<Change>,
    time_s: f64,
    energy: Energy,
    truth: Truth,
    /// The samples of the last block, if they are recorded.
    samples: Option<Vec<Sample>>,
    /// The last step.
    last: Step,
    /// Drive voltage of the last step, V.
    held_v: f64,
    /// `true` if nothing moved in the last step.
    at_rest: bool,
    /// Inputs of the converters in the last held sample, in LSB, for two conversions or one.
    inputs: Vec<(Quad, usize)>,
}

impl DrivenStack {
    /// Creates the stack of a scene, at rest, with the contact at its tip.
    pub fn new(scene: &Driven, stack: &scene::Stack, sliding: Option<(&Dahl, &Slider)>) -> Self {
        let sensors = scene.sensors;
        let (elements, parts) = Elements::new(scene, stack);
        let timing = Timing {
            sample_s: 1.0 / sensors.sample_hz,
            steps: steps_per_sample(scene, sliding, &parts.circuit),
            conversions: sensors.oversample.into(),
            skew_s: sensors.skew_s,
        };
        // Seed offsets far from those of the converters.
        let [ripple_seed, force_seed] = [1, 3].map(|stream| scene.seed ^ (stream << 61));
        let sliding = Sliding::from_scene(scene, sliding, ripple_seed);
        let block_s = f64::from(scene.controller.block_samples) / sensors.sample_hz;
        let delay = Delay::from_samples(scene.amplifier.delay_s * sensors.sample_hz);
        let late_s = delay.as_ref().map_or(0.0, Delay::fraction) / sensors.sample_hz;
        let mut plant = DrivenStack {
            dac: Dac::new(sensors, scene.amplifier),
            adc: Adc::new(sensors, scene.seed),
            timing,
            delay,
            stack: Stack::with_late_drive(parts, scene.amplifier, timing, late_s),
            elements,
            block_s,
            sliding,
            webbing: scene.belt().map(|(contact, belt)| Webbing::new(contact, belt, ripple_seed)),
            load_cell: LoadCell::new(sensors.load_cell_hz, block_s),
            encoder: sensors.encoder_counts_per_mm.map(|counts| Encoder::new(counts, 0.5)),
            force_channel: sensors.force_hz.map(|hz| ForceChannel::new(hz, block_s, sensors.force_noise_n, force_seed)),
            board_c: sensors.board_c.map(|celsius| celsius as f32),
            changes: scene.disturbance.iter().cloned().map(Change::new).collect(),
            time_s: 0.0,
            energy: Energy::default(),
            truth: Truth::default(),
            samples: None,
            last: Step::default(),
            held_v: 0.0,
            at_rest: false,
            inputs: Vec::new(),
        };
        if let (Some(belt), Some(at_s)) = (plant.belt(), scene.belt_stops_s()) {
            // The stop begins with the block that contains its time, as for every fault.
            belt.halt((at_s / block_s).floor() * block_s - 0.5 * block_s, 0.0);
        }
        plant
    }

    /// Returns the truth about the last block.
    pub fn truth(&self) -> &Truth {
        &self.truth
    }

    /// Returns the stack's circuit as it is now.
    pub fn circuit(&self) -> Circuit {
        *self.stack.circuit()
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
        let one = |is: bool| usize::from(is);
        let carriage = 3 * one(self.carriage().is_some());
        self.stack.states() + 2 + one(self.sliding.is_some() || self.webbing.is_some()) + carriage + one(self.elements.heats())
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

    /// Makes one step with the drive held.
    #[inline(always)]
    fn step(stack: &mut Stack, sliding: Option<&mut Sliding>, drive: &HeldDrive, step_s: f64) -> Step {
        let friction = match sliding {
            None => {
                stack.advance(drive, 0.0);
                StepFriction::default()
            }
            Some(sliding) => {
                let held = sliding.force();
                let (v0, position) = (stack.tip_velocity(), stack.tip_displacement());
                stack.advance(drive, held);
                let moved = stack.tip_displacement() - position;
                let mean = sliding.slide(v0, stack.tip_velocity(), moved, step_s);
                stack.correct_force(mean - held);
                StepFriction { mean_n: mean, work_j: mean * moved, changed: sliding.force() != held }
            }
        };
        Step::from_stack(stack, friction)
    }

    /// Returns `true` if nothing moved in the last step and the friction did not change. The state
    /// then remains constant until an input changes.
    fn is_still(&self) -> bool {
        !self.last.friction.changed && self.stack.is_still() && self.carriage().is_none()
    }

    #[cfg(test)]
    pub(crate) fn rests(&self) -> bool {
        self.at_rest
    }

    /// Returns the moving part: the slider, or the belt under a horn.
    fn belt(&mut self) -> Option<&mut BeltMotion> {
        let belt = self.webbing.as_mut().map(|webbing| &mut webbing.belt);
        belt.or(self.sliding.as_mut().and_then(Sliding::slider_mut).map(|slider| &mut slider.belt))
    }

    /// Returns the carriage on the tip.
    fn carriage(&self) -> Option<&Carriage> {
        self.sliding.as_ref().and_then(Sliding::carriage)
    }

    /// Reads the slow sensors at the end of a block.
    fn slow(&mut self) -> SlowSense {
        let position_m = self.truth.belt_position_m;
        let force_n = self.truth.friction_mean_n;
        SlowSense {
            belt: self.encoder.map(|encoder| encoder.read(position_m)),
            temperature: self.board_c,
            force: self.force_channel.as_mut().map(|channel| channel.measure(force_n)),
            ..SlowSense::default()
        }
    }

    /// Closes a block of `steps` steps: updates the energy budget and the truth.
    fn account(&mut self, sums: &Sums, steps: f64) {
        self.stack.settle();
        let circuit = *self.stack.circuit();
        let step_s = self.timing.step_s();
        let supplied = step_s * sums.in_phase;
        self.energy.supplied_j += supplied + step_s * sums.further_supplied;
        let lost = step_s * circuit.rm_ohm * sums.lost;
        self.energy.lost_j += lost + step_s * sums.further_lost;
        if self.elements.heats() {
            let further_w = sums.further_lost / steps;
            self.elements.heat(
                circuit.rm_ohm * sums.lost / steps + further_w,
                self.stack.parts().leak_s * sums.voltage_square / steps,
                &self.stack,
            );
        }
        self.energy.friction_on_tip_j += sums.friction_on_tip;
        self.energy.stored_j = self.stack.stored_j();

        let block_s = steps * step_s;
        let (mean, extremes) = match &mut self.webbing {
            Some(webbing) => {
                let pull = webbing.pull(self.stack.tip_amplitude() / circuit.omega(), block_s);
                (pull, (pull, pull))
            }
            None => (sums.friction / steps, (sums.friction_min, sums.friction_max)),
        };
        let (speed, position_m) = match self.carriage() {
            Some(carriage) => (carriage.speed_m_per_s(), carriage.position_m()),
            None => self.belt().map_or((0.0, 0.0), |belt| (belt.speed_m_per_s(), belt.position_m())),
        };
        self.truth = Truth {
            friction_mean_n: mean,
            friction_min_n: extremes.0.min(mean),
            friction_max_n: extremes.1.max(mean),
            load_cell_n: self.load_cell.measure(mean),
            tip_velocity_m_per_s: self.stack.tip_amplitude(),
            series_resonance_hz: circuit.series_resonance_hz(),
            power_w: supplied / block_s,
            // The motional capacitor's voltage lags the current by a quarter turn.
            quadrature_w: sums.quadrature / steps * circuit.omega() * circuit.cm_f,
            lost_w: lost / block_s,
            friction_on_tip_w: sums.friction_on_tip / block_s,
            friction_on_slider_w: mean * speed,
            belt_position_m: position_m,
            belt_speed_m_per_s: speed,
            tip: Some(TipMotion {
                square_m2_per_s2: sums.lost / steps / circuit.force_factor_n_per_v.powi(2),
                peak_m_per_s: sums.current_peak / circuit.force_factor_n_per_v,
            }),
            horn: self.webbing.as_ref().map(Webbing::truth),
            carriage: self.carriage().map(Carriage::truth),
            heat: self.elements.heat_truth(),
        };
        self.time_s += block_s;
    }

    /// Begins a block. The elements of the plant change only between two blocks.
    pub(crate) fn begin(&mut self) -> Sums {
        self.at_rest = false;
        self.disturb();
        let block_s = self.block_s;
        if let Some(belt) = self.belt() {
            belt.advance(block_s);
        }
        if let Some(samples) = &mut self.samples {
            samples.clear();
        }
        Sums::new()
    }

    /// Plays one code. Returns the codes of voltage and current that were sampled meanwhile.
    #[inline(always)]
    pub(crate) fn play(&mut self, code: u16, sums: &mut Sums) -> (u16, u16) {
        self.play_in(Portable, code, sums)
    }

    /// Plays one code with these registers.
    #[inline(always)]
    fn play_in<F: Registers>(&mut self, four: F, code: u16, sums: &mut Sums) -> (u16, u16) {
        let (steps, step_s) = (self.timing.steps as usize, self.timing.step_s());
        let volts = self.dac.volts(code);
        let (volts, before) = self.delay.as_mut().map_or((volts, volts), |delay| delay.pass(volts));
        let held = before == volts && self.held_v == volts;
        self.held_v = volts;
        let (mut v, mut i, mut friction) = (0, 0, 0.0);
        if held && self.at_rest {
            // Nothing moves: all steps equal the last one, and so do the inputs of the converters.
            (0..steps).for_each(|_| sums.add(&self.last));
            for &(scaled, conversions) in &self.inputs {
                let [voltage, current] = self.adc.digitize(scaled.wide(four), conversions);
                v += voltage;
                i += current;
            }
            friction += steps as f64 * self.last.friction.mean_n;
        } else {
            let mut drive = self.stack.held(volts);
            self.inputs.clear();
            for step in 0..steps {
                if before != volts {
                    drive = self.stack.held_late(step, volts, before);
                }
                self.last = Self::step(&mut self.stack, self.sliding.as_mut(), &drive, step_s);
                sums.add(&self.last);
                let force = self.last.friction.mean_n;
                friction += force;
                let (adc, inputs) = (&mut self.adc, &mut self.inputs);
                self.stack.sample(four, step, &drive, force, |both, conversions| {
                    let scaled = adc.scaled(both);
                    if held {
                        inputs.push((scaled.quad(), conversions));
                    }
                    let [voltage, current] = adc.digitize(scaled, conversions);
                    v += voltage;
                    i += current;
                });
            }
            self.at_rest = held && self.is_still();
        }
        if let Some(samples) = &mut self.samples {
            // The pull of a belt is computed once a block and hardly changes from one to the next.
            let pull_n = self.webbing.as_ref().map_or(0.0, |_| self.truth.friction_mean_n);
            samples.push(Sample {
                voltage_v: self.stack.voltage(),
                motional_current_a: self.stack.motional_current(),
                tip_velocity_m_per_s: self.stack.tip_velocity(),
                tip_envelope_m_per_s: self.stack.tip_amplitude(),
                friction_n: pull_n + friction / steps as f64,
                ..Sample::default()
            });
        }
        (v, i)
    }

    /// Ends a block of `samples` samples, and reads the slow sensors.
    pub(crate) fn end(&mut self, sums: &Sums, samples: usize) -> SlowSense {
        self.account(sums, (samples * self.timing.steps as usize) as f64);
        self.slow()
    }
}

impl Analog for DrivenStack {
    fn exchange(&mut self, drive: &DriveBlock, sense: &mut SenseBlock) {
        let mut sums = self.begin();
        sense.v.clear();
        sense.i.clear();
        self.play_all(drive, &mut sums, sense);
        sense.slow = self.end(&sums, sense.v.len());
    }
}
