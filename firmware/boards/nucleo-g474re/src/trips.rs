//! The two over-current trips: their thresholds, and their test at start with the amplifier off.
//!
//! ```text
//! trip = limit + margin, at most TRIP_A      limit: the stored `limits.current_a`; margin: 248 codes, 0.5 A
//! ```
//!
//! The controller checks each sample against the limit, relative to the zero that it has measured.
//! It handles a current that exceeds the limit by less than the margin. The trips handle a current
//! that exceeds limit plus margin before the block is over.
//!
//! The trip thresholds are relative to mid-scale. The zero of the current may deviate from
//! mid-scale by 200 codes (`MAX_REST_DEVIATION_CODES`). Relative to that zero, the margin is
//! therefore 48 to 448 codes, 0.1 to 0.9 A. The smallest margin of 48 codes covers noise and the
//! comparator's offset.
//!
//! The comparator's hysteresis of 37 codes is below its threshold. The negative trip therefore acts
//! 37 codes later, and the positive trip releases 37 codes later.
//!
//! The test reads the current at rest at both pins of the comparators, PA1 and PA7. Both readings
//! must be near the middle of the range, and must agree. Then each threshold in turn is moved past
//! that level, which must cause a break, and moved back, after which no break may occur.

use firmware::board::start::TripFailure;

use crate::config::{CONVERSIONS, SILENCE, TRIP_A, trip_codes};

/// Largest permitted deviation of the current at rest from the middle of its range, codes: 0.4 A.
const MAX_REST_DEVIATION_CODES: u16 = 200;
/// Largest permitted difference between the two pins, codes: 0.08 A.
const MAX_PIN_DIFFERENCE_CODES: u16 = 40;
/// Distance by which the test moves a threshold past the present level, codes. The comparator's
/// hysteresis is 37 codes.
const TEST_DISTANCE_CODES: u16 = 400;

/// Distance of the trips from the limit, codes: 0.5 A.
const MARGIN_CODES: f32 = 248.0;

/// Thresholds of the two comparators, codes: the positive trip acts above the first, the negative
/// one below the second.
pub type Thresholds = (u16, u16);

/// Returns the thresholds for a limit, A peak, and the scale of the current channel, A per code of
/// a sample.
///
/// The thresholds exceed the limit by the margin. They never exceed [`TRIP_A`] at the built-in
/// scale, for any configured scale.
pub fn thresholds(limit_a: f32, ampere_per_lsb: f32) -> Thresholds {
    let (most, least) = trip_codes(TRIP_A);
    let middle = f32::from(SILENCE);
    // If the limit is NaN, no valid limit was stored; `min` then returns the other operand.
    let distance = (limit_a / (ampere_per_lsb * f32::from(CONVERSIONS)) + MARGIN_CODES).min(middle);
    let (upper, lower) = (middle + distance, middle - distance);
    ((upper as u16).min(most), (lower as u16).max(least))
}

/// Current at rest at both trips, codes of 12 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Levels {
    /// Level at PA1: the current channel of the ADC, and the positive trip.
    pub positive: u16,
    /// Level at PA7: the negative trip.
    pub negative: u16,
}

impl Levels {
    /// Returns the failure that the levels show: a current channel that is offset or not connected,
    /// or a missing wire to PA7.
    pub fn failure(&self) -> Option<TripFailure> {
        if self.positive.abs_diff(SILENCE) > MAX_REST_DEVIATION_CODES {
            Some(TripFailure::NotAtRest)
        } else if self.positive.abs_diff(self.negative) > MAX_PIN_DIFFERENCE_CODES {
            Some(TripFailure::Wire)
        } else {
            None
        }
    }

    /// Returns the steps of the test: thresholds, `true` if they must trip, and the failure if they
    /// do not behave so. The thresholds of the last step remain set.
    pub fn steps(&self, (upper, lower): Thresholds) -> [(Thresholds, bool, TripFailure); 5] {
        let rest = ((upper, lower), false, TripFailure::Standing);
        [
            rest,
            ((self.positive.saturating_sub(TEST_DISTANCE_CODES), lower), true, TripFailure::NoPositive),
            rest,
            ((upper, self.negative.saturating_add(TEST_DISTANCE_CODES)), true, TripFailure::NoNegative),
            rest,
        ]
    }
}

/// Thresholds that trip at any current, so that the enable cannot rise.
pub const ALWAYS_TRIPPING: Thresholds = (0, 4095);
