//! The image: a configuration, then questions and answers, until the host closes its pipe.
//!
//! | exit | means |
//! |---|---|
//! | 0 | the host has closed its pipe |
//! | 1 | the pipes are missing, or a record could not be read |
//! | 101 | a panic; its message is on standard error |
//! | 102 | a hard fault, likewise |

use core::fmt::Write as _;

// For the critical section it provides.
use cortex_m as _;
use cortex_m_rt::entry;
use firmware::config::Config;
use firmware::controller::Controller;
use firmware::lockstep::{self, Answer, Opening, Question, Reason, Silence};
use semihosting::fs::File;
use semihosting::io::{Read as _, Write as _};
use semihosting::{eprintln, process};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::counter::Counter;

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

// On the module, because the macro copies attributes of the function to where nothing is unsafe.
#[expect(unsafe_code, reason = "cortex-m-rt accepts a hard fault handler only as an unsafe fn")]
mod hard_fault {
    use cortex_m_rt::{ExceptionFrame, exception};
    use semihosting::{eprintln, process};

    /// Without it a hard fault would loop for ever, and the host would wait.
    // SAFETY: marked because a handler may meet broken invariants; this one changes nothing and exits.
    #[exception]
    unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
        eprintln!("hard fault at {:#010x}", frame.pc());
        process::exit(102)
    }
}

/// Builds the controller and runs it, one block a question.
fn serve() -> Result<(), &'static str> {
    let mut pipes = Pipes::open()?;
    let Some(config) = pipes.receive::<Config>()? else { return Ok(()) };
    let mut controller = match Controller::build(&config) {
        Ok(controller) => controller,
        Err(error) => return pipes.send(&Opening::Err(reason(&error))),
    };
    pipes.send(&Opening::Ok(Silence { drive: controller.silence() }))?;
    // Started otherwise than by sim-host, QEMU may let time pass by the host's clock: then nothing is counted.
    let counter = Counter::start();
    let counts = counter.calibrate().is_ok();
    let mut answer = Answer::default();
    while let Some(question) = pipes.receive::<Question>()? {
        let before = counter.now();
        let telemetry = controller.process(&question.orders, &question.sense, &mut answer.drive);
        let ticks = counter.since(before);
        answer.telemetry = telemetry;
        answer.instructions = counts.then(|| ticks * 125 / 21);
        pipes.send(&answer)?;
    }
    Ok(())
}

fn reason(error: &firmware::error::Error) -> Reason {
    let mut reason = Reason::new();
    // What does not fit is left out: the parameter comes first.
    let _ = write!(reason, "{error}");
    reason
}

/// The pipes that QEMU has inherited from the host.
struct Pipes {
    from_host: File,
    to_host: File,
    buffer: lockstep::Buffer,
}

impl Pipes {
    fn open() -> Result<Self, &'static str> {
        let missing = |_| "no pipes: this image is started by sim-host";
        Ok(Pipes {
            from_host: File::open(c"/dev/fd/3").map_err(missing)?,
            to_host: File::create(c"/dev/fd/4").map_err(missing)?,
            buffer: lockstep::BUFFER,
        })
    }

    /// The next record; `None` when the host has closed its pipe.
    fn receive<T: DeserializeOwned>(&mut self) -> Result<Option<T>, &'static str> {
        let body =
            lockstep::receive(&mut self.buffer, |bytes| self.from_host.read(bytes)).map_err(|_| "the host's pipe fails")?;
        body.map(lockstep::decode).transpose().map_err(|_| "a record cannot be read: host and image are of different versions")
    }

    fn send<T: Serialize>(&mut self, record: &T) -> Result<(), &'static str> {
        let bytes = lockstep::encode(record, &mut self.buffer).map_err(|_| "a record is too long")?;
        self.to_host.write_all(bytes).map_err(|_| "the pipe to the host fails")
    }
}
