//! What survives a reset of the emulated board: the pages of the settings, and what the reset was for.
//!
//! It stands in RAM that QEMU's STM32F405 has behind what `memory.x` gives to an image: nothing is loaded there, so that a reset leaves it as it
//! is. With the end of QEMU it is gone.
#![expect(unsafe_code, reason = "memory that the linker's script does not know of")]

use core::ptr;
use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m::peripheral::SCB;
use firmware::board::start::Start;
use qemu_m4::pages::Pages;

/// What is there. QEMU's RAM is zero when it starts.
#[repr(C)]
struct Kept {
    /// [`WRITTEN`], once this was.
    mark: u32,
    /// [`WRITTEN`], if the reset was ordered.
    ordered: u32,
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
    let kept = ptr::with_exposed_provenance_mut::<Kept>(ADDRESS);
    // SAFETY: RAM of the machine that nothing else uses, aligned, and large enough (32 KiB at least). Any bytes are a value of these types.
    let kept = unsafe { &mut *kept };
    let ordered = kept.mark == WRITTEN && kept.ordered == WRITTEN;
    if kept.mark != WRITTEN {
        kept.pages.clear();
    }
    (kept.mark, kept.ordered) = (WRITTEN, 0);
    Some((&mut kept.pages, if ordered { Start::Ordered } else { Start::PowerOn }))
}

/// Resets the board.
pub fn reset() -> ! {
    let kept = ptr::with_exposed_provenance_mut::<Kept>(ADDRESS);
    // SAFETY: as above. Whoever has the pages is not called any more; they are not touched.
    unsafe { ptr::write_volatile(&raw mut (*kept).ordered, WRITTEN) };
    SCB::sys_reset()
}
