//! Decoder of floating-point instructions (A6.4 to A6.7) and of missing coprocessors.

use super::{bit, field, reg};
use crate::op::{Float1, Float2, Op};

/// Returns a single-precision register number, with its lowest bit at `low`.
fn single(code: u32, high: u32, low: u32) -> u8 {
    (field(code, high, 4) << 1 | field(code, low, 1)) as u8
}

fn d(code: u32) -> u8 {
    single(code, 12, 22)
}

fn n(code: u32) -> u8 {
    single(code, 16, 7)
}

fn m(code: u32) -> u8 {
    single(code, 0, 5)
}

pub(super) fn decode(code: u32) -> Op {
    let coprocessor = field(code, 8, 4);
    if coprocessor & 0b1110 != 0b1010 {
        return Op::NoCoprocessor;
    }
    let double = coprocessor == 0b1011;
    match field(code, 24, 2) {
        // The unconditional forms (`CDP2`, `MCR2` …) are not allocated.
        _ if bit(code, 28) => Op::Undefined,
        0b00 | 0b01 => transfer(code, double),
        0b10 if bit(code, 4) => move_core(code, double),
        0b10 if double => Op::NoCoprocessor,
        0b10 => data(code),
        _ => Op::Undefined,
    }
}

/// Decodes loads and stores (A6.5), and moves of two registers (A6.7).
fn transfer(code: u32, double: bool) -> Op {
    let (load, back, up, before) = (bit(code, 20), bit(code, 21), bit(code, 23), bit(code, 24));
    let rn = reg(code, 16);
    let first = if double { (field(code, 22, 1) << 4 | field(code, 12, 4)) as u8 * 2 } else { d(code) };
    if !before && !up && !back {
        return if bit(code, 22) { move_two(code, double) } else { Op::Undefined };
    }
    if before && !back {
        let offset = (field(code, 0, 8) << 2) as i16;
        let offset = if up { offset } else { -offset };
        return match (first < 32, load) {
            (false, _) => Op::Undefined,
            (_, true) => Op::FloatLoad { d: first, n: rn, double, offset },
            (_, false) => Op::FloatStore { d: first, n: rn, double, offset },
        };
    }
    // The form with an odd number of words is `FLDMX`; here it moves one word less.
    let count = if double { field(code, 0, 8) as u8 & !1 } else { field(code, 0, 8) as u8 };
    if count == 0 || count > 32 || u32::from(first) + u32::from(count) > 32 || before == up || rn == 15 {
        return Op::Undefined;
    }
    match load {
        true => Op::FloatLoadMany { n: rn, first, count, before, back },
        false => Op::FloatStoreMany { n: rn, first, count, before, back },
    }
}

/// A6.7
fn move_two(code: u32, double: bool) -> Op {
    let (t, t2) = (reg(code, 12), reg(code, 16));
    let s = if double { (field(code, 5, 1) << 4 | field(code, 0, 4)) as u8 * 2 } else { m(code) };
    if field(code, 6, 2) != 0 || !bit(code, 4) || s > 30 {
        return Op::Undefined;
    }
    if bit(code, 20) { Op::FromFloats { s, t, t2 } } else { Op::ToFloats { s, t, t2 } }
}

/// A6.6
fn move_core(code: u32, double: bool) -> Op {
    let t = reg(code, 12);
    let load = bit(code, 20);
    if double {
        let s = (field(code, 7, 1) << 4 | field(code, 16, 4)) as u8 * 2 + field(code, 21, 1) as u8;
        return match (field(code, 22, 2), s < 32, field(code, 5, 2)) {
            (0, true, 0) if load => Op::FromFloat { s, t },
            (0, true, 0) => Op::ToFloat { s, t },
            _ => Op::Undefined,
        };
    }
    match (field(code, 21, 3), load) {
        (0b000, false) => Op::ToFloat { s: n(code), t },
        (0b000, true) => Op::FromFloat { s: n(code), t },
        (0b111, _) if reg(code, 16) != 1 => Op::Undefined,
        (0b111, false) => Op::WriteFpscr { t },
        (0b111, true) => Op::ReadFpscr { t },
        _ => Op::Undefined,
    }
}

/// A6.4
fn data(code: u32) -> Op {
    let (d, n, m) = (d(code), n(code), m(code));
    let low = bit(code, 6);
    let float = |float| Op::Float2 { float, d, n, m };
    match (field(code, 20, 4) & 0b1011, low) {
        (0b0000, false) => float(Float2::Mla),
        (0b0000, true) => float(Float2::Mls),
        (0b0001, false) => float(Float2::Nmls),
        (0b0001, true) => float(Float2::Nmla),
        (0b0010, false) => Op::FloatMul { d, n, m },
        (0b0010, true) => float(Float2::Nmul),
        (0b0011, false) => Op::FloatAdd { d, n, m },
        (0b0011, true) => float(Float2::Sub),
        (0b1000, false) => float(Float2::Div),
        (0b1001, false) => float(Float2::Fnms),
        (0b1001, true) => float(Float2::Fnma),
        (0b1010, false) => float(Float2::Fma),
        (0b1010, true) => float(Float2::Fms),
        (0b1011, false) => Op::FloatImm { d, bits: expand(field(code, 16, 4) << 4 | field(code, 0, 4)) },
        (0b1011, true) => other(code),
        _ => Op::Undefined,
    }
}

/// `VFPExpandImm` (A6.4.1)
fn expand(imm8: u32) -> u32 {
    let exponent = if bit(imm8, 6) { 0b1_1111 << 25 } else { 1 << 30 };
    (imm8 >> 7) << 31 | exponent | field(imm8, 0, 6) << 19
}

/// Decodes other data processing (table A6-4).
fn other(code: u32) -> Op {
    let (d, m) = (d(code), m(code));
    let high = bit(code, 7);
    let float = |float| Op::Float1 { float, d, m };
    match (field(code, 16, 4), high) {
        (0b0000, false) => float(Float1::Mov),
        (0b0000, true) => float(Float1::Abs),
        (0b0001, false) => float(Float1::Neg),
        (0b0001, true) => float(Float1::Sqrt),
        (0b0010, top) => float(Float1::FromHalf { top }),
        (0b0011, top) => float(Float1::ToHalf { top }),
        (0b0100, signal) => Op::FloatCompare { d, m, signal },
        (0b0101, signal) => Op::FloatCompare { d, m: 255, signal },
        (0b1000, signed) => float(Float1::FromInt { signed }),
        (0b1100 | 0b1101, by_zero) => float(Float1::ToInt { signed: bit(code, 16), by_mode: !by_zero }),
        (kind @ (0b1010 | 0b1011 | 0b1110 | 0b1111), word) => {
            let (signed, half) = (kind & 1 == 0, !word);
            let size = if half { 16 } else { 32 };
            let bits = field(code, 0, 4) << 1 | field(code, 5, 1);
            match (bits <= size, kind & 0b0100 != 0) {
                (false, _) => Op::Undefined,
                (_, true) => float(Float1::ToFixed { signed, half, fraction: (size - bits) as u8 }),
                (_, false) => float(Float1::FromFixed { signed, half, fraction: (size - bits) as u8 }),
            }
        }
        _ => Op::Undefined,
    }
}
