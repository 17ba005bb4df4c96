//! Keys of a scene, one file per table.

pub mod carriage;
pub mod circuit;
pub mod comparison;
pub mod contact;
pub mod controller;
pub mod course;
pub mod dring;
pub mod excitation;
pub mod integrator;
pub mod measured_curve;
pub mod plant;
pub mod profile;
pub mod results;
pub mod rig;
pub mod stator;
pub mod vary;
