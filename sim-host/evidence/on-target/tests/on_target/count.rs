//! Cost of a block: instructions in QEMU, by its system timer; cycles on the board, by the core's
//! cycle counter.

/// Unit of the counts on an emulated board.
#[cfg(not(feature = "hil"))]
pub const UNIT: &str = "instructions";
/// Unit of the counts on a real board.
#[cfg(feature = "hil")]
pub const UNIT: &str = "cycles";

#[cfg(not(feature = "hil"))]
pub use self::instructions::Meter;

#[cfg(feature = "hil")]
pub use self::cycles::Meter;

#[cfg(not(feature = "hil"))]
mod instructions {
    use qemu_m4::counter::Counter;

    /// Counter of instructions, to within a tick of 6.
    pub struct Meter(Counter);

    impl Meter {
        /// Starts the timer, and panics if it does not count instructions.
        pub fn start() -> Self {
            let counter = Counter::start();
            assert_eq!(counter.calibrate(), Ok(()), "ticks of a loop of known length");
            Meter(counter)
        }

        /// Returns the instructions that `work` takes.
        pub fn measure(&self, work: &mut dyn FnMut()) -> u32 {
            let before = self.0.now();
            work();
            self.0.since(before) * 125 / 21
        }
    }
}

#[cfg(feature = "hil")]
mod cycles {
    use cortex_m::Peripherals;
    use cortex_m::peripheral::DWT;

    /// Counter of cycles at the part's 16 MHz after reset. The flash has no wait states there, so a
    /// block takes fewer cycles than at full speed.
    pub struct Meter;

    impl Meter {
        /// Starts the processor's cycle counter.
        pub fn start() -> Self {
            let mut core = Peripherals::take().expect("taken once");
            core.DCB.enable_trace();
            core.DWT.enable_cycle_counter();
            Meter
        }

        /// Returns the cycles that `work` takes.
        pub fn measure(&self, work: &mut dyn FnMut()) -> u32 {
            let before = DWT::cycle_count();
            work();
            DWT::cycle_count().wrapping_sub(before)
        }
    }
}
