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
//! [`app::App`], as often as it likes; orders and telemetry pass between the two through queues.
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

pub mod amplitude;
pub mod app;
pub mod belt;
pub mod block;
pub mod block_task;
pub mod burst;
pub mod calibrate;
pub mod capture;
pub mod carried;
pub mod clamped;
pub mod command;
pub mod config;
pub mod controller;
pub mod convert;
pub mod demod;
pub mod error;
pub mod fault_log;
pub mod friction;
mod generate;
pub mod guard;
pub mod identify;
pub mod keeper;
pub mod kept;
pub mod link;
pub mod lockstep;
pub mod motional;
pub mod nco;
pub mod parameters;
pub mod phasing;
pub mod phasor;
pub mod power_up;
pub mod queues;
pub mod refusal;
pub mod restraint;
pub mod scan;
pub mod self_test;
pub mod settings;
pub mod shape;
pub mod shaper;
pub mod source;
pub mod start;
pub mod step;
pub mod supervisor;
pub mod sweep;
pub mod telemetry;
mod track;
pub mod tracker;
pub mod units;
