//! Data exchanged between board and controller once a block.
//!
//! Plain values: no time, no callback, no trait object. The controller's decisions depend only on
//! them and on its state, so that a recorded stream of [`Orders`] and [`SenseBlock`] replays a run
//! bit for bit.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::seam::units::{Hertz, Turns};

/// Longest block of a controller, samples.
pub const MAX_BLOCK_SAMPLES: usize = 100;

/// Largest number of drive lanes (four-phase motor signals).
pub const MAX_LANES: usize = 4;

/// Number of blocks from sense codes to the drive codes computed from them: with half/complete DMA,
/// the codes returned for sense block `k` play as block `k + LATENCY_BLOCKS`, because `k + 1` was
/// returned by the call before.
pub const LATENCY_BLOCKS: usize = 2;

/// Returns the sample of the playing block from which a [dropped](DriveBlock::drops_queue) queue is
/// silent.
///
/// The controller answers within three quarters of a block. Simulated boards are silent from
/// exactly this sample; a real board from the answer on, which is not later.
pub const fn dropped_from(block_samples: usize) -> usize {
    block_samples - block_samples / 4
}

/// Converter codes of one channel over one block.
pub type Codes = Vec<u16, MAX_BLOCK_SAMPLES>;

/// Orders of the background task, latched at the start of each block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Orders {
    /// Number of the order; increases by one with each new order, and is returned in the report.
    pub sequence: u32,
    /// Requested state of the controller.
    pub request: Request,
    /// Number of the attempt; increases by one with each order to scan, calibrate or run. An
    /// attempt that is complete is repeated only under a new number.
    pub attempt: u32,
    /// Gate of the drive in a run.
    pub gate: Gate,
    /// Amplitude set point; `None` is the configured one.
    pub amplitude: Option<Amplitude>,
    /// Offset of the drive from the resonance, or from the configured frequency if nothing is
    /// tracked, Hz: the speed of a motor.
    pub detune: Hertz,
    /// Phase by which lanes 1 and 3 lead lanes 0 and 2: a quarter turn is forward, minus a quarter
    /// is reverse, zero is a standing wave, values between are lower speeds. `None` is the
    /// configured direction.
    pub quadrature: Option<Turns>,
    /// Friction set point; `None` is the configured target. No effect without a friction switch.
    pub friction: Option<Target>,
    /// Torso mass of the occupant as read by the seat, kg; `None` if the seat has not read it.
    pub torso_kg: Option<f32>,
    /// `true` if the emergency stop is pressed.
    pub emergency_stop: bool,
    /// `true` if the host has been silent for longer than its timeout.
    pub host_lost: bool,
    /// `true` clears the fault of an earlier order. Acts once per sequence number.
    pub clear_fault: bool,
}

/// Requested state of the controller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Request {
    /// Stay silent, without a fault.
    #[default]
    Idle,
    /// Self-test and scan, then silence with the transducer identified.
    Scan,
    /// Self-test, scan, lock, and run.
    Run,
    /// Self-test and calibration of the lanes, then silence with the lanes trimmed.
    Calibrate,
}

/// Gate of the drive in a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Gate {
    /// The drive follows the configured burst schedule.
    #[default]
    Scheduled,
    /// The drive is always on.
    On,
    /// The drive is always off; the frequency is held.
    Off,
    /// The drive is off, and stops the residual vibration by driving against it, up to the limits
    /// of voltage and current.
    Brake,
}

/// Amplitude set point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Amplitude {
    /// Peak drive voltage at the amplifier's terminals, V.
    Volts(f32),
    /// Peak motional current, A: tip velocity times force factor, held under any load.
    MotionalCurrent(f32),
}

impl Amplitude {
    /// Returns the amplitude multiplied by `part`.
    #[inline]
    pub(crate) fn derated(self, part: f32) -> Self {
        match self {
            Amplitude::Volts(volts) => Amplitude::Volts(part * volts),
            Amplitude::MotionalCurrent(amperes) => Amplitude::MotionalCurrent(part * amperes),
        }
    }
}

/// Friction set point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Target {
    /// Friction relative to that without vibration, 0 to 1.
    Ratio(f32),
    /// Friction force, N. Needs a force sensor.
    Force(f32),
}

impl Target {
    /// Returns `true` if the target is a ratio from 0 to 1, or a finite force that is not negative.
    pub fn is_plausible(&self) -> bool {
        match *self {
            Target::Ratio(ratio) => (0.0..=1.0).contains(&ratio),
            Target::Force(newtons) => newtons.is_finite() && newtons >= 0.0,
        }
    }
}

/// Codes of the converters in one block, and the latest slow readings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SenseBlock {
    /// Voltage codes, one a sample (summed over oversampled conversions).
    pub v: Codes,
    /// Current codes, sampled with the voltage.
    pub i: Codes,
    /// Readings that change slowly.
    pub slow: SlowSense,
}

/// Slow readings; `None` if the board has no such sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SlowSense {
    /// Reading of the belt's encoder.
    pub belt: Option<BeltSense>,
    /// Temperature at the driver, °C.
    pub temperature: Option<f32>,
    /// Force in the belt or at the slider, N.
    pub force: Option<f32>,
    /// Hardware trips since the last block.
    pub trips: Option<Trips>,
    /// Number of blocks that were due but not delivered since the last call.
    pub missed_blocks: Option<u32>,
}

/// Reading of a quadrature decoder at the end of a block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BeltSense {
    /// Count of the edges of both channels: increases as the belt pays out, decreases as it is
    /// drawn back, and wraps.
    pub counts: i32,
    /// `true` if a line to the encoder is broken: the two wires of a channel are not complementary.
    pub broken: bool,
}

/// Trips of the hardware protection, which acts faster than a block and is reported afterwards.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Trips {
    /// `true` if the comparator on the current sense has tripped.
    pub over_current: bool,
    /// `true` if the amplifier reports a failure or has protected itself.
    pub amplifier_fault: bool,
    /// `true` if the amplifier's supply is outside of its window.
    pub supply: bool,
}

/// Codes to play.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DriveBlock {
    /// DAC codes of each lane.
    pub lanes: Vec<Codes, MAX_LANES>,
    /// Lane to which the board's multiplexer connects the sense channels while these codes play.
    pub listen: u8,
    /// `true` if the controller has entered a fault: the codes returned before must not play any
    /// longer.
    ///
    /// The board silences all lanes at once, in the playing block by sample [`dropped_from`] at the
    /// latest. Then it plays these codes, which are silent too.
    pub drops_queue: bool,
}

impl DriveBlock {
    /// Creates a block of `lanes` lanes with `samples` samples of `code`, to play before the first
    /// call has returned. Lanes beyond [`MAX_LANES`] and samples beyond [`MAX_BLOCK_SAMPLES`] are
    /// omitted.
    pub fn silent(lanes: usize, samples: usize, code: u16) -> Self {
        let lane: Codes = core::iter::repeat_n(code, samples.min(MAX_BLOCK_SAMPLES)).collect();
        DriveBlock { lanes: core::iter::repeat_n(lane, lanes.min(MAX_LANES)).collect(), listen: 0, drops_queue: false }
    }
}
