//! Decoded instructions.

mod choices;
mod decoded;

pub(crate) use choices::*;
pub(crate) use decoded::Decoded;

/// Instruction. Register fields are register numbers; addresses are absolute.
// One variant per line.
#[rustfmt::skip]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Op {
    /// Encoding that ARMv7E-M leaves undefined, including `UDF`.
    Undefined,
    /// Instruction of a missing coprocessor, or of the FPU in double precision.
    NoCoprocessor,
    AddImm { d: u8, n: u8, sets: Sets, imm: u32 },
    SubImm { d: u8, n: u8, sets: Sets, imm: u32 },
    CmpImm { n: u8, imm: u32 },
    /// `MOV Rd, #imm`; the carry comes from the expansion of the immediate if it is rotated.
    MovImm { d: u8, sets: Sets, rotated: bool, imm: u32 },
    AddReg { d: u8, n: u8, m: u8, sets: Sets },
    SubReg { d: u8, n: u8, m: u8, sets: Sets },
    CmpReg { n: u8, m: u8 },
    MovReg { d: u8, m: u8, sets: Sets },
    AluImm { alu: Alu, d: u8, n: u8, sets: Sets, rotated: bool, imm: u32 },
    AluReg { alu: Alu, d: u8, n: u8, m: u8, sets: Sets },
    AluShift { alu: Alu, d: u8, n: u8, m: u8, sets: Sets, shift: Shift, amount: u8 },
    ShiftImm { d: u8, m: u8, sets: Sets, shift: Shift, amount: u8 },
    ShiftReg { d: u8, n: u8, m: u8, sets: Sets, shift: Shift },
    MovTop { d: u8, imm: u16 },
    /// `MOV PC, Rm`
    MovPc { m: u8 },
    /// `ADD PC, Rm`
    AddPc { m: u8 },
    Bits { bits: Bits, d: u8, m: u8 },
    Extend { extend: Extend, d: u8, n: u8, m: u8, rotate: u8 },
    /// `UBFX`, `SBFX`
    Extract { signed: bool, d: u8, n: u8, lsb: u8, width: u8 },
    /// `BFI`; `BFC` with register 15
    Insert { d: u8, n: u8, lsb: u8, width: u8 },
    Saturate { signed: bool, d: u8, n: u8, bits: u8, shift: Shift, amount: u8 },
    Saturate16 { signed: bool, d: u8, n: u8, bits: u8 },
    /// `QADD`, `QSUB`, `QDADD`, `QDSUB`
    SaturatingAdd { d: u8, n: u8, m: u8, double: bool, subtract: bool },
    Pack { d: u8, n: u8, m: u8, top: bool, amount: u8 },
    Select { d: u8, n: u8, m: u8 },
    Parallel { lanes: Lanes, parallel: Parallel, d: u8, n: u8, m: u8 },
    Mul { d: u8, n: u8, m: u8, sets: Sets },
    Mla { d: u8, n: u8, m: u8, a: u8 },
    Mls { d: u8, n: u8, m: u8, a: u8 },
    Product { product: Product, d: u8, n: u8, m: u8, a: u8 },
    Long { long: Long, lo: u8, hi: u8, n: u8, m: u8 },
    Divide { signed: bool, d: u8, n: u8, m: u8 },

    LdrImm { t: u8, n: u8, offset: i16 },
    StrImm { t: u8, n: u8, offset: i16 },
    LoadImm { size: Size, t: u8, n: u8, offset: i16 },
    StoreImm { size: Size, t: u8, n: u8, offset: i16 },
    LoadReg { size: Size, t: u8, n: u8, m: u8, shift: u8 },
    StoreReg { size: Size, t: u8, n: u8, m: u8, shift: u8 },
    /// Load from an address relative to the instruction.
    LoadLiteral { size: Size, t: u8, address: u32 },
    LoadIndexed { size: Size, t: u8, n: u8, after: bool, offset: i16 },
    StoreIndexed { size: Size, t: u8, n: u8, after: bool, offset: i16 },
    /// `LDR PC, …`, all forms but the one relative to the PC.
    LoadPc { n: u8, index: Index, offset: i16 },
    LoadPcReg { n: u8, m: u8, shift: u8 },
    LoadPcLiteral { address: u32 },
    /// Unprivileged forms, `LDRT`, `STRT` ….
    Unprivileged { load: bool, size: Size, t: u8, n: u8, offset: u8 },
    LoadDouble { t: u8, t2: u8, n: u8, index: Index, offset: i16 },
    StoreDouble { t: u8, t2: u8, n: u8, index: Index, offset: i16 },
    LoadDoubleLiteral { t: u8, t2: u8, address: u32 },
    LoadMany { n: u8, list: u16, before: bool, back: bool },
    StoreMany { n: u8, list: u16, before: bool, back: bool },
    Push { list: u16 },
    Pop { list: u16 },
    LoadExclusive { size: Size, t: u8, n: u8, offset: u16 },
    StoreExclusive { size: Size, d: u8, t: u8, n: u8, offset: u16 },
    ClearExclusive,

    Branch { target: u32 },
    BranchIf { condition: u8, target: u32 },
    BranchLink { target: u32 },
    BranchExchange { m: u8 },
    BranchLinkExchange { m: u8 },
    /// `CBZ`, `CBNZ`
    BranchZero { n: u8, nonzero: bool, target: u32 },
    TableBranch { n: u8, m: u8, half: bool },
    It { state: u8 },

    /// `NOP`, `YIELD`, preload and debug hints.
    Nop,
    WaitInterrupt,
    WaitEvent,
    SendEvent,
    /// `DMB`, `DSB`, `ISB`
    Barrier,
    Supervisor,
    Breakpoint { number: u8 },
    /// `CPSIE`, `CPSID`
    ChangeState { disable: bool, primask: bool, faultmask: bool },
    ReadSpecial { d: u8, special: u8 },
    WriteSpecial { n: u8, special: u8, mask: u8 },

    FloatAdd { d: u8, n: u8, m: u8 },
    FloatMul { d: u8, n: u8, m: u8 },
    Float2 { float: Float2, d: u8, n: u8, m: u8 },
    Float1 { float: Float1, d: u8, m: u8 },
    /// `VMOV.F32 Sd, #imm`
    FloatImm { d: u8, bits: u32 },
    /// `VCMP`, `VCMPE`; register 255 for zero
    FloatCompare { d: u8, m: u8, signal: bool },
    FloatLoad { d: u8, n: u8, double: bool, offset: i16 },
    FloatStore { d: u8, n: u8, double: bool, offset: i16 },
    FloatLoadMany { n: u8, first: u8, count: u8, before: bool, back: bool },
    FloatStoreMany { n: u8, first: u8, count: u8, before: bool, back: bool },
    /// `VMOV Sn, Rt` and `VMOV Dd[x], Rt`
    ToFloat { s: u8, t: u8 },
    FromFloat { s: u8, t: u8 },
    /// `VMOV Sm, Sm1, Rt, Rt2` and `VMOV Dm, Rt, Rt2`
    ToFloats { s: u8, t: u8, t2: u8 },
    FromFloats { s: u8, t: u8, t2: u8 },
    /// `VMRS`; register 15 selects the flags.
    ReadFpscr { t: u8 },
    WriteFpscr { t: u8 },
}
