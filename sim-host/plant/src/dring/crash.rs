//! The plant of a crash: a stack driven by the firmware, and the belt whose friction the drive
//! lowers.
//!
//! ```text
//! DAC -> amplifier -> stack -> ADC          as without a belt
//!  \-> actuator -> D-ring, belt, torso -> belt force, filtered -> SlowSense
//! ```
//!
//! The amplitude of an actuator follows the drive: it rises along a straight edge while the DAC
//! plays, and falls along one otherwise. The actuator `stack` is the simulated stack itself. Three
//! motions run in parallel: the switched belt; the same belt without an actuator; and the switched
//! belt again at half the step, for the error estimate.

use firmware::seam::block::{DriveBlock, SenseBlock, SlowSense};
use hal_mock::analog::Analog;

use super::motion::{Extremes, Motion};
use super::state::Tensions;
use super::{Bench, G_M_PER_S2};
use crate::circuit::Circuit;
use crate::converter::Dac;
use crate::driven_stack::DrivenStack;
use crate::encoder::Encoder;
use crate::energy::Energy;
use crate::force_channel::ForceChannel;
use crate::sums::Sums;
use crate::truth::{Sample, Truth};
use contact::wrap::Ring;
use contact::wrap::normal::Normal;
use scene::{self, ActuatorKind, Driven};

/// Swing above which the drive counts as ON, relative to the commanded amplitude.
const ON_THRESHOLD_REL: f64 = 0.25;
/// Seed offset of the force sensor's noise, far from those of the converters.
const FORCE_SEED_OFFSET: u64 = 3 << 61;
/// States of torso, belt and spool.
const STATES: usize = 3;

/// One of the belts at a moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Belt {
    /// Displacement of the torso, m.
    pub x_m: f64,
    /// Speed of the torso, m/s.
    pub v_m_per_s: f64,
    /// Webbing that has come over the D-ring, m.
    pub payout_m: f64,
    /// Speed of the webbing over the D-ring, m/s.
    pub payout_m_per_s: f64,
    /// Force at the shoulder, N.
    pub shoulder_n: f64,
    /// Force at the retractor, N.
    pub retractor_n: f64,
}

/// Both belts at a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Time since the pulse began, s.
    pub time_s: f64,
    /// Deceleration of the vehicle, m/s^2.
    pub pulse_m_per_s2: f64,
    /// Amplitude of the actuator, 0 to 1.
    pub amplitude: f64,
    /// The switched belt.
    pub switched: Belt,
    /// The passive belt, for comparison.
    pub passive: Belt,
}

/// State of a D-ring that vibrates as a whole, at the moment of the fastest outward sliding at full
/// amplitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RingMoment {
    /// The ring, and the direction of its vibration.
    pub ring: Ring,
    /// Normal part of the vibration, if the scene includes it.
    pub normal: Option<Normal>,
    /// Peak velocity of the vibration, m/s.
    pub tip_m_per_s: f64,
    /// Sliding speed, m/s.
    pub speed_m_per_s: f64,
    /// Force at the shoulder, N.
    pub shoulder_n: f64,
    /// Force at the retractor, N.
    pub retractor_n: f64,
}

/// Result of a crash.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Playback {
    /// Mass of the torso, kg.
    pub torso_kg: f64,
    /// One frame a block, from the beginning of the pulse.
    pub frames: Vec<Frame>,
    /// Extremes of the switched belt.
    pub switched: Extremes,
    /// Extremes of the passive belt.
    pub passive: Extremes,
    /// When the drive went ON, s since the pulse began.
    pub low_s: Option<f64>,
    /// Moment of the fastest sliding, for a D-ring that vibrates as a whole.
    pub ring: Option<RingMoment>,
    /// Fraction of the pulse's work that is unaccounted for.
    pub energy_residual: f64,
    /// Relative deviation of peak force or excursion from the motion at half the step, whichever is
    /// larger.
    pub error_estimate: f64,
}

impl Playback {
    /// Returns the acceleration of the chest at a force, in g.
    pub fn chest_g(&self, shoulder_n: f64) -> f64 {
        shoulder_n / self.torso_kg / G_M_PER_S2
    }
}

