//! Decoder of 32-bit loads and stores (A5.3.5 to A5.3.10).

use super::{bit, field, reg};
use crate::op::{Index, Op, Size};

/// Decodes load and store multiple (A5.3.5).
pub(super) fn multiple(code: u32) -> Op {
    let (n, list, back) = (reg(code, 16), field(code, 0, 16) as u16, bit(code, 21));
    let before = match field(code, 23, 2) {
        0b01 => false,
        0b10 => true,
        _ => return Op::Undefined,
    };
    match bit(code, 20) {
        _ if list.count_ones() < 2 || n == 15 => Op::Undefined,
        true => Op::LoadMany { n, list, before, back },
        false if list >> 15 == 1 => Op::Undefined,
        false => Op::StoreMany { n, list, before, back },
    }
}

fn index(code: u32) -> Index {
    match (bit(code, 24), bit(code, 21)) {
        (true, false) => Index::Offset,
        (true, true) => Index::Before,
        (false, _) => Index::After,
    }
}

/// Decodes loads and stores of two words, exclusive accesses and table branches (A5.3.6).
pub(super) fn dual_or_exclusive(address: u32, code: u32) -> Op {
    let (n, t, t2) = (reg(code, 16), reg(code, 12), reg(code, 8));
    let load = bit(code, 20);
    if bit(code, 24) || bit(code, 21) {
        let offset = (field(code, 0, 8) << 2) as i16;
        let offset = if bit(code, 23) { offset } else { -offset };
        return match (load, n) {
            (true, 15) => {
                Op::LoadDoubleLiteral { t, t2, address: (address & !3).wrapping_add(4).wrapping_add_signed(offset.into()) }
            }
            (true, _) => Op::LoadDouble { t, t2, n, index: index(code), offset },
            (false, _) => Op::StoreDouble { t, t2, n, index: index(code), offset },
        };
    }
    let offset = (field(code, 0, 8) << 2) as u16;
    let size = match field(code, 4, 4) {
        0b0100 => Size::Byte,
        0b0101 => Size::Half,
        _ => Size::Word,
    };
    match (bit(code, 23), load, field(code, 4, 4)) {
        (false, true, _) => Op::LoadExclusive { size: Size::Word, t, n, offset },
        (false, false, _) => Op::StoreExclusive { size: Size::Word, d: t2, t, n, offset },
        (true, true, half @ (0b0000 | 0b0001)) => Op::TableBranch { n, m: reg(code, 0), half: half == 1 },
        (true, true, 0b0100 | 0b0101) => Op::LoadExclusive { size, t, n, offset: 0 },
        (true, false, 0b0100 | 0b0101) => Op::StoreExclusive { size, d: reg(code, 0), t, n, offset: 0 },
        _ => Op::Undefined,
    }
}

/// Returns the signed offset of the forms with eight bits.
fn imm8(code: u32) -> i16 {
    let offset = field(code, 0, 8) as i16;
    if bit(code, 9) { offset } else { -offset }
}

/// A5.3.10
pub(super) fn store_single(code: u32) -> Op {
    let (n, t, m) = (reg(code, 16), reg(code, 12), reg(code, 0));
    let size = match field(code, 21, 2) {
        0b00 => Size::Byte,
        0b01 => Size::Half,
        0b10 => Size::Word,
        _ => return Op::Undefined,
    };
    if n == 15 || bit(code, 24) {
        return Op::Undefined;
    }
    let plain = |offset| match size {
        Size::Word => Op::StrImm { t, n, offset },
        _ => Op::StoreImm { size, t, n, offset },
    };
    if bit(code, 23) {
        return plain(field(code, 0, 12) as i16);
    }
    match (bit(code, 11), field(code, 8, 3)) {
        (false, _) if field(code, 6, 5) == 0 => Op::StoreReg { size, t, n, m, shift: field(code, 4, 2) as u8 },
        (true, 0b100) => plain(imm8(code)),
        (true, 0b110) => Op::Unprivileged { load: false, size, t, n, offset: field(code, 0, 8) as u8 },
        (true, 0b101 | 0b111) => Op::StoreIndexed { size, t, n, after: false, offset: imm8(code) },
        (true, 0b001 | 0b011) => Op::StoreIndexed { size, t, n, after: true, offset: imm8(code) },
        _ => Op::Undefined,
    }
}

/// A5.3.7 to A5.3.9
pub(super) fn load_single(address: u32, code: u32) -> Op {
    let (n, t, m) = (reg(code, 16), reg(code, 12), reg(code, 0));
    let size = match (field(code, 21, 2), bit(code, 24)) {
        (0b00, false) => Size::Byte,
        (0b00, true) => Size::SignedByte,
        (0b01, false) => Size::Half,
        (0b01, true) => Size::SignedHalf,
        (0b10, false) => Size::Word,
        _ => return Op::Undefined,
    };
    // A byte or halfword into register 15 is a preload hint, or an unallocated hint.
    let hint = t == 15 && size != Size::Word;
    if n == 15 {
        let offset = field(code, 0, 12);
        let base = (address & !3).wrapping_add(4);
        let address = if bit(code, 23) { base.wrapping_add(offset) } else { base.wrapping_sub(offset) };
        return match t {
            15 if hint => Op::Nop,
            15 => Op::LoadPcLiteral { address },
            _ => Op::LoadLiteral { size, t, address },
        };
    }
    let plain = |offset| match (size, t) {
        _ if hint => Op::Nop,
        (Size::Word, 15) => Op::LoadPc { n, index: Index::Offset, offset },
        (Size::Word, _) => Op::LdrImm { t, n, offset },
        _ => Op::LoadImm { size, t, n, offset },
    };
    if bit(code, 23) {
        return plain(field(code, 0, 12) as i16);
    }
    let shift = field(code, 4, 2) as u8;
    match (bit(code, 11), field(code, 8, 3)) {
        (false, _) if field(code, 6, 5) == 0 => match t {
            15 if hint => Op::Nop,
            15 => Op::LoadPcReg { n, m, shift },
            _ => Op::LoadReg { size, t, n, m, shift },
        },
        (true, 0b100) => plain(imm8(code)),
        (true, 0b110) => Op::Unprivileged { load: true, size, t, n, offset: field(code, 0, 8) as u8 },
        (true, 0b001 | 0b011 | 0b101 | 0b111) if hint => Op::Undefined,
        (true, kind @ (0b001 | 0b011 | 0b101 | 0b111)) => {
            let after = kind & 0b100 == 0;
            match t {
                15 => Op::LoadPc { n, index: if after { Index::After } else { Index::Before }, offset: imm8(code) },
                _ => Op::LoadIndexed { size, t, n, after, offset: imm8(code) },
            }
        }
        _ => Op::Undefined,
    }
}
