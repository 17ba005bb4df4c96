//! Memory that survives a reset of the emulated board: the pages of the settings, and the note of why the last run ended.
//!
//! It stands in RAM that QEMU's STM32F405 has behind what `memory.x` gives to an image: nothing is loaded there, so that a reset leaves it as it
//! is. With the end of QEMU it is gone.
#![expect(unsafe_code, reason = "memory that the linker's script does not know of")]

use core::ptr;
use core::sync::atomic::{AtomicBool, Ordering};

use boards_common::note::{Cause, Note};
use cortex_m::peripheral::SCB;
use firmware::board::start::Start;
use qemu_m4::pages::Pages;

/// The retained memory. QEMU's RAM is zero when it starts.
#[repr(C)]
struct Retained {
    /// [`WRITTEN`], once this was.
    mark: u32,
    note: Note,
    pages: Pages,
}

const ADDRESS: usize = 0x2001_8000;
const WRITTEN: u32 = 0x6b65_7074;

static TAKEN: AtomicBool = AtomicBool::new(false);

/// The pages, and what started the board. Once only.
pub fn take() -> Option<(&'static mut Pages, Start)> {
    if TAKEN.swap(true, Ordering::Relaxed) {
        return None;
    }
    let retained = ptr::with_exposed_provenance_mut::<Retained>(ADDRESS);
    // SAFETY: RAM of the machine that nothing else uses, aligned, and large enough (32 KiB at least). Any bytes are a value of these types.
    let retained = unsafe { &mut *retained };
    if retained.mark != WRITTEN {
        retained.pages.clear();
    }
    retained.mark = WRITTEN;
    let note = core::mem::replace(&mut retained.note, Note::BLANK);
    Some((&mut retained.pages, note.start().unwrap_or(Start::PowerOn)))
}

/// Resets the board, and leaves a note that the reset was ordered.
pub fn reset() -> ! {
    let retained = ptr::with_exposed_provenance_mut::<Retained>(ADDRESS);
    // SAFETY: as above. The owner of the pages is not called any more; they are not touched.
    unsafe { ptr::write_volatile(&raw mut (*retained).note, Note::of(Cause::Ordered, "", 0)) };
    SCB::sys_reset()
}
