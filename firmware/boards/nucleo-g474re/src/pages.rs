//! The pages of the settings in the flash: the last pages of the second bank, while the code runs from the first.
//!
//! Reading one bank goes on while the other is erased or written (RM0440 3.3.9, read-while-write), so that a page's erase does not stall the
//! block interrupt.

use boards_common::area::Area;

/// Bytes of a page in dual-bank mode (RM0440 3.3.1).
pub const PAGE: u32 = 2048;
/// Bytes that are written at once.
pub const WORD: u32 = 8;
/// Where the first bank begins.
pub const FLASH: u32 = 0x0800_0000;
/// Where the second bank begins: the code must end before.
pub const SECOND_BANK: u32 = 0x0804_0000;
/// Pages of the settings: two halves, each with pages to spare.
pub const PAGES: u32 = 8;
/// Where the settings begin.
pub const START: u32 = 0x0808_0000 - PAGES * PAGE;
/// Bytes of the settings.
pub const SIZE: u32 = PAGES * PAGE;
/// The settings.
pub const SETTINGS: Area = Area { start: START, size: SIZE };

/// The number within its bank of the page at an address (`PNB` of RM0440 3.7.5).
pub fn number(address: u32) -> u8 {
    ((address - SECOND_BANK) / PAGE) as u8
}
