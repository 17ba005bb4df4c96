//! The Sonoglide controller.
//!
//! One `no_std` controller generates the ultrasonic drive, keeps a piezo stack at its series
//! resonance by its motional current, and switches friction on and off in bursts. The same code
//! runs as thumb code on a driver board, in an emulator, and on the host against a simulated
//! stack and contact. Transcendental functions come from `libm` or from tables made at compile
//! time, and nothing is fused, so that all of these agree bit for bit.
//!
//! # The signal chain
//!
//! ```text
//! SenseBlock -> convert -> demod -> motional -> tracker -> supervisor -> burst -> shaper -> DriveBlock
//!                                                   \------------- Telemetry leaves sideways, by value
//! ```
//!
//! The hot side is [`controller::Controller::process`], once a block. The slow side is
//! [`board::app::App`], as often as it likes; orders and telemetry pass between the two through queues.
//!
//! A waveform is four independent axes, not one list of cases:
//!
//! ```text
//! drive(n, lane) = envelope(n) * shape(phase(n) + phasing(lane)),   phase advances by sweep(n)
//! ```
#![no_std]
#![forbid(unsafe_code)]

#[cfg(any(test, feature = "scene"))]
extern crate std;

pub mod act;
pub mod board;
pub mod controller;
pub mod find;
pub mod generate;
pub mod guard;
pub mod seam;
pub mod sense;
pub mod track;