/// A stack, and a torso in its belt.
#[derive(Clone, Debug)]
pub struct Crash {
    stack: DrivenStack,
    bench: Bench,
    kind: ActuatorKind,
    edge_s: f64,
    on_codes: u16,
    switched: Motion,
    passive: Motion,
    finer: Motion,
    force: Option<ForceChannel>,
    encoder: Option<Encoder>,
    block_s: f64,
    blocks: u64,
    truth: Truth,
    playback: Playback,
}

impl Crash {
    /// Creates a crash before its pulse, with torso and webbing at rest.
    pub fn new(scene: &Driven, stack: DrivenStack, dring: &scene::Dring) -> Self {
        let bench = Bench::of(dring);
        let (drive, sensors) = (&scene.controller.drive, scene.sensors);
        let asked_v = drive.amplitude_v.or(drive.scan_v).unwrap_or(0.0);
        let block_s = f64::from(scene.controller.block_samples) / sensors.sample_hz;
        Crash {
            stack,
            kind: dring.actuator,
            edge_s: 1e-3 * dring.edge_ms,
            on_codes: (ON_THRESHOLD_REL * asked_v / Dac::new(sensors, scene.amplifier).volt_per_lsb()) as u16,
            switched: Motion::new(bench.clone(), 1),
            passive: Motion::new(bench.passive(), 1),
            finer: Motion::new(bench.clone(), 2),
            force: sensors
                .force_hz
                .map(|hz| ForceChannel::new(hz, block_s, sensors.force_noise_n, scene.seed ^ FORCE_SEED_OFFSET)),
            encoder: sensors.encoder_counts_per_mm.map(|counts| Encoder::new(counts, 0.5)),
            block_s,
            blocks: 0,
            truth: Truth::default(),
            playback: Playback { torso_kg: bench.torso_kg, ..Playback::default() },
            bench,
        }
    }

    /// Returns the truth about the last block.
    pub fn truth(&self) -> &Truth {
        &self.truth
    }

    /// Returns the stack's circuit as it is now.
    pub fn circuit(&self) -> Circuit {
        self.stack.circuit()
    }

    /// Returns the stack's energy budget since the beginning.
    pub fn energy(&self) -> Energy {
        self.stack.energy()
    }

    /// Returns the duration of one sample, s.
    pub fn sample_s(&self) -> f64 {
        self.stack.sample_s()
    }

    /// Starts or stops recording blocks sample by sample.
    pub fn keep_samples(&mut self, keep: bool) {
        self.stack.keep_samples(keep);
    }

    /// Returns the samples of the last block, if they are recorded.
    pub fn samples(&self) -> &[Sample] {
        self.stack.samples()
    }

    /// Returns the result of the crash so far.
    pub fn playback(&self) -> &Playback {
        &self.playback
    }

    /// Returns the number of states that are integrated in time.
    pub fn states(&self) -> usize {
        self.stack.states() + STATES
    }

    /// Returns `true` if the first lane plays a drive rather than silence.
    fn plays(&self, drive: &DriveBlock) -> bool {
        let codes = drive.lanes.first().map_or(&[][..], |lane| lane.as_slice());
        let (least, most) = codes.iter().fold((u16::MAX, 0), |(least, most), &code| (least.min(code), most.max(code)));
        most.saturating_sub(least) / 2 > self.on_codes
    }

    fn keep(&mut self, time_s: f64, plays: bool) {
        let since_s = time_s - self.bench.pulse.at_s;
        if since_s < 0.0 {
            return;
        }
        self.playback.frames.push(Frame {
            time_s: since_s,
            pulse_m_per_s2: self.bench.pulse.at(time_s, self.bench.pulse.contains(time_s)),
            // The amplitude of a stack's tip is part of its velocity.
            amplitude: if self.kind == ActuatorKind::Stack { f64::from(u8::from(plays)) } else { self.switched.amplitude() },
            switched: belt(&self.switched),
            passive: belt(&self.passive),
        });
        self.keep_ring();
        (self.playback.switched, self.playback.passive) = (self.switched.extremes(), self.passive.extremes());
        self.playback.energy_residual = self.switched.energy_residual();
        let finer = self.finer.extremes();
        let off = |own: f64, finer: f64| if finer == 0.0 { 0.0 } else { (own / finer - 1.0).abs() };
        let (force, way) = (self.playback.switched.shoulder_n, self.playback.switched.excursion_m);
        self.playback.error_estimate = off(force, finer.shoulder_n).max(off(way, finer.excursion_m));
    }

