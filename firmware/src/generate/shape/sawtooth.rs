//! The sawtooth, rising, band-limited: the sum of its harmonics, `sum_k (-1)^(k + 1) sin(2 pi k phase) / k`. It passes zero, rising, at
//! phase zero, as the sine does, and falls half a turn later.

use super::bands::{Bands, HALF, Part, additive};
use super::square;

static PARTS: [Part<HALF>; 11] =
    [up_to(2), up_to(3), up_to(4), up_to(5), up_to(6), up_to(8), up_to(10), up_to(12), up_to(16), up_to(20), up_to(25)];

/// The sawtooth's tables.
pub(crate) static BANDS: Bands = Bands::new(&[
    (1, square::fundamental()),
    (2, PARTS[0].table()),
    (3, PARTS[1].table()),
    (4, PARTS[2].table()),
    (5, PARTS[3].table()),
    (6, PARTS[4].table()),
    (8, PARTS[5].table()),
    (10, PARTS[6].table()),
    (12, PARTS[7].table()),
    (16, PARTS[8].table()),
    (20, PARTS[9].table()),
    (25, PARTS[10].table()),
]);

const fn up_to(highest: usize) -> Part<HALF> {
    additive(highest, 1, true)
}
