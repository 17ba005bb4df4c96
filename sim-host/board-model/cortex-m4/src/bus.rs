//! Data bus: memories, registers of the processor, registers of the chip, and bit-band aliases.

use crate::chip::{Access, Chip, Fault, Ports, Width};
use crate::cpu::{Cpu, Trap};
use crate::machine::Machine;
use crate::op::Size;

impl Size {
    #[inline(always)]
    fn bytes(self) -> u32 {
        match self {
            Size::Word => 4,
            Size::Half | Size::SignedHalf => 2,
            Size::Byte | Size::SignedByte => 1,
        }
    }

    fn width(self) -> Width {
        match self.bytes() {
            4 => Width::Word,
            2 => Width::Half,
            _ => Width::Byte,
        }
    }

    /// Extends a value of this size to a register.
    #[inline(always)]
    fn extend(self, value: u32) -> u32 {
        match self {
            Size::Word => value,
            Size::Half => value & 0xFFFF,
            Size::Byte => value & 0xFF,
            Size::SignedHalf => i32::from(value as i16) as u32,
            Size::SignedByte => i32::from(value as i8) as u32,
        }
    }
}

/// Returns the byte address and bit number that a word of a bit-band alias maps to (ARM DDI 0439,
/// 3.7).
fn bit_band(address: u32) -> Option<(u32, u32)> {
    let base = address & 0xF000_0000;
    let offset = address.wrapping_sub(base | 0x0200_0000);
    (matches!(base, 0x2000_0000 | 0x4000_0000) && offset < 0x0200_0000).then_some((base + (offset >> 5), offset >> 2 & 7))
}

impl Cpu {
    /// Converts a fault of the chip to a trap of the processor.
    pub(crate) fn trap(&mut self, fault: Fault) -> Trap {
        match fault {
            Fault::Bus => Trap::Bus,
            Fault::Stop(finding) => {
                self.stop = Some(finding.into());
                Trap::Stop
            }
        }
    }
}

impl<C: Chip> Machine<C> {
    /// Loads one value, extended to a register.
    #[inline(always)]
    pub(crate) fn load(&mut self, size: Size, address: u32) -> Result<u32, Trap> {
        if address & (size.bytes() - 1) != 0 {
            return self.load_unaligned(size, address);
        }
        if self.cpu.mpu.enabled {
            self.check(address, false)?;
        }
        let Some((bank, from)) = self.memory.find(address) else { return self.load_elsewhere(size, address) };
        let region = &self.memory.banks[bank].region;
        if region.waits {
            self.cpu.cost += self.chip.load_wait(address, self.cpu.cycle);
        }
        if !self.memory.damaged.is_empty() {
            self.report_damage(address, size.bytes())?;
        }
        let region = &self.memory.banks[bank].region;
        let bytes = &region.bytes[from..];
        let value = match size.bytes() {
            4 => bytes.first_chunk().map(|bytes| u32::from_le_bytes(*bytes)),
            2 => bytes.first_chunk().map(|bytes| u16::from_le_bytes(*bytes).into()),
            _ => bytes.first().map(|byte| u32::from(*byte)),
        };
        value.map(|value| size.extend(value)).ok_or_else(|| self.bus_fault(address))
    }

    /// Stores the lowest bits of a register.
    #[inline(always)]
    pub(crate) fn store(&mut self, size: Size, address: u32, value: u32) -> Result<(), Trap> {
        if address & (size.bytes() - 1) != 0 {
            return self.store_unaligned(size, address, value);
        }
        if self.cpu.mpu.enabled {
            self.check(address, true)?;
        }
        let Some((bank, from)) = self.memory.find(address) else { return self.store_elsewhere(size, address, value) };
        let bank = &mut self.memory.banks[bank];
        if !bank.region.writable {
            return self.store_elsewhere(size, address, value);
        }
        bank.drop_decoded(from, size.bytes() as usize);
        let bytes = &mut bank.region.bytes[from..];
        let value = value.to_le_bytes();
        let stored = match size.bytes() {
            4 => bytes.first_chunk_mut().map(|bytes| *bytes = value),
            2 => bytes.first_chunk_mut().map(|bytes| *bytes = [value[0], value[1]]),
            _ => bytes.first_mut().map(|byte| *byte = value[0]),
        };
        stored.ok_or_else(|| self.bus_fault(address))
    }

    /// Loads a word that must be aligned: for `LDM`, `LDRD`, `VLDR` and similar.
    #[inline]
    pub(crate) fn load_aligned(&mut self, address: u32) -> Result<u32, Trap> {
        self.must_be_aligned(Size::Word, address)?;
        self.load(Size::Word, address)
    }

    #[inline]
    pub(crate) fn store_aligned(&mut self, address: u32, value: u32) -> Result<(), Trap> {
        self.must_be_aligned(Size::Word, address)?;
        self.store(Size::Word, address, value)
    }

    pub(crate) fn must_be_aligned(&self, size: Size, address: u32) -> Result<(), Trap> {
        if address & (size.bytes() - 1) == 0 { Ok(()) } else { Err(Trap::Unaligned) }
    }

    fn bus_fault(&mut self, address: u32) -> Trap {
        self.cpu.fault_address = address;
        Trap::Bus
    }

