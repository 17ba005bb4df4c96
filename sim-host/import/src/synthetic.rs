//! Synthetic measurements: transducers, sweeps, noise, fixtures and file formats drawn from a seed, with the truth behind each.
//!
//! ```text
//! seed -> circuit (1 to 3 resonances) -> sweep -> reading -> fixture -> noise (white or with memory) -> file
//! ```
//!
//! They are what an import is tested by: [`Example::bounds`] has the Cramér-Rao bound of each number, which no unbiased estimate can be below.

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

/// A synthetic measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Example {
    /// Name of the file, whose ending counts.
    pub name: String,
    /// Content of the file.
    pub bytes: Vec<u8>,
    /// Options that the file needs.
    pub options: Options,
    /// Content of the files of the open and the shorted fixture, where there is one.
    pub fixture: Option<[Vec<u8>; 2]>,
    /// The circuit behind the measurement; the working mode comes first.
    pub truth: Equivalent,
    /// What the example is like, for a table: format, connection, noise.
    pub kind: Kind,
    /// Frequencies of the sweep, Hz.
    pub hz: Vec<f64>,
    /// What lies between transducer and instrument at each frequency; empty where nothing does.
    pub between: Vec<fixture::Fixture>,
    /// Noise of the measurement.
    pub noise: Noise,
}

/// What an example is like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kind {
    /// Form of the file.
    pub form: &'static str,
    /// Whether the noise has a memory.
    pub memory: bool,
    /// Whether there is a fixture to be corrected.
    pub fixture: bool,
}

/// Noise of a synthetic measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// What the instrument reads.
    pub coordinate: Coordinate,
    /// Standard deviation: of each part of a scattering parameter, or of an immittance's size as a part of it.
    pub first: f64,
    /// Standard deviation: of a scattering parameter in proportion to its size, or of an immittance's angle, rad.
    pub second: f64,
    /// Correlation of the noise of neighbouring points.
    pub correlation: f64,
}

impl Noise {
    /// Standard deviations of real and imaginary part of a residual, in the units of the fit.
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
    /// The example of a number.
    pub fn draw(number: u64) -> Self {
        draw::draw(number)
    }

    /// The sweep as it is read from the example's files.
    ///
    /// # Errors
    /// [`ImportError`], as of a file of a user.
    pub fn measured(&self) -> Result<Measured, ImportError> {
        let mut measured = Measured::parse(&self.name, &self.bytes, &self.options)?;
        let read = |bytes: &Vec<u8>| Measured::parse(&self.name, bytes, &self.options);
        let fixture = self.fixture.as_ref().map(|[open, short]| Ok::<_, ImportError>((read(open)?, read(short)?))).transpose()?;
        let (open, short) = fixture.as_ref().map_or((None, None), |(open, short)| (Some(open), Some(short)));
        fixture::apply(&mut measured, open, short, self.options.series_ohm)?;
        Ok(measured)
    }

    /// The circuit found in the example's files.
    ///
    /// # Errors
    /// [`ImportError`], as of a file of a user.
    pub fn import(&self) -> Result<Admittance, ImportError> {
        fit("example", self.measured()?, self.options.modes)
    }

    /// True values of the working mode in the order of [`NAMES`].
    pub fn true_values(&self) -> [f64; 8] {
        bounds::values(&self.truth)
    }

    /// Cramér-Rao bounds of the standard deviations, in the order of [`NAMES`]; nothing where the sweep does not determine them.
    pub fn bounds(&self) -> Option<[f64; 8]> {
        bounds::of(&self.truth, &self.hz, &self.between, &self.noise, |noise, y| noise.sd(y))
    }
}

/// Names of the numbers of a working mode.
pub const NAMES: [&str; 8] = ["series_resonance_hz", "parallel_resonance_hz", "q", "rm_ohm", "lm_h", "cm_f", "c0_f", "coupling"];
