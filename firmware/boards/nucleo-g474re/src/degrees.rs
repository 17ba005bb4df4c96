//! Temperature of the processor, from the factory's calibration.
//!
//! ```text
//! T = (130 - 30) / (TS_CAL2 - TS_CAL1) * (code * VREFINT_CAL / vrefint - TS_CAL1) + 30      (degrees Celsius)
//! ```
//!
//! RM0440 21.4.31 and 21.4.33: the calibration was taken at 3.0 V, and the internal reference
//! measures the present supply. The equation is valid from -40 to 130 degrees Celsius. The sensor
//! has an error of a few degrees (DS12288).

/// Temperature of the lower calibration point, degrees Celsius.
const LOW_POINT_C: f32 = 30.0;
/// Temperature of the upper calibration point, degrees Celsius.
const HIGH_POINT_C: f32 = 130.0;
/// Lowest plausible temperature, degrees Celsius. Below it the sensor has failed.
const MIN_PLAUSIBLE_C: f32 = -55.0;
/// Highest plausible temperature, degrees Celsius. Above it the sensor has failed, or the processor
/// is far too hot.
const MAX_PLAUSIBLE_C: f32 = 155.0;

/// Factory calibration, codes of 12 bits at 3.0 V.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Calibration {
    /// Code of the sensor at 30 degrees Celsius.
    pub low: u16,
    /// Code of the sensor at 130 degrees Celsius.
    pub high: u16,
    /// Code of the internal reference.
    pub reference: u16,
}

/// Returns the temperature from the codes of the sensor and of the internal reference, degrees
/// Celsius.
///
/// An implausible temperature is replaced by the highest plausible one, so that the drive stops.
pub fn celsius(calibration: &Calibration, sensor: u16, reference: u16) -> f32 {
    if calibration.high <= calibration.low || reference == 0 {
        return MAX_PLAUSIBLE_C;
    }
    let at_3_v = f32::from(sensor) * f32::from(calibration.reference) / f32::from(reference);
    let (low, high) = (f32::from(calibration.low), f32::from(calibration.high));
    let celsius = LOW_POINT_C + (HIGH_POINT_C - LOW_POINT_C) * (at_3_v - low) / (high - low);
    if (MIN_PLAUSIBLE_C..=MAX_PLAUSIBLE_C).contains(&celsius) { celsius } else { MAX_PLAUSIBLE_C }
}
