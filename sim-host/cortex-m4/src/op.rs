//! Instructions, decoded once.

/// When an instruction of data processing sets the flags.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sets {
    Never,
    Always,
    /// The 16-bit forms: only outside of an IT block.
    OutsideIt,
}

/// What an instruction of data processing computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Alu {
    And,
    Bic,
    Orr,
    Orn,
    Eor,
    Add,
    Adc,
    Sbc,
    Sub,
    Rsb,
    Mov,
    Mvn,
    Tst,
    Teq,
    Cmp,
    Cmn,
}

/// How an operand is shifted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shift {
    Lsl,
    Lsr,
    Asr,
    Ror,
    Rrx,
}

/// What a load or store moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Size {
    Word,
    Half,
    Byte,
    SignedHalf,
    SignedByte,
}

/// Single-operand operations on the bits of a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bits {
    Rev,
    Rev16,
    Revsh,
    Rbit,
    Clz,
}

/// Extensions of a byte or halfword, with rotation, optionally accumulating.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Extend {
    SignedByte,
    SignedHalf,
    SignedBytes,
    Byte,
    Half,
    Bytes,
}

/// What a parallel addition or subtraction does with each lane's result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lanes {
    Signed,
    SignedSaturating,
    SignedHalving,
    Unsigned,
    UnsignedSaturating,
    UnsignedHalving,
}

/// Which lanes a parallel addition or subtraction adds and subtracts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Parallel {
    Add16,
    Asx,
    Sax,
    Sub16,
    Add8,
    Sub8,
}

/// Products of 64 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Long {
    Smull,
    Umull,
    Smlal,
    Umlal,
    Umaal,
    /// `SMLALBB` … `SMLALTT`: top halves of the first and second operand.
    SmlalHalf {
        top_n: bool,
        top_m: bool,
    },
    /// `SMLALD(X)`, `SMLSLD(X)`.
    Dual {
        swap: bool,
        subtract: bool,
    },
}

/// Products of 32 bits, with an accumulator where its register is not 15.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Product {
    /// `SMULBB` … `SMLATT`.
    Half { top_n: bool, top_m: bool },
    /// `SMULWB`, `SMLAWT` ….
    Wide { top_m: bool },
    /// `SMUAD(X)`, `SMLAD(X)`, `SMUSD(X)`, `SMLSD(X)`.
    Dual { swap: bool, subtract: bool },
    /// `SMMUL(R)`, `SMMLA(R)`, `SMMLS(R)`.
    Most { round: bool, subtract: bool },
    /// `USAD8`, `USADA8`.
    Differences,
}

/// Floating-point operations of two operands and a destination, but for the sum and the product.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Float2 {
    Sub,
    Nmul,
    Div,
    Mla,
    Mls,
    Nmla,
    Nmls,
    Fma,
    Fms,
    Fnma,
    Fnms,
}

/// Floating-point operations of one operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Float1 {
    Mov,
    Abs,
    Neg,
    Sqrt,
    /// Half precision to single, from the low or the top half.
    FromHalf {
        top: bool,
    },
    /// Single to half precision.
    ToHalf {
        top: bool,
    },
    /// `VCVT.F32.S32`, `VCVT.F32.U32`.
    FromInt {
        signed: bool,
    },
    /// `VCVT.S32.F32` towards zero, `VCVTR` by the rounding mode of FPSCR.
    ToInt {
        signed: bool,
        by_mode: bool,
    },
    /// From fixed point, in place.
    FromFixed {
        signed: bool,
        half: bool,
        fraction: u8,
    },
    /// To fixed point, in place.
    ToFixed {
        signed: bool,
        half: bool,
        fraction: u8,
    },
}

/// How the address of a load or store is formed and written back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Index {
    /// `[Rn, #offset]`
    Offset,
    /// `[Rn, #offset]!`
    Before,
    /// `[Rn], #offset`
    After,
}

