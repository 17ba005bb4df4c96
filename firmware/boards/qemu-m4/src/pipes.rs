//! The pipes that QEMU has inherited from the host: files 3 and 4 of its process, by semihosting.

use firmware::lockstep;
use semihosting::fs::File;
use semihosting::io::{Read as _, Write as _};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Both pipes, and room for a record.
pub struct Pipes {
    from_host: File,
    to_host: File,
    buffer: lockstep::Buffer,
}

impl Pipes {
    /// Opens what is there only if a host program has started QEMU.
    pub fn open() -> Result<Self, &'static str> {
        let missing = |_| "no pipes: this image is started by sim-host";
        Ok(Pipes {
            from_host: File::open(c"/dev/fd/3").map_err(missing)?,
            to_host: File::create(c"/dev/fd/4").map_err(missing)?,
            buffer: lockstep::BUFFER,
        })
    }

    /// The body of the next record; `None` when the host has closed its pipe.
    pub fn receive(&mut self) -> Result<Option<&[u8]>, &'static str> {
        lockstep::receive(&mut self.buffer, |bytes| self.from_host.read(bytes)).map_err(|_| "the host's pipe fails")
    }

    /// Sends a record.
    pub fn send<T: Serialize>(&mut self, record: &T) -> Result<(), &'static str> {
        let bytes = lockstep::encode(record, &mut self.buffer).map_err(|_| "a record is too long")?;
        self.to_host.write_all(bytes).map_err(|_| "the pipe to the host fails")
    }
}

/// The record in what was received.
pub fn read<T: DeserializeOwned>(body: &[u8]) -> Result<T, &'static str> {
    lockstep::decode(body).map_err(|_| "a record cannot be read: host and image are of different versions")
}
