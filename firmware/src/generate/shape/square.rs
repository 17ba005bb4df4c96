//! The band-limited square: the sum of its odd harmonics, `sum_k sin(2 pi k phase) / k`.
//!
//! The peaks are the ripple next to each edge. With eleven harmonics the tops are 15 per cent below
//! them, and the fundamental is 1.08. A true square needs a full bridge, not a converter.

use super::bands::{Bands, Blend, Table, additive};

static TABLES: [Table; 10] = [
    odd_up_to(1),
    odd_up_to(3),
    odd_up_to(5),
    odd_up_to(7),
    odd_up_to(9),
    odd_up_to(11),
    odd_up_to(13),
    odd_up_to(17),
    odd_up_to(21),
    odd_up_to(25),
];

/// Tables of the square, each with its highest harmonic.
pub(crate) static BANDS: Bands = Bands::new(&[
    (1, &TABLES[0]),
    (3, &TABLES[1]),
    (5, &TABLES[2]),
    (7, &TABLES[3]),
    (9, &TABLES[4]),
    (11, &TABLES[5]),
    (13, &TABLES[6]),
    (17, &TABLES[7]),
    (21, &TABLES[8]),
    (25, &TABLES[9]),
]);

/// Table of the sine, to which every waveform reduces if no other harmonic is below half the sample
/// rate.
pub(super) static FUNDAMENTAL: &Table = &TABLES[0];
/// The sine at any frequency.
pub(crate) static SINE: Blend = Blend { lower: FUNDAMENTAL, upper: FUNDAMENTAL, weight: 1.0 };

const fn odd_up_to(highest: usize) -> Table {
    additive(highest, 2, false)
}
