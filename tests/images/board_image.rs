//! The ELF file that is flashed: its size, and the functions that can panic.

mod branches;
mod panics;
mod size;
