//! A serial device: a Nucleo's virtual COM port, an adapter, or a pseudo-terminal.

use std::io::{self, Read, Write};
use std::time::{Duration, Instant};

use serialport::{ClearBuffer, ErrorKind, SerialPort};

use super::listed::sentence;
use super::{Port, chance, within};
use crate::link_error::LinkError;

/// Bits a second of the board's UART.
pub const BAUD: u32 = 921_600;
/// Shortest and longest wait within the system.
const SHORTEST: Duration = Duration::from_millis(1);
const LONGEST: Duration = Duration::from_millis(50);

/// A serial device, at [`BAUD`], 8 data bits, no parity, one stop bit, no flow control.
pub struct Serial {
    name: String,
    device: Box<dyn SerialPort>,
    opened: Instant,
}

impl Serial {
    /// Opens the device `name`.
    pub fn open(name: &str) -> Result<Self, LinkError> {
        Ok(Serial { name: name.to_owned(), device: device(name)?, opened: Instant::now() })
    }
}

fn device(name: &str) -> Result<Box<dyn SerialPort>, LinkError> {
    let device = serialport::new(name, BAUD)
        .timeout(LONGEST)
        .open()
        .map_err(|error| LinkError::Open { port: name.to_owned(), why: why(name, &error) })?;
    // What another program has left unread answers no command of ours. A device that cannot do this has nothing to discard.
    let _ = device.clear(ClearBuffer::All);
    Ok(device)
}

/// Why a device cannot be opened, and what to do about it.
fn why(name: &str, error: &serialport::Error) -> String {
    match error.kind {
        ErrorKind::Io(io::ErrorKind::NotFound) => format!("there is no such port. {}", sentence()),
        ErrorKind::Io(io::ErrorKind::PermissionDenied) => format!(
            "this user may not open it. On Linux, join the group that owns it (`ls -l {name}`; mostly `sudo usermod -aG dialout $USER`, then log \
             in again), or add the udev rule of docs/link.md"
        ),
        ErrorKind::NoDevice if !std::path::Path::new(name).exists() => format!("there is no such port. {}", sentence()),
        ErrorKind::NoDevice => {
            "another program has it open (a terminal, a modem manager, another sim-host?): end that first".into()
        }
        _ => format!("{error}. {}", sentence()),
    }
}

impl Port for Serial {
    fn name(&self) -> &str {
        &self.name
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.device.write_all(bytes)
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        within(wait, |left| {
            self.device.set_timeout(left.clamp(SHORTEST, LONGEST))?;
            self.device.read(into)
        })
    }

    fn now(&self) -> Duration {
        self.opened.elapsed()
    }

    fn reopen(&mut self) -> Result<(), LinkError> {
        self.device = device(&self.name)?;
        Ok(())
    }

    fn nonce(&mut self) -> u32 {
        chance()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_that_is_not_there_is_named_with_those_that_are() {
        let Err(LinkError::Open { port, why }) = Serial::open("/dev/ttyNOT") else { panic!("opened") };
        assert_eq!(port, "/dev/ttyNOT");
        assert!(
            why.contains("there is no such port") && (why.contains("Ports there are") || why.contains("no serial port")),
            "{why}"
        );
    }

    #[cfg(unix)]
    #[test]
    fn a_pseudo_terminal_carries_bytes_as_they_are_and_is_opened_once() {
        let (mut board, here) = serialport::TTYPort::pair().unwrap();
        let name = here.name().unwrap();
        drop(here);
        let mut port = Serial::open(&name).unwrap();
        // Nothing is translated, not even what a terminal would make of these.
        let bytes = [0, 3, 4, 10, 13, 17, 19, 26, 255];
        board.write_all(&bytes).unwrap();
        let mut into = [0; 64];
        assert_eq!(port.receive(&mut into, Duration::from_secs(1)).unwrap(), bytes.len());
        assert_eq!(into[..bytes.len()], bytes);
        assert_eq!(port.receive(&mut into, Duration::from_millis(1)).unwrap(), 0);
        let Err(LinkError::Open { why, .. }) = Serial::open(&name) else { panic!("opened twice") };
        assert!(why.contains("another program"), "{why}");
    }
}
