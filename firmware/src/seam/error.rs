//! What can be wrong with a [`Config`](crate::seam::config::Config). Raised by `build()` only: after it the controller cannot fail,
//! it can only fault (see [`supervisor::Fault`](crate::seam::fault::Fault)).

use core::fmt;

/// A configuration that cannot be built, naming the parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Error {
    /// A value is outside its range (or not a number).
    OutOfRange {
        /// The parameter, as a path in the configuration with its unit.
        parameter: &'static str,
        /// What was given.
        value: f64,
        /// The smallest value allowed.
        min: f64,
        /// The largest value allowed.
        max: f64,
    },
    /// Burst windows must be in order, not overlap, and have as many ends as beginnings.
    BurstWindows,
    /// A motional current can only be held where the resonance is tracked.
    CurrentWithoutTracking,
    /// A noise has no phase by which anything could be tracked.
    NoiseWithTracking,
    /// A noise has no frequency that could be swept.
    NoiseWithSweep,
    /// A chirp between two frequencies follows its own course, not the resonance.
    ChirpAgainstTracking,
    /// A chirp about the resonance needs one that is tracked.
    ResonanceWithoutTracking,
    /// A chirp about the resonance passes its own zero, which an exponential one cannot.
    ExponentialAroundResonance,
    /// The frequencies of a calibration must rise.
    TrimOrder,
    /// The friction switch sets a tip velocity, so that the drive's amplitude must be a motional current.
    FrictionWithoutCurrent,
    /// The detents of a knob follow its position, which an encoder has to tell.
    DetentsWithoutEncoder,
    /// A boost is planned from the resonance, which must be tracked.
    BoostWithoutTracking,
    /// A boost is by half cycles of a sine.
    BoostOfShape,
    /// A boost is at the resonance, and a chirp is not.
    BoostWithSweep,
    /// Energy for each metre of belt is known only where the belt has an encoder.
    EnergyWithoutBelt,
    /// What is asked for is not in this image.
    LeftOut {
        /// The parameters that ask for it.
        parameter: &'static str,
        /// The feature that brings it.
        feature: &'static str,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::OutOfRange { parameter, value, min, max } => {
                write!(f, "{parameter} = {value} is outside {min} to {max}")
            }
            Error::CurrentWithoutTracking => f.write_str("drive.amplitude is a motional current, which needs tracking"),
            Error::NoiseWithTracking => {
                f.write_str("drive.shape is a noise, which has no phase to track by: tracking must be off")
            }
            Error::NoiseWithSweep => f.write_str("drive.shape is a noise, whose band does not move: there can be no sweep"),
            Error::ChirpAgainstTracking => {
                f.write_str("sweep is a chirp from one frequency to another, and tracking would move it: tracking must be off")
            }
            Error::ResonanceWithoutTracking => f.write_str("sweep is a chirp about the resonance, which must be tracked"),
            Error::ExponentialAroundResonance => {
                f.write_str("sweep is a chirp about the resonance, from offset to offset through zero: it must be linear")
            }
            Error::FrictionWithoutCurrent => {
                f.write_str("friction is switched by tip velocity: drive.amplitude must be a motional current")
            }
            Error::DetentsWithoutEncoder => f.write_str("friction.detent_pitch_m needs an encoder, front_end.metre_per_count"),
            Error::EnergyWithoutBelt => f.write_str("limits.energy_j_per_m needs a belt encoder, front_end.metre_per_count"),
            Error::LeftOut { parameter, feature } => {
                write!(f, "{parameter} asks for what this image leaves out: build it with the feature `{feature}`")
            }
            Error::TrimOrder => f.write_str("phasing.calibration must be at rising frequencies"),
            Error::BoostWithoutTracking => f.write_str(
                "burst.edge is a boost, which is planned from the tracked resonance: tracking must be an observer or a phase lock",
            ),
            Error::BoostOfShape => f.write_str("burst.edge is a boost, by half cycles of a sine: drive.shape must be one"),
            Error::BoostWithSweep => f.write_str("burst.edge is a boost, at the resonance: there can be no sweep"),
            Error::BurstWindows => {
                f.write_str("burst windows must be in order, must not overlap, and need one end for each beginning")
            }
        }
    }
}

impl core::error::Error for Error {}

/// `value`, if it lies in `min..=max`; not-a-number never does. Compared in f32, in which the values of a configuration are: a
/// limit that is stated exactly must not be refused for its rounding.
pub(crate) fn in_range(parameter: &'static str, value: f64, min: f64, max: f64) -> Result<f64, Error> {
    let within = (min as f32..=max as f32).contains(&(value as f32));
    if within { Ok(value) } else { Err(Error::OutOfRange { parameter, value, min, max }) }
}
