//! Entry to and return from SVCall and PendSV, compared with QEMU: stacked frames, stack pointers,
//! special registers, and floating-point context.
//!
//! A case sets a random state and raises the exception. The handler stores its view of the state,
//! and the case stores the state after the return.

use rand_core::Rng;

use crate::image::{self, STATES, constant};

/// Bytes of a record.
pub const RECORD: usize = 512;
/// Maximum number of cases in one program.
pub const CASES: usize = 1200;

/// Address of the pointer to the current record.
const POINTER: u32 = 0x003F_0000;
/// End of the main stack.
const MAIN: u32 = 0x003F_8000;
/// End of the process stack.
const PROCESS: u32 = 0x003F_C000;

// Word offsets in a record; the words before `FRAME` come from the handler.
/// Basic frame.
const FRAME: u16 = 16;
/// Floating-point frame.
const FLOATS: u16 = 24;
/// Nonzero if the handler uses floating point.
const USES_FLOAT: u16 = 48;
/// Value of R0 that the handler returns.
const NEW_R0: u16 = 49;
/// Values read back from the mask registers.
const MASKED: u16 = 50;
/// R0 to R12 and LR.
const REGISTERS: u16 = 64;
const APSR: u16 = 78;
/// Special registers after the return.
const AFTER: u16 = 79;
/// S0 to S31.
const S: u16 = 88;
const FPSCR: u16 = 120;

const MSP: u16 = 8;
const PSP: u16 = 9;
const PRIMASK: u16 = 16;
const BASEPRI: u16 = 17;
const BASEPRI_MAX: u16 = 18;
const FAULTMASK: u16 = 19;
const CONTROL: u16 = 20;
/// APSR, IPSR, PRIMASK, BASEPRI, FAULTMASK.
const MASKS: [u16; 5] = [0, 5, PRIMASK, BASEPRI, FAULTMASK];
const ISB: [u16; 2] = [0xF3BF, 0x8F6F];

fn mrs(register: u16, special: u16) -> [u16; 2] {
    [0xF3EF, 0x8000 | register << 8 | special]
}

fn msr(special: u16, register: u16) -> [u16; 2] {
    [0xF380 | register, 0x8800 | special]
}

/// Returns an `LDR` of word `word` at the address in `base`.
fn ldr(register: u16, base: u16, word: u16) -> [u16; 2] {
    [0xF8D0 | base, (register << 12) | (4 * word)]
}

fn str(register: u16, base: u16, word: u16) -> [u16; 2] {
    [0xF8C0 | base, (register << 12) | (4 * word)]
}

/// Returns the handler of both exceptions.
fn handler() -> Vec<u16> {
    let mut code = Vec::new();
    code.extend(constant(1, POINTER));
    code.extend(ldr(1, 1, 0));
    code.extend(str(14, 1, 0));
    for (word, special) in (1..).zip([MSP, PSP, CONTROL].into_iter().chain(MASKS)) {
        code.extend(mrs(2, special));
        code.extend(str(2, 1, word));
    }
    // FPCCR without the bits of possible exceptions, FPCAR, ICSR, SHCSR
    for (word, (register, mask)) in
        (9..).zip([(0xE000_EF34, 0xC000_000B), (0xE000_EF38, u32::MAX), (0xE000_ED04, u32::MAX), (0xE000_ED24, u32::MAX)])
    {
        code.extend(constant(3, register));
        code.extend(ldr(2, 3, 0));
        code.extend(constant(3, mask));
        code.extend([0xEA02, 0x0203]); // AND R2, R2, R3
        code.extend(str(2, 1, word));
    }
    // Privileged from here: MRS R2, CONTROL; BIC R2, #1; MSR
    code.extend(mrs(2, CONTROL));
    code.extend([0xF022, 0x0201]);
    code.extend(msr(CONTROL, 2));
    code.extend(ISB);
    // The frame: TST LR, #4; ITE EQ; MRSEQ R0, MSP; MRSNE R0, PSP
    code.extend([0xF01E, 0x0F04, 0xBF0C]);
    code.extend(mrs(0, MSP));
    code.extend(mrs(0, PSP));
    for word in 0..8 {
        code.extend(ldr(2, 0, word));
        code.extend(str(2, 1, FRAME + word));
    }
    // If the handler uses floating point, the lazy frame is stored: VADD S0, S1, S2
    let mut float = vec![0xEE30, 0x0A81];
    // TST LR, #16; BNE over the copy
    let mut copy = Vec::new();
    for word in 0..17 {
        copy.extend(ldr(2, 0, 8 + word));
        copy.extend(str(2, 1, FLOATS + word));
    }
    float.extend([0xF01E, 0x0F10, 0xD100 | (copy.len() as u16 - 1)]);
    float.extend(copy);
    // LDR R2, the choice; CMP R2, #0; BEQ over the floating-point code
    code.extend(ldr(2, 1, USES_FLOAT));
    code.extend([0x2A00, 0xD000 | (float.len() as u16 - 1)]);
    code.extend(float);
    // Another R0 after the return.
    code.extend(ldr(2, 1, NEW_R0));
    code.extend(str(2, 0, 0));
    code.push(0x4770);
    code
}

