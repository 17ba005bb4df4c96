//! Conversion of a contact study's scene to a problem for `contact`, in SI units, with defaults
//! resolved.

use std::f64::consts::TAU;

use super::{Body, Disturbance, Excited, Match, MeanWindow, Model, Profile, Sign, VibrationVelocity, Waveform};
use contact::plane::Direction;
use contact::{self, Law, Motion, Numerics, Problem, Shape, SolveError, State, ToleranceOf};

/// Acceleration of gravity, m/s^2: the weight of a mass is the normal force unless the scene gives
/// one.
pub const GRAVITY_M_PER_S2: f64 = 9.81;
/// Relative difference of stiffness and inertia below which an undamped oscillator is at resonance.
/// Its steady amplitude would be at least 10 000 times the static one, and no run is long enough to
/// reach it.
const RESONANCE_BALANCE_REL: f64 = 1e-4;
/// Stiffness of a contact with negligible friction, N/m.
const NEGLIGIBLE_STIFFNESS_N_PER_M: f64 = 1e-9;
/// Steps per period at which the largest velocity at the end of a step is the peak of a sine to
/// within 5e-6, (pi / 1000)^2 / 2.
const PEAK_STEPS_PER_PERIOD: u32 = 1000;

/// Metrics that need the energies, which cost ten times as much as the motion.
const ENERGY_METRICS: [&str; 5] = ["input_ratio", "stored_ratio", "damper_ratio", "power_ratio_as_printed", "energy_residual"];
/// Largest number of periods up to which the energies are always computed.
const MAX_ENERGY_PERIODS: f64 = 4096.0;

/// Returns the built-in friction law of a contact that vibrates along the motion, `None` if it
/// vibrates across it or has a law of its own.
pub fn law(model: &Model) -> Option<Law> {
    match *model {
        Model::Coulomb(_) => Some(Law::Coulomb),
        Model::Dahl(dahl) => Some(Law::Dahl { stiffness_n_per_m: dahl.stiffness_n_per_m }),
        Model::Lugre(lugre) => Some(Law::Lugre {
            stiffness_n_per_m: lugre.stiffness_n_per_m,
            static_ratio: lugre.static_mu / lugre.mu,
            stribeck_m_per_s: lugre.stribeck_m_per_s,
            sigma1: lugre.sigma1,
            sigma2: lugre.sigma2,
        }),
        Model::Hertz(_) | Model::Compliant(_) | Model::Expression(_) => None,
    }
}

/// Returns the direction of a vibration at an angle to the sliding, `None` if it is along it.
pub fn direction(study: &Excited) -> Option<Direction> {
    let angle_deg = study.excitation.angle_deg;
    (angle_deg != 0.0).then(|| Direction::from_degrees(angle_deg))
}

/// Builds the problem of a study with a friction law.
///
/// # Errors
/// If the velocity ratio refers to a peak that cannot be computed.
pub fn problem(study: &Excited, law: Law) -> Result<Problem, SolveError> {
    let mu = study.model.mu();
    let mut load_steps: Vec<_> = study.disturbance.iter().flat_map(loads).map(|(at_s, normal_n)| (at_s, mu * normal_n)).collect();
    load_steps.sort_by(|a, b| a.0.total_cmp(&b.0));
    let excitation = study.excitation;
    let problem = Problem {
        motion: motion(&study.body),
        law,
        coulomb_n: mu * normal_n(study),
        sliding_m_per_s: 0.0,
        sign: match study.model.sign() {
            Sign::Passive => contact::Sign::Passive,
            Sign::Literal => contact::Sign::Literal,
        },
        waveform: match &excitation.profile {
            Some(profile) => contact::Waveform::measured(profile.played(), excitation.frequency_hz),
            None => waveform(study, shape(study), matched_peak(study)),
        },
        start: State { time_s: 0.0, x_m: excitation.x0_m, v_m_per_s: excitation.v0_m_per_s, force_n: excitation.friction0_n },
        load_steps,
        window_s: window_s(study),
        duration_s: study.duration_s,
    };
    let sliding_m_per_s = match (excitation.sliding_m_per_s, excitation.velocity_ratio, excitation.velocity_ratio_of) {
        (Some(speed), ..) => speed,
        (None, ratio, VibrationVelocity::Steady) => ratio.unwrap_or(0.0) * sine(study, &problem).vibration_m_per_s(),
        (None, ratio, VibrationVelocity::Peak) => ratio.unwrap_or(0.0) * peak_without_friction_m_per_s(&problem)?,
    };
    Ok(Problem { sliding_m_per_s, ..problem })
}

/// Returns the normal forces of a disturbance with their times, s and N. Between two samples of a
/// measured profile the force is their mean, which equals the mean of the straight line.
fn loads(disturbance: &Disturbance) -> Vec<(f64, f64)> {
    let step = disturbance.to.map(|to| (disturbance.at_s, to));
    let samples: Vec<_> = disturbance.profile.iter().flat_map(Profile::played).collect();
    let means = samples.windows(2).map(|pair| (disturbance.at_s + pair[0].0, 0.5 * (pair[0].1 + pair[1].1)));
    let last = samples.last().map(|(time_s, value)| (disturbance.at_s + time_s, *value));
    step.into_iter().chain(means).chain(last).collect()
}

