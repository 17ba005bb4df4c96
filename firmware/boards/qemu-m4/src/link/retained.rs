//! Memory that survives a reset of the emulated board: the pages of the settings, and the note of
//! the reason why the last run ended.
//!
//! It is in RAM of QEMU's STM32F405 after the range that `memory.x` gives to an image. Nothing is
//! loaded there, so a reset does not change it. It is lost when QEMU ends.
#![expect(unsafe_code, reason = "memory outside of the linker script")]

use core::ptr;
use core::sync::atomic::{AtomicBool, Ordering};

use boards_common::note::{Cause, Note};
use cortex_m::peripheral::SCB;
use firmware::board::start::Start;
use qemu_m4::pages::Pages;

/// Retained memory. QEMU's RAM is zero at its start.
#[repr(C)]
struct Retained {
    /// [`WRITTEN`] after the first initialization.
    mark: u32,
    note: Note,
    pages: Pages,
}

/// Address of the retained memory, after the 96 KiB of `memory.x`.
const ADDRESS: usize = 0x2001_8000;
/// Value of `mark` in initialized memory.
const WRITTEN: u32 = 0x6b65_7074;

static TAKEN: AtomicBool = AtomicBool::new(false);

/// Returns the pages and the cause of the start. Returns `None` at every further call.
pub fn take() -> Option<(&'static mut Pages, Start)> {
    if TAKEN.swap(true, Ordering::Relaxed) {
        return None;
    }
    let retained = ptr::with_exposed_provenance_mut::<Retained>(ADDRESS);
    // SAFETY: RAM of the machine that nothing else uses, aligned, and large enough (at least 32
    // KiB). Any bytes are valid values of these types.
    let retained = unsafe { &mut *retained };
    if retained.mark != WRITTEN {
        retained.pages.clear();
    }
    retained.mark = WRITTEN;
    let note = core::mem::replace(&mut retained.note, Note::BLANK);
    Some((&mut retained.pages, note.start().unwrap_or(Start::PowerOn)))
}

/// Resets the board and leaves a note that the reset was ordered.
pub fn reset() -> ! {
    let retained = ptr::with_exposed_provenance_mut::<Retained>(ADDRESS);
    // SAFETY: as in `take`. The owner of the pages no longer runs, and the pages are not
    // accessed here.
    unsafe { ptr::write_volatile(&raw mut (*retained).note, Note::new(Cause::Ordered, "", 0)) };
    SCB::sys_reset()
}
