//! Small programs as machine code: exceptions, cycles, the loading of an image.

mod cycles;
mod debugger;
mod elf;
mod exceptions;
mod halt;
mod support;
