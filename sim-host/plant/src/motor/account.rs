//! Result of a block: the energy budget and the truth.

use std::f64::consts::TAU;

use firmware::seam::block::DriveBlock;

use super::{Block, Motor, tones};
use crate::motor::rotor::Rotor;
use crate::motor::wave::Waves;
use crate::truth::{MotorSample, MotorTruth, Sample, Truth};

impl Motor {
    /// Closes a block of `steps` steps: updates the energy budget and the truth.
    pub(super) fn account(&mut self, drive: &DriveBlock, block: &Block, steps: f64) {
        self.linear.settle();
        let (sums, step_s) = (&block.sums, self.timing.step_s());
        let block_s = steps * step_s;
        let supplied = step_s * sums.in_phase;
        let lost = step_s * self.model.damping_n_s_per_m * sums.lost;
        self.energy.supplied_j += supplied;
        self.energy.lost_j += lost;
        self.energy.friction_on_tip_j += sums.friction_on_tip;
        self.energy.stored_j = self.stored_j();

        let waves = block.tone.waves(&self.model, self.linear.amplitudes(), self.linear.velocities());
        if let Some(rotor) = &mut self.rotor {
            rotor.sit(waves.forward_m, waves.backward_m);
        }
        let mean = sums.friction / steps;
        self.truth = Truth {
            friction_mean_n: mean,
            friction_min_n: sums.friction_min.min(mean),
            friction_max_n: sums.friction_max.max(mean),
            load_cell_n: self.load_cell.measure(mean),
            tip_velocity_m_per_s: waves.omega * waves.forward_m.max(waves.backward_m),
            series_resonance_hz: self.model.series_resonance_hz,
            power_w: supplied / block_s,
            // The amplitude lags the velocity by a quarter turn.
            quadrature_w: sums.quadrature / steps * waves.omega,
            lost_w: lost / block_s,
            friction_on_tip_w: sums.friction_on_tip / block_s,
            friction_on_slider_w: -block.rotor_work / block_s,
            belt_position_m: 0.0,
            belt_speed_m_per_s: 0.0,
            tip: None,
            horn: None,
            carriage: None,
            heat: None,
        };
        self.motor_truth = self.truth_of_motor(drive, &waves, mean, block.normal / steps);
        self.time_s += block_s;
    }

    fn truth_of_motor(&self, drive: &DriveBlock, waves: &Waves, force_n: f64, normal_n: f64) -> MotorTruth {
        let surface = |amplitude: f64| waves.omega * self.model.slope * amplitude;
        let played = |lane: usize| drive.lanes.get(self.lanes.sources()[lane]).into_iter().flatten();
        let codes: Vec<Vec<f64>> =
            (0..drive.lanes.len()).map(|lane| played(lane).map(|&code| self.dac.volts(code)).collect()).collect();
        let cycles = waves.omega * self.timing.sample_s / TAU;
        let ratio = waves.omega / (TAU * self.nominal_hz);
        let errors = tones::errors(codes.iter().map(Vec::as_slice), &self.lanes.errors(), self.direction, cycles, ratio);
        let stronger = waves.forward_m.max(waves.backward_m);
        let rotor = self.rotor.as_ref();
        MotorTruth {
            forward_m: waves.forward_m,
            backward_m: waves.backward_m,
            forward_m_per_s: surface(waves.forward_m),
            backward_m_per_s: surface(waves.backward_m),
            rotor_rad_per_s: rotor.map_or(0.0, Rotor::rad_per_s),
            rotor_m_per_s: rotor.map_or(0.0, Rotor::speed),
            torque_nm: rotor.map_or(0.0, |rotor| rotor.torque_of(force_n)),
            contact_deg: rotor.map_or(0.0, |rotor| rotor.zone(stronger).to_degrees()),
            normal_n,
            normal_shift_hz: rotor.map_or(0.0, |rotor| rotor.normal_shift_hz(stronger, &self.model)),
            lane_phase_error_deg: errors.map(|errors| errors.phase_deg),
            lane_gain_error_percent: errors.map(|errors| errors.gain_percent),
        }
    }

    pub(super) fn sample(&self, force_n: f64) -> Sample {
        let (q, s, v) = (self.linear.amplitudes(), self.linear.velocities(), self.linear.voltages());
        let part = self.model.participation[0];
        let omega = TAU * self.model.series_resonance_hz;
        // Each mode rotates as `w q - j s`; a quarter turn apart, with either sign, they form the
        // two waves.
        let wave = |sense: f64| 0.5 * (omega * q[0] + sense * s[1]).hypot(sense * omega * q[1] - s[0]);
        Sample {
            voltage_v: v[0],
            motional_current_a: self.model.force_factor_n_per_v * (part[0] * s[0] + part[1] * s[1]),
            tip_velocity_m_per_s: part[0] * s[0] + part[1] * s[1],
            tip_envelope_m_per_s: wave(1.0).max(wave(-1.0)),
            friction_n: force_n,
            motor: Some(MotorSample {
                lanes_v: v,
                // At x = 0: w = q_c, u = -z dw/dx = -z k q_s (thesis B.13).
                surface_m: [q[1], -self.model.slope * q[0]],
                rotor_rad_per_s: self.rotor.as_ref().map_or(0.0, Rotor::rad_per_s),
            }),
        }
    }
}
