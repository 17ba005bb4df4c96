//! The temperature of the processor, from the factory's calibration.
//!
//! ```text
//! T = (130 - 30) / (TS_CAL2 - TS_CAL1) * (code * VREFINT_CAL / vrefint - TS_CAL1) + 30      (degrees Celsius)
//! ```
//!
//! RM0440 21.4.31 and 21.4.33: the calibration was taken at 3.0 V, and the internal reference shows the present supply. Valid from -40 to
//! 130 degrees Celsius; the sensor is within some degrees (DS12288).

/// Temperatures of the calibration, degrees Celsius.
const CALIBRATED_C: (f32, f32) = (30.0, 130.0);
/// Temperatures at which the part can run; a sensor that shows others has failed or burns, degrees Celsius.
const PLAUSIBLE_C: (f32, f32) = (-55.0, 155.0);

/// The factory's calibration, codes of 12 bits at 3.0 V.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Calibration {
    /// The sensor at 30 degrees Celsius.
    pub low: u16,
    /// The sensor at 130 degrees Celsius.
    pub high: u16,
    /// The internal reference.
    pub reference: u16,
}

/// Degrees Celsius of a sensor's code, beside the code of the internal reference. One that cannot be is the hottest, so that the drive stops.
pub fn celsius(calibration: &Calibration, sensor: u16, reference: u16) -> f32 {
    if calibration.high <= calibration.low || reference == 0 {
        return PLAUSIBLE_C.1;
    }
    let at_3_v = f32::from(sensor) * f32::from(calibration.reference) / f32::from(reference);
    let (low, high) = (f32::from(calibration.low), f32::from(calibration.high));
    let celsius = CALIBRATED_C.0 + (CALIBRATED_C.1 - CALIBRATED_C.0) * (at_3_v - low) / (high - low);
    if (PLAUSIBLE_C.0..=PLAUSIBLE_C.1).contains(&celsius) { celsius } else { PLAUSIBLE_C.1 }
}