/// Returns the problem with a sine of the scene's peak and frequency, the reference of velocity
/// ratio and kappa.
pub fn sine(study: &Excited, problem: &Problem) -> Problem {
    Problem { waveform: waveform(study, Shape::Sine, peak(study)), ..problem.clone() }
}

/// Metrics of the whole run, not of its window.
const WHOLE_RUN_METRICS: [&str; 4] = ["peak_velocity_m_per_s", "peak_displacement_m", "peak_force_ratio", "reversals"];

/// Returns the numerical settings, for all metrics of a study (`None`) or for some. A study of many
/// periods computes the energies only if one of its expectations needs them.
pub fn numerics(study: &Excited, metrics: Option<&[&str]>) -> Numerics {
    let integrator = &study.integrator;
    let lugre = matches!(study.model, Model::Lugre(_));
    // The work of Dahl's and Coulomb's friction telescopes between reversals, at no cost.
    let is_energy = |metric: &str| ENERGY_METRICS.contains(&metric) || (lugre && metric == "power_ratio");
    let energies = match metrics {
        Some(metrics) => metrics.iter().any(|metric| is_energy(metric)),
        None => {
            let few = study.duration_s * study.excitation.frequency_hz <= MAX_ENERGY_PERIODS;
            few || study.expect.iter().any(|expect| is_energy(&expect.metric))
        }
    };
    let default = Numerics::default();
    let tolerance_of = integrator.tolerance_of.unwrap_or_default();
    Numerics {
        steady: is_steady(study),
        method: integrator.method.unwrap_or_default(),
        steps_per_period: integrator.steps_per_period,
        order: integrator.order,
        tolerance: integrator.tolerance.unwrap_or(default.tolerance),
        tolerance_of,
        energies,
        // A record covers the whole run.
        whole_run: tolerance_of == ToleranceOf::Record
            || metrics.is_none_or(|metrics| metrics.iter().any(|metric| WHOLE_RUN_METRICS.contains(metric))),
    }
}

/// Returns the normal force at the beginning, N.
pub fn normal_n(study: &Excited) -> f64 {
    let weight_n = match study.body {
        Body::Kinematic(_) => 0.0,
        Body::Sdof(sdof) => sdof.mass_kg * GRAVITY_M_PER_S2,
    };
    study.model.normal_n().unwrap_or(weight_n)
}

/// Returns `true` if an undamped oscillator is excited at its resonance: its steady vibration is
/// unbounded.
pub fn resonates(mass_kg: f64, stiffness_n_per_m: f64, damping_ratio: f64, frequency_hz: f64) -> bool {
    let inertia = mass_kg * (TAU * frequency_hz).powi(2);
    damping_ratio == 0.0 && (stiffness_n_per_m - inertia).abs() < RESONANCE_BALANCE_REL * stiffness_n_per_m
}

fn motion(body: &Body) -> Motion {
    match *body {
        Body::Kinematic(_) => Motion::Kinematic,
        Body::Sdof(sdof) => Motion::Sdof {
            mass_kg: sdof.mass_kg,
            stiffness_n_per_m: sdof.stiffness_n_per_m,
            damping_n_s_per_m: 2.0 * sdof.damping_ratio * (sdof.mass_kg * sdof.stiffness_n_per_m).sqrt(),
        },
    }
}

fn shape(study: &Excited) -> Shape {
    let excitation = study.excitation;
    match excitation.waveform {
        Waveform::Sine => Shape::Sine,
        Waveform::Square => Shape::Square,
        Waveform::Sawtooth => Shape::Sawtooth,
        Waveform::Triangle => Shape::Triangle,
        // The rules ensure that the keys of these two are present.
        Waveform::Random => Shape::Random { hold_s: excitation.hold_time_s.unwrap_or(study.duration_s), seed: study.seed },
        Waveform::Chirp => Shape::Chirp {
            start_hz: excitation.start_hz.unwrap_or(excitation.frequency_hz),
            stop_hz: excitation.stop_hz.unwrap_or(excitation.frequency_hz),
            sweep_s: excitation.sweep_s.unwrap_or(study.duration_s),
        },
        Waveform::Measured => Shape::Measured,
        Waveform::Still => Shape::Still,
    }
}

fn waveform(study: &Excited, shape: Shape, peak: f64) -> contact::Waveform {
    contact::Waveform::new(shape, peak, study.excitation.frequency_hz, study.duration_s)
}

/// Returns the peak that the scene gives: a force, N, or a velocity, m/s.
fn peak(study: &Excited) -> f64 {
    match study.body {
        Body::Kinematic(kinematic) => kinematic.vibration_m_per_s(study.excitation.frequency_hz),
        Body::Sdof(_) => study.excitation.force_n.unwrap_or(0.0),
    }
}

