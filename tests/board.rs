//! The host part of the board package: configuration, pins, storage.

mod config;
mod dummy_load;
mod errata;
mod hardware;
mod option_bytes;
mod sensors;
mod storage;
