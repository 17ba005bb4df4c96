//! Tests of the closed form against Runge-Kutta, and of its derivatives against differences.

use super::*;

fn cases() -> [Setting; 4] {
    [
        set_a(65.0, 400.0, PriorKnowledge::NONE),
        Setting { start: Start::Settled, ..set_a(65.0, 400.0, PriorKnowledge::NONE) },
        load_step(PriorKnowledge::NONE, 1),
        set_a(3.0, -2000.0, PriorKnowledge::NONE),
    ]
}

fn time_s(n: usize) -> f64 {
    (n + 1) as f64 * 1e-6
}

#[test]
fn the_current_is_that_of_the_differential_equation() {
    let mut worst: f64 = 0.0;
    for setting in cases() {
        let response = Response::new(&setting.circuit, &setting.drive, &setting.start);
        for (n, measured) in simulated(|_| setting.circuit, &setting.drive, first_state(&setting), 1000).iter().enumerate() {
            let t = time_s(n);
            assert!((response.voltage(t).0 - measured[1]).abs() < 1e-11);
            worst = worst.max((response.current(t).0 - measured[0]).abs());
        }
    }
    // 1.2e-10 A of up to 1 A: the error of the Runge-Kutta steps.
    assert!(worst < 2e-10, "{worst:e}");
}

#[test]
fn derivatives_are_limits_of_differences() {
    let mut worst: f64 = 0.0;
    let steps = [1e-2, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5];
    for setting in cases() {
        let response = Response::new(&setting.circuit, &setting.drive, &setting.start);
        // The state before a jump does not depend on the circuit after it, except by C0, which is
        // tested below.
        for n in (0..6).filter(|&n| n != 3 || !matches!(setting.start, Start::Jump(_))) {
            let at = |sign: f64| {
                let mut by = [0.0; 6];
                by[n] = sign * steps[n];
                moved(&setting, &by)
            };
            let before = first_state(&setting);
            let of = |(circuit, drive): (Circuit, Drive)| match setting.start {
                // The state is fixed while the voltage changes: a jump from rest, plus the free
                // oscillation of the initial state.
                Start::Jump(_) => {
                    let left = Response::new(&circuit, &drive, &Start::Rest);
                    let by = left.clone();
                    (left, Some(by))
                }
                start => (Response::new(&circuit, &drive, &start), None),
            };
            let omega = std::f64::consts::TAU * setting.drive.hz;
            let current = |(response, left): &(Response, Option<Response>), t: f64| {
                let rest = left.as_ref().map_or(0.0, |left| {
                    let by = left.current(t).1;
                    before[0] * by[Parameter::State as usize] + before[1] * omega * by[Parameter::StateQuadrature as usize]
                });
                response.current(t).0 + rest
            };
            let (above, below) = (of(at(1.0)), of(at(-1.0)));
            let scale = (0..500).map(time_s).map(|t| response.current(t).1[n].abs()).fold(0.0, f64::max);
            for t in (0..500).map(time_s) {
                let difference = (current(&above, t) - current(&below, t)) / (2.0 * steps[n]);
                worst = worst.max((difference - response.current(t).1[n]).abs() / scale);
            }
        }
    }
    // 9.3e-10: rounding divided by the step.
    assert!(worst < 2e-9, "{worst:e}");
}

/// A unit current or charge rings down freely.
#[test]
fn the_first_state_rings_down() {
    let mut worst: f64 = 0.0;
    for setting in cases() {
        let omega = std::f64::consts::TAU * setting.drive.hz;
        let response = Response::new(&setting.circuit, &setting.drive, &setting.start);
        let silent = Drive { volts: 0.0, ..setting.drive };
        for (parameter, state) in [(Parameter::State, [1.0, 0.0]), (Parameter::StateQuadrature, [0.0, 1.0 / omega])] {
            for (n, measured) in simulated(|_| setting.circuit, &silent, state, 500).iter().enumerate() {
                worst = worst.max((response.current(time_s(n)).1[parameter as usize] - measured[0]).abs());
            }
        }
    }
    // The worst error is 9.4e-11.
    assert!(worst < 2e-10, "{worst:e}");
}

/// The total current before the jump is known: with a larger C0, less of it was motional.
#[test]
fn c0_derivative_after_a_jump_keeps_the_total_current() {
    let setting = load_step(PriorKnowledge::NONE, 1);
    let (response, part) = (Response::new(&setting.circuit, &setting.drive, &setting.start), 1e-4);
    let omega = std::f64::consts::TAU * setting.drive.hz;
    let clamped = Complex64::new(0.0, omega * setting.circuit.c0_f) * setting.drive.phasor() * part;
    let first = first_state(&setting);
    let at = |sign: f64| {
        let circuit = Circuit { c0_f: setting.circuit.c0_f * (1.0 + sign * part), ..setting.circuit };
        let state = [first[0] - sign * clamped.re, first[1] - sign * clamped.im / omega];
        simulated(|_| circuit, &setting.drive, state, 300)
    };
    let mut worst: f64 = 0.0;
    for (n, (above, below)) in at(1.0).iter().zip(at(-1.0)).enumerate() {
        let error = (above[0] - below[0]) / (2.0 * part) - response.current(time_s(n)).1[Parameter::C0 as usize];
        worst = worst.max(error.abs());
    }
    // The worst error is 1.8e-11 A.
    assert!(worst < 4e-11, "{worst:e}");
}

/// The derivative by the slope is a solution up to a free oscillation, which the initial state
/// contains.
#[test]
fn slope_derivative_equals_the_difference_of_ramps() {
    let setting = cases()[1];
    let (response, rate) = (Response::new(&setting.circuit, &setting.drive, &setting.start), 1e3);
    let resonance = setting.circuit.series_resonance_hz();
    let along = |sign: f64| {
        let circuit = |t: f64| setting.circuit.with_series_resonance(resonance + sign * rate * t);
        simulated(circuit, &setting.drive, first_state(&setting), 1500)
    };
    let (above, below) = (along(1.0), along(-1.0));
    let difference =
        |n: usize| (above[n][0] - below[n][0]) / (2.0 * rate) - response.current(time_s(n)).1[Parameter::Rate as usize];
    let free = |n: usize| {
        let by = response.current(time_s(n)).1;
        [by[Parameter::State as usize], by[Parameter::StateQuadrature as usize]]
    };
    let ([a, b], [c, d]) = (free(0), free(6));
    let (x, y) = (difference(0), difference(6));
    let of = [(x * d - y * b) / (a * d - b * c), (a * y - c * x) / (a * d - b * c)];
    let scale = response.current(1.5e-3).1[Parameter::Rate as usize].abs();
    let mut worst: f64 = 0.0;
    for n in 0..1500 {
        let error = difference(n) - of[0] * free(n)[0] - of[1] * free(n)[1];
        worst = worst.max(error.abs() / scale);
    }
    // 7.7e-6: the cubic term of a ramp of up to 1.5 Hz, with a half bandwidth of 308 Hz.
    assert!(worst < 1e-5, "{worst:e}");
}
