//! Quantities of the friction switch: its measurements, its set point, and its estimate.

/// Set point of the drive, from the friction switch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SetPoint {
    /// The drive is silent.
    Silence,
    /// A motional current, A peak.
    Current(f32),
    /// A motional current during part of each burst period.
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
    /// Belt speed, m/s; none without a sensor.
    pub(crate) belt_m_per_s: Option<f32>,
    /// Where the belt is, counts since power-up; none without a sensor.
    pub(crate) counts: Option<i32>,
    /// Friction, N; none without a sensor.
    pub(crate) force_n: Option<f32>,
    /// Motional current of a block that was ON throughout, and had rung up before it where a boost has done that, A peak.
    pub(crate) motional_a: Option<f32>,
}
