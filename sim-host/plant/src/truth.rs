//! The truth: what the plant did, which the controller never sees.

use crate::carriage::CarriageTruth;

/// The truth about one block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truth {
    /// Friction: mean over the block, and its extremes at the steps, N.
    pub friction_mean_n: f64,
    /// Smallest friction within the block, N.
    pub friction_min_n: f64,
    /// Largest friction within the block, N.
    pub friction_max_n: f64,
    /// The load cell's reading at the block's end, N.
    pub load_cell_n: f64,
    /// Amplitude of the tip velocity at the block's end, m/s.
    pub tip_velocity_m_per_s: f64,
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
    /// Power that the slider's drive gives to friction, W; a rotor takes power, which is less than zero here.
    pub friction_on_slider_w: f64,
    /// How far belt or slider have come at the block's end, m.
    pub belt_position_m: f64,
    /// Speed of belt or slider at the block's end, m/s.
    pub belt_speed_m_per_s: f64,
    /// What only a stack has.
    pub tip: Option<TipMotion>,
    /// What only a horn on a belt has.
    pub horn: Option<HornTruth>,
    /// What only a carriage has.
    pub carriage: Option<CarriageTruth>,
    /// What only a stack that heats itself has.
    pub heat: Option<HeatTruth>,
}

/// How the tip of a stack moved within a block, whatever the waveform.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TipMotion {
    /// Mean square of its velocity, m²/s².
    pub square_m2_per_s2: f64,
    /// Largest velocity to either side, at the steps, m/s.
    pub peak_m_per_s: f64,
}

/// How a stack heated itself in a block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeatTruth {
    /// Temperature over ambient at the block's end, K.
    pub temperature_k: f64,
    /// Losses that heat it, mean over the block, W.
    pub heating_w: f64,
    /// By how much the loss grows with a kelvin at the same motional current, over what leaves with that kelvin. From one on nothing is
    /// steady: thermal runaway.
    pub gain: f64,
    /// Temperature over ambient to which it would come at the motional current of this block, K; not a number where there is none.
    pub lasting_k: f64,
    /// Whether it has been at its Curie point, and has no polarisation any more.
    pub depoled: bool,
}

/// How the horn on a belt vibrated at the end of a block, and what that would do if it lasted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HornTruth {
    /// Amplitude, part of the full one.
    pub amplitude_fraction: f64,
    /// Part of the friction that goes in the end.
    pub lasting_reduction: f64,
}

/// The truth about one block of a travelling-wave motor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorTruth {
    /// Amplitude of the wave that turns the rotor forwards, m, at the block's end.
    pub forward_m: f64,
    /// Amplitude of the wave that runs the other way, m.
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
    /// Half angle over which the crests of the stronger wave touch, degrees.
    pub contact_deg: f64,
    /// Normal force, mean over the block, N.
    pub normal_n: f64,
    /// How far the contact's spring, which is left out, would move the resonance, Hz.
    pub normal_shift_hz: f64,
    /// Largest phase error of a lane as played, degrees; not of silence.
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
    /// Envelope of the tip velocity, `sqrt(v^2 + (w_s x)^2)`; of a stator that of the stronger wave's crests, m/s.
    pub tip_envelope_m_per_s: f64,
    /// Friction, mean over the sample, N.
    pub friction_n: f64,
    /// What only a motor has.
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
