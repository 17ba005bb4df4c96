//! The thesis's method in single precision, as a small processor would run it, with two kinds of
//! clock.
//!
//! Runge-Kutta of fourth order with the signum in the right-hand side, in SI units, on a Dahl
//! oscillator under a cosine. The state is displacement, velocity and friction over Fc, without the
//! belt's position.

use contact::table_4_1::{CONTACT_N_PER_M, COULOMB_N, DRIVE_HZ, FORCE_N, MASS_KG, STIFFNESS_N_PER_M};

/// Source of the phase of the force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// Accumulated time: `t += h`, and `cos(w t)`.
    Accumulated,
    /// Number of the step within its period; restarts every period.
    Reset,
}

/// Result of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Single {
    /// Displacement at the end, m.
    pub x_m: f32,
    /// Mean friction ratio over the second half.
    pub mean: f64,
}

/// Runs `periods` periods at `steps` steps a period, from rest.
///
/// The mean is summed in single precision within a period, and in double precision across periods,
/// as it belongs to the evaluation and not to the processor.
pub fn run(sliding_m_per_s: f64, periods: u32, steps: u32, clock: Clock) -> Single {
    let [force, mass, stiffness, contact, coulomb] =
        [FORCE_N, MASS_KG, STIFFNESS_N_PER_M, CONTACT_N_PER_M, COULOMB_N].map(|value| value as f32);
    let sliding = sliding_m_per_s as f32;
    let omega = (std::f64::consts::TAU * DRIVE_HZ) as f32;
    let h = (1.0 / (DRIVE_HZ * f64::from(steps))) as f32;
    let rates = |[x, v, f]: [f32; 3], drive: f32| {
        let slip = sliding + v;
        [v, (drive - stiffness * x - coulomb * f) / mass, contact / coulomb * (slip - slip.abs() * f)]
    };
    let along = |y: [f32; 3], k: [f32; 3], part: f32| [0, 1, 2].map(|i| y[i] + part * h * k[i]);
    let (mut y, mut t, mut mean) = ([0.0f32; 3], 0.0f32, 0.0f64);
    for period in 0..periods {
        let mut sum = 0.0f32;
        for step in 0..steps {
            let drive = |part: f32| match clock {
                Clock::Accumulated => force * (omega * (t + part * h)).cos(),
                Clock::Reset => force * (std::f32::consts::TAU * ((step as f32 + part) / steps as f32)).cos(),
            };
            let (now, middle, end) = (drive(0.0), drive(0.5), drive(1.0));
            let k1 = rates(y, now);
            let k2 = rates(along(y, k1, 0.5), middle);
            let k3 = rates(along(y, k2, 0.5), middle);
            let k4 = rates(along(y, k3, 1.0), end);
            let before = y[2];
            y = [0, 1, 2].map(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
            sum += 0.5 * (before + y[2]);
            t += h;
        }
        if 2 * period >= periods {
            mean += f64::from(sum) / f64::from(steps) / f64::from(periods - periods.div_ceil(2));
        }
    }
    Single { x_m: y[0], mean }
}
