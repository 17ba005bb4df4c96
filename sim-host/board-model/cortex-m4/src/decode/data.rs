//! Decoder of 32-bit data processing (A5.3.1, A5.3.3, A5.3.11 to A5.3.17).

use super::{bit, field, reg};
use crate::op::{Alu, Bits, Extend, Lanes, Long, Op, Parallel, Product, Sets, Shift};

fn sets(code: u32) -> Sets {
    if bit(code, 20) { Sets::Always } else { Sets::Never }
}

/// Returns the operation of an opcode of four bits. Destination 15 and first operand 15 select
/// other operations, as in the manual.
fn alu(opcode: u32, d: u8, n: u8, code: u32) -> Option<Alu> {
    let flags_only = d == 15 && bit(code, 20);
    Some(match opcode {
        0b0000 if flags_only => Alu::Tst,
        0b0000 => Alu::And,
        0b0001 => Alu::Bic,
        0b0010 if n == 15 => Alu::Mov,
        0b0010 => Alu::Orr,
        0b0011 if n == 15 => Alu::Mvn,
        0b0011 => Alu::Orn,
        0b0100 if flags_only => Alu::Teq,
        0b0100 => Alu::Eor,
        0b1000 if flags_only => Alu::Cmn,
        0b1000 => Alu::Add,
        0b1010 => Alu::Adc,
        0b1011 => Alu::Sbc,
        0b1101 if flags_only => Alu::Cmp,
        0b1101 => Alu::Sub,
        0b1110 => Alu::Rsb,
        _ => return None,
    })
}

/// Returns `i:imm3:imm8` of a 32-bit instruction.
fn imm12(code: u32) -> u32 {
    field(code, 26, 1) << 11 | field(code, 12, 3) << 8 | field(code, 0, 8)
}

/// Returns the constant of `ThumbExpandImm_C` (A5.3.2), and `true` if the carry is set to its top
/// bit.
fn expand(imm12: u32) -> (u32, bool) {
    let byte = imm12 & 0xFF;
    match imm12 >> 8 {
        0b0000 => (byte, false),
        0b0001 => (byte << 16 | byte, false),
        0b0010 => (byte << 24 | byte << 8, false),
        0b0011 => (byte * 0x0101_0101, false),
        _ => ((0x80 | byte & 0x7F).rotate_right(imm12 >> 7), true),
    }
}

pub(super) fn modified_immediate(code: u32) -> Op {
    let (d, n, sets) = (reg(code, 8), reg(code, 16), sets(code));
    let (imm, rotated) = expand(imm12(code));
    match alu(field(code, 21, 4), d, n, code) {
        None => Op::Undefined,
        Some(Alu::Add) => Op::AddImm { d, n, sets, imm },
        Some(Alu::Sub) => Op::SubImm { d, n, sets, imm },
        Some(Alu::Cmp) => Op::CmpImm { n, imm },
        Some(Alu::Mov) => Op::MovImm { d, sets, rotated, imm },
        Some(alu) => Op::AluImm { alu, d, n, sets, rotated, imm },
    }
}

/// A5.3.3
pub(super) fn plain_immediate(address: u32, code: u32) -> Op {
    let (d, n, imm) = (reg(code, 8), reg(code, 16), imm12(code));
    let sets = Sets::Never;
    let lsb = (field(code, 12, 3) << 2 | field(code, 6, 2)) as u8;
    let low5 = field(code, 0, 5) as u8;
    let here = (address & !3).wrapping_add(4);
    match field(code, 20, 5) {
        0b00000 if n == 15 => Op::MovImm { d, sets, rotated: false, imm: here.wrapping_add(imm) },
        0b00000 => Op::AddImm { d, n, sets, imm },
        0b00100 => Op::MovImm { d, sets, rotated: false, imm: u32::from(n) << 12 | imm },
        0b01010 if n == 15 => Op::MovImm { d, sets, rotated: false, imm: here.wrapping_sub(imm) },
        0b01010 => Op::SubImm { d, n, sets, imm },
        0b01100 => Op::MovTop { d, imm: u16::from(n) << 12 | imm as u16 },
        kind @ (0b10000 | 0b10010 | 0b11000 | 0b11010) => {
            let signed = kind & 0b01000 == 0;
            let bits = low5 + u8::from(signed);
            match (kind & 0b00010 != 0, lsb) {
                (true, 0) => Op::Saturate16 { signed, d, n, bits: bits & 0x1F },
                (true, amount) => Op::Saturate { signed, d, n, bits, shift: Shift::Asr, amount },
                (false, amount) => Op::Saturate { signed, d, n, bits, shift: Shift::Lsl, amount },
            }
        }
        0b10100 => Op::Extract { signed: true, d, n, lsb, width: low5 + 1 },
        0b11100 => Op::Extract { signed: false, d, n, lsb, width: low5 + 1 },
        0b10110 if low5 >= lsb => Op::Insert { d, n, lsb, width: low5 - lsb + 1 },
        _ => Op::Undefined,
    }
}

