//! Instructions per second on a loop of typical code:
//! `cargo run --release -p sonoglide-cortex-m4 --example speed`.

#[path = "../tests/programs/support.rs"]
#[expect(dead_code, reason = "shared with the tests")]
mod support;

use std::time::Instant;

/// Loop with loads of halfwords, a multiply-accumulate, floating point, stores, an IT block and a
/// call:
///
/// ```text
///       cpsid i
/// loop: ldrsh r4, [r0], #2        lsrs  r3, r7, #3            bl   function
///       ldrsh r5, [r1], #2        eor.w r3, r3, r6, lsl #2    b    loop
///       smlabb r6, r4, r5, r6     cmp   r3, r7
///       vldr  s0, [r2]            it    hi                  function:
///       vmul.f32 s1, s0, s2       addhi r8, r8, #1            push {r4, lr}
///       vadd.f32 s3, s3, s1       cbz   r5, skip              ubfx r4, r6, #3, #5
///       vstr  s3, [r2, #4]        ldr   r9, [r2, #12]         muls r3, r4, r3
///       str   r6, [r2, #8]        add   r9, r3                pop  {r4, pc}
///       bic   r0, r0, #256  skip:
///       bic   r1, r1, #256
///       adds  r7, r7, #1
/// ```
const LOOP: [u16; 40] = [
    0xB672, 0xF930, 0x4B02, 0xF931, 0x5B02, 0xFB14, 0x6605, 0xED92, 0x0A00, 0xEE60, 0x0A01, 0xEE71, 0x1AA0, 0xEDC2, 0x1A01,
    0x6096, 0xF420, 0x7080, 0xF421, 0x7180, 0x1C7F, 0x08FB, 0xEA83, 0x0386, 0x42BB, 0xBF88, 0xF108, 0x0801, 0xB115, 0xF8D2,
    0x900C, 0x4499, 0xF000, 0xF801, 0xE7DD, 0xB510, 0xF3C6, 0x04C4, 0x4363, 0xBD10,
];

fn main() {
    // Enables the FPU in CPACR.
    let start = [0xF64E, 0x5088, 0xF2CE, 0x0000, 0xF44F, 0x0170, 0x6001];
    let mut machine = support::machine(&[&start[..], &LOOP].concat(), &[]);
    machine.run_until(5).expect("the start runs");
    for (register, value) in [(0, 0x2000_1000), (1, 0x2000_2000), (2, 0x2000_3000)] {
        machine.set_register(register, value);
    }
    for wait in [0, 4] {
        machine.chip.waits = (wait, wait);
        let (before, begin) = (machine.instructions(), Instant::now());
        let cycles = machine.cycle();
        machine.run_until(cycles + 1_000_000_000).expect("the loop runs");
        let (instructions, cycles) = ((machine.instructions() - before) as f64, (machine.cycle() - cycles) as f64);
        let rate = instructions / begin.elapsed().as_secs_f64() * 1e-6;
        println!(
            "{wait} wait states: {rate:.0} million instructions per second, {:.2} cycles per instruction",
            cycles / instructions
        );
    }
}
