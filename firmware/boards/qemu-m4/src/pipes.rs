//! Pipes to the host, which QEMU inherits: file descriptors 3 and 4 of its process, used by
//! semihosting.

use core::fmt::Write as _;

use cortex_m::singleton;
use firmware::board::lockstep::{self, Reason, Record};
use firmware::seam::config::Config;
use semihosting::fs::File;
use semihosting::io::{Read as _, Write as _};

/// Both pipes, and a buffer for a record.
pub struct Pipes {
    from_host: File,
    to_host: File,
    buffer: lockstep::Buffer,
}

impl Pipes {
    /// Opens the pipes, once only. They exist only if a host program has started QEMU.
    ///
    /// Not inlined, so that the stack used by the construction is released.
    #[inline(never)]
    pub fn open() -> Result<&'static mut Self, &'static str> {
        let missing = |_| "no pipes: this image must be started by sim-host";
        let (from_host, to_host) = (File::open(c"/dev/fd/3").map_err(missing)?, File::create(c"/dev/fd/4").map_err(missing)?);
        singleton!(: Pipes = Pipes { from_host, to_host, buffer: lockstep::BUFFER }).ok_or("started twice")
    }

    /// Returns the body of the next record, or `None` if the host has closed its pipe.
    pub fn receive(&mut self) -> Result<Option<&[u8]>, &'static str> {
        lockstep::receive(&mut self.buffer, |bytes| self.from_host.read(bytes)).map_err(|_| "the pipe from the host fails")
    }

    /// Sends a record to the host.
    pub fn send(&mut self, record: &impl Record) -> Result<(), &'static str> {
        let bytes = lockstep::encode(record, &mut self.buffer).map_err(|_| "a record is too long")?;
        self.to_host.write_all(bytes).map_err(|_| "the pipe to the host fails")
    }
}

const OTHER_VERSION: &str = "a record cannot be read: host and image have different versions";

/// Decodes a configuration.
pub fn configuration(body: &[u8]) -> Result<Config, &'static str> {
    lockstep::configuration(body).map_err(|_| OTHER_VERSION)
}

/// Returns the reason why a configuration is refused.
pub fn reason(error: &firmware::seam::error::Error) -> Reason {
    let mut reason = Reason::new();
    // A text that is too long is cut at its end; the parameter comes first.
    let _ = write!(reason, "{error}");
    reason
}

/// Decodes a record.
pub fn read(body: &[u8], record: &mut impl Record) -> Result<(), &'static str> {
    lockstep::decode(body, record).map_err(|_| OTHER_VERSION)
}
