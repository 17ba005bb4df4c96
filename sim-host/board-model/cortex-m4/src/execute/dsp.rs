//! Saturation and parallel arithmetic of the DSP extension (A5.3.13 to A5.3.15).

use crate::cpu::Cpu;
use crate::op::{Lanes, Parallel, Shift};

/// Limits `value` to `bits` bits, signed or unsigned. Returns `true` if that changed it.
fn saturate(value: i64, signed: bool, bits: u8) -> (u32, bool) {
    let (low, high) = match signed {
        true => (-(1i64 << (bits - 1)), (1i64 << (bits - 1)) - 1),
        false => (0, (1i64 << bits) - 1),
    };
    let result = value.clamp(low, high);
    (result as u32, result != value)
}

impl Cpu {
    /// `SSAT`, `USAT`
    pub(super) fn saturate(&mut self, signed: bool, d: u8, n: u8, bits: u8, shift: Shift, amount: u8) {
        let (value, _) = self.shift(self.get(n), shift, amount);
        let (result, saturated) = saturate(i64::from(value as i32), signed, bits);
        self.flags.q |= saturated;
        self.set(d, result);
    }

    /// `SSAT16`, `USAT16`
    pub(super) fn saturate16(&mut self, signed: bool, d: u8, n: u8, bits: u8) {
        let value = self.get(n);
        let (low, first) = saturate(i64::from(value as i16), signed, bits);
        let (high, second) = saturate(i64::from((value >> 16) as i16), signed, bits);
        self.flags.q |= first | second;
        self.set(d, low & 0xFFFF | high << 16);
    }

    /// Executes `QADD` and similar: `m ± n`, with `n` first doubled with saturation if selected.
    pub(super) fn saturating_add(&mut self, d: u8, n: u8, m: u8, double: bool, subtract: bool) {
        let (mut x, y) = (i64::from(self.get(n) as i32), i64::from(self.get(m) as i32));
        if double {
            let (doubled, saturated) = saturate(2 * x, true, 32);
            self.flags.q |= saturated;
            x = i64::from(doubled as i32);
        }
        let (result, saturated) = saturate(if subtract { y - x } else { y + x }, true, 32);
        self.flags.q |= saturated;
        self.set(d, result);
    }

    /// `PKHBT`, `PKHTB`
    pub(super) fn pack(&mut self, d: u8, n: u8, m: u8, top: bool, amount: u8) {
        let shift = if top { Shift::Asr } else { Shift::Lsl };
        let (operand, _) = self.shift(self.get(m), shift, amount);
        let (low, high) = if top { (operand, self.get(n)) } else { (self.get(n), operand) };
        self.set(d, low & 0xFFFF | high & 0xFFFF_0000);
    }

    /// Executes `SEL`: each byte comes from `n` if its GE flag is set, otherwise from `m`.
    pub(super) fn select(&mut self, d: u8, n: u8, m: u8) {
        let mask = (0..4).map(|lane| u32::from(self.flags.ge >> lane & 1) * (0xFF << (8 * lane))).sum::<u32>();
        self.set(d, self.get(n) & mask | self.get(m) & !mask);
    }

    /// Adds or subtracts two halves or four bytes in parallel.
    pub(super) fn parallel(&mut self, lanes: Lanes, parallel: Parallel, d: u8, n: u8, m: u8) {
        let (x, mut y) = (self.get(n), self.get(m));
        let bytes = matches!(parallel, Parallel::Add8 | Parallel::Sub8);
        if matches!(parallel, Parallel::Asx | Parallel::Sax) {
            y = y.rotate_right(16);
        }
        let width = if bytes { 8 } else { 16 };
        let signed = matches!(lanes, Lanes::Signed | Lanes::SignedSaturating | Lanes::SignedHalving);
        let lane = |value: u32, at: u32| match (signed, bytes) {
            (true, true) => i64::from((value >> at) as i8),
            (true, false) => i64::from((value >> at) as i16),
            (false, true) => i64::from((value >> at) as u8),
            (false, false) => i64::from((value >> at) as u16),
        };
        let (mut result, mut ge) = (0, 0);
        for at in (0..32).step_by(width as usize) {
            let subtracts = match parallel {
                Parallel::Add16 | Parallel::Add8 => false,
                Parallel::Sub16 | Parallel::Sub8 => true,
                Parallel::Asx => at == 0,
                Parallel::Sax => at == 16,
            };
            let (x, y) = (lane(x, at), lane(y, at));
            let exact = if subtracts { x - y } else { x + y };
            let value = match lanes {
                Lanes::Signed | Lanes::Unsigned => exact as u32,
                Lanes::SignedHalving | Lanes::UnsignedHalving => (exact >> 1) as u32,
                Lanes::SignedSaturating | Lanes::UnsignedSaturating => saturate(exact, signed, width as u8).0,
            };
            result |= (value & (u32::MAX >> (32 - width))) << at;
            // GE: result not below zero; for an unsigned sum, a carry (A7.7, UADD16).
            let greater = if signed || subtracts { exact >= 0 } else { exact >> width != 0 };
            if greater {
                ge |= (if bytes { 1 } else { 3 }) << (at / 8);
            }
        }
        if matches!(lanes, Lanes::Signed | Lanes::Unsigned) {
            self.flags.ge = ge;
        }
        self.set(d, result);
    }
}
