//! Exceptions: entry, return, priorities, faults, sleep, reset.

use crate::support::{CODE, PART, Part, RAM, constant, handler, machine, store};
use sonoglide_cortex_m4::Machine;

const LOOP: u16 = 0xE7FE;
const RETURN: u16 = 0x4770;
const ENABLE_LINES: u32 = 0xE000_E100;
const CFSR_UNDEFINED: u32 = 1 << 16;
const CFSR_DIVIDED_BY_ZERO: u32 = 1 << 25;
const HFSR_FORCED: u32 = 1 << 30;

fn program(parts: &[&[u16]]) -> Vec<u16> {
    parts.concat()
}

fn run(machine: &mut Machine<Part>, until: u64) {
    machine.run_until(machine.cycle() + until).expect("the program runs");
}

/// Returns code that acknowledges the line at the chip, through R2.
fn acknowledge() -> Vec<u16> {
    [constant(2, PART), vec![0x6012]].concat()
}

#[test]
fn an_interrupt_is_entered_after_twelve_cycles() {
    let start = program(&[&store(ENABLE_LINES, 1), &[0xBF00; 200], &[LOOP]]);
    let mut machine = machine(&start, &[(16, &program(&[&acknowledge(), &[RETURN]]))]);
    machine.chip.rises = 100;
    run(&mut machine, 400);
    // Entry, MOVW, MOVT; the stall of a computed address counts for the store.
    assert_eq!(machine.chip.stores, [(PART, PART, 100 + 12 + 2)]);
    assert_eq!(machine.exception(), 0);
}

#[test]
fn a_line_that_stays_high_pends_again() {
    let start = program(&[&store(ENABLE_LINES, 1), &[LOOP]]);
    // ADDS R4, #1
    let mut machine = machine(&start, &[(16, &[0x3401, RETURN])]);
    (machine.chip.rises, machine.chip.falls) = (100, 1000);
    run(&mut machine, 3000);
    // Each pass takes two cycles of the body, and six of a tail-chained entry.
    assert!((110..115).contains(&machine.register(4)), "{}", machine.register(4));
}

#[test]
fn an_interrupt_within_an_it_block_changes_nothing() {
    // MOVS R3, #200; CMP R3, #0; ITTT NE; ADDNE R4, R5, R6 #1 each; SUBS R3, #1; BNE.N back to CMP
    let start = program(&[&store(ENABLE_LINES, 1), &[0x23C8, 0x2B00, 0xBF1E, 0x3401, 0x3501, 0x3601, 0x3B01, 0xD1F8, LOOP]]);
    // MOVS R0, #0 changes Z and must not be skipped; R7 counts.
    let body = program(&[&acknowledge(), &[0x2000, 0x3701, RETURN]]);
    for rises in 20..60 {
        let mut machine = machine(&start, &[(16, &body)]);
        machine.chip.rises = rises;
        run(&mut machine, 5000);
        let registers: Vec<u32> = (4..8).map(|register| machine.register(register)).collect();
        assert_eq!(registers, [200, 200, 200, 1], "line rises at {rises}");
    }
}

#[test]
fn a_handler_with_floating_point_keeps_the_registers() {
    // VMOV.F32 S0, #1.0; S1, #2.0; then S2 = S0 + S1 eight times, loop.
    let adds: Vec<u16> = [0xEE30, 0x1A20].repeat(8);
    let start =
        program(&[&store(0xE000_ED88, 0xF0_0000), &store(ENABLE_LINES, 1), &[0xEEB7, 0x0A00, 0xEEF0, 0x0A00], &adds, &[LOOP]]);
    // VMOV.F32 S0, #2.0; VMUL.F32 S1, S0, S0
    let body = program(&[&acknowledge(), &[0xEEB0, 0x0A00, 0xEE60, 0x0A00, RETURN]]);
    for rises in 10..40 {
        let mut machine = machine(&start, &[(16, &body)]);
        machine.chip.rises = rises;
        run(&mut machine, 2000);
        let values: Vec<f32> = (0..3).map(|s| f32::from_bits(machine.float_register(s))).collect();
        assert_eq!(values, [1.0, 2.0, 3.0], "line rises at {rises}");
        assert_eq!(machine.chip.stores.len(), 1);
        assert_eq!(machine.register(13), RAM + 0x1_0000);
    }
}

#[test]
fn an_undefined_instruction_is_a_hard_fault_unless_enabled() {
    let mut plain = machine(&[0xDE00], &[(3, &[LOOP]), (6, &[LOOP])]);
    run(&mut plain, 100);
    assert_eq!((plain.exception(), plain.fault_status()), (3, (CFSR_UNDEFINED, HFSR_FORCED)));

    let start = program(&[&store(0xE000_ED24, 1 << 18), &[0xDE00]]);
    let mut enabled = machine(&start, &[(3, &[LOOP]), (6, &[LOOP])]);
    run(&mut enabled, 100);
    assert_eq!((enabled.exception(), enabled.fault_status()), (6, (CFSR_UNDEFINED, 0)));
    // The stacked return address is the address of the instruction.
    let frame = enabled.register(13);
    let stacked = enabled.memory.get(frame + 24, 4).expect("the frame");
    assert_eq!(stacked, (CODE + 0x1000 + 2 * (start.len() as u32 - 1)).to_le_bytes());
}

