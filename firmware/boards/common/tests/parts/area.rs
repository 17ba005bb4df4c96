//! Addresses within an area of the flash.

use boards_common::area::Area;

const PAGE: u32 = 2048;
const WORD: u32 = 8;
const AREA: Area = Area { start: 0x0807_c000, size: 8 * PAGE };

#[test]
fn addresses_must_be_aligned_and_within_the_area() {
    assert_eq!(AREA.address(0, AREA.size, PAGE), Some(AREA.start));
    assert_eq!(AREA.address(PAGE, PAGE, PAGE), Some(AREA.start + PAGE));
    for (offset, length, grid) in
        [(0, AREA.size + PAGE, PAGE), (AREA.size, WORD, WORD), (4, WORD, WORD), (0, 4, WORD), (u32::MAX, 8, 1), (8, PAGE, PAGE)]
    {
        assert_eq!(AREA.address(offset, length, grid), None, "{offset} {length} {grid}");
    }
}
