//! The firmware's own check of its settings: a scene that the firmware refuses is not valid.

use firmware::controller::Controller;
use firmware::seam::error::Error;

use super::Rules;
use super::drive::AMPLITUDE_FRACTION;
use super::drive::{AMPLITUDE, FREQUENCY, SCAN, VELOCITY};
use crate::Scene;
use crate::diagnostic::Problem;
use crate::schema::{Schema, join};
use crate::settings;
use crate::wording::{bound, quantity, range};

const MODE: &str = "controller.tracking.mode";
const SHAPE: &str = "controller.drive.shape";
const AROUND: &str = "controller.sweep.around";
const EDGE: &str = "controller.burst.edge";
const ON_TIMES: &str = "controller.burst.on_s";
const SCALE_HELP: &str = "a code must have a value that the firmware can represent";
const CHIRP_HELP: &str = "a chirp must stay above 0 Hz and below 0.45 of `sensors.sample_hz`; around the resonance, these are \
                       offsets from `drive.frequency_hz`";
const LANE_HELP: &str = "the lane of the largest voltage, with its `gain_trim`, must stay within `controller.limits.voltage_v`";

/// Parameters of the firmware, their keys, and the causes of their ranges. Other parameters have
/// the same name as their key in `[controller]`, and an independent range.
const PARAMETERS: &[(&str, &str, &str)] = &[
    ("sample_hz", "sensors.sample_hz", ""),
    ("lanes", "controller.drive.lanes", "`amplifier.lanes` is the number of lanes of the board"),
    ("front_end.volt_per_lsb", "sensors.v_full_scale_v", SCALE_HELP),
    ("front_end.ampere_per_lsb", "sensors.i_full_scale_a", SCALE_HELP),
    ("front_end.drive_volt_per_lsb", "amplifier.full_scale_v", SCALE_HELP),
    ("drive.frequency_hz", FREQUENCY, "a tone needs more than two samples per period, see `sensors.sample_hz`"),
    ("drive.amplitude_v", AMPLITUDE, LANE_HELP),
    ("drive.scan_volts", SCAN, LANE_HELP),
    ("drive.scan_volts", AMPLITUDE, "without `scan_v`, self-test and scan also use this voltage"),
    ("drive.motional_current_a", VELOCITY, "motional current = force factor x velocity, within `controller.limits.current_a`"),
    (
        "drive.motional_current_a",
        AMPLITUDE_FRACTION,
        "motional current = force factor x amplitude x 2 pi frequency, within `controller.limits.current_a`",
    ),
    ("front_end.drive_lanes", "amplifier.lanes", ""),
    ("drive.noise_low_hz", "controller.drive.noise_low_hz", "the band must be within the range of `sensors.sample_hz`"),
    (
        "friction.detent_pitch_m",
        "controller.friction.detent_pitch_m",
        "a detent needs at least eight counts of the encoder, `sensors.encoder_counts_per_mm`",
    ),
    (
        "drive.noise_high_hz",
        "controller.drive.noise_high_hz",
        "above `noise_low_hz`, and within the range of `sensors.sample_hz`",
    ),
    ("sweep.start_hz", "controller.sweep.start_hz", CHIRP_HELP),
    ("sweep.stop_hz", "controller.sweep.stop_hz", CHIRP_HELP),
    ("sweep.time_s", "controller.sweep.time_s", "at least a block; around the resonance, long enough for the phase to follow"),
    ("friction.force_factor_n_per_v", "controller.tracking.nominal_force_factor_n_per_v", ""),
    (
        "tracking.bandwidth_hz",
        "controller.tracking.bandwidth_hz",
        "the loop acts once per block: a smaller `controller.block_samples`, or a larger `sensors.sample_hz`, allows more",
    ),
];

