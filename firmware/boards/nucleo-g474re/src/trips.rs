//! The two over-current trips: where they act, and their test at start, with the amplifier off.
//!
//! ```text
//! trip = limit + margin, at most TRIP_A      limit: the stored `limits.current_a`; margin: 248 codes, 0.5 A
//! ```
//!
//! The controller looks at each sample, about the zero that it has measured, and acts where the limit is passed by less than the margin; the trips are for a
//! current that is beyond both before the block is over. They stand about mid-scale, and the zero may be 200 codes off it (`REST`): the margin about the
//! zero is 48 to 448 codes, 0.1 to 0.9 A. The least of it is left to noise and to the comparator's offset. Its hysteresis of 37 codes lies
//! below its threshold: the negative trip acts by so much later, and the positive one ends by so much later.
//!
//! The current at rest is read at both pins that the comparators have, PA1 and PA7: both must be at the middle of the range, and alike. Then each
//! threshold is moved past that level in turn, which must raise the break, and back, which must not.

use firmware::board::start::TripFailure;

use crate::config::{CONVERSIONS, SILENCE, TRIP_A, trip_codes};

/// How far the current may be off the middle of its range at rest: 0.4 A, codes.
const REST: u16 = 200;
/// How far the two pins may differ: 0.08 A, codes.
const ALIKE: u16 = 40;
/// How far beyond the present level a threshold is moved. The comparator's hysteresis is 37 codes.
const BEYOND: u16 = 400;

/// How far beyond the limit the trips act: 0.5 A, codes.
const MARGIN: f32 = 248.0;

/// Thresholds of the two comparators, codes: the positive trip acts above the first, the negative one below the second.
pub type Thresholds = (u16, u16);

/// The thresholds for a limit, A peak, at a current channel of this scale, A a code of a sample: beyond the limit by the margin, and never beyond [`TRIP_A`]
/// as built, whatever the scale.
pub fn thresholds(limit_a: f32, ampere_per_lsb: f32) -> Thresholds {
    let (most, least) = trip_codes(TRIP_A);
    let middle = f32::from(SILENCE);
    // A limit that is no number is none that was stored; `min` takes the other one.
    let distance = (limit_a / (ampere_per_lsb * f32::from(CONVERSIONS)) + MARGIN).min(middle);
    let (upper, lower) = (middle + distance, middle - distance);
    ((upper as u16).min(most), (lower as u16).max(least))
}

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

    /// The steps of the test: thresholds, whether they must trip, and the failure where they do otherwise. The last ones are those that stay.
    pub fn steps(&self, (upper, lower): Thresholds) -> [(Thresholds, bool, TripFailure); 5] {
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
