//! Debugger at the modelled board, by GDB's remote serial protocol over TCP. Skipped, with a
//! message, if the image cannot be built.

mod dialogue;
mod driving;
mod gdb;