impl Rules<'_> {
    /// Builds the controller with the settings of the scene, and reports its error.
    pub(super) fn firmware(&mut self) {
        if !self.findings.problems.is_empty() {
            return;
        }
        let Ok(scene) = Scene::from_tree(self.root) else { return };
        let Some(scene) = scene.driven() else { return };
        let Err(error) = Controller::build(&settings::config(&scene)) else { return };
        match error {
            Error::OutOfRange { parameter, value, min, max } => match self.source_of(parameter) {
                Some((key, why)) => self.add_refusal(&key, why, value, (min, max)),
                None => {
                    let message = format!("the firmware refuses its settings: {error}");
                    let problem = Problem::new(self.place("controller"), message, "a setting that is derived from others");
                    self.add("controller", problem);
                }
            },
            Error::CurrentWithoutTracking => {
                let at = self.newer(VELOCITY, MODE);
                let message = "a velocity is controlled through the motional current, which needs tracking";
                let label = if at == MODE { "cannot be `off` with a velocity".to_owned() } else { format!("needs `{MODE}`") };
                let problem = Problem::new(self.place(at), message, label);
                self.add(at, problem.help("give `amplitude_v` instead, or a mode other than `off`"));
            }
            Error::NoiseWithTracking => self.add_contradiction(SHAPE, &error, "needs `controller.tracking.mode = \"off\"`"),
            Error::NoiseWithSweep => self.add_contradiction(SHAPE, &error, "needs a scene without [controller.sweep]"),
            Error::ChirpAgainstTracking => {
                self.add_contradiction(AROUND, &error, "needs `controller.tracking.mode = \"off\"`, or `around = \"resonance\"`")
            }
            Error::ResonanceWithoutTracking => {
                self.add_contradiction(AROUND, &error, "needs a `controller.tracking.mode` other than `off`")
            }
            Error::ExponentialAroundResonance => self.add_contradiction("controller.sweep.kind", &error, "must be `linear`"),
            Error::FrictionWithoutCurrent => {
                self.add_contradiction("controller.friction", &error, "needs `controller.drive.velocity_m_per_s`")
            }
            Error::BoostWithoutTracking => {
                self.add_contradiction(EDGE, &error, "needs `controller.tracking.mode` `observer` or `phase_lock`")
            }
            Error::BoostOfShape => self.add_contradiction(EDGE, &error, "needs `controller.drive.shape = \"sine\"`"),
            Error::BoostWithSweep => self.add_contradiction(EDGE, &error, "needs a scene without [controller.sweep]"),
            Error::DetentsWithoutEncoder => {
                const PITCH: &str = "controller.friction.detent_pitch_m";
                let message = "the detents of a knob follow its position, which needs an encoder";
                let problem = Problem::new(self.place(PITCH), message, "needs `sensors.encoder_counts_per_mm`");
                self.add(PITCH, problem);
            }
            Error::EnergyWithoutBelt => {
                const ENERGY: &str = "controller.limits.energy_j_per_m";
                let message = "energy per metre of belt can only be measured with an encoder";
                let problem = Problem::new(self.place(ENERGY), message, "needs `sensors.encoder_counts_per_mm`");
                self.add(ENERGY, problem);
            }
            // Scenes contain no calibrations, and this program includes all parts.
            Error::TrimOrder | Error::LeftOut { .. } => {}
            Error::BurstWindows => {
                let message = format!("the firmware refuses the burst: {error}");
                let label = format!("each must last at least one sample, {}", quantity(1.0 / scene.sensors.sample_hz, ON_TIMES));
                let problem = Problem::new(self.place(ON_TIMES), message, label);
                self.add(ON_TIMES, problem);
            }
        }
    }

    /// Reports two settings that contradict each other.
    fn add_contradiction(&mut self, key: &str, error: &Error, label: &str) {
        let at = self.newer(key, MODE);
        let problem = Problem::new(self.place(at), format!("the firmware refuses these settings: {error}"), label.to_owned());
        self.add(at, problem);
    }

    /// Returns the key of a parameter, and the cause of its range.
    fn source_of(&self, parameter: &str) -> Option<(String, &'static str)> {
        let mut listed = PARAMETERS.iter().filter(|(name, ..)| *name == parameter);
        if let Some((_, key, why)) = listed.clone().find(|(_, key, _)| self.given(key)).or_else(|| listed.next()) {
            return Some(((*key).to_owned(), why));
        }
        let key = join("controller", parameter);
        Schema::root().at(&key).map(|_| (key, ""))
    }

    fn add_refusal(&mut self, key: &str, why: &str, value: f64, (min, max): (f64, f64)) {
        const EQUAL_REL: f64 = 1e-6;
        let Some(schema) = Schema::root().at(key) else { return };
        let given = self.number(key).unwrap_or(value);
        // The parameter may be a multiple of the key, and has single precision.
        let multiple =
            Some(given / value).filter(|multiple| multiple.is_normal() && (multiple - 1.0).abs() > EQUAL_REL).unwrap_or(1.0);
        let allowed = |key: f64| (min..=max).contains(&f64::from((key / multiple) as f32));
        let (least, most) = schema.range();
        let least = bound(min * multiple, 1.0, allowed).max(least.unwrap_or(f64::MIN));
        let most = bound(max * multiple, -1.0, allowed).min(most.unwrap_or(f64::MAX));
        let from = if self.given(key) { "" } else { ", the default" };
        let message = format!("the firmware refuses `{key}` = {}{from}", quantity(given, key));
        let label = format!("must be {}", range((Some(least), Some(most)), key));
        let problem = Problem::new(self.place(key), message, label);
        let help = if why.is_empty() { schema.description().unwrap_or_default() } else { why };
        self.add(key, problem.help(help));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn listed_parameters_have_number_keys() {
        for (_, key, _) in PARAMETERS {
            assert!(Schema::root().at(key).is_some_and(Schema::is_number), "{key}");
        }
    }
}
