//! The firmware has the last word: it checks its settings itself, and a scene that it refuses is not valid.

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
const BEGINNINGS: &str = "controller.burst.on_s";
const SCALE: &str = "one code must be worth something the firmware can calculate with";
const CARRIED: &str =
    "no chirp through 0 Hz, nor above 0.45 of `sensors.sample_hz`; about a resonance, as offsets from `drive.frequency_hz`";
const LARGEST: &str = "the lane of the largest voltage, with its `gain_trim`, must stay within `controller.limits.voltage_v`";

/// Parameters of the firmware, the keys that they come from, and on what their ranges depend. Others have the name of their key
/// in `[controller]`, and a range of their own.
const PARAMETERS: &[(&str, &str, &str)] = &[
    ("sample_hz", "sensors.sample_hz", ""),
    ("lanes", "controller.drive.lanes", "the board has so many: `amplifier.lanes`"),
    ("front_end.volt_per_lsb", "sensors.v_full_scale_v", SCALE),
    ("front_end.ampere_per_lsb", "sensors.i_full_scale_a", SCALE),
    ("front_end.drive_volt_per_lsb", "amplifier.full_scale_v", SCALE),
    ("drive.frequency_hz", FREQUENCY, "a tone needs more than two samples a period, of `sensors.sample_hz`"),
    ("drive.amplitude_v", AMPLITUDE, LARGEST),
    ("drive.scan_volts", SCAN, LARGEST),
    ("drive.scan_volts", AMPLITUDE, "without `scan_v`, self-test and scan have this voltage, too"),
    ("drive.motional_current_a", VELOCITY, "motional current = force factor x velocity, within `controller.limits.current_a`"),
    (
        "drive.motional_current_a",
        AMPLITUDE_FRACTION,
        "motional current = force factor x amplitude x 2 pi frequency, within `controller.limits.current_a`",
    ),
    ("front_end.drive_lanes", "amplifier.lanes", ""),
    ("drive.noise_low_hz", "controller.drive.noise_low_hz", "the band must lie within what `sensors.sample_hz` carries"),
    (
        "friction.detent_pitch_m",
        "controller.friction.detent_pitch_m",
        "a detent has eight counts of the encoder at least, of `sensors.encoder_counts_per_mm`",
    ),
    (
        "drive.noise_high_hz",
        "controller.drive.noise_high_hz",
        "above `noise_low_hz`, and within what `sensors.sample_hz` carries",
    ),
    ("sweep.start_hz", "controller.sweep.start_hz", CARRIED),
    ("sweep.stop_hz", "controller.sweep.stop_hz", CARRIED),
    ("sweep.time_s", "controller.sweep.time_s", "a block at least; about a resonance so long that its phase can follow"),
    ("friction.force_factor_n_per_v", "controller.tracking.nominal_force_factor_n_per_v", ""),
    (
        "tracking.bandwidth_hz",
        "controller.tracking.bandwidth_hz",
        "the loop acts once a block: fewer `controller.block_samples`, or more `sensors.sample_hz`, allow more",
    ),
];

