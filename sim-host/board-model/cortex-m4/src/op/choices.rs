//! What instructions choose among: operations, shifts, sizes, addressing.

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
