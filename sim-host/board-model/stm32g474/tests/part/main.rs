//! The microcontroller without a processor, with accesses and time from the test.

mod behaviour;
mod board;
mod defects;
mod protection;
mod rig;
mod rules;
mod streams;
mod tim1;
