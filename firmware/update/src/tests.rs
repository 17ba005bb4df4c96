//! Complete updates on simulated flash, with power cuts at every operation.

mod board;
mod cuts;
mod flash;
mod refusals;
