//! Flash layout of a board that can be updated over the link.
//!
//! ```text
//! bank 1  0x0800_0000  first stage, 16 KiB     0x0800_4000  slot, 234 KiB: manifest and running image      0x0803_e800  free, 6 KiB
//! bank 2  0x0804_0000  store, 236 KiB: manifest and received or former image; one page more than the slot
//!         0x0807_b000  state of the first stage, 4 KiB     0x0807_c000  settings, 16 KiB
//!         0x0807_bff8  last word of that state: marker of stored settings
//! ```
//!
//! The running image writes only to the second bank, so that its own code stays readable during the
//! write (RM0440 3.3.9).

use boards_common::area::Area;

use crate::pages::{FLASH, PAGE, SECOND_BANK, START, WORD};

/// Space reserved for the manifest before the image, bytes.
pub const MANIFEST: u32 = 512;
/// Size of the first stage, bytes.
pub const FIRST_STAGE: u32 = 16 << 10;
/// Slot of the running image.
pub const SLOT: Area = Area { start: FLASH + FIRST_STAGE, size: 117 * PAGE };
/// Store of the received or the former image: one page more than the slot, which the swap needs.
pub const STORE: Area = Area { start: SECOND_BANK, size: SLOT.size + PAGE };
/// Task and progress of the first stage: two words, and four for each page of the slot.
pub const STATE: Area = Area { start: SECOND_BANK + STORE.size, size: 2 * PAGE };
/// Address of the image's vector table.
pub const ORIGIN: u32 = SLOT.start + MANIFEST;
/// Name of this board in manifests.
pub const BOARD: &str = "nucleo-g474re";

const _: () = assert!(SLOT.start + SLOT.size <= SECOND_BANK && STATE.start + STATE.size == START);
const _: () = assert!(WORD * (2 + 4 * (SLOT.size / PAGE)) + WORD <= STATE.size);
// VTOR ignores the low bits: ARM DDI 0403 B3.2.5. There are 16 exceptions and 102 interrupts.
const _: () = assert!(ORIGIN.is_multiple_of(512) && 4 * (16 + 102) <= 512);
