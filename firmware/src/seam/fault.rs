//! Why the controller does not drive, or drives less than was asked, each by a number.
//!
//! A [`Fault`] ends the drive and stays until it is cleared. A [`Limit`] does neither: it says why the drive does less than
//! was asked, right now. Numbers are for the log and for other languages, and never change their meaning.

use serde::{Deserialize, Serialize};

/// Why the drive is muted. On the wire it is its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "u8", try_from = "u8")]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[repr(u8)]
pub enum Fault {
    /// The slow side has asked for an emergency stop.
    EmergencyStop = 10,
    /// A block came late, was lost, or was cut short.
    LateBlock = 11,
    /// The host has been silent for longer than it may be while the drive is on.
    HostLost = 12,
    /// A sense channel is offset, stuck, or does not show what was played: 8 blocks, or the self-test's 96.
    SensorImplausible = 20,
    /// More current than the limit, seen here or by the comparator.
    OverCurrent = 21,
    /// Far more current than the clamped capacitance takes.
    LoadShorted = 22,
    /// Far less.
    LoadOpen = 23,
    /// A lane is not heard, is further off than a trim can be for, or does not do what its trim should make it do.
    LaneImplausible = 24,
    /// The clamped capacitance is more than 20 % off what it was told to be: a stack that has depoled, or another stack. Known at the end of the
    /// calibration at power-on, 45 ms at 40 kHz.
    CapacitanceShifted = 25,
    /// The resonance is missing, damped more than it was told, or has company it should not have: a crack. Known at the end of the calibration at
    /// power-on, 55 ms at 40 kHz.
    ResonanceDamaged = 26,
    /// The voltage leads where the current should: the two sense channels are swapped, or one of them is reversed. Known 4 blocks after the
    /// self-test's tone is heard.
    SenseSwapped = 27,
    /// A sense channel stands at the end of its range, for more than an eighth of a block: known with that block. Of the current, where the limit is
    /// beyond the range.
    SenseSaturated = 28,
    /// The scan has found no resonance in the window.
    NoResonance = 30,
    /// The loop has not locked in time.
    NoLock = 31,
    /// The loop was locked and is not any more.
    LossOfLock = 32,
    /// The observer and the motional phase, which it does not use, say different frequencies.
    TrackersDisagree = 33,
    /// It has locked to a resonance that is not the one it was told of.
    WrongMode = 34,
    /// The belt stands still under the drive: muted for 100 ms, or at once where a measurement was under way.
    BeltStopped = 40,
    /// A line to the belt's encoder is broken, or the encoder is gone: known with that block.
    BeltSensorLost = 41,
    /// The encoder counts, and the force is that of a belt that stands: about 4 ms after it has stopped.
    BeltSensorImplausible = 42,
    /// More electrical energy for each metre of belt than the limit.
    EnergyPerLength = 43,
    /// Board or stack are hotter than the limit.
    OverTemperature = 44,
    /// The drive has been ON for longer than the limit.
    OnTimeExceeded = 45,
    /// The force channel is missing, stuck for 32 ms, or reads no number.
    ForceSensorImplausible = 46,
}

impl Fault {
    /// The number of this fault.
    pub fn code(self) -> u8 {
        self as u8
    }
}

/// What keeps the drive from doing what was asked. On the wire it is its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "u8", try_from = "u8")]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[repr(u8)]
pub enum Limit {
    /// The voltage asked for (by an order or by the amplitude loop) is over the voltage limit.
    OverVoltageRequest = 96,
    /// The tracker stands at the edge of the frequency window, or an order asks for more.
    FrequencyWindow = 97,
    /// The drive has been ON for long, in bursts too short for the tracker to hear the resonance.
    NotTracking = 98,
    /// The quadrature asked for is over a quarter turn.
    QuadratureRequest = 99,
    /// The amplitude is reduced: board or stack are nearly too hot, or the mean power is at its limit.
    Derated = 100,
    /// The drive is muted until the belt moves.
    BeltMuted = 101,
    /// The belt is faster than the tip can be: vibration does not change the friction.
    NoAuthority = 102,
    /// The friction ratio asked for is below what the loudest drive does, above one, or nobody knows what it is.
    RatioUnreachable = 103,
    /// The limits leave too little above the drive for a boosted edge: it ends below its level, or it is left out beside the resonance.
    BoostLimited = 104,
    /// The seat has read no torso mass, or one that cannot be: nobody is light, and friction stays HIGH in a crash.
    RestraintUnclassified = 105,
}

/// A number on the wire, and back: a variant that is added later does not change the meaning of the others.
macro_rules! numbered {
    ($name:ident, $($variant:ident)*) => {
        impl From<$name> for u8 {
            fn from(value: $name) -> u8 {
                value as u8
            }
        }

        impl TryFrom<u8> for $name {
            type Error = &'static str;

            fn try_from(code: u8) -> Result<Self, Self::Error> {
                [$($name::$variant),*].into_iter().find(|&known| known as u8 == code).ok_or("a number without a meaning")
            }
        }
    };
}

numbered!(Fault, EmergencyStop LateBlock HostLost SensorImplausible OverCurrent LoadShorted LoadOpen LaneImplausible CapacitanceShifted ResonanceDamaged SenseSwapped SenseSaturated NoResonance NoLock LossOfLock TrackersDisagree WrongMode BeltStopped BeltSensorLost BeltSensorImplausible EnergyPerLength OverTemperature OnTimeExceeded ForceSensorImplausible);
numbered!(Limit, OverVoltageRequest FrequencyWindow NotTracking QuadratureRequest Derated BeltMuted NoAuthority RatioUnreachable BoostLimited RestraintUnclassified);
