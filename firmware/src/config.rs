//! What a user sets, in SI units. May be wrong: [`Controller::build`](crate::controller::Controller::build) checks it.

mod friction;
mod limits;
mod link;
mod restraint;

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::block::{Amplitude, MAX_LANES};
pub use crate::config::friction::{Friction, FrictionLaw};
pub use crate::config::limits::{Limits, Thermometer};
pub use crate::config::link::{LONGEST_PATIENCE_S, Link};
pub use crate::config::restraint::Restraint;

/// The most ON windows a burst schedule can list.
pub const MAX_WINDOWS: usize = 8;

/// The most frequencies at which lanes are calibrated.
pub const MAX_TRIM_POINTS: usize = 5;

/// The whole configuration of a controller.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Config {
    /// Samples a second, of DAC and ADC alike, Hz.
    pub sample_hz: f32,
    /// Samples in a block.
    pub block_samples: u16,
    /// Drive lanes, 1 to 4.
    pub lanes: u8,
    /// What a converter code is worth.
    pub front_end: FrontEnd,
    /// The drive.
    pub drive: Drive,
    /// What the frequency does while running.
    pub sweep: Sweep,
    /// Lane offsets and trims.
    pub phasing: Phasing,
    /// The ON/OFF schedule.
    pub burst: Burst,
    /// How the frequency is found and kept.
    pub tracking: Tracking,
    /// The stack as a thermometer of itself.
    pub thermometer: Thermometer,
    /// What must never be exceeded.
    pub limits: Limits,
    /// The friction switch, which then sets amplitude and bursts while running. The drive's amplitude is its loudest.
    pub friction: Option<Friction>,
    /// When the drive of a seat belt's D-ring is ON, in place of burst schedule and gate; `None`: it serves no belt.
    pub restraint: Option<Restraint>,
    /// The link to the host.
    pub link: Link,
}

/// Scale factors of the converters; on a board they come from the settings store.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrontEnd {
    /// Volts at the stack per voltage code.
    pub volt_per_lsb: f32,
    /// Amperes into the stack per current code.
    pub ampere_per_lsb: f32,
    /// The sense code at zero (before the self-test has measured the offset).
    pub sense_mid_code: u16,
    /// The largest sense code.
    pub sense_max_code: u16,
    /// Volts at the amplifier's output per drive code.
    pub drive_volt_per_lsb: f32,
    /// The drive code at zero volts.
    pub drive_mid_code: u16,
    /// The largest drive code.
    pub drive_max_code: u16,
    /// Drive converters, each with its amplifier, that the board has.
    pub drive_lanes: u8,
    /// Belt that passes from one count of its encoder to the next, m; `None`: there is no encoder.
    pub metre_per_count: Option<f32>,
    /// Bandwidth of the force channel, Hz; `None`: there is no force channel.
    pub force_hz: Option<f32>,
}

/// The drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drive {
    /// Nominal frequency, Hz: the centre of the scan, or the frequency held where nothing is tracked.
    pub frequency_hz: f32,
    /// The amplitude asked for while running.
    pub amplitude: Amplitude,
    /// Peak voltage of self-test and scan, and where the amplitude loop starts from, V.
    pub scan_volts: f32,
    /// The waveform while running; self-test, scan and calibration are by sines.
    pub shape: ShapeKind,
    /// The band of a noise, from and to, Hz.
    pub noise_band_hz: (f32, f32),
    /// Adds random steps of up to one code before rounding, so that rounding leaves noise in place of harmonics.
    pub dither: bool,
    /// Of noise and dither.
    pub seed: u64,
}

impl Drive {
    /// A plain sine; the band of a noise is as wide as half the frequency.
    pub fn sine(frequency_hz: f32, amplitude: Amplitude, scan_volts: f32) -> Self {
        let noise_band_hz = (0.75 * frequency_hz, 1.25 * frequency_hz);
        Drive { frequency_hz, amplitude, scan_volts, shape: ShapeKind::Sine, noise_band_hz, dither: false, seed: 1 }
    }
}

/// The waveform.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ShapeKind {
    /// Sine.
    #[default]
    Sine,
    /// Square, band-limited.
    Square,
    /// Sawtooth, rising, band-limited.
    Sawtooth,
    /// Gaussian noise within a band, clipped at the peak: four times its rms.
    Noise,
}

/// What the frequency does while running.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Sweep {
    /// It stays where it is tracked, or where it was put.
    #[default]
    Hold,
    /// It moves by itself.
    Chirp(Chirp),
}

