//! Pins: modes, levels, and signals of the wires. RM0440 9.

use cortex_m4::{Cycle, Fault, Ports};

use crate::map::SIGNALS;
use crate::map::at::gpio as reg;
use crate::map::base::{GPIOA, GPIOB};
use crate::part::{Now, Stm32g474};
use crate::wires::{Level, Pin, Wires};

/// Bytes from one port to the next.
const STRIDE: u32 = GPIOB - GPIOA;
const PORTS: usize = 7;

/// Outputs of the pins.
#[derive(Clone, Debug)]
pub(crate) struct Gpio {
    /// Driven pins of each port, one bit each.
    driven: [u16; PORTS],
    /// Levels of these pins.
    high: [u16; PORTS],
    /// Pins and channels of TIM1 with their alternate functions.
    channels: Vec<(Pin, u8, usize)>,
}

impl Default for Gpio {
    fn default() -> Self {
        let channels = SIGNALS
            .iter()
            .filter(|(peripheral, ..)| *peripheral == "TIM1")
            .filter_map(|(_, signal, pin, af)| {
                let channel: usize = signal.strip_prefix("CH")?.parse().ok()?;
                Some((Pin::named(pin)?, (*af)?, channel.checked_sub(1)?))
            })
            .filter(|(.., channel)| *channel < 4)
            .collect();
        Gpio { driven: [0; PORTS], high: [0; PORTS], channels }
    }
}

/// Returns the pins, one bit each, whose two bits of a register equal `value`.
fn pairs(register: u32, value: u32) -> u16 {
    let unlike = register ^ (value * 0x5555_5555);
    let mut bits = !(unlike | unlike >> 1) & 0x5555_5555;
    for (shift, mask) in [(1, 0x3333_3333), (2, 0x0f0f_0f0f), (4, 0x00ff_00ff), (8, 0xffff)] {
        bits = (bits | bits >> shift) & mask;
    }
    bits as u16
}

impl<W: Wires> Stm32g474<W> {
    fn port(port: u8) -> u32 {
        GPIOA + u32::from(port) * STRIDE
    }

    /// Returns MODER of a pin: input, output, alternate, analog (9.4.1).
    fn mode(&self, pin: Pin) -> u32 {
        self.regs[Self::port(pin.port) + reg::MODER] >> (2 * pin.number) & 3
    }

    /// Returns the alternate function of a pin; `None` in another mode.
    pub(crate) fn alternate(&self, pin: Pin) -> Option<u8> {
        let afr = self.regs[Self::port(pin.port) + reg::AFR_0 + u32::from(pin.number / 8) * 4];
        (self.mode(pin) == 2).then_some((afr >> (4 * (pin.number % 8)) & 0xf) as u8)
    }

    /// Returns the levels of the pins of a port: driven by the chip, by the wires, or by the pulls.
    /// A floating pin is low.
    pub(crate) fn levels(&mut self, at: Cycle, port: u8) -> u16 {
        let wires = self.wires.inputs(at, port);
        let pulls = self.regs[Self::port(port) + reg::PUPDR];
        let index = usize::from(port);
        let pulled_up = pairs(pulls, 1);
        let mut levels = pulled_up & !wires.driven | wires.high & wires.driven;
        levels = levels & !self.gpio.driven[index] | self.gpio.high[index] & self.gpio.driven[index];
        for (number, high) in self.stuck_pins(port) {
            levels = levels & !(1 << number) | u16::from(high) << number;
        }
        levels
    }

    /// Returns the level of an input pin.
    pub(crate) fn input_level(&mut self, at: Cycle, pin: Pin) -> bool {
        self.levels(at, pin.port) >> pin.number & 1 != 0
    }

    pub(crate) fn read_gpio(&mut self, now: Now, address: u32) -> u32 {
        let port = ((address - GPIOA) / STRIDE) as u8;
        if address - Self::port(port) != reg::IDR {
            return self.regs[address];
        }
        // An analog pin reads as low (9.3.12).
        let analog = pairs(self.regs[Self::port(port) + reg::MODER], 3);
        u32::from(self.levels(now.at, port) & !analog)
    }

    pub(crate) fn write_gpio(&mut self, now: Now, address: u32, value: u32, ports: &mut Ports) -> Result<(), Fault> {
        let port = Self::port(((address - GPIOA) / STRIDE) as u8);
        match address - port {
            // BSRR (9.4.7): the lower half sets, the upper one clears, and set has priority.
            reg::BSRR => {
                let odr = &mut self.regs[port + reg::ODR];
                *odr = *odr & !(value >> 16) | value & 0xffff;
            }
            reg::BRR => self.regs[port + reg::ODR] &= !value,
            reg::LCKR => return self.refuse(now, address, "the register"),
            _ => self.regs[address] = value,
        }
        self.pins_changed(now.at);
        // Only pins in an alternate function can reach a break.
        if !matches!(address - port, reg::BSRR | reg::BRR | reg::ODR) {
            self.update_breaks(now.at, ports);
        }
        self.update_exti(now.at, ports);
        Ok(())
    }

    /// Returns the output of a pin to its wire.
    fn output_of(&self, pin: Pin) -> Level {
        let port = Self::port(pin.port);
        let open_drain = self.regs[port + reg::OTYPER] >> pin.number & 1 != 0;
        let level = match self.mode(pin) {
            1 if self.regs[port + reg::ODR] >> pin.number & 1 != 0 => Level::High,
            1 => Level::Low,
            2 => {
                let function = self.alternate(pin);
                let channel = self.gpio.channels.iter().find(|(at, af, _)| *at == pin && Some(*af) == function);
                channel.map_or(Level::Floating, |(.., channel)| self.tim1.level(*channel))
            }
            _ => Level::Floating,
        };
        if open_drain && level == Level::High { Level::Floating } else { level }
    }

    /// Reports changed outputs to the wires.
    pub(crate) fn pins_changed(&mut self, at: Cycle) {
        for port in 0..PORTS {
            let modes = self.regs[Self::port(port as u8) + reg::MODER];
            // If all pins are analog or input, as after reset, no pin is driven.
            let candidates = pairs(modes, 1) | pairs(modes, 2);
            let looked_at = candidates | self.gpio.driven[port];
            for number in (0..16).filter(|number| looked_at >> number & 1 != 0) {
                let pin = Pin { port: port as u8, number };
                let level = self.output_of(pin);
                let bit = 1 << number;
                let was = match (self.gpio.driven[port] & bit != 0, self.gpio.high[port] & bit != 0) {
                    (false, _) => Level::Floating,
                    (true, true) => Level::High,
                    (true, false) => Level::Low,
                };
                if level != was {
                    let set = |bits: &mut u16, on: bool| if on { *bits |= bit } else { *bits &= !bit };
                    set(&mut self.gpio.driven[port], level != Level::Floating);
                    set(&mut self.gpio.high[port], level == Level::High);
                    self.wires.output(at, pin, level);
                }
            }
        }
    }
}
