//! The data that crosses the seam between a board and the controller, once a block.
//!
//! Plain values: no time, no callback, no trait object. Everything the controller decides follows from these and its
//! state, so a recorded stream of [`Orders`] and [`SenseBlock`] replays a run bit for bit.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::seam::units::{Hertz, Turns};

/// The longest block a controller can be built for, in samples.
pub const MAX_BLOCK_SAMPLES: usize = 100;

/// The most drive lanes (four-phase motor signals).
pub const MAX_LANES: usize = 4;

/// Blocks between the call that returns codes and their playing: with half/complete DMA, the codes returned for sense
/// block `k` play as block `k + LATENCY_BLOCKS`, because `k + 1` was returned by the call before.
pub const LATENCY_BLOCKS: usize = 2;

/// The sample of the block that is playing from which a queue that is [dropped](DriveBlock::drops_queue) is silent at the latest: the controller answers
/// within three quarters of a block. Simulated boards are silent from exactly this sample on; a real one, from its answer on.
pub const fn dropped_from(block_samples: usize) -> usize {
    block_samples - block_samples / 4
}

/// Converter codes of one channel over one block.
pub type Codes = Vec<u16, MAX_BLOCK_SAMPLES>;

/// Orders of the background task, latched at the start of each block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Orders {
    /// Rises by one with every new order, so that a report says which order it obeys.
    pub sequence: u32,
    /// The state that the controller is asked for.
    pub request: Request,
    /// Rises by one with every order to scan, to calibrate or to run, so that what is done is repeated only if it is ordered again.
    pub attempt: u32,
    /// When to let the drive through, while running.
    pub gate: Gate,
    /// The amplitude asked for; `None` keeps the configured one.
    pub amplitude: Option<Amplitude>,
    /// How far to drive beside the resonance, or beside the configured frequency where nothing is tracked, Hz: a motor's speed by frequency.
    pub detune: Hertz,
    /// How far lanes 1 and 3 lead lanes 0 and 2: a quarter turn forward, minus a quarter in reverse, zero a standing wave, and speeds in
    /// between. `None` is the configured direction.
    pub quadrature: Option<Turns>,
    /// Set point of the friction; `None` is the configured target. It has no effect where no friction switch is configured.
    pub friction: Option<Target>,
    /// Torso mass of the occupant, kg, as the seat has read it; `None` where it has not.
    pub torso_kg: Option<f32>,
    /// The emergency stop is pressed.
    pub emergency_stop: bool,
    /// The host has been silent for longer than it may be.
    pub host_lost: bool,
    /// Forget the fault of an earlier order. Acts once per sequence number.
    pub clear_fault: bool,
}

/// What the controller is asked to do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Request {
    /// Stay silent, without a fault.
    #[default]
    Idle,
    /// Self-test and scan, then fall silent again with the transducer identified.
    Scan,
    /// Self-test, scan, lock, and run.
    Run,
    /// Self-test, and measure what each lane adds; then fall silent with the lanes trimmed.
    Calibrate,
}

/// When the drive is let through while running.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Gate {
    /// As the configured burst schedule says.
    #[default]
    Scheduled,
    /// The drive is always on.
    On,
    /// Never; the frequency is held.
    Off,
    /// The drive is off, and the residual vibration is stopped by drive against it, up to the voltage limit.
    Brake,
}

/// The amplitude asked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Amplitude {
    /// Peak drive voltage at the amplifier's terminals, in volts.
    Volts(f32),
    /// Peak motional current, in amperes: the tip velocity times the force factor, held whatever the load does.
    MotionalCurrent(f32),
}

impl Amplitude {
    /// This part of the amplitude.
    #[inline]
    pub(crate) fn derated(self, part: f32) -> Self {
        match self {
            Amplitude::Volts(volts) => Amplitude::Volts(part * volts),
            Amplitude::MotionalCurrent(amperes) => Amplitude::MotionalCurrent(part * amperes),
        }
    }
}

/// Set point of the friction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Target {
    /// A part of the friction without vibration, 0 to 1.
    Ratio(f32),
    /// A friction force, N. Needs a force sensor.
    Force(f32),
}

impl Target {
    /// Whether the target is a finite number and not negative.
    pub fn is_plausible(&self) -> bool {
        match *self {
            Target::Ratio(ratio) => (0.0..=1.0).contains(&ratio),
            Target::Force(newtons) => newtons.is_finite() && newtons >= 0.0,
        }
    }
}

/// What the converters saw during one block, and the latest slow readings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SenseBlock {
    /// Voltage codes, one a sample (summed over oversampled conversions).
    pub v: Codes,
    /// Current codes, sampled with the voltage.
    pub i: Codes,
    /// Readings that change slowly.
    pub slow: SlowSense,
}

/// Slow readings; `None` where the board has no such sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SlowSense {
    /// What the decoder of the belt's encoder has seen.
    pub belt: Option<BeltSense>,
    /// Temperature at the driver, degrees Celsius.
    pub temperature: Option<f32>,
    /// Force in the belt or at the slider, newtons.
    pub force: Option<f32>,
    /// What the hardware has tripped on since the last block.
    pub trips: Option<Trips>,
    /// Blocks that were due and not delivered since the last call.
    pub missed_blocks: Option<u32>,
}

/// What a quadrature decoder knows of the belt at the end of a block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BeltSense {
    /// Edges of both channels so far, up as the belt pays out and down as it is drawn back; wraps.
    pub counts: i32,
    /// A line to the encoder is broken: the two wires of a channel do not contradict each other.
    pub broken: bool,
}

/// Protection that acts in hardware, faster than a block, and is reported to the controller afterwards.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Trips {
    /// The comparator on the current sense has fired.
    pub over_current: bool,
    /// The amplifier says that it has failed, or has protected itself.
    pub amplifier_fault: bool,
    /// The amplifier's supply is outside of its window.
    pub supply: bool,
}

/// The codes to play, for each lane.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DriveBlock {
    /// DAC codes of each lane.
    pub lanes: Vec<Codes, MAX_LANES>,
    /// The lane that the sense channels are connected to while these codes play, by the board's multiplexer.
    pub listen: u8,
    /// The controller has entered a fault: what was returned before and has not played yet must not play. The board is silent at once on all lanes, in the
    /// block that plays at present by sample [`dropped_from`] at the latest, and then plays these codes, which are silent, too.
    pub drops_queue: bool,
}

impl DriveBlock {
    /// `lanes` lanes of `samples` samples at `code`: what plays before the first call has returned.
    ///
    /// Lanes beyond [`MAX_LANES`] and samples beyond [`MAX_BLOCK_SAMPLES`] are left out.
    pub fn silent(lanes: usize, samples: usize, code: u16) -> Self {
        let lane: Codes = core::iter::repeat_n(code, samples.min(MAX_BLOCK_SAMPLES)).collect();
        DriveBlock { lanes: core::iter::repeat_n(lane, lanes.min(MAX_LANES)).collect(), listen: 0, drops_queue: false }
    }
}
