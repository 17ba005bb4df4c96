//! The oscillator over time: Figures 4.8 and 4.9, and its long-term behaviour.

use super::case::PLOTTED_RATIO;
use super::case::{Case, SHORT_S, TABLE_4_1};
use super::claim::{Check, Claim, number, series};
use super::picture::{axis, figure, line, log_axis};
use super::trace::{amplitude_over_time, power_w, trace};
use super::{StudyResult, steady, sweep};
use contact::{Problem, Sign, SolveError, State};
use report::Figure;

/// Length of the long runs, s.
const LONG_S: f64 = 0.25;
/// Length of a bin of the long runs, s.
const BIN_S: f64 = 5e-3;
/// Samples a period of the figures.
const SAMPLES_PER_PERIOD: f64 = 100.0;
/// Plotted duration from the start, s.
const SHOWN_S: f64 = 0.4e-3;

const CHOICES_CAPTION: &str = "Velocity ratio 0.5, 384 N, 60 kHz, Table 4.1. Chosen here, open in the thesis: from rest (x = x' = \
                        F = 0), passive sign (V = Vt + x'); the first 0.4 ms are shown.";

/// Computes Figures 4.8 and 4.9 and their claims.
pub fn study() -> Result<StudyResult, SolveError> {
    let problem = TABLE_4_1.at_ratio(PLOTTED_RATIO, SHORT_S);
    let states = trace(&problem, 1.0 / (SAMPLES_PER_PERIOD * TABLE_4_1.frequency_hz), 0.0, SHOWN_S)?;
    let long = LongRuns::new()?;
    let mut figures = beginning(&problem, &states);
    figures.insert(2, long.figure());
    Ok(StudyResult { figures, claims: vec![long.decays(), averages_stay()?, lowers_friction()?, fast_excitation()?] })
}

fn beginning(problem: &Problem, states: &[State]) -> Vec<Figure> {
    let time: Vec<f64> = states.iter().map(|state| 1e3 * state.time_s).collect();
    let curve = |id: &str, title: &str, label: &str, column: &str, value: &dyn Fn(&State) -> f64| {
        let series = vec![line(title, column, &time, states.iter().map(value).collect())];
        figure(id, &format!("Figure {title}"), CHOICES_CAPTION.into(), [axis("time [ms]"), axis(label)], series)
    };
    vec![
        curve("fig-4-08a", "4.8(a): displacement", "displacement [µm]", "displacement_um", &|state| 1e6 * state.x_m),
        curve("fig-4-08b", "4.8(b): velocity", "velocity [m/s]", "velocity_m_per_s", &|state| state.v_m_per_s),
        curve("fig-4-09a", "4.9(a): instantaneous friction force", "friction / Fc", "friction_over_coulomb", &|state| {
            state.force_n / problem.coulomb_n
        }),
        curve("fig-4-09b", "4.9(b): instantaneous power dissipation", "power [mW]", "power_mw", &|state| {
            1e3 * power_w(problem, state)
        }),
    ]
}

/// Natural part of the velocity in long runs, with either sign.
struct LongRuns {
    time_s: Vec<f64>,
    passive: Vec<f64>,
    literal: Vec<f64>,
}

impl LongRuns {
    fn new() -> Result<Self, SolveError> {
        let signs = [Sign::Passive, Sign::Literal];
        let mut runs = sweep::each(&signs, |&sign| {
            let case = Case { sign, ..TABLE_4_1 };
            amplitude_over_time(&case.at_ratio(PLOTTED_RATIO, LONG_S), case.natural_hz(), BIN_S)
        })?;
        let (_, literal) = runs.pop().unwrap_or_default();
        let (time_s, passive) = runs.pop().unwrap_or_default();
        Ok(LongRuns { time_s, passive, literal })
    }

    fn figure(&self) -> Figure {
        let caption = "Amplitude of the velocity's part at the natural frequency (lock-in over 5 ms) from rest, Table 4.1, \
                       384 N, velocity ratio 0.5. With V = Vt + x' (4.2, 4.25, 4.27) friction damps it; with 4.14 and 4.16 \
                       as printed it grows without bound."
            .into();
        let name = |word: &str, values: &[f64]| {
            let tau = time_constant_s(&self.time_s, values);
            let does = if tau > 0.0 { "falls" } else { "grows" };
            format!("{word}: {does} by e in {:.3} s", tau.abs())
        };
        let series = vec![
            line(name("passive sign", &self.passive), "natural_passive_m_per_s", &self.time_s, self.passive.clone()),
            line(name("literal sign", &self.literal), "natural_literal_m_per_s", &self.time_s, self.literal.clone()),
        ];
        let axes = [axis("time [s]"), log_axis("natural part of the velocity [m/s]")];
        figure("fig-4-08c", "Figure 4.8, long-term: natural part of the velocity", caption, axes, series)
    }

