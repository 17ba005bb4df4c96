//! Decoder of 32-bit branches and control instructions (A5.3.4, A5.3.5), and of hints.

use super::{bit, field, reg, sign_extend};
use crate::op::Op;

pub(super) fn decode(address: u32, code: u32) -> Op {
    let from = address.wrapping_add(4);
    let sign = field(code, 26, 1);
    let (j1, j2) = (field(code, 13, 1), field(code, 11, 1));
    match (bit(code, 14), bit(code, 12)) {
        (false, false) if field(code, 23, 3) != 0b111 => {
            let offset = sign << 20 | j2 << 19 | j1 << 18 | field(code, 16, 6) << 12 | field(code, 0, 11) << 1;
            Op::BranchIf { condition: field(code, 22, 4) as u8, target: from.wrapping_add(sign_extend(offset, 21)) }
        }
        (false, false) => control(code),
        (link, true) => {
            let (i1, i2) = (1 ^ j1 ^ sign, 1 ^ j2 ^ sign);
            let offset = sign << 24 | i1 << 23 | i2 << 22 | field(code, 16, 10) << 12 | field(code, 0, 11) << 1;
            let target = from.wrapping_add(sign_extend(offset, 25));
            if link { Op::BranchLink { target } } else { Op::Branch { target } }
        }
        (true, false) => Op::Undefined,
    }
}

fn control(code: u32) -> Op {
    match field(code, 20, 7) {
        0b011_1000 | 0b011_1001 => {
            Op::WriteSpecial { n: reg(code, 16), special: field(code, 0, 8) as u8, mask: field(code, 10, 2) as u8 }
        }
        0b011_1010 if field(code, 8, 3) == 0 => hint(field(code, 0, 8)),
        0b011_1011 => match field(code, 4, 4) {
            0b0010 => Op::ClearExclusive,
            0b0100..=0b0110 => Op::Barrier,
            _ => Op::Undefined,
        },
        0b011_1110 | 0b011_1111 => Op::ReadSpecial { d: reg(code, 8), special: field(code, 0, 8) as u8 },
        _ => Op::Undefined,
    }
}

/// Decodes a hint of 16 or 32 bits. Unallocated hints do nothing.
pub(super) fn hint(number: u32) -> Op {
    match number {
        2 => Op::WaitEvent,
        3 => Op::WaitInterrupt,
        4 => Op::SendEvent,
        _ => Op::Nop,
    }
}
