//! Embench, CoreMark and Dhrystone 2.1 on the model of the STM32G474, compared with published
//! results to validate its cycles.
//!
//! ```text
//! cargo run --release -p sonoglide-stm32g474 --example benchmarks -- --embench DIR --coremark DIR --dhrystone DIR
//! ```
//!
//! The sources are not part of this repository: each `DIR` is a checkout of `embench/embench-iot`,
//! `eembc/coremark`, or `sifive/benchmark-dhrystone` (Weicker's K&R text of version 2.1). They are
//! built with `arm-none-eabi-gcc` and the port in this folder, run to their end, and must pass
//! their own checks: Embench's results, CoreMark's check sums, and the values that Dhrystone prints
//! for its variables.
//!
//! The baseline of Embench comes from its checkout. That of commit 3ef636f was made with GCC 13.2
//! (according to the following commit), that of tag `embench-1.0` with GCC 9.2. Both were measured
//! with the cycle counter of an STM32F407 at 16 MHz, without wait states of the flash.

mod compile;
mod embench;
mod hosted;

use std::path::{Path, PathBuf};

use compile::Program;
use cortex_m4::Timing;
use hosted::Flash;

type Error = Box<dyn std::error::Error>;

/// Settings of the flash: without wait states, as at the 16 MHz after a reset; and with the four of
/// 170 MHz, with prefetch and caches (as on the board), with caches only, and with neither.
const FLASHES: [Flash; 4] = [
    Flash { name: "no wait states", control: 0x0004_0600 },
    Flash { name: "4, prefetch, caches", control: 0x0004_0704 },
    Flash { name: "4, caches", control: 0x0004_0604 },
    Flash { name: "4, nothing", control: 0x0004_0004 },
];

/// Compiler flags for CoreMark.
const COREMARK: [&str; 4] = ["-Os", "-O2", "-O3", "-O3 -funroll-loops"];

/// Compiler flags for Dhrystone: by its rules, with inlined functions, and with both files compiled
/// as one.
const DHRYSTONE: [&str; 3] = ["-O2 -fno-inline -fno-ipa-cp -fno-ipa-sra", "-O3", "-O3 -flto"];

/// Dhrystones per second of a VAX-11/780.
const VAX: f64 = 1757.0;

fn main() -> Result<(), Error> {
    println!("{}\n", compile::compiler()?);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let folder = PathBuf::from(arguments.next().ok_or_else(|| format!("{argument} needs a folder"))?);
        match argument.as_str() {
            "--coremark" => {
                let names = ["core_main.c", "core_list_join.c", "core_matrix.c", "core_state.c", "core_util.c"];
                let program = program("CoreMark", &folder, &names, "coremark.c", &["-DITERATIONS=40", "-DPERFORMANCE_RUN=1"]);
                measure(&program, &COREMARK, |cycles| 1e6 / cycles, check_coremark)?;
            }
            "--dhrystone" => {
                let names = ["dhry_1.c", "dhry_2.c"];
                let program = program("Dhrystone", &folder, &names, "dhrystone.c", &["-DTIME", "-DDHRY_ITERS=20000"]);
                measure(&program, &DHRYSTONE, |cycles| 1e6 / cycles / VAX, check_dhrystone)?;
            }
            "--embench" => embench::measure(&folder)?,
            _ => return Err(format!("unknown option {argument}: use --coremark, --dhrystone or --embench").into()),
        }
        println!();
    }
    Ok(())
}

fn program(name: &str, folder: &Path, names: &[&str], port: &'static str, defines: &'static [&'static str]) -> Program {
    let sources = names.iter().map(|name| folder.join(name)).collect();
    Program { name: name.to_owned(), sources, headers: folder.to_owned(), port, defines }
}

/// Prints a row for each set of flags and each setting of the flash.
fn measure(
    program: &Program,
    flags: &[&str],
    score: impl Fn(f64) -> f64,
    check: impl Fn(&str) -> Result<(), Error>,
) -> Result<(), Error> {
    println!("| {}, flags | flash | cycles per iteration | per instruction | score per MHz | longest |", program.name);
    println!("|---|---|---|---|---|---|");
    for flags in flags {
        let elf = compile::build(program, flags)?;
        for flash in FLASHES {
            let run = |timing| -> Result<(f64, f64), Error> {
                let run = hosted::run(&elf, flash, timing)?;
                check(&run.text)?;
                Ok((cycles_of_iteration(&run.text)?, run.cycles_per_instruction))
            };
            let ((usual, each), (longest, _)) = (run(Timing::Usual)?, run(Timing::Longest)?);
            let scores = format!("{:.3} | {:.3}", score(usual), score(longest));
            println!("| `{flags}` | {} | {usual:.0} | {each:.3} | {scores} |", flash.name);
        }
    }
    Ok(())
}

/// Parses the line `MEASURED n cycles of m iterations` of the port.
fn cycles_of_iteration(text: &str) -> Result<f64, Error> {
    let line = text.lines().find_map(|line| line.strip_prefix("MEASURED ")).ok_or("the program reports no cycles")?;
    let numbers: Vec<f64> = line.split(' ').filter_map(|word| word.parse().ok()).collect();
    match numbers[..] {
        [cycles, iterations] => Ok(cycles / iterations),
        _ => Err(format!("unexpected: {line}").into()),
    }
}

fn check_coremark(text: &str) -> Result<(), Error> {
    let valid = text.contains("2K performance run parameters") && text.contains("Correct operation validated.");
    if valid { Ok(()) } else { Err(format!("CoreMark reports errors:\n{text}").into()) }
}

/// Checks that each line `name: value` equals its line `should be: value`; a few of these are
/// words.
fn check_dhrystone(text: &str) -> Result<(), Error> {
    let value = |line: &str| line.split_once(':').map(|(_, value)| value.trim().to_owned()).unwrap_or_default();
    let lines: Vec<&str> = text.lines().collect();
    let mut checked = 0;
    for pair in lines.windows(2).filter(|pair| pair[1].trim_start().starts_with("should be:")) {
        let expected = match value(pair[1]).as_str() {
            "Number_Of_Runs + 10" => "20010".to_owned(),
            words if words.starts_with("(implementation-dependent)") => continue,
            other => other.to_owned(),
        };
        if value(pair[0]) != expected {
            return Err(format!("Dhrystone: {} should be {expected}", pair[0].trim()).into());
        }
        checked += 1;
    }
    if checked == 20 { Ok(()) } else { Err(format!("Dhrystone: {checked} values checked\n{text}").into()) }
}
