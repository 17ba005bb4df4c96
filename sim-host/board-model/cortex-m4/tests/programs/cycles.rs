//! Cycles of short kernels, compared with ARM DDI 0439 (section 3.3, table 7-1).

use sonoglide_cortex_m4::Timing::{self, Longest, Usual};

use crate::support::{RAM, machine};

/// Returns the cycles of `kernel` between two `NOP`s, without wait states. R1 to R7 point into the
/// RAM.
fn cycles(kernel: &[u16]) -> u64 {
    cycles_of(Longest, kernel)
}

fn cycles_of(timing: Timing, kernel: &[u16]) -> u64 {
    let nops = [0xBF00; 2];
    let code = [&nops[..], kernel, &nops].concat();
    let mut machine = machine(&code, &[(3, &[0xE7FE])]);
    machine.set_timing(timing);
    for register in 1..8 {
        machine.set_register(register, RAM + 64 * u32::from(register));
    }
    // Each word of the RAM contains an address in the RAM.
    for word in machine.memory.get_mut(RAM, 0x1000).expect("the RAM").chunks_exact_mut(4) {
        word.copy_from_slice(&RAM.to_le_bytes());
    }
    machine.set_register(0, 3);
    let end = machine.register(15) + 2 * (2 + kernel.len() as u32);
    machine.step(u64::MAX).expect("a NOP");
    machine.step(u64::MAX).expect("a NOP");
    let before = machine.cycle();
    while machine.register(15) != end {
        machine.step(u64::MAX).expect("the kernel");
        assert!(machine.exception() == 0 && machine.cycle() < 10_000, "the kernel ends");
    }
    machine.cycle() - before
}

#[test]
fn loads_in_a_row_are_pipelined() {
    // "LDR R0,[R1]; LDR R1,[R2] - normally three cycles total"
    assert_eq!(cycles(&[0x6808, 0x6811]), 3);
    // "LDR R0,[R1,R5]; LDR R1,[R2]; LDR R2,[R3,#4] - normally four cycles total", without the
    // register offset.
    assert_eq!(cycles(&[0x6808, 0x6811, 0x685A]), 4);
    // LDR R2, [R1]; LDR R0, [R2]: the result of the first is the address of the second.
    assert_eq!(cycles(&[0x680A, 0x6810]), 4);
    // The same two loads with a NOP between them.
    assert_eq!(cycles(&[0x6808, 0xBF00, 0x6811]), 2 + 1 + 2);
}

#[test]
fn a_slower_clock_does_not_change_cycles() {
    // LDR R0, [R1]; LDR R4, [R2], eight times, at an eighth of the time: still pipelined.
    let loads = [0x6808, 0x6814].repeat(8);
    let mut machine = machine(&[&[0xBF00; 2][..], &loads].concat(), &[]);
    for register in [1, 2] {
        machine.set_register(register, RAM);
    }
    // No exception is watched, so the rate applies to the thread.
    machine.set_rate(0.125);
    for _ in 0..2 + loads.len() {
        machine.step(u64::MAX).expect("the program");
    }
    assert_eq!(machine.cycle(), (2 + 2 + 15) / 8);
}

#[test]
fn time_can_be_counted_in_instructions() {
    // LDR; UDIV; B to the next instruction; two NOPs
    let kernel = [0x6810, 0xFBB1, 0xF0F2, 0xE7FF, 0xBF00, 0xBF00];
    assert_eq!(cycles_of(Timing::Instructions, &kernel), 5);
    // SysTick with 21 counts in 125 cycles: reload, enable, 250 NOPs, its count to R3.
    let store = crate::support::store;
    let start = [store(0xE000_E014, 999), store(0xE000_E018, 0), store(0xE000_E010, 5)].concat();
    let nops = 250;
    let read = [crate::support::constant(0, 0xE000_E018), vec![0x6803]].concat();
    let mut machine = machine(&[start, vec![0xBF00; nops], read].concat(), &[]);
    machine.set_timing(Timing::Instructions);
    machine.set_systick_clock(21, 125);
    for _ in 0..3 * 5 + nops + 3 {
        machine.step(u64::MAX).expect("the program");
    }
    // Between the store and the load are the NOPs and the constant.
    assert_eq!(machine.register(3), 1000 - (250 + 3) * 21 / 125);
}

