//! The plant of the controller: amplifier, sensors and stack.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Smallest and largest factor by which the laws of temperature and amplitude multiply Rm, C0 and
/// the force factor of a stack. Beyond these, the laws are not valid, because they are the first
/// terms of series.
pub const LAW_FACTORS: (f64, f64) = (0.1, 10.0);

/// The power amplifier: second-order Butterworth low-pass and a source resistance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Amplifier {
    /// Output at the end of the DAC's range, V; the range extends this far on each side of zero.
    #[schemars(range(min = 0.1, max = 1e4))]
    pub full_scale_v: f64,
    /// Corner frequency of the amplifier, Hz.
    #[schemars(range(min = 1e3, max = 1e7))]
    pub bandwidth_hz: f64,
    /// Source resistance of the amplifier, ohm.
    #[schemars(range(min = 1e-3, max = 1e4))]
    pub source_ohm: f64,
    /// Pure delay between DAC and amplifier, s; for a stack.
    #[schemars(range(min = 0.0, max = 1e-3))]
    pub delay_s: f64,
    /// Phase by which each lane of a stator leads its set point, degrees at
    /// `controller.drive.frequency_hz`; at other frequencies in proportion to the frequency.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 4), inner(range(min = -45.0, max = 45.0)))]
    pub lane_phase_error_deg: Vec<f64>,
    /// Relative error of the output of each lane of a stator; positive: too large.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 4), inner(range(min = -0.5, max = 0.5)))]
    pub lane_gain_error: Vec<f64>,
    /// Number of lanes of the board; each has a converter and an amplifier.
    #[schemars(range(min = 1, max = 4))]
    pub lanes: u8,
}

impl Default for Amplifier {
    fn default() -> Self {
        Amplifier {
            full_scale_v: 20.0,
            bandwidth_hz: 200e3,
            source_ohm: 0.3,
            delay_s: 0.0,
            lane_phase_error_deg: Vec::new(),
            lane_gain_error: Vec::new(),
            lanes: 4,
        }
    }
}

/// The converters, the load cell, and the controller's other sensors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Sensors {
    /// Sample rate of DAC and ADC, Hz.
    #[schemars(range(min = 1e5, max = 1e7))]
    pub sample_hz: f64,
    /// Resolution of the ADC, bits.
    #[schemars(range(min = 6, max = 16))]
    pub adc_bits: u8,
    /// Resolution of the DAC, bits.
    #[schemars(range(min = 6, max = 16))]
    pub dac_bits: u8,
    /// Noise of each conversion before averaging, LSB rms.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub noise_lsb: f64,
    /// Offset of each sense channel, LSB.
    #[schemars(range(min = -500.0, max = 500.0))]
    pub offset_lsb: f64,
    /// Conversions per sample, evenly spaced and summed.
    #[schemars(range(min = 1, max = 4))]
    pub oversample: u8,
    /// Voltage at the end of the ADC's range, V; the range extends this far on each side of zero.
    #[schemars(range(min = 1e-3, max = 1e4))]
    pub v_full_scale_v: f64,
    /// Current at the end of the ADC's range, A; the range extends this far on each side of zero.
    #[schemars(range(min = 1e-6, max = 1e3))]
    pub i_full_scale_a: f64,
    /// Delay of the current samples after the voltage samples, s.
    #[schemars(range(min = -2e-7, max = 2e-7))]
    pub skew_s: f64,
    /// Bandwidth of the load cell and its conditioner, Hz.
    #[schemars(range(min = 0.1, max = 1e5))]
    pub load_cell_hz: f64,
    /// Counts of the belt's encoder, four edges per line, for each millimetre of belt or slider.
    /// Default: no encoder.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.1, max = 1e4))]
    pub encoder_counts_per_mm: Option<f64>,
    /// Bandwidth of the controller's force channel, Hz. Default: no force channel.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1.0, max = 1e5))]
    pub force_hz: Option<f64>,
    /// Noise of each reading of the force channel, one per block, N rms.
    #[serde(skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 1e4))]
    pub force_noise_n: f64,
    /// Reading of the temperature sensor at the driver, degrees Celsius. Default: no sensor.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = -273.0, max = 1000.0))]
    pub board_c: Option<f64>,
}

