//! End of a run: the enable drops, the cause is stored in RAM that a reset does not clear, and the
//! processor resets. The next run reports the cause.
#![expect(unsafe_code, reason = "RAM that is not cleared, and handlers of exceptions")]

use core::cell::UnsafeCell;
use core::panic::PanicInfo;
use core::ptr;

use boards_common::note::{Cause, Note};
use cortex_m::interrupt;
use cortex_m::peripheral::{NVIC, SCB};
use cortex_m_rt::{ExceptionFrame, exception};
use stm32_metapac::Interrupt;

use super::{count, guard, protection};

struct Stored(UnsafeCell<Note>);

// SAFETY: read once before any interrupt is enabled, and written only by `store`.
unsafe impl Sync for Stored {}

/// Note in `.uninit`, which is neither loaded nor cleared at start-up (cortex-m-rt). The RAM keeps
/// it through a reset, but not through power-off.
#[unsafe(link_section = ".uninit.note")]
static NOTE: Stored = Stored(UnsafeCell::new(Note::BLANK));

/// Returns the note of the last run and clears it.
pub fn last() -> Option<Note> {
    // SAFETY: called once, before interrupts are enabled. Any contents of the RAM are a valid
    // `Note`, because it consists of integers.
    let note = unsafe { ptr::read_volatile(NOTE.0.get()) };
    // SAFETY: as above.
    unsafe { ptr::write_volatile(NOTE.0.get(), Note::BLANK) };
    note.read().is_some().then_some(note)
}

/// Ends the blocks of this run after a lost sample: drops the enable and stores the cause.
///
/// The watchdog then resets the processor, because it is not fed without blocks. If every run loses
/// samples, the host can communicate with the board until each reset; an immediate reset would
/// leave no time for that.
pub fn end_blocks() {
    NVIC::mask(Interrupt::DMA1_CHANNEL1);
    NVIC::mask(Interrupt::ADC1_2);
    protection::drop_enable();
    store(Cause::StreamLost, "", count::blocks());
}

fn store(cause: Cause, file: &str, line: u32) {
    // SAFETY: called at the priority of the block interrupt, or with interrupts masked, so nothing
    // else writes the note at the same time.
    unsafe { ptr::write_volatile(NOTE.0.get(), Note::new(cause, file, line)) };
}

/// Ends this run: drops the enable, stores the cause and resets the processor.
pub fn end(cause: Cause, file: &str, line: u32) -> ! {
    interrupt::disable();
    protection::drop_enable();
    store(cause, file, line);
    // A reset also stops the sample clock and sets the DACs to zero. The disabled amplifier does
    // not pass this step on.
    SCB::sys_reset()
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    let (file, line) = info.location().map_or(("?", 0), |place| (place.file(), place.line()));
    end(Cause::Panic, file, line)
}

// SAFETY: unsafe because a handler may run with broken invariants. This one uses only registers and
// its own note.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    // After a stack overflow into the guard there may be no exception frame. The address is then
    // meaningless, but the cause is known.
    let cause = if guard::has_overflowed() { Cause::StackOverflow } else { Cause::HardFault };
    end(cause, "", frame.pc())
}

// SAFETY: unsafe for the same reason. This handler ends the run.
#[exception]
unsafe fn DefaultHandler(number: i16) {
    end(Cause::Unexpected, "", number as u32);
}
