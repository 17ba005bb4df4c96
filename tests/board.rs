//! The board package on the host: what of it needs no board, what it is configured with, and how large its image is.

mod branches;
mod config;
mod dummy_load;
mod hardware;
mod option_bytes;
mod panics;
mod sensors;
mod size;
mod storage;
