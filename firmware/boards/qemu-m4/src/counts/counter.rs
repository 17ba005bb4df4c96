//! Counts instructions by the system timer.
//!
//! Under `-icount shift=0` QEMU lets one nanosecond pass for every instruction. The timer runs at the core's 168 MHz, so that
//!
//! ```text
//! instructions = ticks * 1000 / 168 = ticks * 125 / 21
//! ```
//!
//! One tick is six instructions; a kernel is run so often that this is nothing. These are instructions, not cycles.

use core::hint::black_box;

use cortex_m::Peripherals;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

/// The timer counts down from here; 24 bits.
const RELOAD: u32 = 0x00ff_ffff;
/// A loop of two instructions, so many times: 100 000 instructions.
const CALIBRATION_TURNS: u32 = 50_000;
const CALIBRATION_TICKS: u32 = 16_800;
/// Around the loop stand a few more instructions, and either end is within a tick.
const CALIBRATION_TOLERANCE: u32 = 4;

/// The timer.
pub struct Counter;

/// Ticks of some repetitions, and of twice as many.
#[derive(Clone, Copy)]
pub struct Ticks {
    pub once: u32,
    pub twice: u32,
}

impl Counter {
    /// Starts the timer.
    pub fn start() -> Self {
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
        let ticks = Self::ticks(|| cortex_m::asm::delay(CALIBRATION_TURNS - 1));
        if ticks.abs_diff(CALIBRATION_TICKS) <= CALIBRATION_TOLERANCE { Ok(()) } else { Err(ticks) }
    }

    /// The ticks that `work` takes: fewer than [`RELOAD`].
    #[inline(never)]
    pub fn ticks(work: impl FnOnce()) -> u32 {
        let before = SYST::get_current();
        work();
        let after = SYST::get_current();
        before.wrapping_sub(after) & RELOAD
    }

    /// Runs a kernel `repetitions` times, and twice as often.
    pub fn count(&self, repetitions: u32, mut kernel: impl FnMut()) -> Ticks {
        // One loop in the code, and not two that might be compiled differently.
        let mut run = |count: u32| Self::ticks(|| (0..black_box(count)).for_each(|_| kernel()));
        let mut ticks = [0; 2];
        for (ticks, count) in ticks.iter_mut().zip([repetitions, 2 * repetitions]) {
            *ticks = run(count);
        }
        Ticks { once: ticks[0], twice: ticks[1] }
    }
}
