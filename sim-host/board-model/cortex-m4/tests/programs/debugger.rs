//! Actions of a debugger: breakpoints, steps, halts.

use std::collections::BTreeSet;

use crate::support::{CODE, PART, Part, constant, handler, machine, store};
use sonoglide_cortex_m4::{BreakpointInstruction, Ended, Machine};

/// `ADDS R4, #1`, and a branch back to it.
const COUNT: [u16; 2] = [0x3401, 0xE7FD];
const RETURN: u16 = 0x4770;
const ENABLE_LINES: u32 = 0xE000_E100;
const LINE_0: u16 = 16;

/// Returns the address of an instruction of the program, from the number of halfwords before it.
fn at(halves: usize) -> u32 {
    CODE + 0x1000 + 2 * halves as u32
}

/// Returns a machine that enables line 0 and then counts in R4, and the address of the count. The
/// handler acknowledges the line through R2 and adds one to R5.
fn counting() -> (Machine<Part>, u32) {
    let start = store(ENABLE_LINES, 1);
    let count = at(start.len());
    let body = [constant(2, PART), vec![0x6012, 0x3501, RETURN]].concat();
    (machine(&[start, COUNT.to_vec()].concat(), &[(LINE_0.into(), &body)]), count)
}

fn run_to(machine: &mut Machine<Part>, cycles: u64, addresses: &[u32]) -> Ended {
    let addresses: BTreeSet<u32> = addresses.iter().copied().collect();
    machine.run_to(machine.cycle() + cycles, &addresses).expect("the program runs")
}

fn step(machine: &mut Machine<Part>) {
    machine.step_over(machine.cycle() + 1000).expect("the program runs");
}

#[test]
fn a_run_ends_before_the_instruction_at_a_breakpoint() {
    let (mut machine, count) = counting();
    assert_eq!(run_to(&mut machine, 1000, &[count]), Ended::Breakpoint);
    assert_eq!((machine.register(15), machine.register(4)), (count, 0));
    // The run stays there until the instruction is stepped over; the loop then returns to it.
    assert_eq!(run_to(&mut machine, 1000, &[count]), Ended::Breakpoint);
    assert_eq!(machine.register(4), 0);
    step(&mut machine);
    assert_eq!((machine.register(15), machine.register(4)), (count + 2, 1));
    assert_eq!(run_to(&mut machine, 1000, &[count]), Ended::Breakpoint);
    assert_eq!((machine.register(15), machine.register(4)), (count, 1));
    let until = machine.cycle() + 1000;
    assert_eq!(run_to(&mut machine, 1000, &[count + 64]), Ended::Time);
    assert!((until..until + 8).contains(&machine.cycle()), "{} and {until}", machine.cycle());
}

#[test]
fn a_run_with_breakpoints_equals_one_without() {
    let (mut plain, _) = counting();
    let (mut watched, _) = counting();
    for machine in [&mut plain, &mut watched] {
        machine.chip.rises = 100;
    }
    plain.run_until(2000).expect("the program runs");
    assert_eq!(run_to(&mut watched, 2000, &[CODE]), Ended::Time);
    let state = |machine: &Machine<Part>| (machine.cycle(), machine.instructions(), machine.register(4), machine.register(5));
    assert_eq!(state(&plain), state(&watched));
    assert_eq!(plain.register(5), 1);
}

#[test]
fn a_watched_exception_and_a_breakpoint_in_it_both_end_a_run() {
    let (mut machine, _) = counting();
    machine.watch(Some(LINE_0));
    machine.chip.rises = 200;
    let first = handler(LINE_0.into());
    assert!(matches!(run_to(&mut machine, 1000, &[first]), Ended::Passage(passage) if passage.entered));
    assert_eq!(run_to(&mut machine, 1000, &[first]), Ended::Breakpoint);
    assert_eq!((machine.register(15), machine.exception()), (first, LINE_0));
    // The first instruction of the handler, and its return.
    step(&mut machine);
    assert_eq!(machine.register(15), first + 4);
    assert!(matches!(run_to(&mut machine, 1000, &[first]), Ended::Passage(passage) if !passage.entered));
}

