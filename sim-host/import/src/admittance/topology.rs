//! How a transducer was connected between two ports, by what holds of each connection whatever the transducer is:
//! `S11 + S21 = 1` in series, `S21 - S11 = 1` across the line.

use num_complex::Complex64;

use super::coordinate::Topology;
use crate::complex::size;
use crate::error::ImportError;

/// One of the two identities must hold so many times as well as the other.
const CLEARLY: f64 = 5.0;
/// Largest mean distance from an identity that holds.
const HOLDS: f64 = 0.2;

/// Finds the connection of a file with S11, S21, S12, S22.
pub(super) fn found(parameters: &[Vec<Complex64>], remarks: &mut Vec<String>) -> Result<Topology, ImportError> {
    let (s11, s21) = (&parameters[0], &parameters[1]);
    let mean = |of: &dyn Fn(Complex64, Complex64) -> Complex64| {
        s11.iter().zip(s21).map(|(&s11, &s21)| size(of(s11, s21))).sum::<f64>() / s11.len().max(1) as f64
    };
    let (series, shunt) = (mean(&|s11, s21| s11 + s21 - 1.0), mean(&|s11, s21| s21 - s11 - 1.0));
    if series < HOLDS && series * CLEARLY < shunt {
        remarks.push(format!("Series-through: S11 + S21 is 1 to within {series:.3} in the mean"));
        Ok(Topology::SeriesThrough)
    } else if shunt < HOLDS && shunt * CLEARLY < series {
        remarks.push(format!("Shunt-through: S21 - S11 is 1 to within {shunt:.3} in the mean"));
        Ok(Topology::ShuntThrough)
    } else {
        let why = format!(
            "In series S11 + S21 would be 1, and is off by {series:.3} in the mean; across the line S21 - S11 would be 1, and is off by {shunt:.3}"
        );
        Err(ImportError::TopologyDoubtful { why })
    }
}