/// Returns code that writes BASEPRI, BASEPRI_MAX, PRIMASK and FAULTMASK, stores the values read
/// back, and clears all of them. Only implemented bits of a priority are written: QEMU stores the
/// others as well.
fn masks(record: u32, values: [u32; 3]) -> Vec<u16> {
    let mut code = constant(0, record);
    let write = |code: &mut Vec<u16>, special: u16, value: u32| {
        code.extend(constant(1, value));
        code.extend(msr(special, 1));
    };
    write(&mut code, BASEPRI, values[0]);
    write(&mut code, BASEPRI_MAX, values[1]);
    write(&mut code, PRIMASK, values[2]);
    // CPSID F
    code.push(0xB671);
    for (word, special) in (MASKED..).zip([BASEPRI, PRIMASK, FAULTMASK]) {
        code.extend(mrs(2, special));
        code.extend(str(2, 0, word));
    }
    // CPSIE IF
    code.push(0xB663);
    write(&mut code, BASEPRI, 0);
    code
}

/// Returns a case: the code around the exception, and its record.
fn case(record: u32, rng: &mut impl Rng) -> (Vec<u16>, [u32; RECORD / 4]) {
    let mut words = [0; RECORD / 4];
    for place in [NEW_R0..NEW_R0 + 1, REGISTERS..APSR, S..FPSCR].into_iter().flatten() {
        words[usize::from(place)] = rng.next_u32();
    }
    words[usize::from(APSR)] = rng.next_u32() & 0xF80F_0000;
    words[usize::from(FPSCR)] = rng.next_u32() & 0xF000_009F;
    let mut bit = || rng.next_u32() >> 7 & 1;
    let (float, lazy, stack, pend, in_block) = (bit(), bit(), bit(), bit(), bit());
    let unprivileged = bit() & (1 - pend) & (1 - in_block);
    let (align, automatic, offsets, uses) = (bit(), bit() | bit(), [bit(), bit()], bit());
    let base = [0, 0x20, 0xE0, 0x80][(bit() + 2 * bit()) as usize];
    words[usize::from(USES_FLOAT)] = uses;

    let mut code = Vec::new();
    let set = |code: &mut Vec<u16>, address: u32, value: u32| {
        code.extend(constant(0, address));
        code.extend(constant(1, value));
        code.push(0x6001);
    };
    set(&mut code, POINTER, record);
    // A frame with floating-point registers is always aligned (`PushStack`); QEMU aligns it only if
    // STKALIGN is set.
    set(&mut code, 0xE000_ED14, (align | float) << 9);
    set(&mut code, 0xE000_EF34, automatic << 31 | lazy << 30);
    code.extend(masks(record, [bit() << 7 | bit() << 6 | bit() << 5, bit() << 7 | bit() << 5, bit()]));
    for (special, value) in [(MSP, MAIN - 4 * offsets[0]), (PSP, PROCESS - 4 * offsets[1]), (BASEPRI, base)] {
        code.extend(constant(0, value));
        code.extend(msr(special, 0));
    }
    if float == 1 {
        // VLDM R0, {S0-S31}; VMSR FPSCR
        code.extend(constant(0, record + 4 * u32::from(S)));
        code.extend([0xEC90, 0x0A20]);
        code.extend(ldr(0, 0, FPSCR - S));
        code.extend([0xEEE1, 0x0A10]);
    }
    // MRS R0, CONTROL; ORR R0, #; MSR; ISB
    code.extend(mrs(0, CONTROL));
    code.extend([0xF040, (unprivileged | stack << 1) as u16]);
    code.extend(msr(CONTROL, 0));
    code.extend(ISB);
    code.extend(constant(0, record + 4 * u32::from(REGISTERS)));
    // APSR, then LDM R0, {R0-R12, LR}
    code.extend(ldr(1, 0, APSR - REGISTERS));
    code.extend([0xF381, 0x8C00, 0xE890, 0x5FFF]);
    if pend == 1 {
        // Masked until CPSIE I, because QEMU takes an interrupt only at the end of its block.
        code.push(0xB672);
        set(&mut code, 0xE000_ED04, 1 << 28);
        code.extend([0xF3BF, 0x8F4F]);
        code.extend(ISB);
        code.push(0xB662);
    } else if in_block == 1 {
        // ITET EQ; SVCEQ; ADDNE R4, #1; ADDEQ R5, #1
        code.extend([0xBF0A, 0xDF12, 0x3401, 0x3501]);
    } else {
        code.push(0xDF34);
    }
    // PUSH {R0-R12, LR}; MOV R1, SP
    code.extend([0xE92D, 0x5FFF, 0x4669]);
    code.extend(constant(0, record));
    for word in 0..14 {
        code.extend(ldr(2, 1, word));
        code.extend(str(2, 0, REGISTERS + word));
    }
    for (word, special) in (AFTER..).zip([MSP, PSP, CONTROL].into_iter().chain(MASKS)) {
        code.extend(mrs(2, special));
        code.extend(str(2, 0, word));
    }
    if float == 1 {
        // VMRS R2, FPSCR; ADD R0, #; VSTM R0, {S0-S31}
        code.extend([0xEEF1, 0x2A10]);
        code.extend(str(2, 0, FPSCR));
        code.extend([0xF500, 0x70B0, 0xEC80, 0x0A20]);
    }
    // Back to the main stack, without a floating-point context and a base priority.
    code.push(0x2000);
    code.extend(msr(CONTROL, 0));
    code.extend(msr(BASEPRI, 0));
    code.extend(ISB);
    (code, words)
}

/// Returns a program with `count` random cases.
pub fn build(count: usize, rng: &mut impl Rng) -> Vec<u8> {
    let handler = handler();
    let mut code = handler.clone();
    code.extend(image::float_on());
    let mut records = Vec::new();
    for number in 0..count {
        let (body, words) = case(STATES + (number * RECORD) as u32, rng);
        code.extend(body);
        records.extend(words);
    }
    image::assemble(code, handler.len(), &[11, 14], &records)
}