/// A5.3.11
pub(super) fn shifted_register(code: u32) -> Op {
    let (d, n, m, sets) = (reg(code, 8), reg(code, 16), reg(code, 0), sets(code));
    let (shift, amount) = decode_shift(field(code, 4, 2), field(code, 12, 3) << 2 | field(code, 6, 2));
    if field(code, 21, 4) == 0b0110 {
        return Op::Pack { d, n, m, top: bit(code, 5), amount };
    }
    let plain = matches!(shift, Shift::Lsl) && amount == 0;
    match (alu(field(code, 21, 4), d, n, code), plain) {
        (None, _) => Op::Undefined,
        (Some(Alu::Mov), true) => Op::MovReg { d, m, sets },
        (Some(Alu::Mov), false) => Op::ShiftImm { d, m, sets, shift, amount },
        (Some(Alu::Add), true) => Op::AddReg { d, n, m, sets },
        (Some(Alu::Sub), true) => Op::SubReg { d, n, m, sets },
        (Some(Alu::Cmp), true) => Op::CmpReg { n, m },
        (Some(alu), true) => Op::AluReg { alu, d, n, m, sets },
        (Some(alu), false) => Op::AluShift { alu, d, n, m, sets, shift, amount },
    }
}

/// `DecodeImmShift` (A7.4.2)
fn decode_shift(kind: u32, amount: u32) -> (Shift, u8) {
    match (kind, amount) {
        (0b00, amount) => (Shift::Lsl, amount as u8),
        (0b01, 0) => (Shift::Lsr, 32),
        (0b01, amount) => (Shift::Lsr, amount as u8),
        (0b10, 0) => (Shift::Asr, 32),
        (0b10, amount) => (Shift::Asr, amount as u8),
        (_, 0) => (Shift::Rrx, 1),
        (_, amount) => (Shift::Ror, amount as u8),
    }
}

/// A5.3.12
pub(super) fn register(code: u32) -> Op {
    let (d, n, m) = (reg(code, 8), reg(code, 16), reg(code, 0));
    if field(code, 12, 4) != 0b1111 {
        return Op::Undefined;
    }
    let op1 = field(code, 20, 4);
    if op1 & 0b1000 == 0 {
        if field(code, 4, 4) == 0 {
            let shift = [Shift::Lsl, Shift::Lsr, Shift::Asr, Shift::Ror][field(code, 21, 2) as usize];
            return Op::ShiftReg { d, n, m, sets: sets(code), shift };
        }
        if !bit(code, 7) {
            return Op::Undefined;
        }
        let extend = match op1 {
            0b000 => Extend::SignedHalf,
            0b001 => Extend::Half,
            0b010 => Extend::SignedBytes,
            0b011 => Extend::Bytes,
            0b100 => Extend::SignedByte,
            0b101 => Extend::Byte,
            _ => return Op::Undefined,
        };
        return Op::Extend { extend, d, n, m, rotate: 8 * field(code, 4, 2) as u8 };
    }
    if !bit(code, 7) { parallel(code) } else { miscellaneous(code) }
}

