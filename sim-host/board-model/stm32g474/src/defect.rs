//! Defects that can be injected.

use cortex_m4::{Cycle, Fault, Ports};

use crate::factory;
use crate::part::Stm32g474;
use crate::time::Event;
use crate::wires::{Pin, Wires};

/// Effect of a brown-out on the RAM.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ram {
    /// Contents are kept.
    Kept,
    /// Contents are replaced by other bits.
    Lost,
}

/// Defect of the microcontroller or of its supply, from some cycle on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Defect {
    /// ADC `adc` (1 to 5) converts everything to `code`.
    AdcStuck {
        /// Number of the ADC.
        adc: u8,
        /// Code of 12 bits.
        code: u16,
    },
    /// Each result of ADC `adc` (1 to 5) is stored a sample late (ES0430 2.7.6).
    AdcLate {
        /// Number of the ADC.
        adc: u8,
    },
    /// Timer `timer` (2 to 5) stops: its triggers are lost.
    TimerHalts {
        /// Number of the timer.
        timer: u8,
    },
    /// The next `triggers` triggers of timer `timer` (2 to 5) are lost; it continues to count.
    TriggersLost {
        /// Number of the timer.
        timer: u8,
        /// Number of lost triggers.
        triggers: u32,
    },
    /// Channel `channel` (1 to 8) of DMA `dma` stops serving requests.
    DmaHalts {
        /// Number of the DMA controller.
        dma: u8,
        /// Number of the channel.
        channel: u8,
    },
    /// Channel `channel` (1 to 8) of DMA `dma` misses the next `requests` requests.
    DmaMisses {
        /// Number of the DMA controller.
        dma: u8,
        /// Number of the channel.
        channel: u8,
        /// Number of missed requests.
        requests: u32,
    },
    /// The next transfer of channel `channel` (1 to 8) of DMA `dma` has a bus error, which switches
    /// the channel off.
    DmaFails {
        /// Number of the DMA controller.
        dma: u8,
        /// Number of the channel.
        channel: u8,
    },
    /// The output of comparator `comparator` (1 to 7) is stuck.
    ComparatorStuck {
        /// Number of the comparator.
        comparator: u8,
        /// Level of its output, after its polarity.
        high: bool,
    },
    /// The oscillator of the watchdog (LSI) has another frequency, Hz.
    LsiHz(u64),
    /// The crystal stops.
    HseStops,
    /// The PLL loses its lock and stops. If it is the system clock, everything that counts its
    /// cycles stops until the watchdog resets the chip; without a running watchdog the model ends
    /// the run.
    PllUnlocks,
    /// The supply dips: power-on reset; data that the flash was writing are damaged.
    BrownOut {
        /// Effect on the RAM.
        ram: Ram,
    },
    /// One bit of the flash's double word at `address` flips, which is corrected and flagged; or
    /// two bits, which is an error.
    FlashBits {
        /// Address in the double word.
        address: u32,
        /// Number of bits: one or two.
        bits: u8,
    },
    /// A bit of the RAM flips.
    RamBit {
        /// Address of the byte.
        address: u32,
        /// Number of the bit, 0 to 7.
        bit: u8,
    },
    /// The next `bytes` bytes that LPUART1 receives have a flipped bit and the noise flag.
    UartNoise {
        /// Number of bytes.
        bytes: u32,
    },
    /// An input pin is stuck at a level.
    PinStuck {
        /// Stuck pin.
        pin: Pin,
        /// Level of the pin.
        high: bool,
    },
    /// The supply falls below the threshold of PWR_CR2.PLS (`true`), or recovers (`false`).
    SupplyLow(bool),
}

impl<W: Wires> Stm32g474<W> {
    /// Plans a defect at a cycle.
    pub fn inject(&mut self, at: Cycle, defect: Defect) {
        self.defects.push((at, defect));
        self.defects.sort_by_key(|(at, _)| *at);
        self.plan_defect();
    }

    pub(crate) fn plan_defect(&mut self) {
        let next = self.defects.first().map_or(Cycle::MAX, |(at, _)| *at);
        self.agenda.set(Event::Defect, next);
    }

    /// Returns the stuck pins of a port with their levels.
    pub(crate) fn stuck_pins(&self, port: u8) -> impl Iterator<Item = (u8, bool)> {
        self.stuck.iter().filter(move |(pin, _)| pin.port == port).map(|(pin, high)| (pin.number, *high))
    }

    /// Starts the defects that are due.
    pub(crate) fn fail(&mut self, at: Cycle, ports: &mut Ports) -> Result<(), Fault> {
        while self.defects.first().is_some_and(|(due, _)| *due <= at) {
            let (_, defect) = self.defects.remove(0);
            match defect {
                Defect::AdcStuck { adc, code } => self.adcs[usize::from(adc - 1)].stuck = Some(code),
                Defect::AdcLate { adc } => self.adcs[usize::from(adc - 1)].late = Some(0),
                Defect::TriggersLost { timer, triggers } => self.timers[usize::from(timer - 2)].lost = triggers,
                Defect::DmaMisses { dma, channel, requests } => self.dma.miss(usize::from((dma - 1) * 8 + channel - 1), requests),
                Defect::DmaFails { dma, channel } => self.dma.fail_next(usize::from((dma - 1) * 8 + channel - 1)),
                Defect::ComparatorStuck { comparator, high } => {
                    self.stuck_comparators[usize::from(comparator - 1)] = Some(high);
                    self.update_inputs(at, ports)?;
                }
                Defect::LsiHz(hz) => self.change_lsi(at, hz),
                Defect::TimerHalts { timer } => self.halt_timer(at, usize::from(timer - 2)),
                Defect::DmaHalts { dma, channel } => self.dma.halt(usize::from((dma - 1) * 8 + channel - 1)),
                Defect::HseStops => self.hse_stops(at, ports)?,
                Defect::PllUnlocks => self.pll_unlocks(at)?,
                Defect::BrownOut { ram } => {
                    self.flash_loses_power(ports);
                    if ram == Ram::Lost {
                        factory::scramble(ports.memory);
                    }
                    self.rcc.power_lost = true;
                    ports.interrupts.pull_reset();
                }
                Defect::FlashBits { address, bits } => self.flip_flash(address, bits, ports),
                Defect::RamBit { address, bit } => {
                    if let Some([byte]) = ports.memory.get_mut(address, 1) {
                        *byte ^= 1 << (bit & 7);
                    }
                }
                Defect::UartNoise { bytes } => self.uart.noise = bytes,
                Defect::PinStuck { pin, high } => {
                    self.stuck.push((pin, high));
                    self.update_inputs(at, ports)?;
                }
                Defect::SupplyLow(low) => self.supply(at, low, ports),
            }
        }
        self.plan_defect();
        Ok(())
    }
}
