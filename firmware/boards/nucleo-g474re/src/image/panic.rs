//! The end of a run: the enable drops, the cause is stored in RAM that a reset does not clear, and the part resets. The next run reports it.
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

/// `.uninit` is neither loaded nor cleared at start-up (cortex-m-rt); the RAM holds it over a reset, but not over power-off.
#[unsafe(link_section = ".uninit.note")]
static NOTE: Stored = Stored(UnsafeCell::new(Note::BLANK));

/// Returns what ended the last run, and clears it.
pub fn last() -> Option<Note> {
    // SAFETY: called once, before interrupts are enabled. Whatever bits the RAM has, they are a note: it consists of integers.
    let note = unsafe { ptr::read_volatile(NOTE.0.get()) };
    // SAFETY: as above.
    unsafe { ptr::write_volatile(NOTE.0.get(), Note::BLANK) };
    note.read().is_some().then_some(note)
}

/// Ends the blocks of this run, which have lost a sample: drops the enable, stores the cause, and leaves the reset to the watchdog, which is not fed
/// without blocks. Where the next run loses samples too, the host is answered meanwhile; a reset at once would leave no time for that.
pub fn end_blocks() {
    NVIC::mask(Interrupt::DMA1_CHANNEL1);
    NVIC::mask(Interrupt::ADC1_2);
    protection::drop_enable();
    store(Cause::StreamLost, "", count::blocks());
}

fn store(cause: Cause, file: &str, line: u32) {
    // SAFETY: called at the priority of the block interrupt, or with interrupts masked: nothing else writes it meanwhile.
    unsafe { ptr::write_volatile(NOTE.0.get(), Note::of(cause, file, line)) };
}

/// Ends this run: drops the enable, stores the cause, resets.
pub fn end(cause: Cause, file: &str, line: u32) -> ! {
    interrupt::disable();
    protection::drop_enable();
    store(cause, file, line);
    // A reset also stops the sample clock and takes the DACs to zero, which the amplifier does not pass on while it is disabled.
    SCB::sys_reset()
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    let (file, line) = info.location().map_or(("?", 0), |place| (place.file(), place.line()));
    end(Cause::Panic, file, line)
}

// SAFETY: marked because a handler may meet broken invariants; this one uses only registers and its own note.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    // A stack that has grown into its guard may have left no frame: the address is then of no use, but the cause is known.
    let cause = if guard::has_overflowed() { Cause::StackOverflow } else { Cause::HardFault };
    end(cause, "", frame.pc())
}

// SAFETY: marked for the same reason: it ends the run.
#[exception]
unsafe fn DefaultHandler(number: i16) {
    end(Cause::Unexpected, "", number as u32);
}
