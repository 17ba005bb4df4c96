//! The image: receives a configuration, then answers questions until the host closes its pipe.
//!
//! | exit code | meaning |
//! |---|---|
//! | 0 | the host has closed its pipe |
//! | 1 | the pipes are missing, or a record could not be read |
//! | 101 | a panic; its message is on standard error |
//! | 102 | a hard fault; its message is on standard error |
//!
//! The controller and the records are in static memory, as on a board. The measured stack is then
//! that of `process`; the code around it uses less.

use core::mem::MaybeUninit;

// Provides the critical section.
use cortex_m as _;
use cortex_m::singleton;
use cortex_m_rt::entry;
use firmware::board::lockstep::{Answer, Closing, Opening, Question};
use firmware::controller::Controller;
use qemu_m4::counter::Counter;
use qemu_m4::pipes::{Pipes, configuration, read, reason};
use qemu_m4::stack;
use semihosting::{eprintln, process};

const STARTED_TWICE: &str = "started twice";

#[entry]
fn main() -> ! {
    match serve() {
        Ok(()) => process::exit(0),
        Err(trouble) => {
            eprintln!("{trouble}");
            process::exit(1)
        }
    }
}

/// Builds the controller and runs it, one block per question.
fn serve() -> Result<(), &'static str> {
    stack::paint();
    let pipes = Pipes::open()?;
    let Some(controller) = open(pipes)? else { return Ok(()) };
    let stack_power_up_bytes = stack::deepest_bytes();
    let (question, answer) = records().ok_or(STARTED_TWICE)?;
    // If sim-host did not start QEMU, time may follow the host's clock; then instructions are not
    // counted.
    let counter = Counter::start();
    let counts = counter.calibrate().is_ok();
    stack::paint();
    while let Some(body) = pipes.receive()? {
        if body.is_empty() {
            pipes.send(&Closing { stack_power_up_bytes, stack_blocks_bytes: stack::deepest_bytes() })?;
            continue;
        }
        read(body, question)?;
        let before = counter.now();
        controller.process_into(&question.orders, &question.sense, &mut answer.drive, &mut answer.telemetry);
        let ticks = counter.since(before);
        answer.instructions = counts.then(|| ticks * 125 / 21);
        pipes.send(&*answer)?;
    }
    Ok(())
}

/// Returns the static memory for the records. Not inlined, so that the stack used by their
/// construction is released.
#[inline(never)]
fn records() -> Option<&'static mut (Question, Answer)> {
    singleton!(: (Question, Answer) = Default::default())
}

/// Builds the controller that the host describes, and answers. Returns `None` if the host has
/// closed its pipe or if the configuration was refused.
///
/// Not inlined, so that the stack used by the construction is released.
#[inline(never)]
fn open(pipes: &mut Pipes) -> Result<Option<&'static mut Controller>, &'static str> {
    let Some(body) = pipes.receive()? else { return Ok(None) };
    let config = configuration(body)?;
    let place = singleton!(: MaybeUninit<Controller> = MaybeUninit::uninit()).ok_or(STARTED_TWICE)?;
    match Controller::build_in(place, &config) {
        Ok(controller) => {
            pipes.send(&Opening { built: Ok(()), silence: controller.silence() })?;
            Ok(Some(controller))
        }
        Err(error) => {
            pipes.send(&Opening { built: Err(reason(&error)), ..Opening::default() })?;
            Ok(None)
        }
    }
}
