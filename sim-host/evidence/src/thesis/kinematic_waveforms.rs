//! Waveforms on Dahl's equation, system dynamics apart: Figures 4.17 to 4.20 (4.4.1).

use super::case::PLOTTED_RATIO;
use super::case::{Case, TABLE_4_1};
use super::picture::{FRICTION_RATIO, POWER_RATIO, VELOCITY_RATIO, axis, column, figure, line, ranged};
use super::sweep;
use super::trace::{power_w, trace};
use super::waveforms::{Hold, Named, all, labels, rms_matched_peak, two_figures};
use contact::tally::Ratios;
use contact::{Problem, Shape, SolveError, State};
use report::Figure;

/// Length of a run, s, and where its window begins.
pub const RUN_S: f64 = 5e-3;
const WINDOW_FROM_S: f64 = 1e-3;
/// Samples a period of the pictures.
const SAMPLES: f64 = 200.0;
/// Contact of the claims that need a stiff one: kappa = 40.
pub const STIFFER: f64 = 100.0;

const DECLARED: &str = "The waveform is the vibration velocity itself, 60 kHz; the chirp runs from 20 to 200 kHz. Declared here, open in \
                        the thesis: passive sign, means over 1 to 5 ms, the chirp ends with the run, the sawtooth rises, the square's \
                        duty is one half, the random one is uniform and holds each value for a tenth of a period";

/// How the waveforms are made comparable; the thesis does not say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Match {
    /// The waveforms have equal peak velocities.
    Peak,
    /// Equal root mean square.
    Rms,
}

/// A waveform as the vibration velocity, at a velocity ratio by the sine's peak.
pub fn problem(case: &Case, shape: Shape, matched: Match, velocity_ratio: f64) -> Problem {
    let vibration = TABLE_4_1.vibration_m_per_s();
    let peak = match matched {
        Match::Peak => vibration,
        Match::Rms => rms_matched_peak(shape) * vibration,
    };
    let mut problem = case.kinematic(shape, peak, velocity_ratio * vibration, RUN_S);
    problem.window_s.0 = WINDOW_FROM_S;
    problem
}

/// Ratios of all waveforms over the velocity ratio.
pub struct Curves {
    /// Waveforms that are compared.
    pub waveforms: [Named; 5],
    ratios: Vec<f64>,
    peak: Vec<Vec<Ratios>>,
    rms: Vec<Vec<Ratios>>,
}

/// Forces over time, steady, at a velocity ratio of one half.
pub struct Traces {
    /// For each waveform its states.
    pub states: Vec<Vec<State>>,
    /// For each waveform its problem.
    pub problems: Vec<Problem>,
}

/// Figures 4.17 to 4.20, and what they are drawn from.
pub fn results() -> Result<(Curves, Traces, Vec<Figure>), SolveError> {
    let waveforms = all(RUN_S, Hold::TenthPeriod);
    let ratios = sweep::velocity_ratios();
    let curves = |matched: Match| {
        sweep::curves(&waveforms, &ratios, |named, xi| sweep::ratios(&problem(&TABLE_4_1, named.shape, matched, xi)))
    };
    let curves = Curves { peak: curves(Match::Peak)?, rms: curves(Match::Rms)?, waveforms, ratios };
    let traces = Traces::new(&waveforms, &TABLE_4_1)?;
    let figures = [traces.figures(&waveforms), curves.figures()].concat();
    Ok((curves, traces, figures))
}

impl Traces {
    /// The traces of these waveforms, in this contact.
    pub fn new(waveforms: &[Named], case: &Case) -> Result<Self, SolveError> {
        let problems: Vec<Problem> =
            waveforms.iter().map(|named| problem(case, named.shape, Match::Peak, PLOTTED_RATIO)).collect();
        let period_s = 1.0 / TABLE_4_1.frequency_hz;
        let states = sweep::each(&problems, |problem| trace(problem, period_s / SAMPLES, 60.0 * period_s, 80.0 * period_s))?;
        Ok(Traces { states, problems })
    }

    fn figures(&self, waveforms: &[Named]) -> Vec<Figure> {
        let shown = 3 * SAMPLES as usize + 1;
        let time: Vec<f64> =
            self.states[0].iter().take(shown).map(|state| 1e6 * (state.time_s - 60.0 / TABLE_4_1.frequency_hz)).collect();
        let caption = format!("{DECLARED}; equal peaks; velocity ratio 0.5; three periods from the first millisecond on.");
        let curves = |value: &dyn Fn(&Problem, &State) -> f64| {
            let one =
                |index: usize| self.states[index].iter().take(shown).map(|state| value(&self.problems[index], state)).collect();
            waveforms.iter().enumerate().map(|(index, named)| (named.name, one(index))).collect::<Vec<_>>()
        };
        let force = curves(&|problem, state| state.force_n / problem.coulomb_n);
        let power = curves(&|problem, state| 1e3 * power_w(problem, state));
        let time = ("time [µs]", time.as_slice());
        [
            two_figures("fig-4-17", "Figure 4.17: Dahl friction over time", &caption, "friction / Fc", time, &force),
            two_figures("fig-4-18", "Figure 4.18: instantaneous power over time", &caption, "power [mW]", time, &power),
        ]
        .concat()
    }
}

impl Curves {
    /// A quantity of all waveforms at a velocity ratio.
    pub fn at(&self, matched: Match, velocity_ratio: f64, of: impl Fn(&Ratios) -> f64) -> Vec<f64> {
        let index = self.ratios.iter().position(|&xi| xi > velocity_ratio - 1e-9).unwrap_or(0);
        let curves = match matched {
            Match::Peak => &self.peak,
            Match::Rms => &self.rms,
        };
        curves.iter().map(|curve| of(&curve[index])).collect()
    }

    /// Names of the waveforms.
    pub fn labels(&self) -> Vec<String> {
        labels(&self.waveforms)
    }

    fn figures(&self) -> Vec<Figure> {
        let draw = |id: &str, title: &str, label: &str, curves: &[Vec<Ratios>], matched: &str, of: &dyn Fn(&Ratios) -> f64| {
            let named = self.waveforms.iter().zip(curves);
            let curve = |(named, curve): (&Named, &Vec<Ratios>)| {
                line(named.name, column("waveform", named.name), &self.ratios, curve.iter().map(of).collect())
            };
            let caption = format!("{DECLARED}; {matched}.");
            let axes = [ranged(VELOCITY_RATIO, 0.0, 1.0), axis(label)];
            figure(id, &format!("{title}, {matched}"), caption, axes, named.map(curve).collect())
        };
        let power = |ratios: &Ratios| ratios.power.unwrap_or(f64::NAN);
        let (friction, dissipation) = ("Figure 4.19: friction ratio by waveform", "Figure 4.20: power ratio by waveform");
        vec![
            draw("fig-4-19", friction, FRICTION_RATIO, &self.peak, "equal peaks", &|r| r.friction),
            draw("fig-4-19-rms", friction, FRICTION_RATIO, &self.rms, "equal rms", &|r| r.friction),
            draw("fig-4-20", dissipation, POWER_RATIO, &self.peak, "equal peaks", &power),
            draw("fig-4-20-rms", dissipation, POWER_RATIO, &self.rms, "equal rms", &power),
        ]
    }
}
