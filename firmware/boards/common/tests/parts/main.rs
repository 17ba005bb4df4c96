//! Each part of what boards share, by itself.

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
