//! Sonoglide for other tools: a C interface to controller and plant (`include/sonoglide.h`), and
//! the library of functional mock-up units (FMI 3.0), which `sim-host export fmu` packs.
//!
//! Every function may be called from any thread, but not twice at once for the same object. A panic
//! does not leave the library: the function then fails.

mod controller;
mod failure;
mod fmi3;
mod plant;
mod pointers;

#[cfg(test)]
mod tests;
