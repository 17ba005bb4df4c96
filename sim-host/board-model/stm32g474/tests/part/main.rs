//! The part, driven as a program and the time drive it.

mod behaviour;
mod board;
mod defects;
mod protection;
mod rig;
mod rules;
mod streams;
mod tim1;
