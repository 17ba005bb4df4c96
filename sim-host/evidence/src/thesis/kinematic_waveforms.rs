//! Waveforms on Dahl's equation, without system dynamics: Figures 4.17 to 4.20 (4.4.1).

use super::case::PLOTTED_RATIO;
use super::case::{Case, TABLE_4_1};
use super::picture::{FRICTION_RATIO, POWER_RATIO, VELOCITY_RATIO, axis, column, figure, line, ranged};
use super::sweep;
use super::trace::{power_w, trace};
use super::waveforms::{Hold, NamedWaveform, all, labels, rms_matched_peak, two_figures};
use contact::tally::Ratios;
use contact::{Problem, Shape, SolveError, State};
use report::Figure;

/// Length of a run, s.
pub const RUN_S: f64 = 5e-3;
/// Start of the averaging window, s.
const WINDOW_FROM_S: f64 = 1e-3;
/// Samples a period of the figures.
const SAMPLES_PER_PERIOD: f64 = 200.0;
/// Factor on the contact stiffness for the claims that need a stiff contact: kappa = 40.
pub const STIFFER_FACTOR: f64 = 100.0;

const CHOICES_CAPTION: &str = "The waveform is the vibration velocity itself, 60 kHz; the chirp runs from 20 to 200 kHz. Chosen \
                        here, open in the thesis: passive sign, means over 1 to 5 ms, the chirp ends with the run, the \
                        sawtooth rises, the square's duty is one half, the random waveform is uniform and holds each value \
                        for a tenth of a period";

/// Quantity that is equal among the waveforms; the thesis leaves it open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Match {
    /// The waveforms have equal peak velocities.
    Peak,
    /// The waveforms have equal root mean squares.
    Rms,
}

/// Returns the problem with a waveform as the vibration velocity, at a velocity ratio relative to
/// the sine's peak.
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
    /// Compared waveforms.
    pub waveforms: [NamedWaveform; 5],
    ratios: Vec<f64>,
    peak: Vec<Vec<Ratios>>,
    rms: Vec<Vec<Ratios>>,
}

/// Steady forces over time at a velocity ratio of one half.
pub struct Traces {
    /// States, for each waveform.
    pub states: Vec<Vec<State>>,
    /// Problem, for each waveform.
    pub problems: Vec<Problem>,
}

/// Computes Figures 4.17 to 4.20 and their data.
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
    /// Computes the traces of these waveforms in a contact.
    pub fn new(waveforms: &[NamedWaveform], case: &Case) -> Result<Self, SolveError> {
        let problems: Vec<Problem> =
            waveforms.iter().map(|named| problem(case, named.shape, Match::Peak, PLOTTED_RATIO)).collect();
        let period_s = 1.0 / TABLE_4_1.frequency_hz;
        let states =
            sweep::each(&problems, |problem| trace(problem, period_s / SAMPLES_PER_PERIOD, 60.0 * period_s, 80.0 * period_s))?;
        Ok(Traces { states, problems })
    }

    fn figures(&self, waveforms: &[NamedWaveform]) -> Vec<Figure> {
        let shown = 3 * SAMPLES_PER_PERIOD as usize + 1;
        let time: Vec<f64> =
            self.states[0].iter().take(shown).map(|state| 1e6 * (state.time_s - 60.0 / TABLE_4_1.frequency_hz)).collect();
        let caption = format!("{CHOICES_CAPTION}; equal peaks; velocity ratio 0.5; three periods from the first millisecond on.");
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
    /// Returns a quantity of all waveforms at a velocity ratio.
    pub fn at(&self, matched: Match, velocity_ratio: f64, of: impl Fn(&Ratios) -> f64) -> Vec<f64> {
        let index = self.ratios.iter().position(|&xi| xi > velocity_ratio - 1e-9).unwrap_or(0);
        let curves = match matched {
            Match::Peak => &self.peak,
            Match::Rms => &self.rms,
        };
        curves.iter().map(|curve| of(&curve[index])).collect()
    }

    /// Returns the names of the waveforms.
    pub fn labels(&self) -> Vec<String> {
        labels(&self.waveforms)
    }

    fn figures(&self) -> Vec<Figure> {
        let draw = |id: &str, title: &str, label: &str, curves: &[Vec<Ratios>], matched: &str, of: &dyn Fn(&Ratios) -> f64| {
            let named = self.waveforms.iter().zip(curves);
            let curve = |(named, curve): (&NamedWaveform, &Vec<Ratios>)| {
                line(named.name, column("waveform", named.name), &self.ratios, curve.iter().map(of).collect())
            };
            let caption = format!("{CHOICES_CAPTION}; {matched}.");
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
