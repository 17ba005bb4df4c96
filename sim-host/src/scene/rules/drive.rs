//! The drive: what it needs to know beforehand, and what must hold it.

use super::{Rules, shown};
use crate::scene::diagnostic::Problem;
use crate::scene::{Amplifier, Drive, Limits, Sensors, Tracking};

const DRIVE: &str = "controller.drive";
const VELOCITY: &str = "controller.drive.velocity_m_per_s";
const FREQUENCY: &str = "controller.drive.frequency_hz";

impl Rules<'_> {
    pub(super) fn drive(&mut self) {
        let Some(drive) = self.typed::<Drive>(DRIVE) else { return };
        let tracking = self.typed::<Tracking>("controller.tracking");
        if drive.velocity_m_per_s.is_some() {
            self.velocity(&drive, tracking.as_ref());
        }
        for (key, value) in [("amplitude_v", drive.amplitude_v), ("scan_v", drive.scan_v)] {
            if let Some(volts) = value {
                self.voltage(&format!("{DRIVE}.{key}"), volts);
            }
        }
        if let (Some(tracking), Some(sensors)) = (tracking, self.typed::<Sensors>("sensors")) {
            self.frequency(drive.frequency_hz, tracking.span, sensors.sample_hz);
        }
    }

    fn velocity(&mut self, drive: &Drive, tracking: Option<&Tracking>) {
        if tracking.is_some_and(|tracking| tracking.nominal_force_factor_n_per_v.is_none()) {
            let message = "a velocity is held by the motional current, which needs the force factor";
            let label = "needs `controller.tracking.nominal_force_factor_n_per_v`";
            let problem = Problem::new(self.key(VELOCITY), message, label);
            self.add(VELOCITY, problem.help("motional current = force factor x tip velocity"));
        }
        if drive.scan_v.is_none() {
            let message = "with a velocity, self-test and scan need a voltage of their own";
            let problem = Problem::new(self.key(VELOCITY), message, "needs `scan_v` beside it");
            self.add(VELOCITY, problem.help("`scan_v` is the peak voltage before the resonance is known"));
        }
    }

    fn voltage(&mut self, path: &str, volts: f64) {
        let limits = self.typed::<Limits>("controller.limits").map(|limits| limits.voltage_v);
        let amplifier = self.typed::<Amplifier>("amplifier").map(|amplifier| amplifier.full_scale_v);
        for (limit, most) in [("controller.limits.voltage_v", limits), ("amplifier.full_scale_v", amplifier)] {
            let Some(most) = most.filter(|most| volts > *most) else { continue };
            let from = if self.root.at(limit).is_none() { ", the default" } else { "" };
            let message = format!("`{path}` is {} V, more than `{limit}` allows", shown(volts));
            let at = self.newer(path, limit);
            let label = if at == path { format!("must be at most {} V{from}", shown(most)) } else { "too little".to_owned() };
            let problem = Problem::new(self.place(at), message, label);
            self.add(path, problem.help("voltages are peak values, half of peak to peak"));
        }
    }

    fn frequency(&mut self, frequency_hz: f64, span: f64, sample_hz: f64) {
        const USABLE: f64 = 0.45;
        let highest = frequency_hz * (1.0 + span);
        if highest < USABLE * sample_hz {
            return;
        }
        let message = format!("the drive may reach {} Hz, too fast for the converters", shown(highest));
        let label = format!("with its span, must stay below {} Hz", shown(USABLE * sample_hz));
        let problem = Problem::new(self.place(FREQUENCY), message, label);
        let help = format!("`sensors.sample_hz` is {}, and a tone needs more than two samples a period", shown(sample_hz));
        self.add(FREQUENCY, problem.help(help));
    }
}