#[test]
fn division_by_zero_faults_only_if_enabled() {
    // MOVS R1, #5; MOVS R2, #0; UDIV R0, R1, R2
    let divide = [0x2105, 0x2200, 0xFBB1, 0xF0F2, LOOP];
    let mut quiet = machine(&divide, &[(3, &[LOOP])]);
    run(&mut quiet, 100);
    assert_eq!((quiet.exception(), quiet.register(0)), (0, 0));
    let mut trapped = machine(&program(&[&store(0xE000_ED14, 0x210), &divide]), &[(3, &[LOOP])]);
    run(&mut trapped, 100);
    assert_eq!((trapped.exception(), trapped.fault_status().0), (3, CFSR_DIVIDED_BY_ZERO));
}

#[test]
fn a_fault_within_the_hard_fault_locks_up_until_reset() {
    let mut machine = machine(&[0xDE00], &[(3, &[0xDE00])]);
    run(&mut machine, 100);
    assert_eq!((machine.chip.lockups, machine.is_locked_up(), machine.cycle()), (1, true, 100));
    machine.interrupts.pull_reset();
    machine.run_until(101).expect("the reset");
    assert_eq!((machine.chip.resets, machine.is_locked_up()), (1, false));
}

#[test]
fn the_stack_guard_of_the_mpu_faults_before_memory_is_changed() {
    let guard = RAM + 0xFF00;
    // Region 0: 256 bytes without access; then the MPU with the default map; MEMFAULTENA.
    let start = program(&[
        &store(0xE000_ED9C, guard | 1 << 4),
        &store(0xE000_EDA0, 7 << 1 | 1),
        &store(0xE000_ED94, 5),
        &store(0xE000_ED24, 1 << 16),
        // SUB SP, #256 (twice 128), PUSH {R0}: the last word of the guard.
        &[0xB0A0, 0xB0A0, 0xB0A0, 0xB401],
    ]);
    // R0 = MMFAR
    let body = program(&[&constant(0, 0xE000_ED34), &[0x6800, LOOP]]);
    let mut machine = machine(&start, &[(4, &[LOOP]), (3, &body)]);
    machine.set_register(13, guard + 0x180 + 0x100);
    run(&mut machine, 200);
    // The frame of the memory fault does not fit either: DACCVIOL, MSTKERR, MMARVALID, and a hard
    // fault without a frame.
    assert_eq!((machine.exception(), machine.fault_status()), (3, (0x92, HFSR_FORCED)));
    assert_eq!(machine.register(0), guard + 0xFC);
    assert_eq!(machine.memory.get(guard, 256).expect("the guard"), [0; 256]);
}

#[test]
fn a_masked_interrupt_ends_sleep() {
    // CPSID I; WFI; ADDS R4, #1; CPSIE I; loop
    let start = program(&[&store(ENABLE_LINES, 1), &[0xB672, 0xBF30, 0x3401, 0xBF00, 0xB662, LOOP]]);
    let mut machine = machine(&start, &[(16, &program(&[&acknowledge(), &[RETURN]]))]);
    machine.chip.rises = 10_000;
    machine.run_until(9_999).expect("it sleeps");
    assert!(machine.is_asleep());
    assert!(machine.instructions() < 20);
    run(&mut machine, 100);
    assert_eq!((machine.register(4), machine.chip.stores.len()), (1, 1));
}

#[test]
fn the_system_timer_fires_every_reload_plus_one_cycles() {
    let start = program(&[&store(0xE000_E014, 99), &store(0xE000_E018, 0), &store(0xE000_E010, 7), &[LOOP]]);
    let mut machine = machine(&start, &[(15, &[0x3401, RETURN])]);
    run(&mut machine, 100_000);
    assert_eq!(machine.register(4), 999);
}

#[test]
fn an_unknown_register_stops_the_run_by_address() {
    let mut machine = machine(&program(&[&constant(1, 0xE000_2000), &[0x6808]]), &[]);
    let stop = machine.run_until(100).expect_err("it is not modelled");
    assert_eq!(stop.pc, CODE + 0x1008);
    assert!(stop.to_string().starts_with("read of the processor register 0xe0002000"), "{stop}");
}

#[test]
fn a_base_priority_masks_a_less_urgent_line() {
    // Line 0 has the priority 0x40: BASEPRI = 0x40 masks it, 0x50 does not.
    for (limit, entered) in [(0x40, 0), (0x50, 1), (0, 1)] {
        let set = [constant(0, limit), vec![0xF380, 0x8811]].concat();
        let start = program(&[&set, &store(0xE000_E400, 0x40), &store(ENABLE_LINES, 1), &[LOOP]]);
        let mut machine = machine(&start, &[(16, &program(&[&acknowledge(), &[RETURN]]))]);
        machine.chip.rises = 100;
        run(&mut machine, 500);
        assert_eq!(machine.chip.stores.len(), entered, "BASEPRI {limit:#x}");
    }
}

