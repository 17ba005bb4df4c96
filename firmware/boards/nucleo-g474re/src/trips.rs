//! The test of the two over-current trips at start, with the amplifier off.
//!
//! The current at rest is read at both pins that the comparators have, PA1 and PA7: both must be at the middle of the range, and alike. Then each
//! threshold is moved past that level in turn, which must raise the break, and back, which must not.

use firmware::board::start::TripFailure;

use crate::config::{SILENCE, TRIP_A, trip_codes};

/// How far the current may be off the middle of its range at rest: 0.4 A, codes.
const REST: u16 = 200;
/// How far the two pins may differ: 0.08 A, codes.
const ALIKE: u16 = 40;
/// How far beyond the present level a threshold is moved. The comparator's hysteresis is 37 codes.
const BEYOND: u16 = 400;

/// Thresholds of the two comparators, codes: the positive trip acts above the first, the negative one below the second.
pub type Thresholds = (u16, u16);

/// The current at rest, codes of 12 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Levels {
    /// At PA1: the current channel of the ADC, and the positive trip.
    pub positive: u16,
    /// At PA7: the negative trip.
    pub negative: u16,
}

impl Levels {
    /// What the levels themselves say: a current channel that is not connected or offset, or a wire to PA7 that is missing.
    pub fn failure(&self) -> Option<TripFailure> {
        if self.positive.abs_diff(SILENCE) > REST {
            Some(TripFailure::NotAtRest)
        } else if self.positive.abs_diff(self.negative) > ALIKE {
            Some(TripFailure::Wire)
        } else {
            None
        }
    }

    /// The steps of the test: thresholds, whether they must trip, and the failure where they do otherwise.
    pub fn steps(&self) -> [(Thresholds, bool, TripFailure); 5] {
        let (upper, lower) = trip_codes(TRIP_A);
        let rest = ((upper, lower), false, TripFailure::Standing);
        [
            rest,
            ((self.positive.saturating_sub(BEYOND), lower), true, TripFailure::NoPositive),
            rest,
            ((upper, self.negative.saturating_add(BEYOND)), true, TripFailure::NoNegative),
            rest,
        ]
    }
}

/// Thresholds that trip at any current: the enable cannot rise.
pub const ALWAYS: Thresholds = (0, 4095);
