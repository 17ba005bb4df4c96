//! What can be wrong with a [`Config`](crate::config::Config). Raised by `build()` only: after it the controller cannot fail,
//! it can only fault (see [`supervisor::Fault`](crate::supervisor::Fault)).

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
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::OutOfRange { parameter, value, min, max } => {
                write!(f, "{parameter} = {value} is outside {min} to {max}")
            }
            Error::CurrentWithoutTracking => f.write_str("drive.amplitude is a motional current, which needs tracking"),
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
