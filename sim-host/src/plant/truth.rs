//! The truth: what the plant did, which the controller never sees.

/// The truth about one block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truth {
    /// Friction: mean over the block, and its extremes at the steps, N.
    pub friction_mean_n: f64,
    /// Smallest friction, N.
    pub friction_min_n: f64,
    /// Largest friction, N.
    pub friction_max_n: f64,
    /// The load cell's reading at the block's end, N.
    pub load_cell_n: f64,
    /// Amplitude of the tip velocity at the block's end, m/s.
    pub tip_velocity_m_per_s: f64,
    /// Mean square of the tip velocity over the block, m²/s².
    pub tip_square_m2_per_s2: f64,
    /// Largest tip velocity to either side within the block, at the steps, m/s.
    pub tip_peak_m_per_s: f64,
    /// Series resonance during the block, Hz.
    pub series_resonance_hz: f64,
    /// Mean power into the motional branch, W.
    pub power_w: f64,
    /// Mean product of voltage and quarter-period-later current, W: with `power_w` it makes the motional phase, which only a mean
    /// over whole periods shows.
    pub quadrature_w: f64,
    /// Heat in the motional resistance, W.
    pub lost_w: f64,
    /// Power that the tip gives to friction, W.
    pub friction_on_tip_w: f64,
    /// Power that the slider's drive gives to friction, W.
    pub friction_on_slider_w: f64,
}

/// The truth about one sample, for zooms and traces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Voltage at the stack, V.
    pub voltage_v: f64,
    /// Motional current, A.
    pub motional_current_a: f64,
    /// Tip velocity, m/s.
    pub tip_velocity_m_per_s: f64,
    /// Friction, mean over the sample, N.
    pub friction_n: f64,
}