/// A chirp.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Chirp {
    /// How it gets from one end to the other.
    pub kind: ChirpKind,
    /// Where it begins, Hz; about a resonance, as an offset from it.
    pub start_hz: f32,
    /// Where it ends, Hz.
    pub stop_hz: f32,
    /// How long that takes, s; whole blocks.
    pub time_s: f64,
    /// What follows.
    pub then: Then,
    /// What its frequencies count from.
    pub around: Around,
}

/// How a chirp gets from one end to the other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ChirpKind {
    /// By equal steps.
    #[default]
    Linear,
    /// By equal ratios.
    Exponential,
}

/// What follows the end of a chirp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Then {
    /// The last frequency.
    #[default]
    Hold,
    /// The same chirp again.
    Repeat,
    /// The way back, and so on.
    UpDown,
}

/// What the frequencies of a chirp count from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Around {
    /// From 0 Hz: nothing is tracked.
    #[default]
    Zero,
    /// From the resonance, which is tracked meanwhile.
    Resonance,
}

/// Lane offsets and trims.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Phasing {
    /// Turning direction of a four-phase drive.
    pub direction: Direction,
    /// Correction of each lane's phase, turns.
    pub phase_trim_turns: Vec<f32, MAX_LANES>,
    /// Correction of each lane's gain; 1 is none.
    pub gain_trim: Vec<f32, MAX_LANES>,
    /// What a calibration has found, on top of these.
    pub calibration: LaneTrims,
}

/// Trims of all lanes at rising frequencies; straight lines between them, and the nearest beyond.
pub type LaneTrims = Vec<TrimPoint, MAX_TRIM_POINTS>;

/// Trims of all lanes at one frequency.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TrimPoint {
    /// Frequency, Hz.
    pub hz: f32,
    /// Trims, lane by lane.
    pub lanes: [Trim; MAX_LANES],
}

/// Correction of one lane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trim {
    /// Added to the lane's phase, turns.
    pub phase_turns: f32,
    /// Multiplies its gain.
    pub gain: f32,
}

impl Default for Trim {
    fn default() -> Self {
        Trim { phase_turns: 0.0, gain: 1.0 }
    }
}

/// Turning direction of a four-phase drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Direction {
    /// Lanes lead one another in the order 0, 1, 2, 3.
    #[default]
    Forward,
    /// The other way round.
    Reverse,
}

/// The ON/OFF schedule, in seconds since the first sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Burst {
    /// When the drive is ON.
    pub schedule: Schedule,
    /// How it gets there.
    pub edge: Edge,
    /// What has rung up is rung down at the end of each burst, by drive against it.
    pub brake: bool,
}

/// When the drive is ON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Schedule {
    /// Always, while running.
    Continuous,
    /// In each window from `.0` to `.1`, s.
    Windows(Vec<(f64, f64), MAX_WINDOWS>),
    /// For the first part `duty` of every `period_s`.
    Periodic {
        /// Period, s.
        period_s: f64,
        /// Part of the period that is ON, 0 to 1.
        duty: f64,
    },
}

/// How the envelope gets from OFF to ON and back.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Edge {
    /// At once, where the first lane passes zero, and for whole periods.
    Hard,
    /// Along a raised cosine of so many drive periods.
    Soft {
        /// Length of the edge in periods of the nominal frequency.
        cycles: f32,
    },
    /// As fast as the voltage limit allows: rung up by louder drive, and rung down by drive against it, from what is tracked. For sines whose
    /// resonance is tracked.
    Boost,
}

/// How the frequency is found and kept. The nominal values are what a user knows beforehand.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tracking {
    /// What is tracked.
    pub mode: TrackingMode,
    /// The frequency window, as a fraction of the nominal frequency on each side.
    pub span: f32,
    /// Bandwidth of the phase loop, Hz.
    pub bandwidth_hz: f32,
    /// Quality factor, within a factor of two.
    pub nominal_q: f32,
    /// Motional inductance, H, within a tenth; `None`: what the power-on calibration finds.
    pub nominal_lm_h: Option<f32>,
    /// Clamped capacitance, F, within some per cent.
    pub nominal_c0_f: f32,
    /// How fast the clamped capacitance may drift, relative, 1/s: the observer measures it anew as often as that demands. Zero: never.
    pub c0_drift_per_s: f32,
}

/// What is tracked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum TrackingMode {
    /// The resonance itself, from how the motional current changes: does not wait for the ring-up.
    Observer,
    /// The phase of the motional current: the series resonance, at any load.
    PhaseLock,
    /// The phase of the total current: the plain V-I loop, kept as the reference that fails under load.
    ZeroPhase,
    /// Nothing: the nominal frequency is held.
    Off,
}
