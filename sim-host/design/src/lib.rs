//! Design of ultrasonic transducers and horns: a chain of one-dimensional parts, solved in closed
//! form without a mesh, and the equivalent circuit that it has at its electrodes.
//!
//! ```text
//! keys --> build (parts) --> modes (resonances, circuit) --> operating (shape, stress, losses)
//!            |                                                  |
//!          library (materials)                                limits (margins)
//! ```
//!
//! Plane waves in slender parts: lateral dimensions must be small compared with the wavelength.
//!
//! # Example
//!
//! A free rod of half a wavelength, `f = c / 2 L`:
//!
//! ```
//! use sonoglide_design::keys::{Design, Element, Kind, Material};
//!
//! let metal = Material { name: "metal".into(), modulus_pa: 70e9, density_kg_per_m3: 2800.0, q: 1e4, ..Material::default() };
//! let rod = Element {
//!     kind: Kind::Cylinder,
//!     material: Some("metal".into()),
//!     length_m: Some(0.125),
//!     diameter_m: Some(0.02),
//!     ..Element::default()
//! };
//! let design = Design { highest_hz: 30e3, element: vec![rod], material: vec![metal], ..Design::default() };
//! let solved = sonoglide_design::solve(&design)?;
//! assert!((solved.working().series_resonance_hz / 20e3 - 1.0).abs() < 1e-12);
//! # Ok::<(), sonoglide_design::DesignError>(())
//! ```
#![forbid(unsafe_code)]

mod build;
pub mod keys;
pub mod library;
mod limits;
mod material;
mod modes;
mod operating;
mod part;
mod port;
mod solved;

#[cfg(test)]
mod tests;

pub use build::{DesignError, material};
pub use limits::Limit;
pub use modes::{Branch, Mode};
pub use operating::{Operating, Point};
pub use solved::{Circuit, Solved, solve};
