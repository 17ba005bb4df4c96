//! The emulated machine.

/// Program of the emulator.
pub const PROGRAM: &str = "qemu-system-arm";

/// Arguments of the emulator, before the image: an STM32F405, with flash and RAM at the addresses
/// of the reference board, and semihosting on this host's files. The machine's time advances by one
/// nanosecond per instruction; the image uses it to count instructions.
pub const ARGUMENTS: [&str; 10] = [
    "-M",
    "netduinoplus2",
    "-icount",
    "shift=0",
    "-nographic",
    "-monitor",
    "none",
    "-semihosting-config",
    "enable=on,target=native",
    "-kernel",
];

/// Arguments of a machine without a serial port to the host.
pub const NO_SERIAL: [&str; 2] = ["-serial", "null"];

/// Arguments of a machine whose first serial port is the socket inherited as file 5.
pub const SERIAL: [&str; 4] = ["-chardev", "socket,id=link,fd=5", "-serial", "chardev:link"];
