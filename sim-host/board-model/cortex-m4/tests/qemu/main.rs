//! Comparison with QEMU, bit for bit: random instructions from random states.
//!
//! `CORTEX_M4_CASES` sets the number of cases per class (6000 per run of QEMU); `CORTEX_M4_SEED`
//! sets the seed.

mod cases;
mod encodings;
mod exceptions;
mod image;
mod memory_cases;

use std::path::Path;
use std::process::{Command, Stdio};

use cases::{Case, STATE};
use encodings::{CLASSES, Class};
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use sonoglide_cortex_m4::{Access, Breakpoint, Chip, Cycle, Fault, Machine, Memory, Ports, Region};

/// Chip that has only memory, and ends the run at the first breakpoint.
struct Bare;

impl Chip for Bare {
    fn read(&mut self, _: Access, _: Ports) -> Result<u32, Fault> {
        Err(Fault::Bus)
    }
    fn write(&mut self, _: Access, _: u32, _: Ports) -> Result<(), Fault> {
        Err(Fault::Bus)
    }
    fn due(&self) -> Cycle {
        Cycle::MAX
    }
    fn advance(&mut self, _: Cycle, _: Ports) -> Result<(), Fault> {
        Ok(())
    }
    fn fetch_wait(&mut self, _: u32, _: Cycle) -> u32 {
        0
    }
    fn load_wait(&mut self, _: u32, _: Cycle) -> u32 {
        0
    }
    fn damaged(&mut self, _: u32, _: Ports) -> Result<(), Fault> {
        Ok(())
    }
    fn lockup(&mut self, _: Cycle, _: Ports) -> Result<(), Fault> {
        Err(Fault::Stop("lockup".into()))
    }
    fn breakpoint(&mut self, _: Breakpoint, _: Ports) -> Result<Option<u32>, Fault> {
        Err(Fault::Stop("end".into()))
    }
    fn reset(&mut self, _: Cycle, _: Ports) {}
}

/// Runs the program in the model and returns the states.
fn run_here(image: &[u8], len: usize) -> Vec<u8> {
    let mut memory = Memory::default();
    let mut bytes = image.to_vec();
    bytes.resize(4 << 20, 0);
    memory.add(Region { base: 0, bytes, writable: true, waits: false });
    let mut machine = Machine::from_memory(memory, Bare, 0, 3);
    let stop = machine.run_until(1 << 40).expect_err("the program ends with a breakpoint");
    assert_eq!(stop.finding.to_string(), "end", "{stop}");
    assert_eq!(machine.fault_status(), (0, 0), "no case faults");
    machine.memory.get(image::STATES, len).expect("the states").to_vec()
}

/// Runs the program in QEMU and returns the states.
fn run_there(image: &[u8], name: &str, len: usize) -> Vec<u8> {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.bin"));
    std::fs::write(&file, image).expect("the image is written");
    let output = Command::new("qemu-system-arm")
        .args(["-M", "mps2-an386", "-display", "none", "-monitor", "none", "-serial", "none"])
        .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(&file)
        .stdin(Stdio::null())
        .output()
        .expect("QEMU runs");
    assert_eq!(output.stdout.len(), len, "QEMU did not write the states: {}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.chunks_exact(4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]])).collect()
}

/// Returns the name of a word of the state.
fn name(index: usize) -> String {
    match index {
        0..13 => format!("R{index}"),
        13 => "LR".into(),
        14 => "APSR".into(),
        15 => "FPSCR".into(),
        16..48 => format!("S{}", index - 16),
        _ => format!("memory {}", index - 48),
    }
}

/// Runs cases in both, compares every word, and returns the differences.
fn compare(class: &str, cases: &[Case]) -> Vec<String> {
    let image = image::build(cases);
    let len = cases.len() * STATE;
    let (here, there) = (run_here(&image, len), run_there(&image, class, len));
    let mut differences = Vec::new();
    for (number, case) in cases.iter().enumerate() {
        let range = number * STATE..(number + 1) * STATE;
        let (ours, theirs) = (words(&here[range.clone()]), words(&there[range]));
        let wrong: Vec<_> = (0..STATE / 4).filter(|index| ours[*index] != theirs[*index]).collect();
        if !wrong.is_empty() {
            let words: Vec<_> = wrong
                .iter()
                .map(|index| {
                    format!(
                        "{} {:#010x} -> {:#010x}, QEMU {:#010x}",
                        name(*index),
                        case.state[*index],
                        ours[*index],
                        theirs[*index]
                    )
                })
                .collect();
            differences.push(format!("{class}: {:04x?}, FPSCR {:#010x}: {}", case.code, case.state[15], words.join("; ")));
        }
    }
    differences
}

fn number(variable: &str, default: usize) -> usize {
    std::env::var(variable).ok().map_or(default, |value| value.parse().expect("a number"))
}

fn has_qemu() -> bool {
    let found = Command::new("qemu-system-arm").arg("--version").stdout(Stdio::null()).status().is_ok();
    if !found {
        println!("SKIPPED: qemu-system-arm is not installed");
    }
    found
}

/// Compares the requested number of cases, divided into programs of the maximum size.
fn check(name: &str, mut generate: impl FnMut(u32, &mut Xoshiro256PlusPlus) -> Case) {
    if !has_qemu() {
        return;
    }
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(number("CORTEX_M4_SEED", 1) as u64);
    let total = number("CORTEX_M4_CASES", 2000);
    let mut differences = Vec::new();
    let mut done = 0;
    while done < total {
        let count = (total - done).min(image::CASES);
        let cases: Vec<_> = (0..count).map(|number| generate(image::state_address(number), &mut rng)).collect();
        differences.extend(compare(name, &cases));
        done += count;
    }
    println!("{name}: {total} cases, {} differ", differences.len());
    assert!(
        differences.is_empty(),
        "{} of {total} differ:\n{}",
        differences.len(),
        differences[..differences.len().min(12)].join("\n")
    );
}

fn class(name: &str) -> &'static Class {
    CLASSES.iter().find(|class| class.name == name).expect("a class of this name")
}

