mod derivatives;
mod monte_carlo;
mod table;

use super::*;

/// Sensors with one conversion per sample, as in the reproduced study; a scene's default is two.
pub(super) fn sensors(oversample: u8) -> Sensors {
    Sensors { oversample, offset_lsb: 0.0, ..Sensors::default() }
}

/// Returns set A at 40 kHz, driven `beside_hz` off resonance.
pub(super) fn set_a(q: f64, beside_hz: f64, prior: PriorKnowledge) -> Setting {
    let circuit = Circuit { c0_f: 300e-9, cm_f: 20e-9, lm_h: 0.7916e-3, rm_ohm: 1.0, force_factor_n_per_v: 1.0 };
    setting(circuit.with_q(q), beside_hz, prior, &sensors(1))
}

/// Returns a circuit driven from rest by 3 V.
pub(super) fn setting(circuit: Circuit, beside_hz: f64, prior: PriorKnowledge, sensors: &Sensors) -> Setting {
    let hz = circuit.series_resonance_hz() + beside_hz;
    Setting {
        circuit,
        drive: Drive { volts: 3.0, hz, phase_rad: -std::f64::consts::FRAC_PI_2 },
        start: Start::Rest,
        sample_hz: 1e6,
        block_s: 32e-6,
        current_noise_a: noise(sensors, sensors.i_full_scale_a),
        voltage_noise_v: noise(sensors, sensors.v_full_scale_v),
        prior,
    }
}

/// Returns a load step at t = 0: the resonance rises by 200 Hz and Q falls to 20; the drive was at
/// the old resonance.
pub(super) fn load_step(prior: PriorKnowledge, oversample: u8) -> Setting {
    let before = set_a(65.0, 0.0, prior);
    let circuit = before.circuit.with_series_resonance(before.drive.hz + 200.0).with_q(20.0);
    Setting { start: Start::Jump(before.circuit), drive: before.drive, ..setting(circuit, 0.0, prior, &sensors(oversample)) }
}

/// Simulates current and voltage at the end of each sample with the Runge-Kutta method, from this
/// motional current and charge. The circuit may change. It shares no code with the closed form.
pub(super) fn simulated(circuit: impl Fn(f64) -> Circuit, drive: &Drive, state: [f64; 2], samples: u32) -> Vec<[f64; 2]> {
    const STEPS: u32 = 64;
    let omega = std::f64::consts::TAU * drive.hz;
    let angle = |t: f64| omega * t + drive.phase_rad;
    let slope = |t: f64, [current, charge]: [f64; 2]| {
        let now = circuit(t);
        [(drive.volts * angle(t).cos() - now.rm_ohm * current - charge / now.cm_f) / now.lm_h, current]
    };
    let (step_s, mut state, mut measured) = (1e-6 / f64::from(STEPS), state, Vec::new());
    for n in 0..samples * STEPS {
        let t = f64::from(n) * step_s;
        let along = |by: [f64; 2], part: f64| [state[0] + part * step_s * by[0], state[1] + part * step_s * by[1]];
        let k1 = slope(t, state);
        let k2 = slope(t + 0.5 * step_s, along(k1, 0.5));
        let k3 = slope(t + 0.5 * step_s, along(k2, 0.5));
        let k4 = slope(t + step_s, along(k3, 1.0));
        state = std::array::from_fn(|i| state[i] + step_s / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        if (n + 1) % STEPS == 0 {
            let end = f64::from(n + 1) * step_s;
            let clamped = -circuit(end).c0_f * omega * drive.volts * angle(end).sin();
            measured.push([state[0] + clamped, drive.volts * angle(end).cos()]);
        }
    }
    measured
}

/// Returns the initial motional current and charge.
pub(super) fn first_state(setting: &Setting) -> [f64; 2] {
    let circuit = match setting.start {
        Start::Rest => return [0.0; 2],
        Start::Settled => setting.circuit,
        Start::Jump(before) => before,
    };
    let phasor = response::settled(&circuit, &setting.drive);
    [phasor.re, phasor.im / (std::f64::consts::TAU * setting.drive.hz)]
}

/// Moves the resonance, the logarithms of Q, Lm and C0, and voltage and phase of the drive by `by`.
pub(super) fn moved(setting: &Setting, by: &[f64; 6]) -> (Circuit, Drive) {
    let (circuit, drive) = (setting.circuit, setting.drive);
    let (omega, q) = (circuit.omega() + std::f64::consts::TAU * by[0], circuit.q() * by[1].exp());
    let lm_h = circuit.lm_h * by[2].exp();
    let circuit = Circuit {
        lm_h,
        cm_f: 1.0 / (omega * omega * lm_h),
        rm_ohm: omega * lm_h / q,
        c0_f: circuit.c0_f * by[3].exp(),
        ..circuit
    };
    (circuit, Drive { volts: drive.volts * (1.0 + by[4]), phase_rad: drive.phase_rad + by[5], ..drive })
}
