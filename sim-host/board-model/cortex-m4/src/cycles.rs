//! Cycles of each instruction, after ARM DDI 0439 (Cortex-M4 technical reference manual), section
//! 3.3 and table 7-1. Where these give a range, [`Timing`] selects one end of it.
//!
//! | instruction | cycles |
//! |---|---|
//! | data processing, DSP, bit fields, `MUL`, `MLA`, `SMLAxy`, `SMLAD`, `SMULL`, `SMMLA` … | 1 |
//! | `SDIV`, `UDIV` | 12 (2 to 12; the dependence on the quotient is not published) |
//! | `LDR` of any size, register or immediate offset | 2; 1 right after another load whose result is not its address |
//! | any access whose address the previous instruction has computed | 1 more |
//! | `STR` with immediate offset; with register offset | 1; 2, or 1 right after a load |
//! | `LDRD`, `STRD`, `LDM`, `STM`, `PUSH`, `POP` | 1 + N words |
//! | unaligned access | 1 more for a halfword, 2 more for a word |
//! | a taken branch, any write to the PC | plus the refill, see [`timing`](crate::timing) |
//! | `TBB`, `TBH` | 3, and the refill |
//! | `MRS`, `MSR`, `CPS`, barriers; `LDREX`, `STREX` | 2 |
//! | `IT` | 1, as if never folded |
//! | `VADD`, `VMUL`, `VCVT`, `VCMP`, `VMOV`, `VMRS` … | 1 |
//! | result of floating-point arithmetic used by the very next instruction | 1 more |
//! | `VMOV` of two registers | 2 |
//! | `VMLA`, `VFMA` and similar | 3 |
//! | `VDIV`, `VSQRT` | 14 |
//! | `VLDR`, `VSTR` | 2, with a double word 3 |
//! | `VLDM`, `VSTM` | 1 + N words |
//! | interrupt entry; with floating-point registers stored at once | [`ENTRY`]; + [`FLOAT_FRAME`] |
//! | interrupt return | [`RETURN`]; + [`FLOAT_FRAME`] if they are loaded |
//! | lazy store of the floating-point registers | [`FLOAT_FRAME`] |
//! | tail-chained entry | [`TAIL_CHAIN`] |
//!
//! The chip adds the wait states of a fetch that enters a new aligned group of 8 bytes, of a load,
//! and of a register access. With [`Timing::Longest`] it also adds the maximum delay by DMA on the
//! buses.
//!
//! Not modelled: contention of fetches with loads from the same memory, and stalls of the write
//! buffer (a `STR` that finds it full; every store to a register with wait states is counted as
//! one). Not modelled either, which counts too many cycles: `VDIV` in parallel with integer
//! instructions, `IT` folded into the previous instruction, abandoned `LDM`, and late arrival.
//!
//! # Compared with measurements
//!
//! The example `benchmarks` of `sonoglide-stm32g474` runs Embench, CoreMark and Dhrystone on the
//! model. Embench publishes the cycles of its programs on an STM32F407 without wait states.
//! `docs/board.md` contains the comparison.

#[cfg(doc)]
use crate::Timing;
use crate::op::{Float1, Float2, Op};

/// Cycles of exception entry, from memory without wait states.
pub const ENTRY: u32 = 12;
/// Cycles of the return from an exception (10 to 12).
pub const RETURN: u32 = 12;
/// Cycles of an entry that directly follows a return.
pub const TAIL_CHAIN: u32 = 6;
/// Cycles to store or load S0 to S15 and FPSCR.
pub const FLOAT_FRAME: u32 = 17;

/// Returns the cycles of `op` without effects of operands: branch taken, quotient, alignment, and
/// pipelining of loads.
pub(crate) fn base_cycles(op: &Op) -> u8 {
    match op {
        Op::Divide { .. } => 12,
        Op::LoadPc { .. } | Op::LoadPcReg { .. } | Op::LoadPcLiteral { .. } => 2, // plus the refill
        Op::LdrImm { .. } | Op::LoadImm { .. } | Op::LoadReg { .. } | Op::LoadIndexed { .. } => 2,
        Op::LoadLiteral { .. } => 2,
        Op::StoreReg { .. } => 2,
        Op::Unprivileged { load: true, .. } => 2,
        Op::LoadDouble { .. } | Op::StoreDouble { .. } | Op::LoadDoubleLiteral { .. } => 3,
        Op::LoadMany { list, .. } | Op::StoreMany { list, .. } | Op::Push { list } | Op::Pop { list } => {
            1 + list.count_ones() as u8
        }
        Op::LoadExclusive { .. } | Op::StoreExclusive { .. } => 2,
        Op::TableBranch { .. } => 3,
        Op::Barrier | Op::ChangeState { .. } | Op::ReadSpecial { .. } | Op::WriteSpecial { .. } => 2,
        Op::Float2 { float: Float2::Div, .. } | Op::Float1 { float: Float1::Sqrt, .. } => 14,
        Op::Float2 { float: Float2::Sub | Float2::Nmul, .. } => 1,
        Op::Float2 { .. } => 3,
        Op::FloatLoad { double, .. } | Op::FloatStore { double, .. } => 2 + u8::from(*double),
        Op::FloatLoadMany { count, .. } | Op::FloatStoreMany { count, .. } => 1 + count,
        Op::ToFloats { .. } | Op::FromFloats { .. } => 2,
        _ => 1,
    }
}