#[test]
fn a_store_takes_one_cycle_and_ends_pipelining() {
    // STR R0, [R1]
    assert_eq!(cycles(&[0x6008]), 1);
    // LDR; STR; LDR
    assert_eq!(cycles(&[0x6810, 0x6008, 0x6818]), 2 + 1 + 2);
}

#[test]
fn a_just_computed_address_takes_a_cycle() {
    // ADDS R1, #4; LDR R0, [R1]
    assert_eq!(cycles(&[0x3104, 0x6808]), 1 + 3);
    // with an instruction between
    assert_eq!(cycles(&[0x3104, 0xBF00, 0x6808]), 1 + 1 + 2);
}

#[test]
fn several_words_take_one_cycle_more_than_their_number() {
    // LDM R1!, {R2-R5}; PUSH, POP of two; LDRD R4, R5, [R2]
    assert_eq!(cycles(&[0xC93C]), 5);
    assert_eq!(cycles(&[0xB430, 0xBC30]), 3 + 3);
    assert_eq!(cycles(&[0xE9D2, 0x4500]), 3);
}

#[test]
fn products_take_one_cycle_and_quotients_twelve() {
    // SMLABB, UMULL, MLA; UDIV
    assert_eq!(cycles(&[0xFB11, 0x3002, 0xFBA2, 0x0103, 0xFB01, 0x3002]), 3);
    assert_eq!(cycles(&[0xFBB1, 0xF0F2]), 12);
}

#[test]
fn each_iteration_but_the_last_adds_the_refill() {
    // SUBS R0, #1; BNE: three iterations
    assert_eq!(cycles(&[0x3801, 0xD1FD]), 3 + 2 * 4 + 1);
    assert_eq!(cycles_of(Usual, &[0x3801, 0xD1FD]), 3 + 2 * 2 + 1);
}

#[test]
fn the_refill_depends_on_the_target() {
    let cycles = [Usual, Longest].map(|timing| move |kernel: &[u16]| cycles_of(timing, kernel));
    let both = |kernel: &[u16]| cycles.map(|cycles| cycles(kernel));
    // B over a NOP, to NOP
    assert_eq!(both(&[0xE000, 0xBF00, 0xBF00]), [2 + 1, 4 + 1]);
    // to a 32-bit MOV that is aligned, and to one that is not
    assert_eq!(both(&[0xE000, 0xBF00, 0xF04F, 0x0400]), [2 + 1, 4 + 1]);
    assert_eq!(both(&[0xE7FF, 0xF04F, 0x0400]), [2 + 2, 4 + 1]);
    // BL to a BX LR, and over it by B
    assert_eq!(both(&[0xF000, 0xF801, 0xE000, 0x4770]), [2 + 3 + 2, 4 + 4 + 4]);
    // ADR R4, the last NOP; PUSH {R4}; POP {PC} of an odd address
    assert_eq!(both(&[0xA401, 0x3401, 0xB410, 0xBD00, 0xBF00]), [1 + 1 + 2 + 5 + 1; 2]);
}

