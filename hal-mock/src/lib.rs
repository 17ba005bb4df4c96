//! Mocks of every interface of the Sonoglide controller, on one virtual clock.
//!
//! * [`analog`]: the converters, as one trait; [`block_clock`] drives a controller through it with the latency of a real
//!   DMA, and is what the simulator uses too. [`loop_back`] is the simplest thing to put behind it.
//! * [`tracer`] and [`fault_injector`]: middleware on that trait. They nest. [`noise`] is middleware on the link.
//! * [`pin`], [`link`], [`watchdog`], [`flash`]: the slow seams; [`time`] is what they share.
//! * [`mod@bench`]: all of it together, with a [`host`] at the other end of the link.
//!
//! Nothing here sleeps or looks at a wall clock: time is the number of samples played. What damages things does so by seeded
//! [`chance`].
#![forbid(unsafe_code)]

pub mod analog;
pub mod bench;
pub mod block_clock;
pub mod chance;
pub mod fault_injector;
pub mod flash;
pub mod host;
pub mod link;
pub mod loop_back;
pub mod noise;
pub mod pin;
pub mod time;
pub mod tracer;
pub mod watchdog;
