//! Frequency, amplitude and waveform of the drive.

use config_macro::settings;
#[cfg(feature = "scene")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Choice, Config, Limits, Setting};
use crate::seam::block::Amplitude;
use crate::seam::config::Parameter;

/// Frequency, amplitude and waveform of the drive.
#[settings(table = "drive", scene = Drive)]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drive {
    /// Nominal frequency: the centre of the scan, Hz.
    #[setting(min = 100.0, max = 450e3, key = 4)]
    pub frequency_hz: f32,
    /// Amplitude set point in a run.
    #[setting(controller)]
    pub amplitude: Amplitude,
    /// Peak drive voltage, V.
    #[setting(scene, min = 1e-3, max = 1e4, key = 5, read = amplitude_v, write = set_amplitude_v)]
    pub amplitude_v: Option<f32>,
    /// Peak tip velocity, held by the motional-current loop, m/s. Needs
    /// `tracking.nominal_force_factor_n_per_v`.
    #[setting(scene, min = 1e-6, max = 100.0)]
    pub velocity_m_per_s: Option<f32>,
    /// Peak voltage of self-test and scan, V. Default: `amplitude_v`.
    #[setting(scene, min = 1e-3, max = 1e4)]
    pub scan_v: Option<f32>,
    /// Peak voltage of self-test and scan, and start value of the amplitude loop, V.
    #[setting(controller)]
    pub scan_volts: f32,
    /// Offset of the drive from the resonance in a run, Hz; from `frequency_hz` if nothing is
    /// tracked.
    #[setting(scene, default, min = -450e3, max = 450e3, quiet)]
    pub detune_hz: f32,
    /// Waveform in a run.
    #[setting(default, key = 64)]
    pub shape: ShapeKind,
    /// Lower end of the noise band, Hz. Default: 0.75 of `frequency_hz`.
    #[setting(scene, min = 100.0, max = 450e3)]
    pub noise_low_hz: Option<f32>,
    /// Upper end of the noise band, Hz. Default: 1.25 of `frequency_hz`.
    #[setting(scene, min = 100.0, max = 450e3)]
    pub noise_high_hz: Option<f32>,
    /// Noise band, from and to, Hz.
    #[setting(controller)]
    pub noise_band_hz: (f32, f32),
    /// Adds random steps of up to one code before rounding, so that rounding causes noise instead
    /// of harmonics.
    #[setting(default, key = 28, quiet)]
    pub dither: bool,
    /// Rise time of the amplitude from that of the scan to the set point, after a lock, s. Zero: at
    /// once.
    #[setting(default, min = 0.0, max = 100.0, key = 91, quiet)]
    pub soft_start_s: f32,
    /// Number of drive lanes; the stack is connected to the first.
    #[setting(scene, default = 1, min = 1, max = 4)]
    pub lanes: u8,
    /// Seed of noise and dither.
    #[setting(controller)]
    pub seed: u64,
}

impl Drive {
    /// Peak voltage of the scan, V.
    pub(crate) const SCAN_VOLTS: Setting = Setting { name: "drive.scan_volts", ..Self::SCAN_V };
    /// Amplitude as a motional current, A peak.
    pub(crate) const MOTIONAL_CURRENT_A: Setting = Setting { name: "drive.motional_current_a", ..Limits::CURRENT_A };

    /// Parameters that are not a single field. The amplitude is a voltage or a current; the other
    /// one reads as zero.
    pub(crate) const OTHERS: &'static [Parameter] = &[
        Parameter {
            key: 6,
            name: Self::MOTIONAL_CURRENT_A.name,
            range: Self::MOTIONAL_CURRENT_A.range(),
            read: |config| if let Amplitude::MotionalCurrent(amperes) = config.drive.amplitude { amperes } else { 0.0 },
            write: |config, value| config.drive.amplitude = Amplitude::MotionalCurrent(value),
        },
        Parameter {
            key: 7,
            name: Self::SCAN_VOLTS.name,
            range: Self::SCAN_VOLTS.range(),
            read: |config| config.drive.scan_volts,
            write: |config, value| config.drive.scan_volts = value,
        },
        Parameter {
            key: 66,
            name: Self::NOISE_LOW_HZ.name,
            range: Self::NOISE_LOW_HZ.range(),
            read: |config| config.drive.noise_band_hz.0,
            write: |config, value| config.drive.noise_band_hz.0 = value,
        },
        Parameter {
            key: 67,
            name: Self::NOISE_HIGH_HZ.name,
            range: Self::NOISE_HIGH_HZ.range(),
            read: |config| config.drive.noise_band_hz.1,
            write: |config, value| config.drive.noise_band_hz.1 = value,
        },
    ];

    /// Creates a plain sine. Its noise band is half as wide as the frequency.
    pub fn sine(frequency_hz: f32, amplitude: Amplitude, scan_volts: f32) -> Self {
        let noise_band_hz = (0.75 * frequency_hz, 1.25 * frequency_hz);
        Drive {
            frequency_hz,
            amplitude,
            scan_volts,
            shape: ShapeKind::Sine,
            noise_band_hz,
            dither: false,
            soft_start_s: 0.0,
            seed: 1,
        }
    }
}

/// Waveform in a run. Self-test, scan and calibration use sines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "scene", derive(JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum ShapeKind {
    /// A sine wave.
    #[default]
    Sine,
    /// A band-limited square wave.
    Square,
    /// A band-limited rising sawtooth.
    Sawtooth,
    /// Gaussian noise within a band, clipped at the peak, which is four times its rms. It cannot be
    /// tracked.
    Noise,
}

impl Choice for ShapeKind {
    const ALL: &'static [Self] = &[ShapeKind::Sine, ShapeKind::Square, ShapeKind::Sawtooth, ShapeKind::Noise];
    const NAMES: &'static [&'static str] = &["sine", "square", "sawtooth", "noise"];
}

/// Returns the voltage as a parameter; zero if the amplitude is a motional current.
fn amplitude_v(config: &Config) -> f32 {
    if let Amplitude::Volts(volts) = config.drive.amplitude { volts } else { 0.0 }
}

fn set_amplitude_v(config: &mut Config, value: f32) {
    config.drive.amplitude = Amplitude::Volts(value);
}
