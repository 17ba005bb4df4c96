//! Products (A7.7, A5.3.16, A5.3.17).

use crate::cpu::{Cpu, Trap};
use crate::op::{Long, Product};

/// Returns the low or the top half as a signed number.
fn half(value: u32, top: bool) -> i64 {
    i64::from(if top { (value >> 16) as i16 } else { value as i16 })
}

/// Returns the sum or difference of the two products of halves.
fn dual(x: u32, y: u32, swap: bool, subtract: bool) -> i64 {
    let y = if swap { y.rotate_right(16) } else { y };
    let (low, high) = (half(x, false) * half(y, false), half(x, true) * half(y, true));
    if subtract { low - high } else { low + high }
}

impl Cpu {
    /// Computes a product of 32 bits, without an accumulator if `a` is 15. An overflow of an
    /// addition sets Q.
    pub(super) fn product(&mut self, product: Product, d: u8, n: u8, m: u8, a: u8) {
        let (x, y) = (self.get(n), self.get(m));
        let accumulator = if a == 15 { 0 } else { self.get(a) };
        let signed = i64::from(accumulator as i32);
        let mut overflows = |sum: i64| {
            self.flags.q |= sum != i64::from(sum as i32);
            sum as u32
        };
        let result = match product {
            Product::Half { top_n, top_m } => overflows(half(x, top_n) * half(y, top_m) + signed),
            Product::Wide { top_m } => overflows(((i64::from(x as i32) * half(y, top_m)) >> 16) + signed),
            Product::Dual { swap, subtract } => overflows(dual(x, y, swap, subtract) + signed),
            Product::Most { round, subtract } => {
                let exact = i64::from(x as i32) * i64::from(y as i32);
                let base = signed << 32;
                let sum = if subtract { base.wrapping_sub(exact) } else { base.wrapping_add(exact) };
                (sum.wrapping_add(i64::from(round) << 31) >> 32) as u32
            }
            Product::Differences => {
                let sum: u32 = x.to_le_bytes().iter().zip(y.to_le_bytes()).map(|(x, y)| u32::from(x.abs_diff(y))).sum();
                accumulator.wrapping_add(sum)
            }
        };
        self.set(d, result);
    }

    /// Computes a product of 64 bits.
    #[inline]
    pub(super) fn long(&mut self, long: Long, lo: u8, hi: u8, n: u8, m: u8) {
        let (x, y) = (self.get(n), self.get(m));
        let (unsigned, signed) = (u64::from(x) * u64::from(y), (i64::from(x as i32) * i64::from(y as i32)) as u64);
        let (low, high) = (self.get(lo), self.get(hi));
        let accumulator = u64::from(high) << 32 | u64::from(low);
        let result = match long {
            Long::Smull => signed,
            Long::Umull => unsigned,
            Long::Smlal => accumulator.wrapping_add(signed),
            Long::Umlal => accumulator.wrapping_add(unsigned),
            Long::Umaal => unsigned + u64::from(low) + u64::from(high),
            Long::SmlalHalf { top_n, top_m } => accumulator.wrapping_add((half(x, top_n) * half(y, top_m)) as u64),
            Long::Dual { swap, subtract } => accumulator.wrapping_add(dual(x, y, swap, subtract) as u64),
        };
        self.set(lo, result as u32);
        self.set(hi, (result >> 32) as u32);
    }

    /// Executes `SDIV`, `UDIV`, rounded towards zero. A division by zero gives 0, or a fault if
    /// CCR.DIV_0_TRP is set.
    pub(super) fn divide(&mut self, signed: bool, d: u8, n: u8, m: u8) -> Result<(), Trap> {
        let (x, y) = (self.get(n), self.get(m));
        if y == 0 && self.scb.traps_division() {
            return Err(Trap::DivideByZero);
        }
        let quotient = match signed {
            _ if y == 0 => 0,
            true => (x as i32).wrapping_div(y as i32) as u32,
            false => x / y,
        };
        self.set(d, quotient);
        Ok(())
    }
}
