//! Cross-crate tests in one binary, with one module for each tested function.

mod amplitude;
mod app;
mod applications;
mod belt;
mod board;
mod clamped;
mod contact;
mod drive;
mod edges;
mod friction;
mod friction_switch;
mod heat;
mod link;
mod motor;
mod observer;
mod scenes;
mod tracking;
