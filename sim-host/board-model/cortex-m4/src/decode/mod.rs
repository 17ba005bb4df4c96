//! Decoder from halfwords to [`Op`], after ARM DDI 0403 (ARMv7-M), chapter A5.

mod branch;
mod data;
mod float;
mod load_store;
mod thumb16;

use crate::op::{Decoded, Op};

/// Returns `true` if a first halfword belongs to a 32-bit instruction (A5.1).
pub(crate) fn is_wide(first: u16) -> bool {
    first >= 0xE800
}

/// Decodes the instruction at `address`. The second halfword is used only by 32-bit instructions.
pub(crate) fn decode(address: u32, first: u16, second: u16) -> Decoded {
    let (op, len) = if is_wide(first) {
        (wide(address, u32::from(first) << 16 | u32::from(second)), 4)
    } else {
        (thumb16::decode(address, u32::from(first)), 2)
    };
    Decoded::new(op, len)
}

/// Decodes a 32-bit instruction (A5.3, table A5-9).
fn wide(address: u32, code: u32) -> Op {
    match field(code, 27, 2) {
        0b01 => match field(code, 25, 2) {
            0b00 if bit(code, 22) => load_store::dual_or_exclusive(address, code),
            0b00 => load_store::multiple(code),
            0b01 => data::shifted_register(code),
            _ => float::decode(code),
        },
        0b10 => {
            if bit(code, 15) {
                branch::decode(address, code)
            } else if bit(code, 25) {
                data::plain_immediate(address, code)
            } else {
                data::modified_immediate(code)
            }
        }
        _ => match field(code, 24, 3) {
            0b000 if !bit(code, 20) => load_store::store_single(code),
            0b000 | 0b001 if bit(code, 20) => load_store::load_single(address, code),
            0b001 => Op::Undefined,
            0b010 => data::register(code),
            0b011 if bit(code, 23) => data::long_multiply(code),
            0b011 => data::multiply(code),
            _ => float::decode(code),
        },
    }
}

fn field(code: u32, low: u32, width: u32) -> u32 {
    code >> low & ((1 << width) - 1)
}

fn bit(code: u32, at: u32) -> bool {
    code >> at & 1 == 1
}

/// Returns a register number of four bits.
fn reg(code: u32, low: u32) -> u8 {
    field(code, low, 4) as u8
}

/// Sign-extends the lowest `bits` of `value`.
fn sign_extend(value: u32, bits: u32) -> u32 {
    let above = 32 - bits;
    ((value << above) as i32 >> above) as u32
}
