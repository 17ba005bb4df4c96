//! Metrics of a travelling-wave motor.

use crate::instruments::View;
use crate::instruments::view::crossing;
use crate::metrics::Metrics;
use crate::record::Row;
use crate::schedule::first_window;
use plant::motor::steady::Steady;
use plant::truth::MotorTruth;
use report::statistics::mean;
use scene::Direction;

/// Maximum speed of a stopped rotor, relative to its steady speed.
const STOPPED_REL: f64 = 1e-3;

impl View<'_> {
    fn steadily(&self, value: impl Fn(&MotorTruth) -> Option<f64>) -> Option<f64> {
        mean(self.steady().filter_map(|row| self.motor_truth(row).and_then(&value)))
    }

    pub(super) fn motor(&self, metrics: &mut Metrics) {
        if self.scene.stator().is_none() {
            return;
        }
        let reverse = self.scene.controller.phasing.direction == Direction::Reverse;
        let asked = |forward: f64, backward: f64| if reverse { (backward, forward) } else { (forward, backward) };
        let (with, against) = (
            self.steadily(|motor| Some(asked(motor.forward_m, motor.backward_m).0)),
            self.steadily(|motor| Some(asked(motor.forward_m, motor.backward_m).1)),
        );
        let surface = self.steadily(|motor| Some(asked(motor.forward_m_per_s, motor.backward_m_per_s).0));
        metrics.put("backward_wave_percent", with.zip(against).map(|(with, against)| 100.0 * against / with));
        metrics.put("forward_wave_m", with);
        metrics.put("backward_wave_m", against);
        metrics.put("surface_speed_m_per_s", surface);
        self.rotor(with.zip(surface), metrics);
        metrics.put("lane_phase_error_deg_max", self.steadily(|motor| motor.lane_phase_error_deg));
        metrics.put("lane_gain_error_percent_max", self.steadily(|motor| motor.lane_gain_error_percent));
    }

    /// Adds the metrics of the rotor. `wave` is the amplitude of the commanded wave, and its
    /// surface speed.
    fn rotor(&self, wave: Option<(f64, f64)>, metrics: &mut Metrics) {
        let Some(rotor) = self.scene.rotor() else { return };
        let speed = self.steadily(|motor| Some(motor.rotor_rad_per_s));
        let torque = self.steadily(|motor| Some(motor.torque_nm));
        metrics.put("rotor_speed_rad_per_s", speed);
        let ratio = speed.zip(wave).map(|(speed, (_, surface))| speed.abs() * rotor.radius_m / surface);
        metrics.put("rotor_speed_ratio", ratio);
        let closed = torque.zip(speed).zip(wave).map(|((torque, speed), (amplitude, _))| {
            let most = rotor.mu * rotor.preload_n * rotor.radius_m;
            let steady = Steady::new(amplitude, rotor.contact_stiffness_n_per_m, rotor.preload_n);
            steady.speed_ratio(torque * speed.signum() / most)
        });
        metrics.put("rotor_speed_ratio_closed_form", closed);
        metrics.put("rotor_torque_nm", torque);
        metrics.put("rotor_power_w", mean(self.steady().map(|row| -row.truth.friction_on_slider_w)));
        metrics.put("contact_deg", self.steadily(|motor| Some(motor.contact_deg)));
        metrics.put("normal_force_n", self.steadily(|motor| Some(motor.normal_n)));
        metrics.put("normal_shift_hz", self.steadily(|motor| Some(motor.normal_shift_hz)));
        if let Some(speed) = speed {
            self.start_and_stop(speed, metrics);
        }
    }

    fn start_and_stop(&self, steady: f64, metrics: &mut Metrics) {
        let run_from = self.plays_from(firmware::seam::mode::Mode::Run).unwrap_or(f64::INFINITY);
        let window = self.scene.controller.burst.as_ref().and_then(|burst| first_window(burst, run_from));
        let part = |row: &Row| self.motor_truth(row).map_or(0.0, |motor| motor.rotor_rad_per_s / steady);
        let reaches = |from: f64, there: &dyn Fn(f64) -> bool| {
            let mut before: Option<&Row> = None;
            for row in self.rows.iter().filter(|row| row.time_s >= from) {
                if there(part(row)) {
                    return before.map(|last| 1e3 * (crossing(last, row, there, part) - from));
                }
                before = Some(row);
            }
            None
        };
        metrics.put("start_time_ms", window.and_then(|(on, _)| reaches(on, &|part| part >= 0.9)));
        metrics.put("stop_time_ms", window.and_then(|(_, off)| reaches(off, &|part| part.abs() <= STOPPED_REL)));
    }
}
