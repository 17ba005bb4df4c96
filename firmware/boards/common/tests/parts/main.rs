//! Unit tests of each shared part of the boards.

mod area;
mod beat;
mod led;
mod note;
mod packing;
mod reader;
mod rings;
mod stack_guard;
mod step;
mod supply_window;
mod thermistor;
mod wires;
