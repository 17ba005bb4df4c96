//! The emulated machine.

/// The emulator.
pub const PROGRAM: &str = "qemu-system-arm";

/// Its arguments, before the image: an STM32F405, with flash and RAM where the reference board has them, and semihosting on this
/// host's files. Its time passes by instructions, one nanosecond each, which is how the image counts them.
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

/// Arguments of a machine whose serial port nobody hears.
pub const NO_SERIAL: [&str; 2] = ["-serial", "null"];

/// Arguments of a machine whose first serial port is the socket that it has inherited as its file 5.
pub const SERIAL: [&str; 4] = ["-chardev", "socket,id=link,fd=5", "-serial", "chardev:link"];