impl Default for Sensors {
    fn default() -> Self {
        Sensors {
            sample_hz: 1e6,
            adc_bits: 12,
            dac_bits: 12,
            noise_lsb: 1.0,
            offset_lsb: 3.0,
            oversample: 2,
            v_full_scale_v: 20.0,
            i_full_scale_a: 4.0,
            skew_s: 0.0,
            load_cell_hz: 80.0,
            encoder_counts_per_mm: None,
            force_hz: None,
            force_noise_n: 0.0,
            board_c: None,
        }
    }
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// The piezo stack with its modes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stack {
    /// Temperature over ambient, K. For a stack that heats itself (`[stack.thermal]`): temperature
    /// of the surroundings, at which it begins.
    #[serde(default)]
    #[schemars(range(min = -300.0, max = 1000.0))]
    pub temperature_k: f64,
    /// Self-heating of the stack. Default: the stack has the temperature of its surroundings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thermal: Option<Thermal>,
    /// Mechanical design from which circuit and further modes follow, instead of `bvd` and `mode`.
    #[serde(default, skip_serializing)]
    pub design: Option<StackDesign>,
    /// Butterworth-Van Dyke equivalent circuit.
    pub bvd: Bvd,
    /// Further modes, which disturb the working mode.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 3))]
    pub mode: Vec<Mode>,
}

/// The mechanical design of the stack.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StackDesign {
    /// Name of a built-in scene of a design, or of its file, relative to this file.
    pub file: String,
}

/// The stack as one body heated by its own losses: `C dT/dt = P - (T - surroundings) / R`. The
/// losses are those of all motional branches and of `bvd.loss_tangent`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Thermal {
    /// Heat capacity of the heated body, J/K.
    #[schemars(range(min = 1e-6, max = 1e6))]
    pub heat_capacity_j_per_k: f64,
    /// Thermal resistance to the surroundings, K/W.
    #[schemars(range(min = 1e-6, max = 1e6))]
    pub resistance_k_per_w: f64,
    /// Part of the motional loss that heats the stack; the rest is lost elsewhere, in a horn or a
    /// load.
    #[serde(default = "default::heating_fraction")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub heating_fraction: f64,
    /// Ambient temperature, degrees Celsius, at which `stack.temperature_k` is 0.
    #[serde(default = "default::ambient_c")]
    #[schemars(range(min = -273.0, max = 500.0))]
    pub ambient_c: f64,
    /// Curie point of the ceramic, degrees Celsius. A stack that reaches it loses its polarisation
    /// permanently, as with the fault `depoled`.
    #[schemars(range(min = 50.0, max = 1500.0))]
    pub curie_c: f64,
    /// Highest operating temperature of the ceramic, degrees Celsius. Above it, the ceramic slowly
    /// loses its polarisation; this is reported but not simulated. Default: half of `curie_c`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = -100.0, max = 1500.0))]
    pub depoling_c: Option<f64>,
}

impl Thermal {
    /// Returns the highest operating temperature of the ceramic, degrees Celsius.
    pub fn hottest_c(&self) -> f64 {
        self.depoling_c.unwrap_or(0.5 * self.curie_c)
    }

    /// Returns the thermal time constant, s.
    pub fn time_constant_s(&self) -> f64 {
        self.heat_capacity_j_per_k * self.resistance_k_per_w
    }
}

/// A further mode: a series branch in parallel with that of the working mode. It does not move the
/// tip in the direction of friction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Mode {
    /// Series resonance of the mode, Hz.
    #[schemars(range(min = 100.0, max = 450e3))]
    pub series_resonance_hz: f64,
    /// Quality factor at series resonance.
    #[schemars(range(min = 1.0, max = 1e6))]
    pub q: f64,
    /// Motional inductance of the mode, H.
    #[schemars(range(min = 1e-9, max = 1e4))]
    pub lm_h: f64,
}

