//! Rules of the drive: required nominal values, and limits of voltage and frequency.

use super::kind::BELT;
use super::{Rules, shown};
use crate::diagnostic::Problem;

pub(super) const AMPLITUDE: &str = "controller.drive.amplitude_v";
pub(super) const VELOCITY: &str = "controller.drive.velocity_m_per_s";
pub(super) const AMPLITUDE_FRACTION: &str = "rig.belt.amplitude_fraction";
pub(super) const SCAN: &str = "controller.drive.scan_v";
const FORCE_FACTOR: &str = "controller.tracking.nominal_force_factor_n_per_v";
pub(super) const FREQUENCY: &str = "controller.drive.frequency_hz";

impl Rules<'_> {
    pub(super) fn drive(&mut self) {
        self.velocity();
        self.voltage(AMPLITUDE);
        self.voltage(SCAN);
        self.frequency();
    }

    fn velocity(&mut self) {
        let key_given = if self.given(BELT) { AMPLITUDE_FRACTION } else { VELOCITY };
        if self.value(key_given).is_none() {
            return;
        }
        let missing = [
            (
                FORCE_FACTOR,
                "a velocity is controlled through the motional current, which needs the force factor",
                format!("needs `{FORCE_FACTOR}`"),
                "motional current = force factor x tip velocity",
            ),
            (
                SCAN,
                "with a velocity, self-test and scan need their own voltage",
                "needs `scan_v` as well".to_owned(),
                "`scan_v` is the peak voltage before the resonance is known",
            ),
        ];
        for (path, message, label, help) in missing {
            if self.lacks(path) {
                let problem = Problem::new(self.key(key_given), message, label);
                self.add(path, problem.help(help));
            }
        }
    }

    fn voltage(&mut self, path: &str) {
        let Some(volts) = self.number(path) else { return };
        for limit in ["controller.limits.voltage_v", "amplifier.full_scale_v"] {
            let Some(most) = self.number(limit).filter(|most| volts > *most) else { continue };
            let from = if self.given(limit) { "" } else { ", the default" };
            let message = format!("`{path}` is {} V, more than `{limit}` allows", shown(volts));
            let at = self.newer(path, limit);
            let label = if at == path { format!("must be at most {} V{from}", shown(most)) } else { "too low".to_owned() };
            let problem = Problem::new(self.place(at), message, label);
            self.add(path, problem.help("voltages are peak values, half of peak to peak"));
        }
    }

    fn frequency(&mut self) {
        const MAX_FREQUENCY_REL: f64 = 0.45;
        let numbers = (self.number(FREQUENCY), self.number("controller.tracking.span"), self.number("sensors.sample_hz"));
        let (Some(frequency_hz), Some(span), Some(sample_hz)) = numbers else { return };
        let highest = frequency_hz * (1.0 + span);
        if highest < MAX_FREQUENCY_REL * sample_hz {
            return;
        }
        let message = format!("the drive can reach {} Hz, too high for the converters", shown(highest));
        let label = format!("including its span, must be below {} Hz", shown(MAX_FREQUENCY_REL * sample_hz));
        let problem = Problem::new(self.place(FREQUENCY), message, label);
        let help = format!("`sensors.sample_hz` is {}, and a tone needs more than two samples per period", shown(sample_hz));
        self.add(FREQUENCY, problem.help(help));
    }
}
