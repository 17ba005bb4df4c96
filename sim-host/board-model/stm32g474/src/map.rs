//! Register map: addresses, and the current value of every register.

use std::ops::{Index, IndexMut};

use crate::reset::RESETS;

/// Permitted accesses to a register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Read and write.
    ReadWrite,
    /// Read only.
    Read,
    /// Write only.
    Write,
}

/// Register of the microcontroller.
#[derive(Debug)]
pub struct Register {
    /// Name of its peripheral, such as `ADC1`.
    pub peripheral: &'static str,
    /// Name of the register, such as `CFGR`; elements of arrays are numbered from zero.
    pub name: &'static str,
    /// First address of its peripheral.
    pub base: u32,
    /// Address of the register.
    pub address: u32,
    /// Permitted accesses.
    pub access: Access,
    /// Address and bit in RCC that enable its clock.
    pub enable: Option<(u32, u32)>,
    /// Address and bit in RCC that reset it.
    pub reset: Option<(u32, u32)>,
    /// Fields: name, lowest bit, width.
    pub fields: &'static [(&'static str, u32, u32)],
}

/// Constants and table from the build script.
#[expect(missing_docs, clippy::unreadable_literal, reason = "made by the build script from the metadata of the chip")]
pub mod generated {
    use super::{Access, Register};
    include!(concat!(env!("OUT_DIR"), "/registers.rs"));
}

pub use generated::{REGISTERS, SIGNALS, TRIGGERS, at, base, line};

impl Register {
    /// Returns the defined bits; all others are reserved.
    pub fn mask(&self) -> u32 {
        self.fields.iter().fold(0, |mask, (_, low, width)| mask | ((((1_u64 << width) - 1) as u32) << low))
    }

    /// Returns the names of the fields with any of `bits`.
    pub fn names(&self, bits: u32) -> Vec<&'static str> {
        let mut names: Vec<_> = self
            .fields
            .iter()
            .filter(|(_, low, width)| (((1_u64 << width) - 1) as u32) << low & bits != 0)
            .map(|(name, ..)| *name)
            .collect();
        names.dedup();
        names
    }
}

/// Number of words in the address ranges with registers.
const WORDS: usize = 0xd100;

/// Returns the index of an address in [`Registers`].
#[inline(always)]
fn place(address: u32) -> Option<usize> {
    let (from, first, last) = match address >> 20 {
        0x400 => (0x4000_0000, 0, 0xc000),
        0x480 => (0x4800_0000, 0xc000, 0xc800),
        0x500 => (0x5000_0000, 0xc800, 0xd000),
        0xe00 => (0xe004_2000, 0xd000, 0xd100),
        _ => return None,
    };
    let place = first + address.checked_sub(from)? as usize / 4;
    (place < last).then_some(place)
}

/// Current values of all registers, by address.
#[derive(Clone, Debug)]
pub struct Registers {
    values: Vec<u32>,
    /// Index into [`REGISTERS`] plus one.
    entries: Vec<u16>,
    masks: Vec<u32>,
}

impl Default for Registers {
    fn default() -> Self {
        let mut registers = Registers { values: vec![0; WORDS], entries: vec![0; WORDS], masks: vec![0; WORDS] };
        for (index, register) in REGISTERS.iter().enumerate() {
            if let Some(place) = place(register.address) {
                registers.entries[place] = index as u16 + 1;
                registers.masks[place] = register.mask();
            }
        }
        registers.reset(|_| true);
        registers
    }
}

impl Registers {
    /// Returns the register at an address, and the mask of its bits.
    pub fn find(&self, address: u32) -> Option<(&'static Register, u32)> {
        let place = place(address)?;
        let entry = usize::from(self.entries[place]).checked_sub(1)?;
        Some((&REGISTERS[entry], self.masks[place]))
    }

    /// Returns `true` if the address is in a range with registers.
    pub fn covers(address: u32) -> bool {
        place(address).is_some()
    }

    /// Resets the registers for which `which` returns `true`.
    pub fn reset(&mut self, which: impl Fn(&Register) -> bool) {
        for register in REGISTERS {
            if let (Some(place), true) = (place(register.address), which(register)) {
                self.values[place] = 0;
            }
        }
        for (address, value) in RESETS {
            if self.find(*address).is_some_and(|(register, _)| which(register)) {
                self[*address] = *value;
            }
        }
    }
}

impl Index<u32> for Registers {
    type Output = u32;

    #[inline(always)]
    fn index(&self, address: u32) -> &u32 {
        &self.values[place(address).unwrap_or(0)]
    }
}

impl IndexMut<u32> for Registers {
    #[inline(always)]
    fn index_mut(&mut self, address: u32) -> &mut u32 {
        &mut self.values[place(address).unwrap_or(0)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_agree_with_the_manual() {
        // RM0440, table of the register boundary addresses.
        for (name, address) in [("TIM1", 0x4001_2c00), ("LPUART1", 0x4000_8000), ("ADC5", 0x5000_0600), ("DMA2", 0x4002_0400)] {
            assert!(REGISTERS.iter().any(|register| register.peripheral == name && register.base == address), "{name}");
        }
    }

    #[test]
    fn every_reset_value_belongs_to_a_register() {
        let registers = Registers::default();
        for (address, value) in RESETS {
            assert!(registers.find(*address).is_some(), "{address:#x}");
            assert_eq!(registers[*address], *value);
        }
    }

    #[test]
    fn undefined_bits_are_reserved() {
        let registers = Registers::default();
        let (register, mask) = registers.find(base::IWDG + at::iwdg::RLR).unwrap();
        assert_eq!((register.peripheral, register.name, mask), ("IWDG", "RLR", 0xfff));
        assert_eq!(registers.find(base::PWR + at::pwr::CR5).unwrap().1, 0x100);
        assert_eq!(registers.find(base::LPUART1 + at::lpuart::BRR).unwrap().1, 0xf_ffff);
    }
}
