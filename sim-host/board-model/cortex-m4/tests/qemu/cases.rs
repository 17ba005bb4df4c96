//! Random cases: instructions with their initial state.

use rand_core::Rng;

use crate::encodings::Class;

/// Bytes of a state: R0 to R12 and LR, APSR, FPSCR, S0 to S31, and memory for loads and stores.
pub const STATE: usize = 256;
/// Offset of the memory in a state, bytes.
pub const SCRATCH: u32 = 192;
/// Length of the memory in a state, bytes.
pub const SCRATCH_LEN: u32 = 64;

/// Instructions and the words of their initial state.
pub struct Case {
    pub code: Vec<u16>,
    pub state: [u32; STATE / 4],
}

/// Returns a random register number out of R0 to R12 and LR.
pub fn register(rng: &mut impl Rng) -> u32 {
    [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 14][rng.next_u32() as usize % 14]
}

/// Returns the index of a register in the state.
pub fn place(register: u32) -> usize {
    if register == 14 { 13 } else { register as usize }
}

/// Returns a random word: a boundary value, one with few bits, or any.
fn word(rng: &mut impl Rng) -> u32 {
    const BORDERS: [u32; 14] =
        [0, 1, 2, 31, 32, 33, 0x7F, 0x80, 0xFFFF, 0x8000, 0x7FFF_FFFF, 0x8000_0000, 0xFFFF_FFFF, 0x7FFF_8000];
    match rng.next_u32() % 8 {
        0..3 => BORDERS[rng.next_u32() as usize % BORDERS.len()],
        3 => rng.next_u32() & 0x8000_7FFF,
        4 => rng.next_u32() >> (rng.next_u32() % 32),
        _ => rng.next_u32(),
    }
}

/// Returns the bits of a random single-precision number: special ones, ones near each other, or
/// any.
fn float(rng: &mut impl Rng) -> u32 {
    const SPECIAL: [u32; 16] = [
        0,
        1,
        0x007F_FFFF,
        0x0080_0000,
        0x0080_0001,
        0x3F80_0000,
        0x3F80_0001,
        0x3F7F_FFFF,
        0x4F00_0000,
        0x4EFF_FFFF,
        0x7F7F_FFFF,
        0x7F80_0000,
        0x7FC0_0000,
        0x7F80_0001,
        0x7FC1_2345,
        0x3F00_0000,
    ];
    let sign = rng.next_u32() & 1 << 31;
    let near =
        |rng: &mut _, exponent: u32, span: u32| (exponent + Rng::next_u32(rng) % span) << 23 | Rng::next_u32(rng) & 0x7F_FFFF;
    sign | match rng.next_u32() % 8 {
        0..2 => SPECIAL[rng.next_u32() as usize % SPECIAL.len()],
        2..5 => near(rng, 120, 14),
        5 => near(rng, 58, 12),
        6 => near(rng, 0, 4) >> (rng.next_u32() % 8),
        _ => rng.next_u32() & 0x7FFF_FFFF,
    }
}

/// Returns a random state. FPSCR mostly has the default mode with the inexact flag set, as in real
/// programs.
pub fn state(rng: &mut impl Rng) -> [u32; STATE / 4] {
    let mut state = [0; STATE / 4];
    state[..14].fill_with(|| word(rng));
    state[14] = rng.next_u32() & 0xF80F_0000;
    state[15] = match rng.next_u32() % 4 {
        0 => 0x10,
        1 => rng.next_u32() & 0x9F,
        _ => rng.next_u32() & 0xF7C0_009F,
    };
    state[16..48].fill_with(|| float(rng));
    state[48..].fill_with(|| word(rng));
    state
}

/// Returns an instance of a pattern. Equal letters of a register field are the same register.
fn instance(pattern: &str, rng: &mut impl Rng) -> u32 {
    let mut registers = [None; 128];
    let mut code = 0;
    let letters = pattern.as_bytes();
    let mut at = 0;
    while at < letters.len() {
        let letter = letters[at];
        let run = letters[at..].iter().take_while(|other| **other == letter).count();
        let is_register = b"dnmatlh".contains(&letter) && (run == 3 || run == 4);
        if is_register {
            let value =
                *registers[usize::from(letter)].get_or_insert_with(|| if run == 3 { rng.next_u32() % 8 } else { register(rng) });
            code = code << run | value;
            at += run;
        } else {
            code = code << 1 | if letter == b'0' || letter == b'1' { u32::from(letter - b'0') } else { rng.next_u32() >> 31 };
            at += 1;
        }
    }
    code
}

/// Returns the halfwords of an instruction.
pub fn halfwords(code: u32) -> Vec<u16> {
    if code >> 16 == 0 { vec![code as u16] } else { vec![(code >> 16) as u16, code as u16] }
}

/// Returns a random predictable encoding of a class.
pub fn encoding(class: &Class, rng: &mut impl Rng) -> u32 {
    loop {
        let code = instance(class.patterns[rng.next_u32() as usize % class.patterns.len()], rng);
        if (class.allowed)(code) {
            return code;
        }
    }
}

/// Returns a case with one instruction of a class.
pub fn single(class: &Class, rng: &mut impl Rng) -> Case {
    Case { code: halfwords(encoding(class, rng)), state: state(rng) }
}

/// Returns an IT block of one to four instructions of 16 and 32 bits.
pub fn it_block(classes: &[&Class], rng: &mut impl Rng) -> Case {
    let condition = rng.next_u32() % 14;
    let mask = 1 + rng.next_u32() % 15;
    let mut code = vec![(0xBF00 | condition << 4 | mask) as u16];
    for _ in 0..4 - mask.trailing_zeros() {
        code.extend(halfwords(encoding(classes[rng.next_u32() as usize % classes.len()], rng)));
    }
    Case { code, state: state(rng) }
}

/// Returns a branch over an instruction that changes R0: by condition, by zero, by table, or by
/// register.
pub fn branch(rng: &mut impl Rng) -> Case {
    let mut state = state(rng);
    let condition = rng.next_u32() % 14;
    let low = rng.next_u32() % 8;
    let skipped = [0x3001, 0x3101];
    let code = match rng.next_u32() % 8 {
        0 => vec![(0xD000 | condition << 8) as u16],
        1 => vec![0xE000],
        2 => vec![(0xF000 | condition << 6) as u16, 0x8001],
        3 => vec![0xF000, 0xB801],
        // BL: LR is compared as well.
        4 => vec![0xF000, 0xF801],
        5 => vec![(0xB100 | (rng.next_u32() & 1) << 11 | low) as u16],
        6 => {
            let register = register(rng);
            state[place(register)] = rng.next_u32() % 3;
            // Byte table: 2, 3 or 4 halfwords ahead.
            return Case { code: vec![0xE8DF, 0xF000 | register as u16, 0x0302, 0x0004, 0x3001, 0x3101, 0x3201, 0xBF00], state };
        }
        _ => {
            let register = register(rng);
            state[place(register)] = rng.next_u32() % 2;
            // Halfword table: 2 or 3 halfwords ahead.
            return Case { code: vec![0xE8DF, 0xF010 | register as u16, 0x0002, 0x0003, 0x3001, 0x3101], state };
        }
    };
    Case { code: [code, skipped.to_vec()].concat(), state }
}
