//! Decoder of 16-bit instructions (A5.2).

use super::{bit, field, sign_extend};
use crate::op::{Alu, Bits, Extend, Op, Sets, Shift, Size};

/// Returns a register number of three bits.
fn low(code: u32, at: u32) -> u8 {
    field(code, at, 3) as u8
}

pub(super) fn decode(address: u32, code: u32) -> Op {
    match field(code, 12, 4) {
        0b0000 | 0b0001 => shift_add(code),
        0b0010 | 0b0011 => immediate(code),
        0b0100 if !bit(code, 11) => match bit(code, 10) {
            false => data_processing(code),
            true => high_registers(code),
        },
        0b0100 => load_word(address, low(code, 8), field(code, 0, 8)),
        0b0101 => register_offset(code),
        0b0110 => word_immediate(bit(code, 11), low(code, 0), low(code, 3), field(code, 6, 5)),
        0b0111 => sized(bit(code, 11), Size::Byte, code, 0),
        0b1000 => sized(bit(code, 11), Size::Half, code, 1),
        0b1001 => word_immediate(bit(code, 11), low(code, 8), 13, field(code, 0, 8)),
        0b1010 if bit(code, 11) => Op::AddImm { d: low(code, 8), n: 13, sets: Sets::Never, imm: field(code, 0, 8) << 2 },
        0b1010 => mov((address & !3).wrapping_add(4 + (field(code, 0, 8) << 2)), low(code, 8)),
        0b1011 => miscellaneous(address, code),
        0b1100 => {
            let (n, list) = (low(code, 8), field(code, 0, 8) as u16);
            match bit(code, 11) {
                _ if list == 0 => Op::Undefined,
                true => Op::LoadMany { n, list, before: false, back: list >> n & 1 == 0 },
                false => Op::StoreMany { n, list, before: false, back: true },
            }
        }
        0b1101 => match field(code, 8, 4) {
            0b1110 => Op::Undefined,
            0b1111 => Op::Supervisor,
            condition => {
                let offset = sign_extend(field(code, 0, 8), 8) << 1;
                Op::BranchIf { condition: condition as u8, target: target(address, offset) }
            }
        },
        // The other codes are 32-bit instructions.
        _ => Op::Branch { target: target(address, sign_extend(field(code, 0, 11), 11) << 1) },
    }
}

fn target(address: u32, offset: u32) -> u32 {
    address.wrapping_add(4).wrapping_add(offset)
}

/// Returns a move of a constant to a register that leaves the flags unchanged.
fn mov(imm: u32, d: u8) -> Op {
    Op::MovImm { d, sets: Sets::Never, rotated: false, imm }
}

/// `LDR Rt, [PC, #offset]`
fn load_word(address: u32, t: u8, words: u32) -> Op {
    Op::LoadLiteral { size: Size::Word, t, address: (address & !3).wrapping_add(4 + (words << 2)) }
}

fn word_immediate(load: bool, t: u8, n: u8, words: u32) -> Op {
    let offset = (words << 2) as i16;
    if load { Op::LdrImm { t, n, offset } } else { Op::StrImm { t, n, offset } }
}

fn sized(load: bool, size: Size, code: u32, scale: u32) -> Op {
    let (t, n, offset) = (low(code, 0), low(code, 3), (field(code, 6, 5) << scale) as i16);
    if load { Op::LoadImm { size, t, n, offset } } else { Op::StoreImm { size, t, n, offset } }
}

fn shift_add(code: u32) -> Op {
    let (d, n, m) = (low(code, 0), low(code, 3), low(code, 6));
    let sets = Sets::OutsideIt;
    let amount = field(code, 6, 5) as u8;
    match field(code, 9, 5) {
        0b01100 => Op::AddReg { d, n, m, sets },
        0b01101 => Op::SubReg { d, n, m, sets },
        0b01110 => Op::AddImm { d, n, sets, imm: u32::from(m) },
        0b01111 => Op::SubImm { d, n, sets, imm: u32::from(m) },
        kind => match kind >> 2 {
            0b000 if amount == 0 => Op::MovReg { d, m: n, sets },
            0b000 => Op::ShiftImm { d, m: n, sets, shift: Shift::Lsl, amount },
            0b001 => Op::ShiftImm { d, m: n, sets, shift: Shift::Lsr, amount: if amount == 0 { 32 } else { amount } },
            _ => Op::ShiftImm { d, m: n, sets, shift: Shift::Asr, amount: if amount == 0 { 32 } else { amount } },
        },
    }
}

fn immediate(code: u32) -> Op {
    let (d, imm, sets) = (low(code, 8), field(code, 0, 8), Sets::OutsideIt);
    match field(code, 11, 2) {
        0b00 => Op::MovImm { d, sets, rotated: false, imm },
        0b01 => Op::CmpImm { n: d, imm },
        0b10 => Op::AddImm { d, n: d, sets, imm },
        _ => Op::SubImm { d, n: d, sets, imm },
    }
}