    /// Records this moment of a ring if no earlier one has faster sliding.
    fn keep_ring(&mut self) {
        let Some((tip_m_per_s, table)) = self.switched.ring() else { return };
        let moving = belt(&self.switched);
        let fastest = self.playback.ring.map_or(0.0, |ring| ring.speed_m_per_s);
        if tip_m_per_s > 0.0 && self.switched.amplitude() >= 1.0 && moving.payout_m_per_s > fastest {
            self.playback.ring = Some(RingMoment {
                ring: *table.ring(),
                normal: table.normal().copied(),
                tip_m_per_s,
                speed_m_per_s: moving.payout_m_per_s,
                shoulder_n: moving.shoulder_n,
                retractor_n: moving.retractor_n,
            });
        }
    }
}

fn belt(motion: &Motion) -> Belt {
    let (state, Tensions { shoulder_n, retractor_n }) = (motion.state(), motion.tensions());
    Belt {
        x_m: state.x_m,
        v_m_per_s: state.v_m_per_s,
        payout_m: state.payout_m,
        payout_m_per_s: motion.payout_m_per_s(),
        shoulder_n,
        retractor_n,
    }
}

impl Crash {
    /// Begins a block.
    pub(crate) fn begin(&mut self) -> Sums {
        self.stack.begin()
    }

    /// Plays one code. Returns the codes of voltage and current that were sampled meanwhile.
    pub(crate) fn play(&mut self, code: u16, sums: &mut Sums) -> (u16, u16) {
        self.stack.play(code, sums)
    }

    /// Ends the block that played `drive`, and reads the slow sensors.
    pub(crate) fn end(&mut self, drive: &DriveBlock, sums: &Sums) -> SlowSense {
        let slow = self.stack.end(sums, drive.lanes.first().map_or(0, |lane| lane.len()));
        self.advance(drive, slow)
    }

    /// Advances torso and belt by a block in which the stack has played `drive`. Returns the sensor
    /// readings.
    fn advance(&mut self, drive: &DriveBlock, slow: SlowSense) -> SlowSense {
        let plays = self.plays(drive);
        let begins_s = self.blocks as f64 * self.block_s;
        if plays && self.playback.low_s.is_none() && begins_s >= self.bench.pulse.at_s {
            self.playback.low_s = Some(begins_s - self.bench.pulse.at_s);
        }
        let rate_per_s = if plays { 1.0 } else { -1.0 } / self.edge_s;
        for motion in [&mut self.switched, &mut self.finer] {
            match self.kind {
                ActuatorKind::Stack => motion.shake(self.stack.truth().tip_velocity_m_per_s),
                _ => motion.drive(rate_per_s),
            }
        }
        self.blocks += 1;
        let time_s = self.blocks as f64 * self.block_s;
        for motion in [&mut self.switched, &mut self.passive, &mut self.finer] {
            motion.advance_to(time_s);
        }
        let (shoulder_n, payout_m) = (self.switched.tensions().shoulder_n, self.switched.state().payout_m);
        self.truth =
            Truth { belt_position_m: payout_m, belt_speed_m_per_s: self.switched.payout_m_per_s(), ..*self.stack.truth() };
        self.keep(time_s, plays);
        SlowSense {
            force: self.force.as_mut().map(|force| force.measure(shoulder_n)),
            belt: self.encoder.map(|encoder| encoder.read(payout_m)),
            ..slow
        }
    }
}

impl Analog for Crash {
    fn exchange(&mut self, drive: &DriveBlock, sense: &mut SenseBlock) {
        self.stack.exchange(drive, sense);
        sense.slow = self.advance(drive, sense.slow);
    }
}
