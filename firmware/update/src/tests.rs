//! The whole way of an update on simulated flash, with the power cut at every operation.

mod board;
mod cuts;
mod flash;
mod refusals;
