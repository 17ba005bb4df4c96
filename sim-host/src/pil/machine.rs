//! The emulated machine.

/// The emulator.
pub const PROGRAM: &str = "qemu-system-arm";

/// Its arguments, before the image: an STM32F405, with flash and RAM where the reference board has them, and semihosting on this
/// host's files. Its time passes by instructions, one nanosecond each, which is how the image counts them.
pub const ARGUMENTS: [&str; 12] = [
    "-M",
    "netduinoplus2",
    "-icount",
    "shift=0",
    "-nographic",
    "-monitor",
    "none",
    "-serial",
    "null",
    "-semihosting-config",
    "enable=on,target=native",
    "-kernel",
];
