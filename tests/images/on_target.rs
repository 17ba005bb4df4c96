//! Tests of the package `on-target`, each on a processor that QEMU has just reset.
//!
//!     cargo test -p image-scenarios on_target -- --nocapture     # with the name and the output of
//! each test
//!
//! embedded-test stores a list of the tests in the image. The list consists of symbols in the
//! section `.embedded_test`, whose names are JSON, each at the address of the function to run. The
//! processor receives the address as its command line, by semihosting. A test ends with an exit, or
//! with an abort after a panic. Skipped under the same conditions as the
//! [processor in the loop](super::processor_in_the_loop).

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use object::{Object as _, ObjectSection as _, ObjectSymbol as _};
use pil::machine::{ARGUMENTS, NO_SERIAL, PROGRAM, machine};
use pil::test_image;
use serde_json::Value;

use crate::processor_in_the_loop::is_there;

/// Section of the list of tests.
const SECTION: &str = ".embedded_test";
/// Version of the format of the list, and of the protocol.
const VERSION: u32 = 1;
/// Exit code of QEMU after a successful test.
const SUCCESS: i32 = 0;
/// Exit code of QEMU after an abort.
const ABORTED: i32 = 134;
/// Beginning of the semihosting option of the machine, to which a command line is appended.
const SEMIHOSTING: &str = "enable=on";

/// Test of the list.
struct Test {
    name: String,
    should_panic: bool,
    time: Duration,
    /// Address of the function to run.
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

/// Runs one test. Returns the exit status and the output of QEMU.
fn run(image: &Path, test: &Test) -> Output {
    let mut command = Command::new(PROGRAM);
    command.args(["-M", machine(image).expect("the image")]).args(NO_SERIAL);
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
    child.wait_with_output().expect("the output of QEMU")
}

/// Returns an error if a test has not ended as expected.
fn judge(test: &Test, output: &Output) -> Result<(), String> {
    let panicked = String::from_utf8_lossy(&output.stderr).contains("panicked at");
    match (output.status.code(), test.should_panic) {
        (Some(SUCCESS), false) => Ok(()),
        (Some(ABORTED), true) if panicked => Ok(()),
        (Some(SUCCESS), true) => Err("it did not panic".into()),
        (None, _) => Err(format!("not ended after {:?}", test.time)),
        _ => Err(output.status.to_string()),
    }
}

#[test]
fn every_test_on_the_target_passes() {
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

/// A test that fails, that hangs, or that panics unexpectedly is detected.
#[test]
fn a_failed_test_is_detected() {
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
