//! Waveforms: phase to amplitude, with a peak of one, so that a voltage limit applies to any shape.
//!
//! | shape | made by | file |
//! |---|---|---|
//! | sine | one rotating phasor for all lanes | [`sine`] |
//! | square, sawtooth | tables of one period, each the sum of as many harmonics as the sample rate permits | `square`, `sawtooth`, `bands` |
//! | noise | a filter on random numbers | `noise` |

pub(crate) mod bands;
pub(crate) mod noise;
pub(crate) mod sawtooth;
pub mod sine;
pub(crate) mod square;

use crate::generate::shape::bands::Bands;
use crate::generate::shape::noise::Noise;
use crate::seam::config::{Config, ShapeKind};
use crate::seam::error::Error;
use crate::seam::features::{self, Waveforms};

/// Waveform, ready to be played.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A sine wave.
    Sine,
    /// A waveform of harmonics.
    Harmonics(Waveforms, &'static Bands),
    /// A band-limited noise.
    Noise(Waveforms, Noise),
}

impl Shape {
    /// Returns `true` if the waveform has a fundamental: a noise has none.
    pub(crate) fn has_fundamental(&self) -> bool {
        !matches!(self, Shape::Noise(..))
    }

    /// Builds the configured waveform.
    pub fn build(config: &Config) -> Result<Self, Error> {
        Ok(match config.drive.shape {
            ShapeKind::Sine => Shape::Sine,
            ShapeKind::Square => Shape::Harmonics(features::waveforms()?, &square::BANDS),
            ShapeKind::Sawtooth => Shape::Harmonics(features::waveforms()?, &sawtooth::BANDS),
            ShapeKind::Noise => Shape::Noise(features::waveforms()?, Noise::build(config)?),
        })
    }
}