/// Butterworth-Van Dyke equivalent circuit. Give `c0_f` or `ct_f`, and either `cm_f`, `lm_h`,
/// `rm_ohm`, or `series_resonance_hz`, `q`, `coupling`, or any other complete set: `q` or `rm_ohm`,
/// and two of `series_resonance_hz`, `parallel_resonance_hz`, `lm_h`, and `cm_f` or `coupling`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bvd {
    /// Clamped capacitance of the stack, F.
    #[schemars(range(min = 1e-13, max = 1e-3))]
    pub c0_f: f64,
    /// Capacitance of the stack far below its resonances, F: the sum of `c0_f` and all modes. May
    /// be given instead of `c0_f`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-13, max = 1e-3))]
    pub ct_f: Option<f64>,
    /// Motional capacitance of the working mode, F.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-16, max = 1e-3))]
    pub cm_f: Option<f64>,
    /// Motional inductance of the working mode, H.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-9, max = 1e4))]
    pub lm_h: Option<f64>,
    /// Motional resistance of the working mode, ohm.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-6, max = 1e7))]
    pub rm_ohm: Option<f64>,
    /// Series resonance of the working mode, Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 100.0, max = 450e3))]
    pub series_resonance_hz: Option<f64>,
    /// Parallel resonance of the working mode with `c0_f`, Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 100.0, max = 1e6))]
    pub parallel_resonance_hz: Option<f64>,
    /// Quality factor at series resonance.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1.0, max = 1e6))]
    pub q: Option<f64>,
    /// Effective coupling k: `k^2 = Cm / (C0 + Cm)`, which is below one for any capacitances. Data
    /// that give more are inconsistent: such a stack would be a source of energy.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-4, max = 0.99))]
    pub coupling: Option<f64>,
    /// Force factor, N/V: tip force per volt, and motional current per tip velocity, A per m/s.
    #[serde(default = "default::force_factor")]
    #[schemars(range(min = 1e-6, max = 1e4))]
    pub force_factor_n_per_v: f64,
    /// Dielectric loss tangent of `c0_f` at the series resonance: a constant conductance in
    /// parallel with it.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub loss_tangent: f64,
    /// Change of the series resonance with the stack's temperature, Hz/K. Temperature and amplitude
    /// together change it by at most 20 %.
    #[serde(default)]
    #[schemars(range(min = -1e4, max = 1e4))]
    pub temperature_hz_per_k: f64,
    /// Relative change of `c0_f` with the stack's temperature, 1/K.
    #[serde(default)]
    #[schemars(range(min = -0.1, max = 0.1))]
    pub temperature_c0_per_k: f64,
    /// Change of the series resonance with the square of the motional current's amplitude, Hz/A^2;
    /// negative for a stack that softens.
    #[serde(default)]
    #[schemars(range(min = -1e12, max = 1e12))]
    pub duffing_hz_per_a2: f64,
    /// Relative change of the motional resistance with the stack's temperature, 1/K.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = -0.1, max = 0.1))]
    pub temperature_rm_per_k: f64,
    /// Relative change of the force factor with the stack's temperature, 1/K; the mechanical
    /// resonance and its damping do not change.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = -0.1, max = 0.1))]
    pub temperature_force_factor_per_k: f64,
    /// Relative change of the motional resistance with the square of the motional current's
    /// amplitude, 1/A^2.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = -1e12, max = 1e12))]
    pub amplitude_rm_per_a2: f64,
    /// Largest factor by which the amplitude multiplies the motional resistance, so that Q has a
    /// lowest value. Default: no limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1.001, max = 1e3))]
    pub amplitude_rm_most: Option<f64>,
}

/// Force factor of a stack that gives none, N/V.
pub(crate) const DEFAULT_FORCE_FACTOR_N_PER_V: f64 = 1.0;

/// Defaults that serde needs as functions.
mod default {
    pub(super) fn force_factor() -> f64 {
        super::DEFAULT_FORCE_FACTOR_N_PER_V
    }

    pub(super) fn heating_fraction() -> f64 {
        1.0
    }

    pub(super) fn ambient_c() -> f64 {
        25.0
    }
}
