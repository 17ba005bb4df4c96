//! The truth: states of the plant that the controller never receives.

use crate::carriage::CarriageTruth;

/// The truth about one block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truth {
    /// Mean friction over the block, N.
    pub friction_mean_n: f64,
    /// Smallest friction at the steps of the block, N.
    pub friction_min_n: f64,
    /// Largest friction at the steps of the block, N.
    pub friction_max_n: f64,
    /// The load cell's reading at the block's end, N.
    pub load_cell_n: f64,
    /// Amplitude of the tip velocity at the block's end, m/s.
    pub tip_velocity_m_per_s: f64,
    /// Series resonance during the block, Hz.
    pub series_resonance_hz: f64,
    /// Mean power into the motional branch, W.
    pub power_w: f64,
    /// Mean product of the voltage and the current a quarter period later, W. With `power_w` it
    /// gives the motional phase, but only as a mean over whole periods.
    pub quadrature_w: f64,
    /// Heat in the motional resistance, W.
    pub lost_w: f64,
    /// Power from the tip into friction, W.
    pub friction_on_tip_w: f64,
    /// Power from the slider's drive into friction, W; negative for a rotor, which takes power.
    pub friction_on_slider_w: f64,
    /// Position of belt or slider at the block's end, m.
    pub belt_position_m: f64,
    /// Speed of belt or slider at the block's end, m/s.
    pub belt_speed_m_per_s: f64,
    /// Motion of the tip, for a stack.
    pub tip: Option<TipMotion>,
    /// Vibration of the horn, for a horn on a belt.
    pub horn: Option<HornTruth>,
    /// Forces on the carriage, if there is one.
    pub carriage: Option<CarriageTruth>,
    /// Thermal state, for a stack that heats itself.
    pub heat: Option<HeatTruth>,
}

/// Motion of a stack's tip within a block, for any waveform.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TipMotion {
    /// Mean square of its velocity, m²/s².
    pub square_m2_per_s2: f64,
    /// Largest velocity to either side, at the steps, m/s.
    pub peak_m_per_s: f64,
}

/// Thermal state of a stack that heats itself, for one block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeatTruth {
    /// Temperature over ambient at the block's end, K.
    pub temperature_k: f64,
    /// Losses that heat it, mean over the block, W.
    pub heating_w: f64,
    /// Increase of the loss per kelvin at the same motional current, relative to the additional
    /// heat flow per kelvin. At one or above there is no steady state: thermal runaway.
    pub gain: f64,
    /// Final temperature over ambient at the motional current of this block, K; NaN if there is
    /// none.
    pub lasting_k: f64,
    /// `true` if it has reached its Curie point and lost its polarisation.
    pub depoled: bool,
}

/// Vibration of the horn on a belt at the end of a block, and its lasting effect.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HornTruth {
    /// Amplitude, relative to the full one.
    pub amplitude_fraction: f64,
    /// Reduction of the friction in the steady state, relative.
    pub lasting_reduction: f64,
}

/// The truth about one block of a travelling-wave motor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorTruth {
    /// Amplitude of the wave that turns the rotor forwards, m, at the block's end.
    pub forward_m: f64,
    /// Amplitude of the wave in the other direction, m.
    pub backward_m: f64,
    /// Surface speed at the crests of the forward wave alone, m/s.
    pub forward_m_per_s: f64,
    /// Surface speed at the crests of the backward wave alone, m/s.
    pub backward_m_per_s: f64,
    /// Speed of the rotor, rad/s.
    pub rotor_rad_per_s: f64,
    /// Surface speed of the rotor, m/s.
    pub rotor_m_per_s: f64,
    /// Torque of the friction on the rotor, mean over the block, N m.
    pub torque_nm: f64,
    /// Half the angle over which the crests of the stronger wave touch, degrees.
    pub contact_deg: f64,
    /// Normal force, mean over the block, N.
    pub normal_n: f64,
    /// Shift of the resonance that the omitted spring of the contact would cause, Hz.
    pub normal_shift_hz: f64,
    /// Largest phase error of a lane as played, degrees; `None` in silence.
    pub lane_phase_error_deg: Option<f64>,
    /// Largest amplitude error of a lane as played, per cent.
    pub lane_gain_error_percent: Option<f64>,
}

/// The truth about one sample, for zooms and traces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Voltage at the stack, V.
    pub voltage_v: f64,
    /// Motional current of the sample, A.
    pub motional_current_a: f64,
    /// Tip velocity of the sample, m/s.
    pub tip_velocity_m_per_s: f64,
    /// Envelope of the tip velocity, `sqrt(v^2 + (w_s x)^2)`; for a stator, that of the stronger
    /// wave's crests, m/s.
    pub tip_envelope_m_per_s: f64,
    /// Friction, mean over the sample, N.
    pub friction_n: f64,
    /// Additional truth of a motor.
    pub motor: Option<MotorSample>,
}

/// The truth about one sample of a motor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorSample {
    /// Voltages of the lanes, V.
    pub lanes_v: [f64; 4],
    /// Displacement of the surface under the first tab across and along the ring, m.
    pub surface_m: [f64; 2],
    /// Speed of the rotor, rad/s.
    pub rotor_rad_per_s: f64,
}