#[test]
fn a_supervisor_call_returns_to_the_next_instruction() {
    // SVC #1; ADDS R4, #1; loop. In the handler: MRS R5, IPSR.
    let mut machine = machine(&[0xDF01, 0x3401, LOOP], &[(11, &[0xF3EF, 0x8505, RETURN])]);
    run(&mut machine, 100);
    assert_eq!((machine.register(5), machine.register(4), machine.exception()), (11, 1, 0));
}

#[test]
fn a_reset_request_restarts_chip_and_processor() {
    let start = program(&[&[0x3401], &store(0xE000_ED0C, 0x05FA_0004), &[LOOP]]);
    let mut machine = machine(&start, &[]);
    machine.run_until(50).expect("it resets repeatedly");
    assert!(machine.chip.resets > 2);
    assert!(machine.register(4) <= 1);
}

#[test]
fn a_damaged_word_pends_the_nmi_where_it_is_read() {
    // R0 = a constant in flash, LDR R3, [R0]; loop
    let start = program(&[&constant(0, CODE + 0x2000), &[0x6803, LOOP]]);
    let mut machine = machine(&start, &[(2, &[0x3401, RETURN])]);
    machine.memory.damage(CODE + 0x2004);
    run(&mut machine, 100);
    assert_eq!((machine.chip.damaged.as_slice(), machine.register(4)), (&[CODE + 0x2000][..], 1));
}

#[test]
fn an_answered_breakpoint_continues_with_the_answer() {
    let mut machine = machine(&[0xBEAB, 0x3401, LOOP], &[(3, &[LOOP])]);
    machine.chip.answer = Some(7);
    run(&mut machine, 50);
    assert_eq!((machine.register(0), machine.register(4)), (7, 1));
    let mut alone = crate::support::machine(&[0xBEAB], &[(3, &[LOOP])]);
    run(&mut alone, 50);
    assert_eq!((alone.exception(), alone.fault_status().1), (3, 1 << 31));
}

#[test]
fn overwritten_code_is_decoded_again() {
    let mut machine = machine(&[LOOP], &[]);
    let put = |machine: &mut Machine<Part>, halves: [u16; 2]| {
        let bytes: Vec<u8> = halves.iter().flat_map(|half| half.to_le_bytes()).collect();
        machine.memory.get_mut(RAM, 4).expect("the RAM").copy_from_slice(&bytes);
        machine.set_register(15, RAM);
        run(machine, 20);
    };
    put(&mut machine, [0x2401, LOOP]);
    assert_eq!(machine.register(4), 1);
    put(&mut machine, [0x2402, LOOP]);
    assert_eq!(machine.register(4), 2);
    // Overwriting by the program: STRH R0, [R1] over the instruction that follows a branch to it.
    machine.set_register(0, 0x2403);
    machine.set_register(1, RAM);
    let bytes: Vec<u8> = [0x8008u16, 0xE7FB].iter().flat_map(|half| half.to_le_bytes()).collect();
    machine.memory.get_mut(RAM + 4, 4).expect("the RAM").copy_from_slice(&bytes);
    machine.set_register(15, RAM + 4);
    run(&mut machine, 20);
    assert_eq!(machine.register(4), 3);
}

#[test]
fn the_profile_counts_exceptions_and_masked_time() {
    // CPSID I, 20 NOP, CPSIE I
    let start = program(&[&store(ENABLE_LINES, 1), &[0xB672], &[0xBF00; 20], &[0xB662], &[LOOP]]);
    let mut machine = machine(&start, &[(16, &program(&[&acknowledge(), &[RETURN]]))]);
    machine.chip.rises = 100;
    machine.start_profile(None);
    run(&mut machine, 500);
    let profile = machine.take_profile().expect("the profile");
    assert_eq!([machine.take_longest_masked(), machine.take_longest_masked()], [20 + 2, 0]);
    let handled: Vec<_> = profile.handled().collect();
    assert_eq!(handled.len(), 1);
    assert_eq!((handled[0].0, handled[0].1.entries), (16, 1));
    let functions = machine.functions_of(&profile);
    assert_eq!(functions.len(), 1);
    assert!(functions[0].all.instructions > 100 && functions[0].name.is_none());
    assert_eq!(handler(16) & 1, 0);
}

/// Of the only exception, also the cost in its longest execution.
#[test]
fn the_profile_of_one_exception_has_its_longest_execution() {
    let start = program(&[&store(ENABLE_LINES, 1), &[LOOP]]);
    let mut machine = machine(&start, &[(16, &program(&[&acknowledge(), &[RETURN]]))]);
    machine.start_profile(Some(16));
    for rises in [100, 600] {
        machine.chip.rises = rises;
        run(&mut machine, 500);
    }
    let profile = machine.take_profile().expect("the profile");
    let (_, handled) = profile.handled().next().expect("the exception");
    let functions = machine.functions_of(&profile);
    let [function] = &*functions else { panic!("{functions:?}") };
    assert_eq!(handled.entries, 2);
    assert_eq!(2 * function.longest.instructions, function.all.instructions);
    assert!(function.longest.cycles > 0 && function.longest.cycles < handled.longest);
}
