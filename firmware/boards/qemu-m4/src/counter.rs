//! Counter of instructions, derived from the system timer.
//!
//! Under `-icount shift=0` QEMU advances time by one nanosecond per instruction. The timer runs at
//! the core's 168 MHz, so that
//!
//! ```text
//! instructions = ticks * 1000 / 168 = ticks * 125 / 21
//! ```
//!
//! One tick is about six instructions. The counter measures instructions, not cycles.

use cortex_m::Peripherals;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

/// Value from which the timer counts down: 24 bits, a hundred million instructions.
const RELOAD: u32 = 0x00ff_ffff;
/// Turns of a loop of two instructions: 100 000 instructions.
const CALIBRATION_TURNS: u32 = 50_000;
/// Expected ticks of the calibration loop.
const CALIBRATION_TICKS: u32 = 16_800;
/// Permitted deviation of the calibration, ticks: a few instructions around the loop, and one tick
/// at either end.
const CALIBRATION_TOLERANCE: u32 = 4;

/// Counter of instructions, based on a hardware timer of the emulated board.
pub struct Counter;

impl Counter {
    /// Starts the timer and returns its counter.
    pub fn start() -> Self {
        // At a second call the peripherals are taken, and the timer already runs.
        if let Some(mut peripherals) = Peripherals::take() {
            peripherals.SYST.set_clock_source(SystClkSource::Core);
            peripherals.SYST.set_reload(RELOAD);
            peripherals.SYST.clear_current();
            peripherals.SYST.enable_counter();
        }
        Counter
    }

    /// Checks that the timer counts instructions, with a loop of known length. Returns the ticks of
    /// the loop otherwise.
    pub fn calibrate(&self) -> Result<(), u32> {
        // `delay` makes one turn more than its argument.
        let ticks = self.ticks(|| cortex_m::asm::delay(CALIBRATION_TURNS - 1));
        if ticks.abs_diff(CALIBRATION_TICKS) <= CALIBRATION_TOLERANCE { Ok(()) } else { Err(ticks) }
    }

    /// Returns the ticks that `work` takes, at most [`RELOAD`].
    #[inline(never)]
    pub fn ticks(&self, work: impl FnOnce()) -> u32 {
        let before = self.now();
        work();
        self.since(before)
    }

    /// Returns the present count of the timer.
    pub fn now(&self) -> u32 {
        SYST::get_current()
    }

    /// Returns the ticks since an earlier count, at most [`RELOAD`].
    pub fn since(&self, before: u32) -> u32 {
        before.wrapping_sub(SYST::get_current()) & RELOAD
    }
}
