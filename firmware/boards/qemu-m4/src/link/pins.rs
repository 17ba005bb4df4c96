//! Pins and watchdog that the host reads and sets with each block.

use core::convert::Infallible;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use firmware::board::app::Watchdog;
use firmware::board::lockstep::Board;

static ENABLE: AtomicBool = AtomicBool::new(false);
static STOP: AtomicBool = AtomicBool::new(false);
static FED: AtomicU32 = AtomicU32::new(0);
static RESETS: AtomicBool = AtomicBool::new(false);

/// Presses or releases the emergency stop.
pub fn press(stop: bool) {
    STOP.store(stop, Ordering::Relaxed);
}

/// Returns the state of the board that the host receives with each block.
pub fn seen(failed: bool) -> Board {
    Board {
        enable: ENABLE.load(Ordering::Relaxed),
        fed: FED.load(Ordering::Relaxed),
        failed,
        resets: RESETS.load(Ordering::Relaxed),
    }
}

/// Output that enables the emulated amplifier.
pub struct Enable;

impl ErrorType for Enable {
    type Error = Infallible;
}

impl OutputPin for Enable {
    fn set_low(&mut self) -> Result<(), Infallible> {
        ENABLE.store(false, Ordering::Relaxed);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        ENABLE.store(true, Ordering::Relaxed);
        Ok(())
    }
}

/// Contact of the emergency stop: low while it is pressed.
pub struct Stop;

impl ErrorType for Stop {
    type Error = Infallible;
}

impl InputPin for Stop {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(!STOP.load(Ordering::Relaxed))
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        Ok(STOP.load(Ordering::Relaxed))
    }
}

/// Watchdog that counts its feeds. A reset waits until the block is answered.
pub struct VirtualWatchdog;

impl Watchdog for VirtualWatchdog {
    fn feed(&mut self) {
        FED.fetch_add(1, Ordering::Relaxed);
    }

    fn reset(&mut self) {
        RESETS.store(true, Ordering::Relaxed);
    }
}
