//! What a board and a host exchange with the controller: plain values, without time, callback or trait object.
//!
//! [`config`] comes in once, [`block`] in each block; [`telemetry`] goes out, with [`mode`], [`fault`] and [`transducer`] in it. [`error`] says why a
//! configuration cannot be built, [`refusal`] why a command is not obeyed, [`features`] what an image was compiled with. [`units`], [`phasor`] and
//! `compare` and `fixed_point` are the numbers that all layers reckon with. This layer depends on no other.

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
