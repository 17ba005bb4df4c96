//! Frequency over time. [`hold`]: the frequency is constant until the scan, the tracker or an order
//! changes it. `chirp`: it moves between two frequencies, or about the held one. The phase is
//! always continuous.

pub(crate) mod chirp;
pub mod hold;

use crate::generate::sweep::chirp::Chirp;
use crate::generate::sweep::hold::Hold;
use crate::seam::config::{Config, Sweep as SweepConfig};
use crate::seam::error::Error;

/// Highest frequency, relative to the sample rate.
pub(crate) const MAX_FREQUENCY_REL: f64 = 0.45;

/// Held frequency, and the chirp that departs from it while running.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// Constant frequency that is held without a chirp.
    pub hold: Hold,
    chirp: Option<Chirp>,
}

impl Sweep {
    /// Builds the sweep, and checks its frequencies.
    pub(crate) fn build(config: &Config) -> Result<Self, Error> {
        let hold = Hold::build(config.drive.frequency_hz, config.sample_hz)?;
        let chirp = match &config.sweep {
            SweepConfig::Hold => None,
            SweepConfig::Chirp(chirp) => Some(Chirp::build(chirp, config)?),
        };
        Ok(Sweep { hold, chirp })
    }

    /// Returns `true` if there is no chirp.
    pub(crate) fn holds(&self) -> bool {
        self.chirp.is_none()
    }

    /// Restarts the chirp.
    pub(crate) fn restart(&mut self) {
        self.chirp.iter_mut().for_each(Chirp::restart);
    }

    /// Returns the tuning word of the next block's first sample, and its increment a sample. The
    /// chirp acts only if `running`.
    pub(crate) fn next(&mut self, running: bool) -> (u64, u64) {
        match self.chirp.as_mut().filter(|_| running) {
            Some(chirp) => chirp.next(self.hold.word()),
            None => (self.hold.word(), 0),
        }
    }
}
