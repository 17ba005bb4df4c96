//! Program that runs cases in sequence: it loads the state of each, runs its instructions, and
//! stores the state in place.

use crate::cases::{Case, STATE};

/// Address of the states: the upper half of the 4 MiB at address 0 of the MPS2 boards.
pub const STATES: u32 = 0x0020_0000;
/// Maximum number of cases in one program.
pub const CASES: usize = 6000;

/// Returns `MOVW`, `MOVT` that load a constant to a low register.
pub fn constant(register: u16, value: u32) -> Vec<u16> {
    let half = |opcode: u16, value: u16| {
        let (i, high) = (value >> 11 & 1, value >> 12);
        [opcode | i << 10 | high, (value >> 8 & 7) << 12 | register << 8 | value & 0xFF]
    };
    [half(0xF240, value as u16), half(0xF2C0, (value >> 16) as u16)].concat()
}

/// Returns the address of a case's state.
pub fn state_address(number: usize) -> u32 {
    STATES + (number * STATE) as u32
}

/// Returns code that enables the FPU in CPACR, with DSB and ISB.
pub fn float_on() -> Vec<u16> {
    [constant(0, 0xE000_ED88), vec![0xF44F, 0x0170, 0x6001, 0xF3BF, 0x8F4F, 0xF3BF, 0x8F6F]].concat()
}

/// Returns the whole memory: vectors, code, states.
pub fn build(cases: &[Case]) -> Vec<u8> {
    let mut code = float_on();
    for (number, case) in cases.iter().enumerate() {
        code.extend(constant(0, state_address(number)));
        // MOV SP, R0; ADD R0, SP, #64; VLDM R0, {S0-S31}; FPSCR; APSR; LDM SP, {R0-R12, LR}
        code.extend([0x4685, 0xA810, 0xEC90, 0x0A20, 0x980F, 0xEEE1, 0x0A10, 0x980E, 0xF380, 0x8C00, 0xE89D, 0x5FFF]);
        code.extend(&case.code);
        // STM SP, {R0-R12, LR}; APSR; FPSCR; VSTM
        code.extend([0xE88D, 0x5FFF, 0xF3EF, 0x8000, 0x900E, 0xEEF1, 0x0A10, 0x900F, 0xA810, 0xEC80, 0x0A20]);
    }
    let states: Vec<u32> = cases.iter().flat_map(|case| case.state).collect();
    assemble(code, 0, &[], &states)
}

/// Assembles a program that starts `entry` halfwords into its code and writes its states to
/// standard output at the end.
///
/// The `handled` exceptions jump to the beginning of the code. All other exceptions end the
/// program, so that later states do not change.
pub fn assemble(mut code: Vec<u16>, entry: usize, handled: &[usize], states: &[u32]) -> Vec<u8> {
    let end = 0x100 + 2 * code.len() as u32;
    let arguments = end.next_multiple_of(4) + 0x40;
    let call = |operation: u16, argument: u32| [vec![0x2000 | operation], constant(1, argument), vec![0xBEAB]].concat();
    code.extend(call(1, arguments)); // SYS_OPEN
    code.extend(constant(1, arguments + 16));
    code.push(0x6008); // STR R0, [R1]
    code.extend(call(5, arguments + 16)); // SYS_WRITE
    code.extend(call(0x18, 0x2_0026)); // SYS_EXIT
    code.push(0xE7FE);

    let mut image = vec![0; STATES as usize];
    let mut put = |at: u32, words: &[u32]| {
        for (place, word) in image[at as usize..].chunks_exact_mut(4).zip(words) {
            place.copy_from_slice(&word.to_le_bytes());
        }
    };
    put(0, &[0x003F_FF00, 0x101 + 2 * entry as u32]);
    put(8, &std::array::from_fn::<u32, 14, _>(|at| if handled.contains(&(at + 2)) { 0x101 } else { end | 1 }));
    // Opening ":tt" for writing gives standard output.
    put(arguments, &[arguments + 32, 4, 3, 0, 0, STATES, 4 * states.len() as u32, 0, u32::from_le_bytes(*b":tt\0")]);
    for (place, half) in image[0x100..].chunks_exact_mut(2).zip(&code) {
        place.copy_from_slice(&half.to_le_bytes());
    }
    assert!(0x100 + 2 * code.len() < arguments as usize && arguments + 64 < STATES, "the code overlaps the states");
    image.extend(states.iter().flat_map(|word| word.to_le_bytes()));
    image
}
