//! Doubles for every seam of the Sonoglide controller, on one virtual clock.
//!
//! * [`analog`]: the converters, as one trait; [`block_clock`] drives a controller through it with the latency of a real
//!   DMA, and is what the simulator uses too. [`loop_back`] is the simplest thing to put behind it.
//! * [`tracer`] and [`fault_injector`]: middleware on that trait. They nest.
//! * [`pin`], [`link`], [`watchdog`], [`flash`]: the slow seams.
//!
//! Nothing here sleeps or looks at a wall clock: time is the number of samples played.
#![forbid(unsafe_code)]

pub mod analog;
pub mod block_clock;
pub mod loop_back;
