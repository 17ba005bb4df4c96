//! Cross-crate tests, in one binary: one module for each thing that is tested whole.

mod app;