/// Checks the named classes in sequence.
fn check_classes(names: &[&str]) {
    for name in names {
        check(name, |_, rng| cases::single(class(name), rng));
    }
}

#[test]
fn data_processing_agrees() {
    check_classes(&[
        "immediate",
        "plain immediate",
        "shifted register",
        "extract",
        "insert",
        "16 bits",
        "compare of high registers",
    ]);
}

#[test]
fn dsp_instructions_agree() {
    check_classes(&["saturate", "extend, reverse, select", "parallel", "saturating add"]);
}

#[test]
fn products_and_quotients_agree() {
    check_classes(&["multiply", "long multiply, divide"]);
}

#[test]
fn floating_point_agrees() {
    check_classes(&["float arithmetic", "float move, compare", "float move of two", "float convert", "float fixed point"]);
}

#[test]
fn it_blocks_agree() {
    let classes = ["16 bits", "shifted register", "immediate"].map(class);
    check("it", |_, rng| cases::it_block(&classes, rng));
}

#[test]
fn branches_agree() {
    check("branch", |_, rng| cases::branch(rng));
}

#[test]
fn loads_and_stores_agree() {
    check("single", memory_cases::single);
    check("narrow", memory_cases::narrow);
    check("several", memory_cases::several);
    check("stack", |_, rng| memory_cases::stack(rng));
    check("float transfer", memory_cases::float);
}

#[test]
fn exceptions_agree() {
    if !has_qemu() {
        return;
    }
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(number("CORTEX_M4_SEED", 1) as u64);
    let mut left = number("CORTEX_M4_CASES", 2000);
    while left > 0 {
        let count = left.min(exceptions::CASES);
        let image = exceptions::build(count, &mut rng);
        let len = count * exceptions::RECORD;
        let (here, there) = (run_here(&image, len), run_there(&image, "exceptions", len));
        for (number, (ours, theirs)) in
            here.chunks_exact(exceptions::RECORD).zip(there.chunks_exact(exceptions::RECORD)).enumerate()
        {
            let (ours, theirs) = (words(ours), words(theirs));
            let differences: Vec<_> = (0..ours.len()).filter(|word| ours[*word] != theirs[*word]).collect();
            let shown =
                differences.iter().map(|word| format!("word {word}: {:#010x}, QEMU {:#010x}", ours[*word], theirs[*word]));
            assert!(differences.is_empty(), "case {number}:\n{}", shown.collect::<Vec<_>>().join("\n"));
        }
        // R14 in the handler: each type of return must occur.
        let links: std::collections::BTreeSet<_> = here.chunks_exact(exceptions::RECORD).map(|record| words(record)[0]).collect();
        assert!(count < 200 || links.len() >= 5, "{links:08x?}");
        left -= count;
    }
}