#[test]
fn a_pending_interrupt_waits_for_a_step_and_enters_in_a_run() {
    let (mut machine, count) = counting();
    assert_eq!(run_to(&mut machine, 1000, &[count]), Ended::Breakpoint);
    machine.chip.rises = machine.cycle();
    for stepped in 1..20 {
        step(&mut machine);
        step(&mut machine);
        assert_eq!((machine.register(15), machine.register(4), machine.exception()), (count, stepped, 0));
    }
    assert_eq!(run_to(&mut machine, 1000, &[handler(LINE_0.into())]), Ended::Breakpoint);
    assert_eq!(machine.exception(), LINE_0);
    assert_eq!(run_to(&mut machine, 1000, &[count]), Ended::Breakpoint);
    assert_eq!((machine.register(5), machine.exception()), (1, 0));
}

#[test]
fn a_step_returns_from_a_handler_and_does_not_enter_the_next() {
    let (mut machine, count) = counting();
    assert_eq!(run_to(&mut machine, 1000, &[count]), Ended::Breakpoint);
    // The line stays high: it pends again at the return.
    machine.chip.rises = machine.cycle();
    let leaves = handler(LINE_0.into()) + 12;
    assert_eq!(run_to(&mut machine, 1000, &[leaves]), Ended::Breakpoint);
    machine.chip.rises = machine.cycle();
    step(&mut machine);
    assert_eq!((machine.register(15), machine.exception()), (count, 0));
}

#[test]
fn a_breakpoint_instruction_halts_only_with_a_debugger() {
    // MOVS R4, #1; BKPT #3; MOVS R4, #2; B to itself
    let start = [0x2401, 0xBE03, 0x2402, 0xE7FE];
    let mut alone = machine(&start, &[(3, &[0xE7FE])]);
    alone.run_until(200).expect("the program runs");
    assert_eq!((alone.exception(), alone.register(4)), (3, 1), "a hard fault");

    let mut machine = machine(&start, &[]);
    machine.attach_debugger(true);
    for _ in 0..2 {
        let stop = machine.run_to(200, &BTreeSet::new()).expect_err("it halts");
        assert!(stop.finding.is::<BreakpointInstruction>(), "{stop}");
        assert_eq!((machine.register(15), machine.register(4), machine.exception()), (at(1), 1, 0));
    }
    assert!(machine.skip_breakpoint() && !machine.skip_breakpoint());
    assert_eq!(run_to(&mut machine, 200, &[]), Ended::Time);
    assert_eq!((machine.register(15), machine.register(4)), (at(3), 2));
}

#[test]
fn the_chip_runs_and_counters_stop_during_a_halt() {
    // TRCENA, CYCCNTENA, and SysTick with the core clock and without its exception.
    let enable = [
        store(0xE000_EDFC, 1 << 24),
        store(0xE000_1000, 1),
        store(0xE000_E014, 0xFFFF),
        store(0xE000_E018, 0),
        store(0xE000_E010, 5),
        store(ENABLE_LINES, 1),
    ]
    .concat();
    let count = at(enable.len());
    let body = [constant(2, PART), vec![0x6012, 0x3501, RETURN]].concat();
    let mut machine = machine(&[enable, COUNT.to_vec()].concat(), &[(LINE_0.into(), &body)]);
    assert_eq!(run_to(&mut machine, 1000, &[count]), Ended::Breakpoint);
    let counters = |machine: &mut Machine<Part>| [0xE000_1004, 0xE000_E018].map(|address| machine.processor_register(address));
    let (before, now) = (counters(&mut machine), machine.cycle());
    assert!(before.iter().all(|count| count.is_some_and(|count| count > 0)), "{before:?}");
    machine.chip.rises = now + 10;
    machine.halt_until(now + 1000).expect("no finding");
    assert_eq!((machine.cycle(), machine.register(15), machine.exception()), (now + 1000, count, 0));
    assert_eq!(counters(&mut machine), before);
    assert_eq!(machine.chip.rises, u64::MAX, "the line has risen");
    // The interrupt is pending, and both counters continue from their values.
    assert_eq!(run_to(&mut machine, 1000, &[handler(LINE_0.into())]), Ended::Breakpoint);
    let ran = (machine.cycle() - now - 1000) as u32;
    let after = counters(&mut machine);
    assert_eq!(after[0].zip(before[0]).map(|(after, before)| after - before), Some(ran));
    assert_eq!(after[1].zip(before[1]).map(|(after, before)| before - after), Some(ran));
    assert_eq!((machine.processor_register(0xE000_E010), machine.processor_register(0x4000_0000)), (None, None));
}
