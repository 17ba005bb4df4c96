//! Measurements and set point of the friction switch.

/// Set point of the drive, from the friction switch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SetPoint {
    /// No drive.
    Silence,
    /// Constant motional current, A peak.
    Current(f32),
    /// Motional current during part of each burst period.
    Bursts {
        /// Motional current, A peak.
        amperes: f32,
        /// ON time of a burst, samples.
        on_samples: f32,
    },
}

/// Measurements of one block that the friction switch uses.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sensed {
    /// Belt speed, m/s; `None` without a sensor.
    pub(crate) belt_m_per_s: Option<f32>,
    /// Belt position, counts since power-up; `None` without a sensor.
    pub(crate) counts: Option<i32>,
    /// Friction, N; `None` without a sensor.
    pub(crate) force_n: Option<f32>,
    /// Motional current, A peak; `None` unless the block was ON throughout and, after a boost,
    /// fully built up.
    pub(crate) motional_a: Option<f32>,
}