#[test]
fn the_third_unaligned_wide_instruction_waits() {
    let cycles = |timing, aligned: bool, count: usize| {
        let nop = if aligned { &[][..] } else { &[0xBF00] };
        // MOV.W R4, #0
        cycles_of(timing, &[nop, &[0xF04F, 0x0400].repeat(count)].concat()) - nop.len() as u64
    };
    assert_eq!([1, 2, 3, 4, 6].map(|count| cycles(Usual, true, count)), [1, 2, 3, 4, 6]);
    assert_eq!([1, 2, 3, 4, 6].map(|count| cycles(Usual, false, count)), [1, 2, 4, 5, 7]);
    assert_eq!([1, 2, 3, 4, 6].map(|count| cycles(Longest, false, count)), [1, 2, 4, 5, 7]);
    // NOP; MOV.W R4, #0, four times; STR.W R4, [R1], twice; MOV.W R4, #0
    let mixed = [&[0xBF00][..], &[0xF04F, 0x0400].repeat(4), &[0xF8C1, 0x4000].repeat(2), &[0xF04F, 0x0400]].concat();
    assert_eq!([Usual, Longest].map(|timing| cycles_of(timing, &mixed)), [1 + 7 + 1, 1 + 7 + 3]);
}

#[test]
fn a_load_relative_to_the_pc_may_wait_for_the_fetch() {
    // LDR R4, [PC]; LDR R5, [PC]; LDR R6, [R1]
    let loads = [0x4C00, 0x4D00, 0x680E];
    assert_eq!(cycles_of(Usual, &loads), 2 + 1 + 1);
    assert_eq!(cycles_of(Longest, &loads), 3 + 3 + 1);
    // VLDR S0, [PC], with the FPU on
    let start = crate::support::store(0xE000_ED88, 0xF0_0000);
    let cost = |timing| cycles_of(timing, &[&start[..], &[0xED9F, 0x0A00]].concat()) - cycles_of(timing, &start);
    assert_eq!((cost(Usual), cost(Longest)), (2, 3));
}

#[test]
fn floating_point_takes_the_manuals_cycles() {
    // CPACR
    let start = |kernel: &[u16]| cycles(&[crate::support::store(0xE000_ED88, 0xF0_0000), kernel.to_vec()].concat());
    let base = start(&[]);
    // VMUL; VFMA; VDIV; VSQRT of independent registers
    assert_eq!(start(&[0xEE20, 0x0A81]) - base, 1);
    assert_eq!(start(&[0xEEA0, 0x0A81]) - base, 3);
    assert_eq!(start(&[0xEE80, 0x0A81]) - base, 14);
    assert_eq!(start(&[0xEEB1, 0x0AC0]) - base, 14);
    // VMUL S0, S1, S2; VMUL S1, S0, S0 waits for the first.
    assert_eq!(start(&[0xEE20, 0x0A81, 0xEE60, 0x0A00]) - base, 3);
    // VLDM R2, {S0-S7}: one cycle more than words
    assert_eq!(start(&[0xEC92, 0x0A08]) - base, 9);
}

#[test]
fn registers_have_their_own_wait_states() {
    // LDR R0, [R1]; STR R0, [R1] of a register of the chip
    let mut machine = machine(&[0x6808, 0x6008], &[]);
    machine.chip.register_wait = 2;
    machine.set_register(1, crate::support::PART + 8);
    machine.step(u64::MAX).expect("the load");
    assert_eq!(machine.cycle(), 2 + 2);
    machine.step(u64::MAX).expect("the store");
    assert_eq!(machine.cycle(), 4 + 1 + 2);
}

#[test]
fn other_masters_delay_only_the_longest_timing() {
    for (timing, cycles) in [(Usual, 2), (Longest, 2 + 5)] {
        let mut machine = machine(&[0xBF00; 2], &[]);
        machine.set_timing(timing);
        machine.step(u64::MAX).expect("a NOP");
        machine.chip.held_up = 5;
        machine.step(u64::MAX).expect("a NOP");
        assert_eq!(machine.cycle(), cycles);
        assert_eq!(machine.chip.held_up, 0, "the delay is read with any timing");
    }
}

#[test]
fn each_group_of_eight_bytes_has_wait_states() {
    let mut machine = machine(&[0xBF00; 64], &[]);
    machine.chip.waits = (4, 0);
    let (cycle, instructions) = (machine.cycle(), 32);
    for _ in 0..instructions {
        machine.step(u64::MAX).expect("a NOP");
    }
    assert_eq!(machine.cycle() - cycle, instructions + 4 * instructions / 4);
}
