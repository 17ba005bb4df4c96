//! Appendix B of the thesis: an ultrasonic motor made of one sheet of PZT-5A.
//!
//! ```text
//! sheet (Figure B.8) --> wave (B.12) --> particle (B.11, B.13, B.14) --> rotor
//!                          `--> electrodes (12 tabs) --> backward wave --> mode shapes
//! ```
//!
//! The appendix measures little: two frequencies, about 20 nm, and shapes that it calls erratic.
//! The studies judge if its equations, its electrodes and its reasons explain them.

mod backward;
mod charge;
mod displacement;
mod electrodes;
mod particle;
mod plate;
mod quadrature;
mod rotor;
mod rotor_claims;
mod shapes;
mod sheet;
mod sheet_table;
mod wave;

pub use electrodes::Pattern;
pub use sheet::{DENSITY_5A_KG_PER_M3, DENSITY_5H_KG_PER_M3, DENSITY_KG_PER_M3, DENSITY_SIMULATED_KG_PER_M3, Sheet};
pub use sheet_table::table;

use super::StudyResult;
use contact::SolveError;

/// Frequencies of the vibrometer's measurements, Hz (B.5).
pub const MEASURED_HZ: [f64; 2] = [20e3, 40e3];
/// Measured displacement, m (B.6).
pub const MEASURED_M: f64 = 20e-9;
/// Voltage of the simulation, V (Table B.1); the prototype's is not given.
pub const VOLTAGE_V: f64 = 60.0;

/// Studies sheet, wave and particle: B.2, B.4.
pub fn wave_study() -> Result<StudyResult, SolveError> {
    let [locus, dispersion] = [particle::figure(), wave::figure()];
    let claims = [vec![wave::claim()], particle::claims(), displacement::claims()].concat();
    Ok(StudyResult { figures: vec![dispersion, locus], claims })
}

/// Studies electrodes, signals and mode shapes: B.4.1 to B.6.
pub fn shape_study() -> Result<StudyResult, SolveError> {
    let figures = [electrodes::figures(), vec![backward::figure(), shapes::figure()]].concat();
    let claims = [electrodes::claims(), vec![quadrature::claim()], shapes::claims()].concat();
    Ok(StudyResult { figures, claims })
}

/// Studies the rotor: B.7, B.8.
pub fn rotor_study() -> Result<StudyResult, SolveError> {
    Ok(StudyResult { figures: vec![rotor_claims::figure()], claims: rotor_claims::claims() })
}
