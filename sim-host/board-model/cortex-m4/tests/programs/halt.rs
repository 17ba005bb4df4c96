//! Actions on the run from outside the program, by a debugger or a fault of the processor.

use crate::support::{PART, Part, RAM, constant, machine, store};
use sonoglide_cortex_m4::Machine;

const LOOP: u16 = 0xE7FE;
const RETURN: u16 = 0x4770;
const ENABLE_LINES: u32 = 0xE000_E100;

fn run(machine: &mut Machine<Part>, cycles: u64) {
    machine.run_until(machine.cycle() + cycles).expect("the program runs");
}

/// Returns a handler that acknowledges the line at the chip through R2, adds one to R5, and
/// returns.
fn handler() -> Vec<u16> {
    [constant(2, PART), vec![0x6012, 0x3501, RETURN]].concat()
}

#[test]
fn a_halted_processor_stops_and_its_clone_continues_equally() {
    // ADDS R4, #1; B back
    let start = [store(ENABLE_LINES, 1), vec![0x3401, 0xE7FD]].concat();
    let mut machine = machine(&start, &[(16, &handler())]);
    run(&mut machine, 100);
    let mut twin = machine.clone();
    let (counted, now) = (machine.register(4), machine.cycle());
    machine.chip.rises = now + 10;
    machine.halt_until(now + 1000).expect("the chip continues");
    assert_eq!((machine.register(4), machine.register(5), machine.cycle()), (counted, 0, now + 1000));
    run(&mut machine, 100);
    assert_eq!(machine.register(5), 1, "the interrupt was pending");
    run(&mut twin, 100);
    assert!(twin.register(4) > counted && twin.register(5) == 0);
}

#[test]
fn masking_blocks_interrupts_and_poke_writes_memory() {
    let start = [store(ENABLE_LINES, 1), vec![LOOP]].concat();
    let mut machine = machine(&start, &[(16, &handler())]);
    run(&mut machine, 100);
    machine.mask_interrupts();
    machine.chip.rises = machine.cycle() + 10;
    run(&mut machine, 1000);
    assert_eq!(machine.register(5), 0);
    machine.poke(RAM + 8, 0x1234_5678).expect("memory");
    assert_eq!(machine.memory.get(RAM + 8, 4), Some(&[0x78, 0x56, 0x34, 0x12][..]));
}