/// A5.2.2
fn data_processing(code: u32) -> Op {
    let (d, m, sets) = (low(code, 0), low(code, 3), Sets::OutsideIt);
    let alu = |alu| Op::AluReg { alu, d, n: d, m, sets };
    let shift = |shift| Op::ShiftReg { d, n: d, m, sets, shift };
    match field(code, 6, 4) {
        0b0000 => alu(Alu::And),
        0b0001 => alu(Alu::Eor),
        0b0010 => shift(Shift::Lsl),
        0b0011 => shift(Shift::Lsr),
        0b0100 => shift(Shift::Asr),
        0b0101 => alu(Alu::Adc),
        0b0110 => alu(Alu::Sbc),
        0b0111 => shift(Shift::Ror),
        0b1000 => Op::AluReg { alu: Alu::Tst, d, n: d, m, sets: Sets::Always },
        0b1001 => Op::AluImm { alu: Alu::Rsb, d, n: m, sets, rotated: false, imm: 0 },
        0b1010 => Op::CmpReg { n: d, m },
        0b1011 => Op::AluReg { alu: Alu::Cmn, d, n: d, m, sets: Sets::Always },
        0b1100 => alu(Alu::Orr),
        0b1101 => Op::Mul { d, n: m, m: d, sets },
        0b1110 => alu(Alu::Bic),
        _ => alu(Alu::Mvn),
    }
}

/// A5.2.3
fn high_registers(code: u32) -> Op {
    let d = (field(code, 7, 1) << 3 | field(code, 0, 3)) as u8;
    let m = field(code, 3, 4) as u8;
    match field(code, 8, 2) {
        0b00 if d == 15 => Op::AddPc { m },
        0b00 => Op::AddReg { d, n: d, m, sets: Sets::Never },
        0b01 => Op::CmpReg { n: d, m },
        0b10 if d == 15 => Op::MovPc { m },
        0b10 => Op::MovReg { d, m, sets: Sets::Never },
        _ if bit(code, 7) => Op::BranchLinkExchange { m },
        _ => Op::BranchExchange { m },
    }
}

/// A5.2.4, register offsets
fn register_offset(code: u32) -> Op {
    let (t, n, m, shift) = (low(code, 0), low(code, 3), low(code, 6), 0);
    let load = |size| Op::LoadReg { size, t, n, m, shift };
    let store = |size| Op::StoreReg { size, t, n, m, shift };
    match field(code, 9, 3) {
        0b000 => store(Size::Word),
        0b001 => store(Size::Half),
        0b010 => store(Size::Byte),
        0b011 => load(Size::SignedByte),
        0b100 => load(Size::Word),
        0b101 => load(Size::Half),
        0b110 => load(Size::Byte),
        _ => load(Size::SignedHalf),
    }
}

/// A5.2.5
fn miscellaneous(address: u32, code: u32) -> Op {
    let (d, m) = (low(code, 0), low(code, 3));
    let extend = |extend| Op::Extend { extend, d, n: 15, m, rotate: 0 };
    let bits = |bits| Op::Bits { bits, d, m };
    match field(code, 8, 4) {
        0b0000 => {
            let imm = field(code, 0, 7) << 2;
            match bit(code, 7) {
                false => Op::AddImm { d: 13, n: 13, sets: Sets::Never, imm },
                true => Op::SubImm { d: 13, n: 13, sets: Sets::Never, imm },
            }
        }
        0b0001 | 0b0011 | 0b1001 | 0b1011 => {
            let offset = field(code, 9, 1) << 6 | field(code, 3, 5) << 1;
            Op::BranchZero { n: d, nonzero: bit(code, 11), target: target(address, offset) }
        }
        0b0010 => match field(code, 6, 2) {
            0b00 => extend(Extend::SignedHalf),
            0b01 => extend(Extend::SignedByte),
            0b10 => extend(Extend::Half),
            _ => extend(Extend::Byte),
        },
        0b0100 | 0b0101 => push_pop(code, Op::Push { list: field(code, 0, 8) as u16 | (field(code, 8, 1) << 14) as u16 }),
        0b0110 if field(code, 5, 3) == 0b011 => {
            Op::ChangeState { disable: bit(code, 4), primask: bit(code, 1), faultmask: bit(code, 0) }
        }
        0b1010 => match field(code, 6, 2) {
            0b00 => bits(Bits::Rev),
            0b01 => bits(Bits::Rev16),
            0b11 => bits(Bits::Revsh),
            _ => Op::Undefined,
        },
        0b1100 | 0b1101 => push_pop(code, Op::Pop { list: field(code, 0, 8) as u16 | (field(code, 8, 1) << 15) as u16 }),
        0b1110 => Op::Breakpoint { number: field(code, 0, 8) as u8 },
        0b1111 if field(code, 0, 4) != 0 => Op::It { state: field(code, 0, 8) as u8 },
        0b1111 => super::branch::hint(field(code, 4, 4)),
        _ => Op::Undefined,
    }
}

/// Returns `op`, or undefined for an empty list, which is unpredictable in the manual.
fn push_pop(code: u32, op: Op) -> Op {
    if field(code, 0, 9) == 0 { Op::Undefined } else { op }
}
