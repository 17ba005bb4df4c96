//! Reasons for which a [`Config`](crate::seam::config::Config) cannot be built. Only `build()`
//! returns them. Afterwards the controller cannot fail; it can only raise a
//! [`Fault`](crate::seam::fault::Fault).

use core::fmt;

/// Reason for which a configuration cannot be built, with the name of the parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Error {
    /// A value is out of range or not a number.
    OutOfRange {
        /// Path of the parameter in the configuration, with its unit.
        parameter: &'static str,
        /// Configured value.
        value: f64,
        /// Smallest allowed value.
        min: f64,
        /// Largest allowed value.
        max: f64,
    },
    /// Burst windows must be in order, must not overlap, and need one end for each beginning.
    BurstWindows,
    /// A motional current can only be held if the resonance is tracked.
    CurrentWithoutTracking,
    /// A noise has no phase to track.
    NoiseWithTracking,
    /// A noise has a fixed band and cannot be swept.
    NoiseWithSweep,
    /// A chirp between two frequencies cannot follow the resonance.
    ChirpAgainstTracking,
    /// A chirp about the resonance needs a tracked resonance.
    ResonanceWithoutTracking,
    /// A chirp about the resonance passes through zero offset, which an exponential chirp cannot.
    ExponentialAroundResonance,
    /// The frequencies of a calibration must rise.
    TrimOrder,
    /// The friction switch sets a tip velocity: the drive's amplitude must be a motional current.
    FrictionWithoutCurrent,
    /// The detents of a knob depend on its position, which needs an encoder.
    DetentsWithoutEncoder,
    /// A boost is planned from the resonance, which must be tracked.
    BoostWithoutTracking,
    /// A boost consists of half cycles of a sine.
    BoostOfShape,
    /// A boost needs the resonance, which a chirp leaves.
    BoostWithSweep,
    /// An energy limit per metre of belt needs a belt encoder.
    EnergyWithoutBelt,
    /// A configured part is not in this image.
    LeftOut {
        /// Parameters that need the part.
        parameter: &'static str,
        /// Cargo feature that includes it.
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
            Error::NoiseWithTracking => f.write_str("drive.shape = noise has no phase to track: tracking must be off"),
            Error::NoiseWithSweep => f.write_str("drive.shape = noise has a fixed band: it cannot be combined with a sweep"),
            Error::ChirpAgainstTracking => {
                f.write_str("sweep is a chirp between two frequencies, which tracking would change: tracking must be off")
            }
            Error::ResonanceWithoutTracking => f.write_str("sweep is a chirp about the resonance, which must be tracked"),
            Error::ExponentialAroundResonance => {
                f.write_str("sweep is a chirp about the resonance, which passes through zero offset: it must be linear")
            }
            Error::FrictionWithoutCurrent => {
                f.write_str("friction is switched by tip velocity: drive.amplitude must be a motional current")
            }
            Error::DetentsWithoutEncoder => f.write_str("friction.detent_pitch_m needs an encoder, front_end.metre_per_count"),
            Error::EnergyWithoutBelt => f.write_str("limits.energy_j_per_m needs a belt encoder, front_end.metre_per_count"),
            Error::LeftOut { parameter, feature } => {
                write!(f, "{parameter} needs a part that is not in this image: build it with the feature `{feature}`")
            }
            Error::TrimOrder => f.write_str("the frequencies of phasing.calibration must rise"),
            Error::BoostWithoutTracking => f.write_str(
                "burst.edge = boost is planned from the tracked resonance: tracking must be an observer or a phase lock",
            ),
            Error::BoostOfShape => f.write_str("burst.edge = boost needs drive.shape = sine"),
            Error::BoostWithSweep => f.write_str("burst.edge = boost cannot be combined with a sweep"),
            Error::BurstWindows => {
                f.write_str("burst windows must be in order, must not overlap, and need one end for each beginning")
            }
        }
    }
}

impl core::error::Error for Error {}

/// Returns `value` if it lies in `min..=max`, which a not-a-number never does. The comparison is in
/// f32, as the values of a configuration are: a value equal to a limit must not be refused for its
/// rounding.
pub(crate) fn in_range(parameter: &'static str, value: f64, min: f64, max: f64) -> Result<f64, Error> {
    let within = (min as f32..=max as f32).contains(&(value as f32));
    if within { Ok(value) } else { Err(Error::OutOfRange { parameter, value, min, max }) }
}