/// Returns the peak of the waveform: the scene's peak, or the peak that gives the rms of a sine
/// with it.
fn matched_peak(study: &Excited) -> f64 {
    let rms = contact::Waveform::shape_rms(shape(study));
    match study.excitation.matched {
        Match::Rms if rms > 0.0 => peak(study) * contact::Waveform::shape_rms(Shape::Sine) / rms,
        _ => peak(study),
    }
}

/// Returns `true` if the means are to be those of the steady state. Measured curves lie over a run.
fn is_steady(study: &Excited) -> bool {
    let integrator = &study.integrator;
    let is_default = integrator.window_periods.is_none() && study.overlay.is_empty();
    integrator.window.map_or(is_default, |window| window == MeanWindow::Steady)
}

/// Returns the window of the means, s. A window that ends within round-off of the end of the run
/// ends with it.
fn window_s(study: &Excited) -> (f64, f64) {
    let second = |periods: f64| periods / study.excitation.frequency_hz;
    match study.integrator.window_periods.as_deref() {
        Some(&[from, to]) => (second(from), second(to).min(study.duration_s)),
        _ => (0.5 * study.duration_s, study.duration_s),
    }
}

/// Returns the largest velocity of the run without friction, m/s.
fn peak_without_friction_m_per_s(problem: &Problem) -> Result<f64, SolveError> {
    let alone = Problem { law: Law::Dahl { stiffness_n_per_m: NEGLIGIBLE_STIFFNESS_N_PER_M }, ..problem.clone() };
    let fine = Numerics { method: contact::Method::Rk4, steps_per_period: Some(PEAK_STEPS_PER_PERIOD), ..Numerics::default() };
    let solution = contact::solve(&alone, &fine, &mut |_| ())?;
    let start = problem.start.v_m_per_s.abs();
    Ok(solution.tally.map_or(start, |tally| tally.peak_velocity_m_per_s.max(start)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::load;

    /// Returns the problem of the built-in scene with changes.
    fn changed(changes: &[&str]) -> Problem {
        let sets: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
        let scene = load("contact", &sets).unwrap_or_else(|error| panic!("{error}")).scene;
        let study = scene.excited().unwrap();
        problem(&study, law(&study.model).unwrap()).unwrap()
    }

    #[test]
    fn table_4_1_matches_the_contact_crate() {
        let mut kernels = contact::table_4_1::table_4_1(0.5, 200.0);
        kernels.coulomb_n = 0.1 * (0.02 * GRAVITY_M_PER_S2);
        assert_eq!(changed(&[]), kernels);
    }

    #[test]
    fn velocity_ratio_refers_to_the_sine() {
        let sine = changed(&[]).sliding_m_per_s;
        for waveform in ["square", "still", "triangle"] {
            let square = changed(&[&format!("excitation.waveform={waveform}"), "excitation.match=rms"]);
            assert_eq!(square.sliding_m_per_s, sine, "{waveform}");
        }
        assert_eq!(changed(&["excitation.waveform=square", "excitation.match=rms"]).waveform.amplitude(), 384.0 * 0.5f64.sqrt());
        assert_eq!(changed(&["excitation.sliding_m_per_s=0.1"]).sliding_m_per_s, 0.1);
    }

    /// From rest the mass also vibrates at its own frequency: x' = F0 w / (Ks - m w^2) (sin w t -
    /// (wn / w) sin wn t). The sampling is denser than the method's.
    #[test]
    fn peak_velocity_is_without_friction() {
        let (wn, w) = ((133e6f64 / 0.02).sqrt(), TAU * 60e3);
        let amplitude = 384.0 * w / (133e6 - 0.02 * w * w);
        let steps = 5_000_000;
        let at = |step: u32| f64::from(step) / f64::from(steps) * 200.0 / 60e3;
        let velocity = |t: f64| amplitude * (wn / w * (wn * t).sin() - (w * t).sin());
        let peak = (0..=steps).map(|step| velocity(at(step)).abs()).fold(0.0, f64::max);
        let sliding = changed(&["excitation.velocity_ratio_of=peak"]).sliding_m_per_s;
        assert!((sliding / (0.5 * peak) - 1.0).abs() < 1e-5, "{sliding} {}", 0.5 * peak);
    }

    #[test]
    fn loads_step_in_order() {
        let step = |number: u8, at: &str, to: &str| {
            let key = |key: &str, value: &str| format!("disturbance.{number}.{key}={value}");
            [key("at_s", at), key("key", "contact.normal_n"), key("to", to)]
        };
        let sets = [step(0, "2e-3", "0.5"), step(1, "1e-3", "2")].concat();
        let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
        assert_eq!(changed(&sets).load_steps, [(1e-3, 0.2), (2e-3, 0.05)]);
    }

    #[test]
    fn damping_is_relative_to_critical() {
        let Motion::Sdof { damping_n_s_per_m, .. } = changed(&["rig.sdof.damping_ratio=0.01"]).motion else {
            panic!("not an oscillator")
        };
        assert!((damping_n_s_per_m - 2.0 * 0.01 * 0.02 * TAU * 12_978.69).abs() < 1e-5, "{damping_n_s_per_m}");
    }
}
