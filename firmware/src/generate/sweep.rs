//! Time to frequency. [`hold`]: the frequency stays where it was put until the scan, the tracker or an order moves it. `chirp`: it moves by
//! itself, between two frequencies or about the one that is held. Nothing here ever breaks the phase.

pub(crate) mod chirp;
pub mod hold;

use crate::generate::sweep::chirp::Chirp;
use crate::generate::sweep::hold::Hold;
use crate::seam::config::{Config, Sweep as SweepConfig};
use crate::seam::error::Error;

/// The highest frequency that a sample rate permits, as a part of it.
pub(crate) const HIGHEST: f64 = 0.45;

/// The frequency held, and the chirp that departs from it while running.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// The constant frequency that is held without a chirp.
    pub hold: Hold,
    chirp: Option<Chirp>,
}

impl Sweep {
    /// Checks the frequencies.
    pub(crate) fn build(config: &Config) -> Result<Self, Error> {
        let hold = Hold::build(config.drive.frequency_hz, config.sample_hz)?;
        let chirp = match &config.sweep {
            SweepConfig::Hold => None,
            SweepConfig::Chirp(chirp) => Some(Chirp::build(chirp, config)?),
        };
        Ok(Sweep { hold, chirp })
    }

    /// Whether there is no chirp.
    pub(crate) fn holds(&self) -> bool {
        self.chirp.is_none()
    }

    /// Restarts the chirp.
    pub(crate) fn restart(&mut self) {
        self.chirp.iter_mut().for_each(Chirp::restart);
    }

    /// Tuning word of the next block's first sample and its increment from sample to sample. `running`: the chirp has its turn.
    pub(crate) fn next(&mut self, running: bool) -> (u64, u64) {
        match self.chirp.as_mut().filter(|_| running) {
            Some(chirp) => chirp.next(self.hold.word()),
            None => (self.hold.word(), 0),
        }
    }
}