    fn decays(&self) -> Claim {
        let check = |condition: &str, values: &[f64]| {
            let change = values.last().copied().unwrap_or(f64::NAN) / values.first().copied().unwrap_or(f64::NAN);
            let tau = time_constant_s(&self.time_s, values);
            let numbers = vec![
                number("natural part, last 5 ms over first", change),
                number("time constant (negative: grows) [s]", tau),
                number("change within 1 ms [%]", 100.0 * ((-SHORT_S / tau).exp() - 1.0)),
            ];
            Check::new(condition, change < 1.0, numbers)
        };
        Claim {
            id: "decays-to-steady-state",
            section: "4.3.1, Figs. 4.8, 4.9",
            says: "Displacement, velocity and friction decrease with time towards a steady state.",
            checks: vec![
                check("passive sign (V = Vt + x')", &self.passive),
                check("literal sign (4.14 and 4.16 as printed)", &self.literal),
            ],
        }
    }
}

/// Returns the time constant of an exponential decay, s, by linear regression of the logarithm;
/// negative for growth.
pub fn time_constant_s(time_s: &[f64], values: &[f64]) -> f64 {
    let count = time_s.len() as f64;
    let logs: Vec<f64> = values.iter().map(|value| value.ln()).collect();
    let (mean_t, mean_y) = (time_s.iter().sum::<f64>() / count, logs.iter().sum::<f64>() / count);
    let covariance: f64 = time_s.iter().zip(&logs).map(|(t, y)| (t - mean_t) * (y - mean_y)).sum();
    let variance: f64 = time_s.iter().map(|t| (t - mean_t) * (t - mean_t)).sum();
    -variance / covariance
}

fn averages_stay() -> Result<Claim, SolveError> {
    let half_s = 10e-3;
    let problem = TABLE_4_1.at_ratio(PLOTTED_RATIO, 2.0 * half_s);
    let states = trace(&problem, 1.0 / (50.0 * TABLE_4_1.frequency_hz), 0.0, problem.duration_s)?;
    let (early, late) = states.split_at(states.len() / 2);
    let mean = |part: &[State], value: &dyn Fn(&State) -> f64| part.iter().map(value).sum::<f64>() / part.len() as f64;
    let peak = states.iter().map(|state| state.x_m.abs()).fold(0.0, f64::max);
    let x = [mean(early, &|state| state.x_m), mean(late, &|state| state.x_m)];
    let numbers = vec![
        number("mean x, 0-10 ms [nm]", 1e9 * x[0]),
        number("mean x, 10-20 ms [nm]", 1e9 * x[1]),
        number("peak x [nm]", 1e9 * peak),
        number("mean x', 0-10 ms [um/s]", 1e6 * mean(early, &|state| state.v_m_per_s)),
        number("mean x', 10-20 ms [um/s]", 1e6 * mean(late, &|state| state.v_m_per_s)),
    ];
    Ok(Claim {
        id: "averages-stay",
        section: "4.3.1",
        says: "While the peaks decrease, the average displacement and velocity stay constant.",
        checks: vec![Check::new(
            "from rest, passive sign (equal within 1 % of the peak)",
            (x[1] - x[0]).abs() < 0.01 * peak,
            numbers,
        )],
    })
}

fn lowers_friction() -> Result<Claim, SolveError> {
    let xi = [0.1, 0.3, 0.5, 0.7, 0.9];
    let labels = xi.map(|xi| format!("{xi}"));
    let with = sweep::each(&xi, |&xi| {
        let mut problem = TABLE_4_1.at_ratio(xi, 20.0 * SHORT_S);
        problem.window_s.0 = 10.0 * SHORT_S;
        sweep::friction(&problem)
    })?;
    let without = xi.map(|xi| steady::dahl(xi, TABLE_4_1.kappa()).friction);
    let holds = with.iter().zip(&without).all(|(with, without)| with < without);
    let numbers = [series("r with", &labels, &with), series("r without", &labels, &without)].concat();
    Ok(Claim {
        id: "natural-part-lowers-friction",
        section: "4.3.1",
        says: "Oscillation at the natural frequency tends to lower the true friction force.",
        checks: vec![Check::new("residue of a start from rest, 10-20 ms, velocity ratio of the forced part", holds, numbers)],
    })
}

fn fast_excitation() -> Result<Claim, SolveError> {
    let hz = [30e3, 60e3, 120e3, 240e3];
    let labels = hz.map(|hz| format!("{} kHz", hz / 1e3));
    let shares = sweep::each(&hz, |&frequency_hz| {
        let case = Case { frequency_hz, ..TABLE_4_1 };
        let (_, amplitude) = amplitude_over_time(&case.at_ratio(PLOTTED_RATIO, BIN_S), case.natural_hz(), BIN_S)?;
        Ok(amplitude.first().copied().unwrap_or(f64::NAN) / case.vibration_m_per_s())
    })?;
    Ok(Claim {
        id: "fast-excitation-suppresses",
        section: "4.3.1",
        says: "Natural oscillation is suppressed if the excitation frequency is far above the natural one.",
        checks: vec![Check::new(
            "from rest, first 5 ms; natural part of the velocity over the forced one",
            sweep::falls(&shares),
            series("natural/forced", &labels, &shares),
        )],
    })
}
