//! The sawtooth, rising, band-limited: the sum of its harmonics, `sum_k (-1)^(k + 1) sin(2 pi k phase) / k`. It passes zero, rising, at
//! phase zero, as the sine does, and falls half a turn later.

use super::bands::{Bands, Table, additive};

static TABLES: [Table; 12] =
    [up_to(1), up_to(2), up_to(3), up_to(4), up_to(5), up_to(6), up_to(8), up_to(10), up_to(12), up_to(16), up_to(20), up_to(25)];

/// The sawtooth's tables.
pub(crate) static BANDS: Bands = Bands::new(&[
    (1, &TABLES[0]),
    (2, &TABLES[1]),
    (3, &TABLES[2]),
    (4, &TABLES[3]),
    (5, &TABLES[4]),
    (6, &TABLES[5]),
    (8, &TABLES[6]),
    (10, &TABLES[7]),
    (12, &TABLES[8]),
    (16, &TABLES[9]),
    (20, &TABLES[10]),
    (25, &TABLES[11]),
]);

const fn up_to(highest: usize) -> Table {
    additive(highest, 1, true)
}
