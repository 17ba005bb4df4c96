//! Variants of instructions: operations, shifts, sizes, addressing.

/// Condition under which data processing sets the flags.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sets {
    Never,
    Always,
    /// Only outside an IT block: the 16-bit forms.
    OutsideIt,
}

/// Operation of data processing.
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

/// Type of shift of an operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shift {
    Lsl,
    Lsr,
    Asr,
    Ror,
    Rrx,
}

/// Size and signedness of a load or store.
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

/// Treatment of each lane's result in parallel addition and subtraction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lanes {
    Signed,
    SignedSaturating,
    SignedHalving,
    Unsigned,
    UnsignedSaturating,
    UnsignedHalving,
}

/// Lanes that a parallel operation adds and subtracts.
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

/// Products of 32 bits, with an accumulator if its register is not 15.
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

/// Floating-point operations of two operands and a destination, other than the sum and the product.
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
    /// `VCVT.S32.F32` towards zero, or `VCVTR` with the rounding mode of FPSCR.
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

/// Address of a load or store, and write-back to its base register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Index {
    /// `[Rn, #offset]`
    Offset,
    /// `[Rn, #offset]!`
    Before,
    /// `[Rn], #offset`
    After,
}
