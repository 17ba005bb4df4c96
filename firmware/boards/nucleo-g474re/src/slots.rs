//! The flash of a board that can be updated over the link.
//!
//! ```text
//! bank 1  0x0800_0000  first stage, 16 KiB     0x0800_4000  slot, 234 KiB: manifest and the image that runs      0x0803_e800  free, 6 KiB
//! bank 2  0x0804_0000  store, 236 KiB: manifest and the image that is received, or the former one; a page more than the slot
//!         0x0807_b000  state of the first stage, 4 KiB     0x0807_c000  settings, 16 KiB
//! ```
//!
//! The running image writes to the second bank only, so that its own code can be read meanwhile (RM0440 3.3.9).

use boards_common::area::Area;

use crate::pages::{FLASH, PAGE, SECOND_BANK, START};

/// Bytes of a manifest before the image.
pub const MANIFEST: u32 = 512;
/// Bytes of the first stage.
pub const FIRST_STAGE: u32 = 16 << 10;
/// The slot of the image that runs.
pub const SLOT: Area = Area { start: FLASH + FIRST_STAGE, size: 117 * PAGE };
/// What is received, or the former image: a page more than the slot, which the swap needs.
pub const STORE: Area = Area { start: SECOND_BANK, size: SLOT.size + PAGE };
/// What the first stage is to do, and how far it is: two words, and four for each page of the slot.
pub const STATE: Area = Area { start: SECOND_BANK + STORE.size, size: 2 * PAGE };
/// Where the image's vector table stands.
pub const ORIGIN: u32 = SLOT.start + MANIFEST;
/// Name of this board in its manifests.
pub const BOARD: &str = "nucleo-g474re";

const _: () = assert!(SLOT.start + SLOT.size <= SECOND_BANK && STATE.start + STATE.size == START);
const _: () = assert!(8 * (2 + 4 * (SLOT.size / PAGE)) <= STATE.size);
// VTOR ignores the low bits: ARM DDI 0403 B3.2.5; 16 exceptions and 102 interrupts.
const _: () = assert!(ORIGIN.is_multiple_of(512) && 4 * (16 + 102) <= 512);
