//! Decoded instruction with the data that determines its cycles.

use super::Op;

/// Decoded instruction, stored next to its bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Decoded {
    pub(crate) op: Op,
    /// Length in bytes: 2 or 4, or 0 if nothing is decoded yet.
    pub(crate) len: u8,
    /// Cycles that do not depend on the operands.
    pub(crate) cycles: u8,
    /// Register that data processing computes, or none.
    pub(crate) computes: u8,
    /// The two registers of the address of a load or store, in four bits each; 15 for none.
    pub(crate) bases: u8,
}

impl Decoded {
    /// No register.
    pub(crate) const NONE: u8 = 0xFF;
    /// Mark of a branch: the next instruction is its target.
    pub(crate) const TARGET: u8 = 0xFE;
    /// Neither load nor store, or one relative to the PC.
    pub(crate) const NO_BASES: u8 = 0xFF;
    pub(crate) const NOTHING: Decoded =
        Decoded { op: Op::Undefined, len: 0, cycles: 0, computes: Decoded::NONE, bases: Decoded::NO_BASES };

    pub(crate) fn new(op: Op, len: u8) -> Decoded {
        Decoded { op, len, cycles: crate::cycles::base_cycles(&op), computes: op.computes(), bases: op.bases() }
    }
}

impl Op {
    fn computes(&self) -> u8 {
        match *self {
            Op::AddImm { d, .. } | Op::SubImm { d, .. } | Op::MovImm { d, .. } | Op::AddReg { d, .. } | Op::SubReg { d, .. } => d,
            Op::MovReg { d, .. } | Op::AluImm { d, .. } | Op::AluReg { d, .. } | Op::AluShift { d, .. } => d,
            Op::ShiftImm { d, .. } | Op::ShiftReg { d, .. } | Op::MovTop { d, .. } | Op::Bits { d, .. } => d,
            Op::Extend { d, .. } | Op::Extract { d, .. } | Op::Insert { d, .. } | Op::Saturate { d, .. } => d,
            Op::Saturate16 { d, .. } | Op::SaturatingAdd { d, .. } | Op::Pack { d, .. } | Op::Select { d, .. } => d,
            Op::Parallel { d, .. } | Op::Mul { d, .. } | Op::Mla { d, .. } | Op::Mls { d, .. } => d,
            Op::Product { d, .. } | Op::Divide { d, .. } => d,
            // One of two registers; an address from the other one misses its stall.
            Op::Long { lo, .. } => lo,
            _ => Decoded::NONE,
        }
    }

    fn bases(&self) -> u8 {
        let (n, m) = match *self {
            Op::LdrImm { n, .. } | Op::StrImm { n, .. } | Op::LoadImm { n, .. } | Op::StoreImm { n, .. } => (n, 15),
            Op::LoadReg { n, m, .. } | Op::StoreReg { n, m, .. } | Op::LoadPcReg { n, m, .. } | Op::TableBranch { n, m, .. } => {
                (n, m)
            }
            Op::LoadIndexed { n, .. } | Op::StoreIndexed { n, .. } | Op::LoadPc { n, .. } | Op::Unprivileged { n, .. } => (n, 15),
            Op::LoadDouble { n, .. } | Op::StoreDouble { n, .. } | Op::LoadMany { n, .. } | Op::StoreMany { n, .. } => (n, 15),
            Op::LoadExclusive { n, .. } | Op::StoreExclusive { n, .. } | Op::FloatLoad { n, .. } | Op::FloatStore { n, .. } => {
                (n, 15)
            }
            Op::FloatLoadMany { n, .. } | Op::FloatStoreMany { n, .. } => (n, 15),
            Op::Push { .. } | Op::Pop { .. } => (13, 15),
            _ => (15, 15),
        };
        n | m << 4
    }
}