/// A5.3.13, A5.3.14
fn parallel(code: u32) -> Op {
    let (d, n, m) = (reg(code, 8), reg(code, 16), reg(code, 0));
    let lanes = match field(code, 4, 3) {
        0b000 => Lanes::Signed,
        0b001 => Lanes::SignedSaturating,
        0b010 => Lanes::SignedHalving,
        0b100 => Lanes::Unsigned,
        0b101 => Lanes::UnsignedSaturating,
        0b110 => Lanes::UnsignedHalving,
        _ => return Op::Undefined,
    };
    let parallel = match field(code, 20, 3) {
        0b000 => Parallel::Add8,
        0b001 => Parallel::Add16,
        0b010 => Parallel::Asx,
        0b100 => Parallel::Sub8,
        0b101 => Parallel::Sub16,
        0b110 => Parallel::Sax,
        _ => return Op::Undefined,
    };
    Op::Parallel { lanes, parallel, d, n, m }
}

/// A5.3.15
fn miscellaneous(code: u32) -> Op {
    let (d, n, m) = (reg(code, 8), reg(code, 16), reg(code, 0));
    let bits = |bits| Op::Bits { bits, d, m };
    let low = field(code, 4, 2);
    match (field(code, 20, 3), low) {
        _ if bit(code, 6) => Op::Undefined,
        (0b000, _) => Op::SaturatingAdd { d, n, m, double: low & 1 == 1, subtract: low & 2 == 2 },
        (0b001, 0b00) => bits(Bits::Rev),
        (0b001, 0b01) => bits(Bits::Rev16),
        (0b001, 0b10) => bits(Bits::Rbit),
        (0b001, _) => bits(Bits::Revsh),
        (0b010, 0b00) => Op::Select { d, n, m },
        (0b011, 0b00) => bits(Bits::Clz),
        _ => Op::Undefined,
    }
}

/// A5.3.16
pub(super) fn multiply(code: u32) -> Op {
    let (d, n, m, a) = (reg(code, 8), reg(code, 16), reg(code, 0), reg(code, 12));
    let product = |product| Op::Product { product, d, n, m, a };
    let (high, low) = (bit(code, 5), bit(code, 4));
    match (field(code, 20, 3), field(code, 4, 2)) {
        _ if field(code, 6, 2) != 0 => Op::Undefined,
        (0b000, 0b00) if a == 15 => Op::Mul { d, n, m, sets: Sets::Never },
        (0b000, 0b00) => Op::Mla { d, n, m, a },
        (0b000, 0b01) => Op::Mls { d, n, m, a },
        (0b001, _) => product(Product::Half { top_n: high, top_m: low }),
        (0b010, 0b00 | 0b01) => product(Product::Dual { swap: low, subtract: false }),
        (0b011, 0b00 | 0b01) => product(Product::Wide { top_m: low }),
        (0b100, 0b00 | 0b01) => product(Product::Dual { swap: low, subtract: true }),
        (0b101, 0b00 | 0b01) => product(Product::Most { round: low, subtract: false }),
        (0b110, 0b00 | 0b01) => product(Product::Most { round: low, subtract: true }),
        (0b111, 0b00) => product(Product::Differences),
        _ => Op::Undefined,
    }
}

/// A5.3.17
pub(super) fn long_multiply(code: u32) -> Op {
    let (lo, hi, n, m) = (reg(code, 12), reg(code, 8), reg(code, 16), reg(code, 0));
    let long = |long| Op::Long { long, lo, hi, n, m };
    let low = field(code, 4, 4);
    match (field(code, 20, 3), low) {
        (0b000, 0b0000) => long(Long::Smull),
        (0b001, 0b1111) => Op::Divide { signed: true, d: hi, n, m },
        (0b010, 0b0000) => long(Long::Umull),
        (0b011, 0b1111) => Op::Divide { signed: false, d: hi, n, m },
        (0b100, 0b0000) => long(Long::Smlal),
        (0b100, 0b1000..=0b1011) => long(Long::SmlalHalf { top_n: low & 2 == 2, top_m: low & 1 == 1 }),
        (0b100, 0b1100 | 0b1101) => long(Long::Dual { swap: low & 1 == 1, subtract: false }),
        (0b101, 0b1100 | 0b1101) => long(Long::Dual { swap: low & 1 == 1, subtract: true }),
        (0b110, 0b0000) => long(Long::Umlal),
        (0b110, 0b0110) => long(Long::Umaal),
        _ => Op::Undefined,
    }
}
