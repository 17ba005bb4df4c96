//! Data processing of words: arithmetic, logic, shifts, bit fields (A7.7).

use crate::cpu::Cpu;
use crate::op::{Alu, Bits, Extend, Sets, Shift};

/// Returns sum, carry out and overflow: `AddWithCarry` (A2.2.1).
#[inline(always)]
pub(super) fn add_with_carry(x: u32, y: u32, carry: bool) -> (u32, bool, bool) {
    let wide = u64::from(x) + u64::from(y) + u64::from(carry);
    let sum = wide as u32;
    (sum, wide >> 32 != 0, ((x ^ sum) & (y ^ sum)) >> 31 == 1)
}

impl Cpu {
    /// Computes `d = x + y + carry`, and all four flags if selected.
    #[inline(always)]
    pub(super) fn add(&mut self, d: u8, x: u32, y: u32, carry: bool, sets: Sets) {
        let (sum, c, v) = add_with_carry(x, y, carry);
        if self.sets(sets) {
            self.set_nz(sum);
            self.flags.c = c;
            self.flags.v = v;
        }
        self.set(d, sum);
    }

    #[inline(always)]
    pub(super) fn compare(&mut self, x: u32, y: u32) {
        let (sum, c, v) = add_with_carry(x, !y, true);
        self.set_nz(sum);
        self.flags.c = c;
        self.flags.v = v;
    }

    /// Stores a result, and sets N, Z, and C from the shifter if selected.
    #[inline(always)]
    pub(super) fn logical(&mut self, d: u8, result: u32, carry: bool, sets: Sets) {
        if self.sets(sets) {
            self.set_nz(result);
            self.flags.c = carry;
        }
        self.set(d, result);
    }

    /// Executes an operation with its second operand and the carry out of the shifter.
    #[inline]
    pub(super) fn alu(&mut self, alu: Alu, d: u8, n: u8, operand: (u32, bool), sets: Sets) {
        let (x, (y, carry)) = (self.get(n), operand);
        match alu {
            Alu::And => self.logical(d, x & y, carry, sets),
            Alu::Bic => self.logical(d, x & !y, carry, sets),
            Alu::Orr => self.logical(d, x | y, carry, sets),
            Alu::Orn => self.logical(d, x | !y, carry, sets),
            Alu::Eor => self.logical(d, x ^ y, carry, sets),
            Alu::Mov => self.logical(d, y, carry, sets),
            Alu::Mvn => self.logical(d, !y, carry, sets),
            Alu::Add => self.add(d, x, y, false, sets),
            Alu::Adc => self.add(d, x, y, self.flags.c, sets),
            Alu::Sbc => self.add(d, x, !y, self.flags.c, sets),
            Alu::Sub => self.add(d, x, !y, true, sets),
            Alu::Rsb => self.add(d, !x, y, true, sets),
            Alu::Cmp => self.compare(x, y),
            Alu::Cmn => {
                let (sum, c, v) = add_with_carry(x, y, false);
                self.set_nz(sum);
                self.flags.c = c;
                self.flags.v = v;
            }
            Alu::Tst | Alu::Teq => {
                self.set_nz(if alu == Alu::Tst { x & y } else { x ^ y });
                self.flags.c = carry;
            }
        }
    }

    /// Returns an immediate with the carry of its expansion.
    #[inline(always)]
    pub(super) fn expanded(&self, imm: u32, rotated: bool) -> (u32, bool) {
        (imm, if rotated { imm >> 31 == 1 } else { self.flags.c })
    }

    #[inline]
    pub(super) fn shift_imm(&mut self, d: u8, m: u8, sets: Sets, shift: Shift, amount: u8) {
        let (result, carry) = self.shift(self.get(m), shift, amount);
        self.logical(d, result, carry, sets);
    }

    pub(super) fn bits(&mut self, bits: Bits, d: u8, m: u8) {
        let value = self.get(m);
        let result = match bits {
            Bits::Rev => value.swap_bytes(),
            Bits::Rev16 => value.swap_bytes().rotate_left(16),
            Bits::Revsh => i32::from((value as u16).swap_bytes() as i16) as u32,
            Bits::Rbit => value.reverse_bits(),
            Bits::Clz => value.leading_zeros(),
        };
        self.set(d, result);
    }

    /// Executes `SXTB` … `UXTAB16`; without an accumulator if `n` is 15.
    pub(super) fn extend(&mut self, extend: Extend, d: u8, n: u8, m: u8, rotate: u8) {
        let value = self.get(m).rotate_right(u32::from(rotate));
        let base = if n == 15 { 0 } else { self.get(n) };
        let lanes = |low: u32, high: u32| base.wrapping_add(low) & 0xFFFF | (base >> 16).wrapping_add(high) << 16;
        let signed = |byte: u32| i32::from(byte as i8) as u32;
        let result = match extend {
            Extend::SignedByte => base.wrapping_add(signed(value)),
            Extend::SignedHalf => base.wrapping_add(i32::from(value as i16) as u32),
            Extend::Byte => base.wrapping_add(value & 0xFF),
            Extend::Half => base.wrapping_add(value & 0xFFFF),
            Extend::SignedBytes => lanes(signed(value), signed(value >> 16)),
            Extend::Bytes => lanes(value & 0xFF, value >> 16 & 0xFF),
        };
        self.set(d, result);
    }

    /// Executes `UBFX`, `SBFX`. Bits above 31 are unpredictable in the manual and read as 0 here.
    pub(super) fn extract(&mut self, signed: bool, d: u8, n: u8, lsb: u8, width: u8) {
        let above = 32 - u32::from(width);
        let field = (self.get(n) >> lsb) << above;
        self.set(d, if signed { (field as i32 >> above) as u32 } else { field >> above });
    }

    /// Executes `BFI`, and `BFC` if `n` is 15.
    pub(super) fn insert(&mut self, d: u8, n: u8, lsb: u8, width: u8) {
        let mask = (u32::MAX >> (32 - u32::from(width))) << lsb;
        let source = if n == 15 { 0 } else { self.get(n) << lsb };
        self.set(d, self.get(d) & !mask | source & mask);
    }
}
