//! Determination of the connection of a transducer between two ports, by identities that hold for
//! every transducer: `S11 + S21 = 1` in series, `S21 - S11 = 1` across the line.

use num_complex::Complex64;

use super::coordinate::Topology;
use crate::complex::size;
use crate::error::ImportError;

/// Factor by which one identity must hold better than the other.
const MIN_RATIO: f64 = 5.0;
/// Largest mean deviation from an identity that holds.
const MAX_DEVIATION: f64 = 0.2;

/// Determines the connection from a file with S11, S21, S12, S22.
pub(super) fn found(parameters: &[Vec<Complex64>], remarks: &mut Vec<String>) -> Result<Topology, ImportError> {
    let (s11, s21) = (&parameters[0], &parameters[1]);
    let mean = |of: &dyn Fn(Complex64, Complex64) -> Complex64| {
        s11.iter().zip(s21).map(|(&s11, &s21)| size(of(s11, s21))).sum::<f64>() / s11.len().max(1) as f64
    };
    let (series, shunt) = (mean(&|s11, s21| s11 + s21 - 1.0), mean(&|s11, s21| s21 - s11 - 1.0));
    if series < MAX_DEVIATION && series * MIN_RATIO < shunt {
        remarks.push(format!("Series-through: S11 + S21 is 1, with a mean deviation of {series:.3}"));
        Ok(Topology::SeriesThrough)
    } else if shunt < MAX_DEVIATION && shunt * MIN_RATIO < series {
        remarks.push(format!("Shunt-through: S21 - S11 is 1, with a mean deviation of {shunt:.3}"));
        Ok(Topology::ShuntThrough)
    } else {
        let why = format!(
            "In series S11 + S21 would be 1; its mean deviation is {series:.3}. Across the line S21 - S11 would be 1; its mean \
             deviation is {shunt:.3}"
        );
        Err(ImportError::TopologyDoubtful { why })
    }
}
