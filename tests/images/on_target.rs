//! The tests of the package `on-target`, each in a processor of its own that QEMU has just reset.
//!
//!     cargo test -p image-scenarios on_target -- --nocapture     # with each test's name, and what it says
//!
//! embedded-test leaves a list of the tests in the image: in the section `.embedded_test`, symbols whose names are JSON, each at the address of
//! the function to be run. The processor receives the function's name as its command line, by semihosting; it ends by an exit, or by an abort,
//! which is a panic. Skipped as the [processor in the loop](super::processor_in_the_loop) is.

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use object::{Object as _, ObjectSection as _, ObjectSymbol as _};
use pil::machine::{ARGUMENTS, NO_SERIAL, PROGRAM};
use pil::test_image;
use serde_json::Value;

use crate::processor_in_the_loop::is_there;

/// Where the list of tests is.
const SECTION: &str = ".embedded_test";
/// Version of the list's format, and of the protocol.
const VERSION: u32 = 1;
/// What QEMU ends with after a test that was fine, and after an abort.
const FINE: i32 = 0;
const ABORTED: i32 = 134;
/// What the machine's option for semihosting begins with; a command line goes behind.
const SEMIHOSTING: &str = "enable=on";

/// A test of the list.
struct Test {
    name: String,
    should_panic: bool,
    time: Duration,
    /// The function to be run.
    address: u32,
}

fn tests(image: &[u8]) -> Vec<Test> {
    let file = object::File::parse(image).expect("an ELF file");
    let section = file.section_by_name(SECTION).expect("a list of tests");
    let list = section.data().expect("its bytes");
    let word = |symbol: &object::Symbol| {
        let at = (symbol.address() - section.address()) as usize;
        u32::from_le_bytes(list[at..at + 4].try_into().expect("four bytes"))
    };
    let named = |name: &str| file.symbols().find(|symbol| symbol.name() == Ok(name));
    assert_eq!(named("EMBEDDED_TEST_VERSION").map(|symbol| word(&symbol)), Some(VERSION));
    let test = |symbol: object::Symbol| {
        let about: Value = serde_json::from_str(symbol.name().ok()?).ok()?;
        Some(Test {
            name: about["name"].as_str()?.to_owned(),
            should_panic: about["should_panic"].as_bool()?,
            time: Duration::from_secs(about["timeout"].as_u64()?),
            address: word(&symbol),
        })
    };
    file.symbols().filter_map(test).collect()
}

/// Runs one test; what QEMU ended with, and what was said on the way.
fn run(image: &Path, test: &Test) -> Output {
    let mut command = Command::new(PROGRAM);
    command.args(NO_SERIAL);
    for argument in ARGUMENTS {
        let line = format!("{argument},arg=run_addr,arg={}", test.address);
        command.arg(if argument.starts_with(SEMIHOSTING) { &line } else { argument });
    }
    let mut child =
        command.arg(image).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("QEMU starts");
    let until = Instant::now() + test.time;
    while child.try_wait().expect("QEMU").is_none() {
        if Instant::now() > until {
            child.kill().expect("QEMU ends");
            break;
        }
        thread::sleep(Duration::from_millis(2));
    }
    child.wait_with_output().expect("what QEMU has said")
}

/// What is wrong with how it ended; nothing if it is fine.
fn judge(test: &Test, output: &Output) -> Result<(), String> {
    let panicked = String::from_utf8_lossy(&output.stderr).contains("panicked at");
    match (output.status.code(), test.should_panic) {
        (Some(FINE), false) => Ok(()),
        (Some(ABORTED), true) if panicked => Ok(()),
        (Some(FINE), true) => Err("it did not panic".into()),
        (None, _) => Err(format!("not ended after {:?}", test.time)),
        _ => Err(output.status.to_string()),
    }
}

#[test]
fn every_test_on_the_target_is_passed() {
    if !is_there("tests on the target") {
        return;
    }
    let image = test_image().expect("the tests build");
    let tests = tests(&std::fs::read(&image).expect("the image"));
    assert!(tests.len() >= 8 && tests.iter().any(|test| test.should_panic), "{} tests", tests.len());
    let mut failed = Vec::new();
    for test in &tests {
        let output = run(&image, test);
        let verdict = judge(test, &output);
        let words =
            [&output.stdout[..], &output.stderr[..]].map(|bytes| String::from_utf8_lossy(bytes).trim().replace('\n', " "));
        let ended = verdict.as_ref().map_or_else(|why| format!("FAILED ({why})"), |()| "ok".to_owned());
        println!("on target: {} ... {ended}  {}", test.name, words.join(" "));
        failed.extend(verdict.is_err().then_some(&test.name));
    }
    assert!(failed.is_empty(), "{failed:?}");
}

/// A test that fails, that hangs, or that panics where it must not, is seen.
#[test]
fn a_test_that_is_not_passed_is_seen() {
    if !is_there("tests on the target") {
        return;
    }
    let image = test_image().expect("the tests build");
    let tests = tests(&std::fs::read(&image).expect("the image"));
    let find = |name: &str| tests.iter().find(|test| test.name == name).expect("a test");
    let (panics, fine) = (find("a_panic_is_seen"), find("the_controller_builds_and_plays_silence"));
    let judged = |test: &Test, of: &Test| judge(&Test { name: String::new(), ..*test }, &run(&image, of));
    assert_eq!(judged(&Test { should_panic: false, name: String::new(), ..*panics }, panics), Err("exit status: 134".into()));
    assert_eq!(judged(panics, fine), Err("it did not panic".into()));
    let hasty = Test { time: Duration::ZERO, name: String::new(), ..*fine };
    assert_eq!(judge(&hasty, &run(&image, &hasty)), Err("not ended after 0ns".into()));
}
