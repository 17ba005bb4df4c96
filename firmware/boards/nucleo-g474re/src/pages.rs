//! Flash pages of the settings: the last pages of the second bank. The code runs from the first
//! bank.
//!
//! One bank can be read while the other is erased or written (RM0440 3.3.9, read-while-write), so
//! erasing a page does not stall the block interrupt.

use boards_common::area::Area;

/// Size of a page in dual-bank mode, bytes (RM0440 3.3.1).
pub const PAGE: u32 = 2048;
/// Size of the unit of writing, bytes.
pub const WORD: u32 = 8;
/// Address of the first bank.
pub const FLASH: u32 = 0x0800_0000;
/// Address of the second bank. The code must end before it.
pub const SECOND_BANK: u32 = 0x0804_0000;
/// Number of pages of the settings: two halves, each with spare pages.
pub const PAGES: u32 = 8;
/// Address of the settings.
pub const START: u32 = 0x0808_0000 - PAGES * PAGE;
/// Size of the settings, bytes.
pub const SIZE: u32 = PAGES * PAGE;
/// Flash area of the settings, and the page before them. The last word of that page marks that
/// settings were stored; the rest of it belongs to the first stage.
pub const SETTINGS: Area = Area { start: START - PAGE, size: PAGE + SIZE };

/// Returns the number within its bank of the page at an address (`PNB`, RM0440 3.7.5).
pub fn number(address: u32) -> u8 {
    ((address - SECOND_BANK) / PAGE) as u8
}
