//! Serial devices: the virtual COM port of a Nucleo, an adapter, or a pseudo-terminal.

use std::io::{self, Read, Write};
use std::time::{Duration, Instant};

use serialport::{ClearBuffer, ErrorKind, SerialPort};

use super::listed::sentence;
use super::{BAUD, Port, chance, within};
use crate::link_error::LinkError;

/// Shortest read timeout.
const MIN_READ_TIMEOUT: Duration = Duration::from_millis(1);
/// Longest read timeout.
const MAX_READ_TIMEOUT: Duration = Duration::from_millis(50);

/// Serial device at [`BAUD`], with 8 data bits, no parity, one stop bit and no flow control.
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
        .timeout(MAX_READ_TIMEOUT)
        .open()
        .map_err(|error| LinkError::Open { port: name.to_owned(), why: why(name, &error) })?;
    // Discards bytes that another program has not read. If the device does not support this, it has
    // no buffer.
    let _ = device.clear(ClearBuffer::All);
    Ok(device)
}

/// Returns the reason why a device cannot be opened, with a remedy.
fn why(name: &str, error: &serialport::Error) -> String {
    match error.kind {
        ErrorKind::Io(io::ErrorKind::NotFound) => format!("there is no such port. {}", sentence()),
        ErrorKind::Io(io::ErrorKind::PermissionDenied) => format!(
            "permission denied. On Linux, join the group that owns the port (`ls -l {name}`; usually `sudo usermod -aG dialout \
             $USER`, then log in again), or add the udev rule of docs/link.md"
        ),
        ErrorKind::NoDevice if !std::path::Path::new(name).exists() => format!("there is no such port. {}", sentence()),
        ErrorKind::NoDevice => {
            "another program uses it (a terminal, a modem manager, another sim-host?): end that program first".into()
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
            self.device.set_timeout(left.clamp(MIN_READ_TIMEOUT, MAX_READ_TIMEOUT))?;
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
    fn the_error_for_a_missing_port_lists_the_existing_ports() {
        let Err(LinkError::Open { port, why }) = Serial::open("/dev/ttyNOT") else { panic!("opened") };
        assert_eq!(port, "/dev/ttyNOT");
        assert!(
            why.contains("there is no such port") && (why.contains("Serial ports here") || why.contains("no serial port")),
            "{why}"
        );
    }

    #[cfg(unix)]
    #[test]
    fn a_pseudo_terminal_is_transparent_and_exclusive() {
        let (mut board, here) = serialport::TTYPort::pair().unwrap();
        let name = here.name().unwrap();
        drop(here);
        let mut port = Serial::open(&name).unwrap();
        // A terminal would translate or interpret these.
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
