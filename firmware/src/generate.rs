//! Signal generation: the converter codes of one block for a [plan](step::Plan), from frequency,
//! envelope, amplitude, lanes and shape.
//!
//! A waveform combines four independent parts:
//!
//! ```text
//! drive(n, lane) = envelope(n) * shape(phase(n) + phasing(lane)),   phase advances by sweep(n)
//! ```
//!
//! This layer depends on [`seam`](crate::seam) only.

pub(crate) mod amplitude;
pub mod burst;
pub(crate) mod drive_scale;
pub(crate) mod fold_back;
pub mod nco;
pub mod phasing;
pub mod shape;
pub mod shaper;
pub(crate) mod signal_generator;
pub mod step;
pub mod sweep;
