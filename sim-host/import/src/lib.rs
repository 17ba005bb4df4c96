//! Import of measured data. An admittance becomes an equivalent circuit with standard deviations,
//! and a friction log becomes a contact. Both can be written as scenes.
//!
//! ```text
//! file -> text -> table or Touchstone -> sweep -> fixture -> fit -> circuit, figures, scene
//! ```
//!
//! # Example
//!
//! ```
//! use sonoglide_import::admittance::{fit, measured::Measured, options::Options};
//! use sonoglide_import::synthetic::Example;
//!
//! let example = Example::draw(1);
//! let measured = Measured::parse(&example.name, &example.bytes, &example.options)?;
//! let found = fit("mine", measured, None)?;
//! let truth = example.truth.branches[0].hz;
//! let stated = found.circuit.series_resonance_hz;
//! assert!((stated.value - truth).abs() < 4.0 * stated.sd);
//! # Ok::<(), sonoglide_import::error::ImportError>(())
//! ```
#![forbid(unsafe_code)]

pub mod admittance;
mod complex;
pub mod error;
pub mod friction;
pub mod least_squares;
mod quantity;
mod rows;
pub mod signal;
pub mod synthetic;
mod thinned;
mod touchstone;
mod traces;
pub mod units;
