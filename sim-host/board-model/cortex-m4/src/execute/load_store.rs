//! Loads and stores of one or several words.

use crate::chip::Chip;
use crate::cpu::{Cpu, Last, Trap};
use crate::machine::Machine;
use crate::op::{Index, Size};
use crate::timing::Target;

impl Cpu {
    /// Returns the address of an access and the value of its base register afterwards.
    pub(super) fn indexed(&self, n: u8, index: Index, offset: i16) -> (u32, u32) {
        // Register 15 as a base is aligned.
        let base = if n == 15 { self.get(15) & !3 } else { self.get(n) };
        let moved = base.wrapping_add_signed(offset.into());
        match index {
            Index::Offset => (moved, base),
            Index::Before => (moved, moved),
            Index::After => (base, moved),
        }
    }

    /// Subtracts one cycle right after a load, unless the load computes the address or the fetch of
    /// this instruction had to wait.
    #[inline(always)]
    pub(super) fn pipeline(&mut self, n: u8, m: u8) {
        let last = self.last_load;
        if last.next == self.instructions && last.register != n && last.register != m && self.cost == 2 {
            self.cost = 1;
        }
    }
}

impl<C: Chip> Machine<C> {
    /// Loads into a register. The address comes from registers `n` and `m`.
    #[inline(always)]
    pub(super) fn load_to(&mut self, size: Size, t: u8, address: u32, n: u8, m: u8) -> Result<(), Trap> {
        self.cpu.pipeline(n, m);
        let value = self.load(size, address)?;
        self.cpu.set(t, value);
        self.cpu.last_load = Last { register: t, next: self.cpu.instructions + 1 };
        Ok(())
    }

    pub(super) fn load_double(&mut self, t: u8, t2: u8, address: u32) -> Result<(), Trap> {
        let first = self.load_aligned(address)?;
        let second = self.load_aligned(address.wrapping_add(4))?;
        self.cpu.set(t, first);
        self.cpu.set(t2, second);
        Ok(())
    }

    /// Executes `LDM`, `POP`. The PC is loaded last; the base is restored if a word faults.
    pub(super) fn load_many(&mut self, n: u8, list: u16, before: bool, back: bool) -> Result<(), Trap> {
        let base = self.cpu.get(n);
        let bytes = 4 * list.count_ones();
        let mut address = if before { base.wrapping_sub(bytes) } else { base };
        let moved = if before { address } else { base.wrapping_add(bytes) };
        let mut values = [0; 16];
        for (register, value) in values.iter_mut().enumerate() {
            if list >> register & 1 == 1 {
                *value = self.load_aligned(address)?;
                address = address.wrapping_add(4);
            }
        }
        if back {
            self.cpu.set(n, moved);
        }
        for register in 0..15 {
            if list >> register & 1 == 1 {
                self.cpu.set(register, values[usize::from(register)]);
            }
        }
        if list >> 15 == 1 {
            self.cpu.branch_exchange(values[15], Target::Loaded);
        }
        Ok(())
    }

    /// `STM`, `PUSH`
    pub(super) fn store_many(&mut self, n: u8, list: u16, before: bool, back: bool) -> Result<(), Trap> {
        let base = self.cpu.get(n);
        let bytes = 4 * list.count_ones();
        let mut address = if before { base.wrapping_sub(bytes) } else { base };
        let moved = if before { address } else { base.wrapping_add(bytes) };
        let mut rest = list;
        while rest != 0 {
            let register = rest.trailing_zeros() as u8;
            rest &= rest - 1;
            self.store_aligned(address, self.cpu.get(register))?;
            address = address.wrapping_add(4);
        }
        if back {
            self.cpu.set(n, moved);
        }
        Ok(())
    }

    /// `LDREX`, `LDREXB`, `LDREXH`
    pub(super) fn load_exclusive(&mut self, size: Size, t: u8, n: u8, offset: u16) -> Result<(), Trap> {
        let address = self.cpu.get(n).wrapping_add(offset.into());
        self.must_be_aligned(size, address)?;
        let value = self.load(size, address)?;
        self.cpu.exclusive = Some(address);
        self.cpu.set(t, value);
        Ok(())
    }

    /// Executes `STREX`, `STREXB`, `STREXH`. One address is marked; the monitor of the M4 covers
    /// all memory, which makes no difference to a correct program.
    pub(super) fn store_exclusive(&mut self, size: Size, d: u8, t: u8, n: u8, offset: u16) -> Result<(), Trap> {
        let address = self.cpu.get(n).wrapping_add(offset.into());
        self.must_be_aligned(size, address)?;
        let marked = self.cpu.exclusive == Some(address);
        if marked {
            self.store(size, address, self.cpu.get(t))?;
        }
        self.cpu.exclusive = None;
        self.cpu.set(d, u32::from(!marked));
        Ok(())
    }

    /// Executes `LDRT`, `STRT` and similar, with the rights of unprivileged thread mode.
    pub(super) fn unprivileged(&mut self, load: bool, size: Size, t: u8, address: u32) -> Result<(), Trap> {
        self.as_user = true;
        let done = match load {
            true => self.load(size, address).map(|value| self.cpu.set(t, value)),
            false => self.store(size, address, self.cpu.get(t)),
        };
        self.as_user = false;
        done
    }
}
