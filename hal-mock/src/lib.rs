//! Mocks of every interface of the Sonoglide controller, on one virtual clock.
//!
//! * [`analog`]: trait of the converters; [`block_clock`] drives a controller through it with the
//!   latency of a real DMA, and is also used by the simulator. [`loop_back`] is the simplest load
//!   for it.
//! * [`tracer`] and [`fault_injector`]: middleware on that trait, which can be nested. [`noise`] is
//!   middleware on the link.
//! * [`pin`], [`link`], [`watchdog`], [`flash`]: the slow interfaces; they share [`time`].
//! * [`mod@bench`]: all of it together, with a [`host`] at the other end of the link.
//!
//! No mock sleeps or reads a wall clock: time is the number of samples played. All random damage is
//! drawn from a seeded [`chance`].
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
