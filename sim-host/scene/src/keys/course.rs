//! `[[disturbance]]` and `[[fault]]`: what changes and what breaks on the way.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Profile;

/// A change of one plant value on the way. Give `to` (a step), or `rate_per_s` (a ramp), or `sine_amplitude` and `sine_hz`, or `profile` (as measured).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Disturbance {
    /// When it begins, s.
    #[schemars(range(min = 0.0, max = 1e5))]
    pub at_s: f64,
    /// Plant value that changes.
    pub key: DisturbedKey,
    /// New value, of a step.
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
    /// Measured course that the value follows from `at_s` on, to the end of the run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub profile: Option<Profile>,
}

/// A plant value that can change on the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
pub enum DisturbedKey {
    /// Series resonance, Hz; the motional inductance stays.
    #[serde(rename = "stack.bvd.series_resonance_hz")]
    SeriesResonance,
    /// Quality factor; the motional inductance stays.
    #[serde(rename = "stack.bvd.q")]
    Q,
    /// Clamped capacitance of the stack, F.
    #[serde(rename = "stack.bvd.c0_f")]
    ClampedCapacitance,
    /// Temperature of the stack over ambient, K.
    #[serde(rename = "stack.temperature_k")]
    Temperature,
    /// Series resonance of the first further mode, Hz; its inductance and quality factor stay.
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
    /// Force of a horn on a belt, N; with it goes how much the belt damps the horn.
    #[serde(rename = "rig.belt.load_n")]
    BeltLoad,
    /// Speed of a belt, m/s.
    #[serde(rename = "rig.belt.speed_m_per_s")]
    BeltSpeed,
    /// Series resonance of a stator, Hz; its modal mass and damping stay.
    #[serde(rename = "stator.series_resonance_hz")]
    StatorResonance,
    /// Load torque on the rotor, N m.
    #[serde(rename = "rig.rotor.torque_nm")]
    Torque,
    /// Force that presses the rotor on, N.
    #[serde(rename = "rig.rotor.preload_n")]
    Preload,
    /// Normal force of a contact study, N; a step, or a measured course, which goes in a step from sample to sample.
    #[serde(rename = "contact.normal_n")]
    Normal,
}

impl Disturbance {
    /// `true` if a step or a measured profile replaces the scene's own value from the beginning of the run. A series
    /// resonance or C0 also says what the inductance is, and a first normal force what ratios are counted by: these are left.
    pub fn replaces(&self, key: &str) -> bool {
        let own = serde_json::to_value(self.key).ok();
        self.at_s <= 0.0
            && (self.profile.is_some() || self.to.is_some())
            && own.as_ref().and_then(|own| own.as_str()) == Some(key)
            && REPLACED.contains(&key)
    }
}

/// Keys whose value means nothing but where they begin.
const REPLACED: [&str; 8] = [
    "stack.bvd.q",
    "stack.temperature_k",
    "rig.slider.load_n",
    "rig.slider.speed_m_per_s",
    "rig.belt.load_n",
    "rig.belt.speed_m_per_s",
    "rig.rotor.torque_nm",
    "rig.rotor.preload_n",
];

/// Something that breaks on the way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fault {
    /// When, s: from the block that it falls into; at 0 it has been so from the beginning.
    #[schemars(range(min = 0.0, max = 1e5))]
    pub at_s: f64,
    /// Part that breaks, and how.
    pub kind: FaultKind,
    /// Lane of a stator that it happens to, from 0; of the kinds `lane_open`, `lane_weak`, `lane_reversed` and `lanes_exchanged`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 3))]
    pub lane: Option<u8>,
    /// Lane that plays what `lane` should, and the other way round; of `lanes_exchanged`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 3))]
    pub other_lane: Option<u8>,
    /// Part of its voltage that the lane still plays; of `lane_weak`. Absent: a half.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub gain: Option<f64>,
}

/// Kinds of faults that a scene can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FaultKind {
    /// The current channel reads nothing: a broken lead.
    Open,
    /// A short of 50 milliohm across the stack.
    Short,
    /// The stack has lost its polarisation: C0 down by a third, the coupling down to a tenth.
    Depoled,
    /// The stack has a crack: Q down to a fifth, and a further mode 1.5 % below with a fifth of the motional capacitance.
    Cracked,
    /// Voltage and current channel are exchanged.
    Swapped,
    /// The voltage channel stays at its last code.
    SensorStuck,
    /// Both channels read the end of their range.
    Saturation,
    /// One block arrives without codes.
    Dropout,
    /// One block is delivered late.
    LateBlock,
    /// The belt stands from now on, and with it its encoder; in a scene without belt or slider, an encoder appears that stands.
    BeltStopped,
    /// The belt's encoder stays at its last count, and the belt moves on.
    EncoderStuck,
    /// A line of the belt's encoder is broken.
    EncoderLost,
    /// The belt stands from now on, and its encoder goes on counting as it last did.
    EncoderLies,
    /// The force channel stays at its last reading.
    ForceStuck,
    /// The temperature sensor at the driver reads 200 degrees Celsius.
    Overtemperature,
    /// The electrodes of a lane of the stator are not connected: its amplifier plays, and nothing draws a current.
    LaneOpen,
    /// The amplifier of a lane plays only a part of its voltage.
    LaneWeak,
    /// The amplifier of a lane plays the opposite of its voltage.
    LaneReversed,
    /// The inputs of the amplifiers of two lanes are exchanged.
    LanesExchanged,
}
