//! What the switch is asked, what it hears, what it orders, and what it believes.

/// What is to be played.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wanted {
    /// Nothing.
    Silence,
    /// This motional current, A.
    Current(f32),
    /// This motional current, A, for so many samples of each burst.
    Bursts {
        /// Peak, A.
        amperes: f32,
        /// ON time of a burst, samples.
        on_samples: f32,
    },
}

/// What one block has to say.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sensed {
    /// Belt speed, m/s; none without a sensor.
    pub(crate) belt_m_per_s: Option<f32>,
    /// Friction, N; none without a sensor.
    pub(crate) force_n: Option<f32>,
    /// Motional current of a block that was ON throughout, and had rung up before it where a boost has done that, A peak.
    pub(crate) motional_a: Option<f32>,
}