impl Rules<'_> {
    /// Builds the controller that the scene is for.
    pub(super) fn firmware(&mut self) {
        if !self.findings.problems.is_empty() {
            return;
        }
        let Ok(scene) = Scene::of_tree(self.root) else { return };
        let Some(scene) = scene.driven() else { return };
        let Err(error) = Controller::build(&settings::config(&scene)) else { return };
        match error {
            Error::OutOfRange { parameter, value, min, max } => match self.source_of(parameter) {
                Some((key, why)) => self.refused(&key, why, value, (min, max)),
                None => {
                    let message = format!("the firmware refuses its settings: {error}");
                    let problem = Problem::new(self.place("controller"), message, "a setting that follows from others");
                    self.add("controller", problem);
                }
            },
            Error::CurrentWithoutTracking => {
                let at = self.newer(VELOCITY, MODE);
                let message = "a velocity is held by the motional current, which needs tracking";
                let label = if at == MODE { "cannot be `off` with a velocity".to_owned() } else { format!("needs `{MODE}`") };
                let problem = Problem::new(self.place(at), message, label);
                self.add(at, problem.help("give `amplitude_v` instead, or a mode other than `off`"));
            }
            Error::NoiseWithTracking => self.contradicts(SHAPE, &error, "needs `controller.tracking.mode = \"off\"`"),
            Error::NoiseWithSweep => self.contradicts(SHAPE, &error, "needs a scene without [controller.sweep]"),
            Error::ChirpAgainstTracking => {
                self.contradicts(AROUND, &error, "needs `controller.tracking.mode = \"off\"`, or `around = \"resonance\"`")
            }
            Error::ResonanceWithoutTracking => {
                self.contradicts(AROUND, &error, "needs a `controller.tracking.mode` other than `off`")
            }
            Error::ExponentialAroundResonance => self.contradicts("controller.sweep.kind", &error, "must be `linear`"),
            Error::FrictionWithoutCurrent => {
                self.contradicts("controller.friction", &error, "needs `controller.drive.velocity_m_per_s`")
            }
            Error::BoostWithoutTracking => {
                self.contradicts(EDGE, &error, "needs `controller.tracking.mode` `observer` or `phase_lock`")
            }
            Error::BoostOfShape => self.contradicts(EDGE, &error, "needs `controller.drive.shape = \"sine\"`"),
            Error::BoostWithSweep => self.contradicts(EDGE, &error, "needs a scene without [controller.sweep]"),
            Error::DetentsWithoutEncoder => {
                const PITCH: &str = "controller.friction.detent_pitch_m";
                let message = "the detents of a knob follow its position, which an encoder has to tell";
                let problem = Problem::new(self.place(PITCH), message, "needs `sensors.encoder_counts_per_mm`");
                self.add(PITCH, problem);
            }
            Error::EnergyWithoutBelt => {
                const ENERGY: &str = "controller.limits.energy_j_per_m";
                let message = "energy for each metre of belt is known only where the belt has an encoder";
                let problem = Problem::new(self.place(ENERGY), message, "needs `sensors.encoder_counts_per_mm`");
                self.add(ENERGY, problem);
            }
            // Calibrations are measured, and no scene states one; this program leaves nothing out.
            Error::TrimOrder | Error::LeftOut { .. } => {}
            Error::BurstWindows => {
                let message = format!("the firmware refuses the burst: {error}");
                let label = format!("each must last a sample at least, {}", quantity(1.0 / scene.sensors.sample_hz, BEGINNINGS));
                let problem = Problem::new(self.place(BEGINNINGS), message, label);
                self.add(BEGINNINGS, problem);
            }
        }
    }

    /// Two settings that do not go together.
    fn contradicts(&mut self, key: &str, error: &Error, label: &str) {
        let at = self.newer(key, MODE);
        let problem = Problem::new(self.place(at), format!("the firmware refuses these settings: {error}"), label.to_owned());
        self.add(at, problem);
    }

    /// The key that a parameter comes from, and on what its range depends.
    fn source_of(&self, parameter: &str) -> Option<(String, &'static str)> {
        let mut listed = PARAMETERS.iter().filter(|(name, ..)| *name == parameter);
        if let Some((_, key, why)) = listed.clone().find(|(_, key, _)| self.given(key)).or_else(|| listed.next()) {
            return Some(((*key).to_owned(), why));
        }
        let key = join("controller", parameter);
        Schema::root().at(&key).map(|_| (key, ""))
    }

    fn refused(&mut self, key: &str, why: &str, value: f64, (min, max): (f64, f64)) {
        const SAME: f64 = 1e-6;
        let Some(schema) = Schema::root().at(key) else { return };
        let given = self.number(key).unwrap_or(value);
        // The parameter may be some multiple of the key, and is in single precision.
        let multiple =
            Some(given / value).filter(|multiple| multiple.is_normal() && (multiple - 1.0).abs() > SAME).unwrap_or(1.0);
        let allowed = |key: f64| (min..=max).contains(&f64::from((key / multiple) as f32));
        let (least, most) = schema.range();
        let least = bound(min * multiple, 1.0, allowed).max(least.unwrap_or(f64::MIN));
        let most = bound(max * multiple, -1.0, allowed).min(most.unwrap_or(f64::MAX));
        let from = if self.given(key) { "" } else { ", the default" };
        let message = format!("the firmware refuses `{key}` of {}{from}", quantity(given, key));
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
    fn parameters_come_from_numbers_of_a_scene() {
        for (_, key, _) in PARAMETERS {
            assert!(Schema::root().at(key).is_some_and(Schema::is_number), "{key}");
        }
    }
}
