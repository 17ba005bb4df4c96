//! The state of a run at one moment, as an observer receives it.

/// State of a run at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// Time of the state, s.
    pub time_s: f64,
    /// Displacement x of the oscillator, m.
    pub x_m: f64,
    /// Velocity x' of the oscillator, m/s.
    pub v_m_per_s: f64,
    /// Friction F, N. At the start of a LuGre run: the force in the bristles.
    pub force_n: f64,
}
