//! The pipes that QEMU has inherited from the host: files 3 and 4 of its process, by semihosting.

use core::fmt::Write as _;

use cortex_m::singleton;
use firmware::board::lockstep::{self, Reason, Record};
use firmware::seam::config::Config;
use semihosting::fs::File;
use semihosting::io::{Read as _, Write as _};

/// Both pipes, and room for a record.
pub struct Pipes {
    from_host: File,
    to_host: File,
    buffer: lockstep::Buffer,
}

impl Pipes {
    /// Opens what is there only if a host program has started QEMU. Once only. Not inlined, for what passes over the stack on the way.
    #[inline(never)]
    pub fn open() -> Result<&'static mut Self, &'static str> {
        let missing = |_| "no pipes: this image is started by sim-host";
        let (from_host, to_host) = (File::open(c"/dev/fd/3").map_err(missing)?, File::create(c"/dev/fd/4").map_err(missing)?);
        singleton!(: Pipes = Pipes { from_host, to_host, buffer: lockstep::BUFFER }).ok_or("started twice")
    }

    /// The body of the next record; `None` when the host has closed its pipe.
    pub fn receive(&mut self) -> Result<Option<&[u8]>, &'static str> {
        lockstep::receive(&mut self.buffer, |bytes| self.from_host.read(bytes)).map_err(|_| "the host's pipe fails")
    }

    /// Sends a record to the host.
    pub fn send(&mut self, record: &impl Record) -> Result<(), &'static str> {
        let bytes = lockstep::encode(record, &mut self.buffer).map_err(|_| "a record is too long")?;
        self.to_host.write_all(bytes).map_err(|_| "the pipe to the host fails")
    }
}

const OTHER_VERSION: &str = "a record cannot be read: host and image are of different versions";

/// The configuration in what was received.
pub fn configuration(body: &[u8]) -> Result<Config, &'static str> {
    lockstep::configuration(body).map_err(|_| OTHER_VERSION)
}

/// Why a configuration is refused.
pub fn reason(error: &firmware::seam::error::Error) -> Reason {
    let mut reason = Reason::new();
    // What does not fit is left out: the parameter comes first.
    let _ = write!(reason, "{error}");
    reason
}

/// Reads the record in what was received.
pub fn read(body: &[u8], record: &mut impl Record) -> Result<(), &'static str> {
    lockstep::decode(body, record).map_err(|_| OTHER_VERSION)
}
