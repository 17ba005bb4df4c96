//! ELF file of the flashed image: its size, and the functions that can panic.

mod branches;
mod panics;
mod size;
