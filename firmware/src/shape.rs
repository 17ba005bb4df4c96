//! Phase to amplitude: the waveform, of peak one, so that a voltage limit is a limit for every shape.
//!
//! | shape | is made | file |
//! |---|---|---|
//! | sine | from one rotating phasor, for all lanes | [`sine`] |
//! | square, sawtooth | by tables of one period, each the sum of as many harmonics as the sample rate carries | [`square`], [`sawtooth`], [`bands`] |
//! | noise | by a filter, from random numbers | [`noise`] |

pub mod bands;
pub mod noise;
pub mod sawtooth;
pub mod sine;
pub mod square;

use crate::config::{Config, ShapeKind};
use crate::error::Error;
use crate::shape::bands::Bands;
use crate::shape::noise::Noise;

/// A waveform, ready to be played.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A sine.
    Sine,
    /// A waveform of harmonics.
    Harmonics(&'static Bands),
    /// A noise.
    Noise(Noise),
}

impl Shape {
    /// The amplitude of its fundamental, of a peak of one, at a frequency (cycles a sample). A noise has none.
    pub fn fundamental(&self, cycles_per_sample: f32) -> Option<f32> {
        match self {
            Shape::Sine => Some(1.0),
            Shape::Harmonics(bands) => Some(bands.at(cycles_per_sample).fundamental()),
            Shape::Noise(_) => None,
        }
    }

    /// The configured waveform.
    pub fn build(config: &Config) -> Result<Self, Error> {
        match config.drive.shape {
            ShapeKind::Sine => Ok(Shape::Sine),
            #[cfg(feature = "waveforms")]
            ShapeKind::Square => Ok(Shape::Harmonics(&square::BANDS)),
            #[cfg(feature = "waveforms")]
            ShapeKind::Sawtooth => Ok(Shape::Harmonics(&sawtooth::BANDS)),
            #[cfg(feature = "waveforms")]
            ShapeKind::Noise => Noise::build(config).map(Shape::Noise),
            #[cfg(not(feature = "waveforms"))]
            _ => Err(Error::WithoutWaveforms),
        }
    }
}
