//! `[[disturbance]]` and `[[fault]]`: changes and faults during a run.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Profile;

/// A change of one plant value during the run. Give `to` (a step), or `rate_per_s` (a ramp), or
/// `sine_amplitude` and `sine_hz`, or `profile` (as measured).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Disturbance {
    /// Beginning of the change, s.
    #[schemars(range(min = 0.0, max = 1e5))]
    pub at_s: f64,
    /// Plant value that changes.
    pub key: DisturbedKey,
    /// New value after a step.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to: Option<f64>,
    /// Slope of a ramp, per second.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_per_s: Option<f64>,
    /// Amplitude of a sine about the present value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sine_amplitude: Option<f64>,
    /// Frequency of the sine, Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1e4))]
    pub sine_hz: Option<f64>,
    /// Measured profile that the value follows from `at_s` to the end of the run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub profile: Option<Profile>,
}

/// A plant value that can change during the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
pub enum DisturbedKey {
    /// Series resonance, Hz; the motional inductance does not change.
    #[serde(rename = "stack.bvd.series_resonance_hz")]
    SeriesResonance,
    /// Quality factor; the motional inductance does not change.
    #[serde(rename = "stack.bvd.q")]
    Q,
    /// Clamped capacitance of the stack, F.
    #[serde(rename = "stack.bvd.c0_f")]
    ClampedCapacitance,
    /// Temperature of the stack over ambient, K.
    #[serde(rename = "stack.temperature_k")]
    Temperature,
    /// Series resonance of the first further mode, Hz; its inductance and quality factor do not
    /// change.
    #[serde(rename = "stack.mode.0.series_resonance_hz")]
    FurtherResonance0,
    /// Series resonance of the second further mode, Hz.
    #[serde(rename = "stack.mode.1.series_resonance_hz")]
    FurtherResonance1,
    /// Series resonance of the third further mode, Hz.
    #[serde(rename = "stack.mode.2.series_resonance_hz")]
    FurtherResonance2,
    /// Load on the slider, N.
    #[serde(rename = "rig.slider.load_n")]
    Load,
    /// Sliding speed of the slider, m/s.
    #[serde(rename = "rig.slider.speed_m_per_s")]
    Speed,
    /// Force of a horn on a belt, N; the damping of the horn by the belt changes with it.
    #[serde(rename = "rig.belt.load_n")]
    BeltLoad,
    /// Speed of a belt, m/s.
    #[serde(rename = "rig.belt.speed_m_per_s")]
    BeltSpeed,
    /// Series resonance of a stator, Hz; its modal mass and damping do not change.
    #[serde(rename = "stator.series_resonance_hz")]
    StatorResonance,
    /// Load torque on the rotor, N m.
    #[serde(rename = "rig.rotor.torque_nm")]
    Torque,
    /// Force that presses the rotor on, N.
    #[serde(rename = "rig.rotor.preload_n")]
    Preload,
    /// Normal force of a contact study, N; a step, or a measured profile, which is applied in steps
    /// from sample to sample.
    #[serde(rename = "contact.normal_n")]
    Normal,
}

impl Disturbance {
    /// `true` if a step or a measured profile replaces the scene's own value from the beginning of
    /// the run.
    ///
    /// Excluded are values that have a second meaning: a series resonance or C0 also determines the
    /// inductance, and the first normal force is the reference of ratios.
    pub fn replaces(&self, key: &str) -> bool {
        let own = serde_json::to_value(self.key).ok();
        self.at_s <= 0.0
            && (self.profile.is_some() || self.to.is_some())
            && own.as_ref().and_then(|own| own.as_str()) == Some(key)
            && INITIAL_VALUE_KEYS.contains(&key)
    }
}

/// Keys whose value only sets the beginning of the run.
const INITIAL_VALUE_KEYS: [&str; 8] = [
    "stack.bvd.q",
    "stack.temperature_k",
    "rig.slider.load_n",
    "rig.slider.speed_m_per_s",
    "rig.belt.load_n",
    "rig.belt.speed_m_per_s",
    "rig.rotor.torque_nm",
    "rig.rotor.preload_n",
];

/// A fault during the run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fault {
    /// Time of the fault, s. It acts from the block that contains this time; at 0, from the
    /// beginning.
    #[schemars(range(min = 0.0, max = 1e5))]
    pub at_s: f64,
    /// Part that fails, and the kind of failure.
    pub kind: FaultKind,
    /// Lane of the stator that fails, from 0; for the kinds `lane_open`, `lane_weak`,
    /// `lane_reversed` and `lanes_exchanged`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 3))]
    pub lane: Option<u8>,
    /// Lane that is exchanged with `lane`; for `lanes_exchanged`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 3))]
    pub other_lane: Option<u8>,
    /// Part of the voltage that the lane still outputs; for `lane_weak`. Default: 0.5.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub gain: Option<f64>,
    /// Resistance of a `short` across the stack, ohm. Default: 0.05.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-3, max = 1e6))]
    pub ohm: Option<f64>,
}

/// Kinds of faults that a scene can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FaultKind {
    /// The current channel reads zero, as with a broken lead.
    Open,
    /// A short across the stack, of 50 milliohm unless `ohm` is given.
    Short,
    /// The stack has lost its polarisation: C0 falls by a third, the coupling to a tenth.
    Depoled,
    /// The stack has a crack: Q falls to a fifth, and a further mode appears 1.5 % below, with a
    /// fifth of the motional capacitance.
    Cracked,
    /// Voltage and current channel are exchanged.
    Swapped,
    /// The voltage channel stays at its last code.
    SensorStuck,
    /// The current channel is one sample late against the voltage channel.
    CurrentLate,
    /// Both channels read the end of their range.
    Saturation,
    /// One block arrives without codes.
    Dropout,
    /// One block is delivered late.
    LateBlock,
    /// The belt stops, and its encoder with it. In a scene without belt or slider, an encoder is
    /// added that does not move.
    BeltStopped,
    /// The belt's encoder stays at its last count while the belt moves.
    EncoderStuck,
    /// A line of the belt's encoder is broken.
    EncoderLost,
    /// The belt stops, but its encoder continues to count at the last rate.
    EncoderLies,
    /// The force channel stays at its last reading.
    ForceStuck,
    /// The temperature sensor at the driver reads 200 degrees Celsius.
    Overtemperature,
    /// The electrodes of a lane of the stator are not connected: its amplifier outputs a voltage,
    /// but no current flows.
    LaneOpen,
    /// The amplifier of a lane outputs only a part of its voltage.
    LaneWeak,
    /// The amplifier of a lane outputs its voltage with reversed sign.
    LaneReversed,
    /// The inputs of the amplifiers of two lanes are exchanged.
    LanesExchanged,
}
