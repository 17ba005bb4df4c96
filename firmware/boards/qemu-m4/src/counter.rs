//! Counts instructions by the system timer.
//!
//! Under `-icount shift=0` QEMU lets one nanosecond pass for every instruction. The timer runs at the core's 168 MHz, so that
//!
//! ```text
//! instructions = ticks * 1000 / 168 = ticks * 125 / 21
//! ```
//!
//! One tick is six instructions. These are instructions, not cycles.

use cortex_m::Peripherals;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

/// The timer counts down from here; 24 bits, a hundred million instructions.
const RELOAD: u32 = 0x00ff_ffff;
/// Turns of a loop of two instructions: 100 000 instructions.
const CALIBRATION_TURNS: u32 = 50_000;
/// The ticks they must take, and how far they may be from that: a few instructions stand around the loop, and a tick at either end.
const CALIBRATION_TICKS: u32 = 16_800;
const CALIBRATION_TOLERANCE: u32 = 4;

/// A hardware timer of the emulated board, as a counter of instructions.
pub struct Counter;

impl Counter {
    /// Starts the timer, and returns its counter.
    pub fn start() -> Self {
        // Taken once only; afterwards it runs already.
        if let Some(mut peripherals) = Peripherals::take() {
            peripherals.SYST.set_clock_source(SystClkSource::Core);
            peripherals.SYST.set_reload(RELOAD);
            peripherals.SYST.clear_current();
            peripherals.SYST.enable_counter();
        }
        Counter
    }

    /// Whether the timer counts instructions: a loop of known length. If not, the ticks it took.
    pub fn calibrate(&self) -> Result<(), u32> {
        // `delay` turns once more than it is asked for.
        let ticks = self.ticks(|| cortex_m::asm::delay(CALIBRATION_TURNS - 1));
        if ticks.abs_diff(CALIBRATION_TICKS) <= CALIBRATION_TOLERANCE { Ok(()) } else { Err(ticks) }
    }

    /// The ticks that `work` takes: at most [`RELOAD`].
    #[inline(never)]
    pub fn ticks(&self, work: impl FnOnce()) -> u32 {
        let before = self.now();
        work();
        self.since(before)
    }

    /// Present count of the timer.
    pub fn now(&self) -> u32 {
        SYST::get_current()
    }

    /// The ticks since then: at most [`RELOAD`].
    pub fn since(&self, before: u32) -> u32 {
        before.wrapping_sub(SYST::get_current()) & RELOAD
    }
}
