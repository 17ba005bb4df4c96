//! The emulated machines.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Program of the emulator.
pub const PROGRAM: &str = "qemu-system-arm";

/// Machine with a Cortex-M4F: an STM32F405, with flash and RAM at the addresses of the reference
/// board.
const CORTEX_M4: &str = "netduinoplus2";
/// Machine with a Cortex-M33 in its secure state.
const CORTEX_M33: &str = "mps2-an505";
/// Highest byte of the addresses of the code of that machine.
const CORTEX_M33_CODE: u8 = 0x10;

/// Returns the machine for an image, by the entry of its ELF file (little-endian, at byte 24).
pub fn machine(image: &Path) -> io::Result<&'static str> {
    let mut head = [0; 28];
    File::open(image)?.read_exact(&mut head)?;
    Ok(if head[27] == CORTEX_M33_CODE { CORTEX_M33 } else { CORTEX_M4 })
}

/// Arguments of the emulator, between the machine and the image, with semihosting on this host's
/// files. The machine's time advances by one nanosecond per instruction; the image uses it to count
/// instructions.
pub const ARGUMENTS: [&str; 8] =
    ["-icount", "shift=0", "-nographic", "-monitor", "none", "-semihosting-config", "enable=on,target=native", "-kernel"];

/// Arguments of a machine without a serial port to the host.
pub const NO_SERIAL: [&str; 2] = ["-serial", "null"];

/// Arguments of a machine whose first serial port is the socket inherited as file 5.
pub const SERIAL: [&str; 4] = ["-chardev", "socket,id=link,fd=5", "-serial", "chardev:link"];
