//! What can be made to fail.

/// What becomes of the RAM in a brown-out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ram {
    /// It keeps its contents.
    Kept,
    /// It comes up with other bits.
    Lost,
}

/// A defect of the part or of its supply, from some time on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Defect {
    /// ADC `adc` (1 to 5) converts everything to `code`.
    AdcStuck {
        /// The ADC.
        adc: u8,
        /// The code of 12 bits.
        code: u16,
    },
    /// Timer `timer` (2 to 5) stands: its triggers are lost.
    TimerHalts {
        /// The timer.
        timer: u8,
    },
    /// Channel `channel` (1 to 8) of DMA `dma` serves no request any more.
    DmaHalts {
        /// The DMA controller.
        dma: u8,
        /// The channel.
        channel: u8,
    },
    /// The crystal stops.
    HseStops,
    /// The PLL loses its lock, and the processor the clock that it has from it: the run ends here unless the system clock is another one.
    PllUnlocks,
    /// The supply dips: power-on reset; what the flash was writing is damaged.
    BrownOut {
        /// What becomes of the RAM.
        ram: Ram,
    },
    /// Bits of the flash's double word at `address` flip: one, which is corrected and flagged, or two, which is not.
    FlashBits {
        /// The address.
        address: u32,
        /// One or two.
        bits: u8,
    },
    /// A bit of the RAM flips.
    RamBit {
        /// Address of the byte.
        address: u32,
        /// The bit, 0 to 7.
        bit: u8,
    },
    /// The next `bytes` bytes that LPUART1 receives have a flipped bit and the flag of noise.
    UartNoise {
        /// How many.
        bytes: u32,
    },
    /// An input pin is stuck at a level.
    PinStuck {
        /// The pin.
        pin: crate::Pin,
        /// The level.
        high: bool,
    },
    /// The supply falls below the threshold of PWR_CR2.PLS, or comes back.
    SupplyLow(bool),
}
