//! Synthetic measurements with known truth: transducers, sweeps, noise, fixtures and file formats
//! drawn from a seed.
//!
//! ```text
//! seed -> circuit (1 to 3 resonances) -> sweep -> reading -> fixture -> noise (white or correlated) -> file
//! ```
//!
//! They test the import. [`Example::bounds`] contains the Cramér-Rao bound of each value, which is
//! the smallest standard deviation of an unbiased estimate.

mod draw;
mod file;
mod friction;
mod mutate;
pub(crate) mod random;

use num_complex::Complex64;

use crate::admittance::circuit::Equivalent;
use crate::admittance::coordinate::Coordinate;
use crate::admittance::measured::Measured;
use crate::admittance::options::Options;
use crate::admittance::{Admittance, bounds, fit, fixture};
use crate::error::ImportError;
pub use friction::{Bounded, FrictionExample};
pub use mutate::mutated;

/// Synthetic measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Example {
    /// Name of the file, whose extension matters.
    pub name: String,
    /// Content of the file.
    pub bytes: Vec<u8>,
    /// Options that the file needs.
    pub options: Options,
    /// Contents of the files of the open and the shorted fixture, if there is a fixture.
    pub fixture: Option<[Vec<u8>; 2]>,
    /// True circuit; the working mode comes first.
    pub truth: Equivalent,
    /// Properties of the example, for a table.
    pub kind: Kind,
    /// Frequencies of the sweep, Hz.
    pub hz: Vec<f64>,
    /// Network between transducer and instrument at each frequency; empty if there is none.
    pub between: Vec<fixture::Fixture>,
    /// Noise of the measurement.
    pub noise: Noise,
}

/// Properties of an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kind {
    /// Format of the file.
    pub form: &'static str,
    /// `true` if the noise is correlated.
    pub memory: bool,
    /// `true` if there is a fixture to be corrected.
    pub fixture: bool,
}

/// Noise of a synthetic measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Quantity that the instrument reads.
    pub coordinate: Coordinate,
    /// Standard deviation of each part of a scattering parameter, or of the relative magnitude of
    /// an immittance.
    pub first: f64,
    /// Standard deviation relative to the magnitude of a scattering parameter, or of the angle of
    /// an immittance, rad.
    pub second: f64,
    /// Correlation of the noise of neighbouring points.
    pub correlation: f64,
}

impl Noise {
    /// Returns the standard deviations of real and imaginary part of a residual, in the units of
    /// the fit.
    fn sd(&self, admittance: Complex64) -> [f64; 2] {
        match self.coordinate {
            Coordinate::Scattering(..) => {
                let size = self.coordinate.of(admittance).norm_sqr();
                [(self.first * self.first + self.second * self.second * size).sqrt(); 2]
            }
            Coordinate::Immittance => [self.first, self.second],
        }
    }
}

impl Example {
    /// Draws the example with this number.
    pub fn draw(number: u64) -> Self {
        draw::draw(number)
    }

    /// Reads the sweep from the files of the example.
    ///
    /// # Errors
    /// Returns [`ImportError`], as for a file of a user.
    pub fn measured(&self) -> Result<Measured, ImportError> {
        let mut measured = Measured::parse(&self.name, &self.bytes, &self.options)?;
        let read = |bytes: &Vec<u8>| Measured::parse(&self.name, bytes, &self.options);
        let fixture = self.fixture.as_ref().map(|[open, short]| Ok::<_, ImportError>((read(open)?, read(short)?))).transpose()?;
        let (open, short) = fixture.as_ref().map_or((None, None), |(open, short)| (Some(open), Some(short)));
        fixture::apply(&mut measured, open, short, self.options.series_ohm)?;
        Ok(measured)
    }

    /// Fits the circuit to the files of the example.
    ///
    /// # Errors
    /// Returns [`ImportError`], as for a file of a user.
    pub fn import(&self) -> Result<Admittance, ImportError> {
        fit("example", self.measured()?, self.options.modes)
    }

    /// Returns the true values of the working mode in the order of [`NAMES`].
    pub fn true_values(&self) -> [f64; 8] {
        bounds::values(&self.truth)
    }

    /// Returns the Cramér-Rao bounds of the standard deviations, in the order of [`NAMES`]; `None`
    /// if the sweep does not determine the values.
    pub fn bounds(&self) -> Option<[f64; 8]> {
        bounds::deviations(&self.truth, &self.hz, &self.between, &self.noise, |noise, y| noise.sd(y))
    }
}

/// Names of the values of a working mode.
pub const NAMES: [&str; 8] = ["series_resonance_hz", "parallel_resonance_hz", "q", "rm_ohm", "lm_h", "cm_f", "c0_f", "coupling"];
