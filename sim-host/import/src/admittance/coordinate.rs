//! Coordinates of a measurement: the reading of the instrument as a function of the admittance `Y`
//! of the transducer.
//!
//! ```text
//! one port          S11 = (1 - Z0 Y) / (1 + Z0 Y)
//! series-through    S21 = 2 Z0 Y / (1 + 2 Z0 Y)           the transducer between two ports
//! shunt-through     S21 = 2 / (2 + Z0 Y)                  the transducer across the line
//! immittance        ln Y: magnitude and angle, for impedance and admittance
//! ```
//!
//! The noise of a network analyser is that of its scattering parameter, and nearly independent of
//! the frequency. The error of an impedance analyser is proportional to its reading, in magnitude
//! and angle. In these coordinates the residuals of a fit are the noise of the instrument.
//!
//! A one-port measurement at 50 ohm is insensitive for a transducer of some kiloohm, because `S11`
//! is close to 1 for all of them. The range of a two-port measurement is wider.

use num_complex::Complex64;
use serde::Serialize;

use crate::complex::{angle, polar};

/// Connection of a transducer to a network analyser.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Topology {
    /// At one port; measured by its reflection S11.
    OnePort,
    /// Between two ports; measured by the transmission S21.
    SeriesThrough,
    /// From the line between two ports to ground; measured by the transmission S21.
    ShuntThrough,
}

/// Quantity that the instrument reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coordinate {
    /// A scattering parameter against this resistance, ohm.
    Scattering(Topology, f64),
    /// An impedance or an admittance.
    Immittance,
}

impl Coordinate {
    /// Returns the reading of an admittance, S.
    pub fn of(self, admittance: Complex64) -> Complex64 {
        match self {
            Coordinate::Scattering(Topology::OnePort, ohm) => (1.0 - ohm * admittance) / (1.0 + ohm * admittance),
            Coordinate::Scattering(Topology::SeriesThrough, ohm) => 2.0 * ohm * admittance / (1.0 + 2.0 * ohm * admittance),
            Coordinate::Scattering(Topology::ShuntThrough, ohm) => 2.0 / (2.0 + ohm * admittance),
            Coordinate::Immittance => Complex64::new(0.5 * libm::log(admittance.norm_sqr()), angle(admittance)),
        }
    }

    /// Returns the derivative of the reading by the admittance, 1/S.
    pub fn slope(self, admittance: Complex64) -> Complex64 {
        let square = |z: Complex64| z * z;
        match self {
            Coordinate::Scattering(Topology::OnePort, ohm) => -2.0 * ohm / square(1.0 + ohm * admittance),
            Coordinate::Scattering(Topology::SeriesThrough, ohm) => 2.0 * ohm / square(1.0 + 2.0 * ohm * admittance),
            Coordinate::Scattering(Topology::ShuntThrough, ohm) => -2.0 * ohm / square(2.0 + ohm * admittance),
            Coordinate::Immittance => admittance.inv(),
        }
    }

    /// Returns the admittance of a reading, S; not finite if the reading has none.
    pub fn admittance(self, reading: Complex64) -> Complex64 {
        match self {
            Coordinate::Scattering(Topology::OnePort, ohm) => (1.0 - reading) / (1.0 + reading) / ohm,
            Coordinate::Scattering(Topology::SeriesThrough, ohm) => reading / (1.0 - reading) / (2.0 * ohm),
            Coordinate::Scattering(Topology::ShuntThrough, ohm) => 2.0 * (1.0 - reading) / reading / ohm,
            Coordinate::Immittance => polar(libm::exp(reading.re), reading.im),
        }
    }

    /// Returns the difference of two readings; whole turns of an angle are removed.
    pub fn difference(self, one: Complex64, other: Complex64) -> Complex64 {
        let difference = one - other;
        match self {
            Coordinate::Immittance => {
                let turns = (difference.im / std::f64::consts::TAU).round();
                Complex64::new(difference.re, difference.im - std::f64::consts::TAU * turns)
            }
            Coordinate::Scattering(..) => difference,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reading_and_slope_agree_with_the_admittance() {
        let all = [Topology::OnePort, Topology::SeriesThrough, Topology::ShuntThrough].map(|t| Coordinate::Scattering(t, 50.0));
        for coordinate in all.into_iter().chain([Coordinate::Immittance]) {
            let y = Complex64::new(3e-3, -7e-3);
            assert!((coordinate.admittance(coordinate.of(y)) - y).norm_sqr() < 1e-30, "{coordinate:?}");
            let step = Complex64::new(1e-9, 2e-9);
            let numeric = (coordinate.of(y + step) - coordinate.of(y - step)) / (2.0 * step);
            assert!((numeric / coordinate.slope(y) - 1.0).norm_sqr() < 1e-12, "{coordinate:?}");
        }
    }
}
