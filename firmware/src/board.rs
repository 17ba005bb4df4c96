//! Code shared by all boards in addition to the controller: the background task, the link to the
//! host, stored settings, power-up, captures, field update, and the records by which a board in an
//! emulator runs in lockstep with a simulation.
//!
//! This layer may depend on all others; none depends on it.

pub mod app;
pub mod block_task;
pub mod capture;
pub mod command;
pub mod fault_log;
pub mod hardware;
pub mod link;
pub mod lockstep;
pub mod parameters;
pub mod power_up;
pub mod queues;
pub mod settings;
pub(crate) mod settings_store;
pub mod start;
pub mod stored_state;
pub mod update;