    /// Returns an error if the MPU forbids the access.
    #[inline(always)]
    fn check(&mut self, address: u32, write: bool) -> Result<(), Trap> {
        let privileged = self.cpu.privileged() && !self.as_user;
        if privileged && self.cpu.mpu.is_open(address) { Ok(()) } else { self.check_regions(address, write, privileged) }
    }

    #[cold]
    #[inline(never)]
    fn check_regions(&mut self, address: u32, write: bool, privileged: bool) -> Result<(), Trap> {
        let without = self.cpu.faultmask || self.cpu.ipsr == 2 || self.cpu.ipsr == 3;
        if self.cpu.mpu.allows(address, write, privileged, without) {
            return Ok(());
        }
        self.cpu.fault_address = address;
        Err(Trap::Memory)
    }

    /// Loads byte by byte, with the extra cycles of the split accesses.
    #[cold]
    fn load_unaligned(&mut self, size: Size, address: u32) -> Result<u32, Trap> {
        self.may_be_unaligned(size, address)?;
        let mut value = 0;
        for byte in 0..size.bytes() {
            value |= self.load(Size::Byte, address.wrapping_add(byte))? << (8 * byte);
        }
        Ok(size.extend(value))
    }

    #[cold]
    fn store_unaligned(&mut self, size: Size, address: u32, value: u32) -> Result<(), Trap> {
        self.may_be_unaligned(size, address)?;
        for byte in 0..size.bytes() {
            self.store(Size::Byte, address.wrapping_add(byte), value >> (8 * byte))?;
        }
        Ok(())
    }

    /// Returns an error if unaligned accesses fault: by CCR, and always to device memory (A3.2.1,
    /// B3.1).
    fn may_be_unaligned(&mut self, size: Size, address: u32) -> Result<(), Trap> {
        if self.cpu.scb.traps_unaligned() || matches!(address >> 29, 2 | 5..) {
            return Err(Trap::Unaligned);
        }
        self.cpu.cost += size.bytes() / 2;
        Ok(())
    }

    /// Loads from an address without memory.
    #[inline(never)]
    fn load_elsewhere(&mut self, size: Size, address: u32) -> Result<u32, Trap> {
        self.cpu.fault_address = address;
        if is_private(address) {
            return self.read_private(size.width(), address).map(|value| size.extend(value));
        }
        if let Some((byte, bit)) = bit_band(address) {
            return Ok(self.load(Size::Byte, byte)? >> bit & 1);
        }
        let access = self.access(size, address);
        let ports = Ports { memory: &mut self.memory, interrupts: &mut self.interrupts };
        let answer = self.chip.read(access, ports);
        self.cpu.cost += self.chip.access_wait(address);
        self.update_from_chip();
        answer.map(|value| size.extend(value)).map_err(|fault| self.cpu.trap(fault))
    }

    /// Stores to an address without writable memory.
    #[inline(never)]
    fn store_elsewhere(&mut self, size: Size, address: u32, value: u32) -> Result<(), Trap> {
        self.cpu.fault_address = address;
        let value = match size.width() {
            Width::Word => value,
            Width::Half => value & 0xFFFF,
            Width::Byte => value & 0xFF,
        };
        if is_private(address) {
            return self.write_private(size.width(), address, value);
        }
        if let Some((byte, bit)) = bit_band(address) {
            let old = self.load(Size::Byte, byte)?;
            return self.store(Size::Byte, byte, old & !(1 << bit) | (value & 1) << bit);
        }
        let access = self.access(size, address);
        let ports = Ports { memory: &mut self.memory, interrupts: &mut self.interrupts };
        let answer = self.chip.write(access, value, ports);
        self.cpu.cost += self.chip.access_wait(address);
        self.update_from_chip();
        answer.map_err(|fault| self.cpu.trap(fault))
    }

    fn access(&self, size: Size, address: u32) -> Access {
        Access { address, width: size.width(), at: self.cpu.cycle, pc: self.cpu.pc }
    }

    /// Updates the deadline after the chip has acted: its lines and its next event may have
    /// changed.
    pub(crate) fn update_from_chip(&mut self) {
        if self.interrupts.has_changed() {
            self.cpu.schedule_check();
        } else {
            self.cpu.deadline = self.cpu.deadline.min(self.chip.due());
        }
    }

    /// Reports a read of damaged bytes to the chip.
    #[cold]
    pub(crate) fn report_damage(&mut self, address: u32, len: u32) -> Result<(), Trap> {
        let (first, last) = (address & !7, address.wrapping_add(len - 1) & !7);
        for word in [Some(first), (last != first).then_some(last)].into_iter().flatten() {
            if !self.memory.is_damaged(word) {
                continue;
            }
            let ports = Ports { memory: &mut self.memory, interrupts: &mut self.interrupts };
            // Address of the access, or of the next word that it extends into.
            let answer = self.chip.damaged(address.max(word), ports);
            self.update_from_chip();
            answer.map_err(|fault| self.cpu.trap(fault))?;
        }
        Ok(())
    }
}

/// Returns `true` for the processor's own registers: the internal part of the private peripheral
/// bus (B3.1). The external part belongs to the chip.
fn is_private(address: u32) -> bool {
    address >> 18 == 0xE000_0000 >> 18
}
