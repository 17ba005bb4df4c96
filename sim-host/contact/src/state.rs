//! What a study sees of a run at one moment.

/// A moment of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// Time of the state, s.
    pub time_s: f64,
    /// Displacement x of the oscillator, m.
    pub x_m: f64,
    /// Velocity x' of the oscillator, m/s.
    pub v_m_per_s: f64,
    /// Friction F, N. At the beginning of a LuGre run: the force in the bristles.
    pub force_n: f64,
}
