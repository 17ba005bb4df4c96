//! The square, band-limited: the sum of its odd harmonics, `sum_k sin(2 pi k phase) / k`.
//!
//! The peaks are the ripple beside each edge; with eleven harmonics the tops lie 15 per cent below them, and the fundamental is 1.08. A true
//! square belongs to a full bridge, not to a converter.

use super::bands::{Bands, Part, QUARTER, Table, additive};

static PARTS: [Part<QUARTER>; 10] = [
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

/// The square's tables.
pub(crate) static BANDS: Bands = Bands::new(&[
    (1, PARTS[0].table()),
    (3, PARTS[1].table()),
    (5, PARTS[2].table()),
    (7, PARTS[3].table()),
    (9, PARTS[4].table()),
    (11, PARTS[5].table()),
    (13, PARTS[6].table()),
    (17, PARTS[7].table()),
    (21, PARTS[8].table()),
    (25, PARTS[9].table()),
]);

/// The sine, which every waveform is where nothing else is below half the sample rate.
pub(super) const fn fundamental() -> Table {
    PARTS[0].table()
}

const fn odd_up_to(highest: usize) -> Part<QUARTER> {
    additive(highest, 2, false)
}