/// An instruction. Register fields are register numbers; addresses are absolute, as the place of the instruction is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Op {
    /// An encoding that ARMv7E-M leaves undefined, `UDF` included.
    Undefined,
    /// An instruction of a coprocessor that does not exist, or of the FPU in double precision.
    NoCoprocessor,
    AddImm {
        d: u8,
        n: u8,
        sets: Sets,
        imm: u32,
    },
    SubImm {
        d: u8,
        n: u8,
        sets: Sets,
        imm: u32,
    },
    CmpImm {
        n: u8,
        imm: u32,
    },
    /// With the carry that the expansion of the immediate gives, if it gives one.
    MovImm {
        d: u8,
        sets: Sets,
        rotated: bool,
        imm: u32,
    },
    AddReg {
        d: u8,
        n: u8,
        m: u8,
        sets: Sets,
    },
    SubReg {
        d: u8,
        n: u8,
        m: u8,
        sets: Sets,
    },
    CmpReg {
        n: u8,
        m: u8,
    },
    MovReg {
        d: u8,
        m: u8,
        sets: Sets,
    },
    AluImm {
        alu: Alu,
        d: u8,
        n: u8,
        sets: Sets,
        rotated: bool,
        imm: u32,
    },
    AluReg {
        alu: Alu,
        d: u8,
        n: u8,
        m: u8,
        sets: Sets,
    },
    AluShift {
        alu: Alu,
        d: u8,
        n: u8,
        m: u8,
        sets: Sets,
        shift: Shift,
        amount: u8,
    },
    ShiftImm {
        d: u8,
        m: u8,
        sets: Sets,
        shift: Shift,
        amount: u8,
    },
    ShiftReg {
        d: u8,
        n: u8,
        m: u8,
        sets: Sets,
        shift: Shift,
    },
    MovTop {
        d: u8,
        imm: u16,
    },
    /// `MOV PC, Rm`
    MovPc {
        m: u8,
    },
    /// `ADD PC, Rm`
    AddPc {
        m: u8,
    },
    Bits {
        bits: Bits,
        d: u8,
        m: u8,
    },
    Extend {
        extend: Extend,
        d: u8,
        n: u8,
        m: u8,
        rotate: u8,
    },
    /// `UBFX`, `SBFX`
    Extract {
        signed: bool,
        d: u8,
        n: u8,
        lsb: u8,
        width: u8,
    },
    /// `BFI`; `BFC` with register 15
    Insert {
        d: u8,
        n: u8,
        lsb: u8,
        width: u8,
    },
    Saturate {
        signed: bool,
        d: u8,
        n: u8,
        bits: u8,
        shift: Shift,
        amount: u8,
    },
    Saturate16 {
        signed: bool,
        d: u8,
        n: u8,
        bits: u8,
    },
    /// `QADD`, `QSUB`, `QDADD`, `QDSUB`
    SaturatingAdd {
        d: u8,
        n: u8,
        m: u8,
        double: bool,
        subtract: bool,
    },
    Pack {
        d: u8,
        n: u8,
        m: u8,
        top: bool,
        amount: u8,
    },
    Select {
        d: u8,
        n: u8,
        m: u8,
    },
    Parallel {
        lanes: Lanes,
        parallel: Parallel,
        d: u8,
        n: u8,
        m: u8,
    },
    Mul {
        d: u8,
        n: u8,
        m: u8,
        sets: Sets,
    },
    Mla {
        d: u8,
        n: u8,
        m: u8,
        a: u8,
    },
    Mls {
        d: u8,
        n: u8,
        m: u8,
        a: u8,
    },
    Product {
        product: Product,
        d: u8,
        n: u8,
        m: u8,
        a: u8,
    },
    Long {
        long: Long,
        lo: u8,
        hi: u8,
        n: u8,
        m: u8,
    },
    Divide {
        signed: bool,
        d: u8,
        n: u8,
        m: u8,
    },

    LdrImm {
        t: u8,
        n: u8,
        offset: i16,
    },
    StrImm {
        t: u8,
        n: u8,
        offset: i16,
    },
    LoadImm {
        size: Size,
        t: u8,
        n: u8,
        offset: i16,
    },
    StoreImm {
        size: Size,
        t: u8,
        n: u8,
        offset: i16,
    },
    LoadReg {
        size: Size,
        t: u8,
        n: u8,
        m: u8,
        shift: u8,
    },
    StoreReg {
        size: Size,
        t: u8,
        n: u8,
        m: u8,
        shift: u8,
    },
    /// A load from an address relative to the instruction.
    LoadLiteral {
        size: Size,
        t: u8,
        address: u32,
    },
    LoadIndexed {
        size: Size,
        t: u8,
        n: u8,
        after: bool,
        offset: i16,
    },
    StoreIndexed {
        size: Size,
        t: u8,
        n: u8,
        after: bool,
        offset: i16,
    },
    /// `LDR PC, …`, all forms but the one relative to the PC.
    LoadPc {
        n: u8,
        index: Index,
        offset: i16,
    },
    LoadPcReg {
        n: u8,
        m: u8,
        shift: u8,
    },
    LoadPcLiteral {
        address: u32,
    },
    /// The unprivileged forms, `LDRT`, `STRT` ….
    Unprivileged {
        load: bool,
        size: Size,
        t: u8,
        n: u8,
        offset: u8,
    },
    LoadDouble {
        t: u8,
        t2: u8,
        n: u8,
        index: Index,
        offset: i16,
    },
    StoreDouble {
        t: u8,
        t2: u8,
        n: u8,
        index: Index,
        offset: i16,
    },
    LoadDoubleLiteral {
        t: u8,
        t2: u8,
        address: u32,
    },
    LoadMany {
        n: u8,
        list: u16,
        before: bool,
        back: bool,
    },
    StoreMany {
        n: u8,
        list: u16,
        before: bool,
        back: bool,
    },
    Push {
        list: u16,
    },
    Pop {
        list: u16,
    },
    LoadExclusive {
        size: Size,
        t: u8,
        n: u8,
        offset: u16,
    },
    StoreExclusive {
        size: Size,
        d: u8,
        t: u8,
        n: u8,
        offset: u16,
    },
    ClearExclusive,

    Branch {
        target: u32,
    },
    BranchIf {
        condition: u8,
        target: u32,
    },
    BranchLink {
        target: u32,
    },
    BranchExchange {
        m: u8,
    },
    BranchLinkExchange {
        m: u8,
    },
    /// `CBZ`, `CBNZ`
    BranchZero {
        n: u8,
        nonzero: bool,
        target: u32,
    },
    TableBranch {
        n: u8,
        m: u8,
        half: bool,
    },
    It {
        state: u8,
    },

    /// `NOP`, `YIELD`, preload and debug hints.
    Nop,
    WaitInterrupt,
    WaitEvent,
    SendEvent,
    /// `DMB`, `DSB`, `ISB`
    Barrier,
    Supervisor,
    Breakpoint {
        number: u8,
    },
    /// `CPSIE`, `CPSID`
    ChangeState {
        disable: bool,
        primask: bool,
        faultmask: bool,
    },
    ReadSpecial {
        d: u8,
        special: u8,
    },
    WriteSpecial {
        n: u8,
        special: u8,
        mask: u8,
    },

    FloatAdd {
        d: u8,
        n: u8,
        m: u8,
    },
    FloatMul {
        d: u8,
        n: u8,
        m: u8,
    },
    Float2 {
        float: Float2,
        d: u8,
        n: u8,
        m: u8,
    },
    Float1 {
        float: Float1,
        d: u8,
        m: u8,
    },
    /// `VMOV.F32 Sd, #imm`
    FloatImm {
        d: u8,
        bits: u32,
    },
    /// `VCMP`, `VCMPE`; register 255 for zero
    FloatCompare {
        d: u8,
        m: u8,
        signal: bool,
    },
    FloatLoad {
        d: u8,
        n: u8,
        double: bool,
        offset: i16,
    },
    FloatStore {
        d: u8,
        n: u8,
        double: bool,
        offset: i16,
    },
    FloatLoadMany {
        n: u8,
        first: u8,
        count: u8,
        before: bool,
        back: bool,
    },
    FloatStoreMany {
        n: u8,
        first: u8,
        count: u8,
        before: bool,
        back: bool,
    },
    /// `VMOV Sn, Rt` and `VMOV Dd[x], Rt`
    ToFloat {
        s: u8,
        t: u8,
    },
    FromFloat {
        s: u8,
        t: u8,
    },
    /// `VMOV Sm, Sm1, Rt, Rt2` and `VMOV Dm, Rt, Rt2`
    ToFloats {
        s: u8,
        t: u8,
        t2: u8,
    },
    FromFloats {
        s: u8,
        t: u8,
        t2: u8,
    },
    /// `VMRS`, to the flags with register 15
    ReadFpscr {
        t: u8,
    },
    WriteFpscr {
        t: u8,
    },
}

/// A decoded instruction, as it stands next to its bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Decoded {
    pub(crate) op: Op,
    /// Bytes: 2 or 4, and 0 where nothing is decoded yet.
    pub(crate) len: u8,
    /// Cycles that are known without the operands.
    pub(crate) cycles: u8,
    /// The register that data processing computes, or none.
    pub(crate) computes: u8,
    /// The two registers that give the address of a load or store, each in four bits; 15 for none.
    pub(crate) bases: u8,
}

impl Decoded {
    /// No register.
    pub(crate) const NONE: u8 = 0xFF;
    pub(crate) const NOTHING: Decoded = Decoded { op: Op::Undefined, len: 0, cycles: 0, computes: Decoded::NONE, bases: 0xFF };

    pub(crate) fn new(op: Op, len: u8) -> Decoded {
        Decoded { op, len, cycles: crate::cycles::of(&op), computes: op.computes(), bases: op.bases() }
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
            // One of two; an address from the other one misses its stall.
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
