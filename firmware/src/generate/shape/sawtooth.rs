//! The rising, band-limited sawtooth: the sum of its harmonics,
//! `sum_k (-1)^(k + 1) sin(2 pi k phase) / k`. Like the sine, it crosses zero, rising, at phase
//! zero; it falls half a turn later.

use super::bands::{Bands, Table, additive};
use super::square;

static TABLES: [Table; 11] =
    [up_to(2), up_to(3), up_to(4), up_to(5), up_to(6), up_to(8), up_to(10), up_to(12), up_to(16), up_to(20), up_to(25)];

/// Tables of the sawtooth.
pub(crate) static BANDS: Bands = Bands::new(&[
    (1, square::FUNDAMENTAL),
    (2, &TABLES[0]),
    (3, &TABLES[1]),
    (4, &TABLES[2]),
    (5, &TABLES[3]),
    (6, &TABLES[4]),
    (8, &TABLES[5]),
    (10, &TABLES[6]),
    (12, &TABLES[7]),
    (16, &TABLES[8]),
    (20, &TABLES[9]),
    (25, &TABLES[10]),
]);

const fn up_to(highest: usize) -> Table {
    additive(highest, 1, true)
}
