//! The interface of the controller to board and host: plain values, without time, callback or trait
//! object.
//!
//! [`config`] is read once, [`block`] in each block. [`telemetry`] is the output, with [`mode`],
//! [`fault`] and [`transducer`]. [`error`] lists the reasons for which a configuration is refused,
//! [`refusal`] those for a command, and [`features`] the optional parts of an image. [`units`],
//! [`phasor`], `compare` and `fixed_point` are the arithmetic of all layers. This layer does not
//! depend on any other.

pub mod block;
pub(crate) mod compare;
pub mod config;
pub mod error;
pub mod fault;
pub mod features;
pub(crate) mod fixed_point;
pub mod mode;
pub mod phasor;
pub mod refusal;
pub mod telemetry;
pub mod transducer;
pub mod units;
