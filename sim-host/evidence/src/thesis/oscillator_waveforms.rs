//! Waveforms on the oscillator: Figures 4.21 to 4.26 (4.4.2).

use super::case::PLOTTED_RATIO;
use super::case::{SHORT_S, TABLE_4_1};
use super::picture::{FRICTION_RATIO, POWER_RATIO, VELOCITY_RATIO, axis, column, figure, line, log_axis, ranged};
use super::sweep;
use super::trace::{power_w, trace};
use super::waveforms::{Hold, NamedWaveform, all, labels, two_figures};
use contact::tally::Ratios;
use contact::{Problem, SolveError, State};
use report::Figure;

/// Samples a period of the figures.
const SAMPLES_PER_PERIOD: f64 = 100.0;

const CHOICES_CAPTION: &str = "Equal peak force, 384 N; the velocity ratio is relative to the sine's steady vibration velocity \
                        (0.0534 m/s) for all. Chosen here, open in the thesis: from rest, passive sign, the first \
                        millisecond, in which the chirp sweeps from 20 to 200 kHz; the random waveform is uniform and held \
                        as its name states";

/// Returns six waveforms: the thesis's five, with its random one for both hold times.
pub fn waveforms(duration_s: f64) -> Vec<NamedWaveform> {
    let [_, _, _, _, stepped] = all(duration_s, Hold::SolverStep);
    [all(duration_s, Hold::TenthPeriod).as_slice(), &[stepped]].concat()
}

/// Results of the waveforms on the oscillator.
pub struct Results {
    /// Compared waveforms.
    pub waveforms: Vec<NamedWaveform>,
    ratios: Vec<f64>,
    curves: Vec<Vec<Ratios>>,
    /// States over time at a velocity ratio of one half, for each waveform.
    pub states: Vec<Vec<State>>,
    /// Problem, for each waveform.
    pub problems: Vec<Problem>,
}

/// Returns the problem of a waveform at a velocity ratio relative to the sine's steady velocity.
pub fn problem(named: &NamedWaveform, velocity_ratio: f64, duration_s: f64) -> Problem {
    TABLE_4_1.oscillator(named.shape, velocity_ratio * TABLE_4_1.vibration_m_per_s(), duration_s)
}

impl Results {
    /// Runs the problems of all waveforms.
    pub fn new() -> Result<Self, SolveError> {
        let waveforms = waveforms(SHORT_S);
        let ratios = sweep::spaced(0.05, 1.0, 20);
        let curves = sweep::curves(&waveforms, &ratios, |named, xi| sweep::ratios(&problem(named, xi, SHORT_S)))?;
        let problems: Vec<Problem> = waveforms.iter().map(|named| problem(named, PLOTTED_RATIO, SHORT_S)).collect();
        let every_s = 1.0 / (SAMPLES_PER_PERIOD * TABLE_4_1.frequency_hz);
        let states = sweep::each(&problems, |problem| trace(problem, every_s, 0.0, SHORT_S))?;
        Ok(Results { waveforms, ratios, curves, states, problems })
    }

    /// Returns a quantity of all waveforms at a velocity ratio.
    pub fn at(&self, velocity_ratio: f64, of: impl Fn(&Ratios) -> f64) -> Vec<f64> {
        let index = self.ratios.iter().position(|&xi| xi > velocity_ratio - 1e-9).unwrap_or(0);
        self.curves.iter().map(|curve| of(&curve[index])).collect()
    }

    /// Returns the largest value over the run at a velocity ratio of one half, for each waveform.
    pub fn largest(&self, of: impl Fn(&Problem, &State) -> f64) -> Vec<f64> {
        let one =
            |(problem, states): (&Problem, &Vec<State>)| states.iter().map(|state| of(problem, state)).fold(f64::MIN, f64::max);
        self.problems.iter().zip(&self.states).map(one).collect()
    }

    /// Returns the names of the waveforms.
    pub fn labels(&self) -> Vec<String> {
        labels(&self.waveforms)
    }

    /// Draws Figures 4.21 to 4.26.
    pub fn figures(&self) -> Vec<Figure> {
        let time: Vec<f64> = self.states[0].iter().map(|state| 1e3 * state.time_s).collect();
        let caption = format!("{CHOICES_CAPTION}. Velocity ratio 0.5.");
        let over_time = |id: &str, title: &str, label: &str, value: &dyn Fn(&Problem, &State) -> f64| {
            let one = |index: usize| self.states[index].iter().map(|state| value(&self.problems[index], state)).collect();
            let curves: Vec<_> = self.waveforms.iter().enumerate().map(|(index, named)| (named.name, one(index))).collect();
            two_figures(id, title, &caption, label, ("time [ms]", &time), &curves)
        };
        let over_ratio = |id: &str, title: &str, y, of: &dyn Fn(&Ratios) -> f64| {
            // By 4.35 the random walk reaches thousands, which would flatten all other curves.
            let drawn = |named: &NamedWaveform| !(id.ends_with("printed") && named.name.ends_with("T/10"));
            let named = self.waveforms.iter().zip(&self.curves).filter(|(named, _)| drawn(named));
            let curve = |(named, curve): (&NamedWaveform, &Vec<Ratios>)| {
                line(named.name, column("waveform", named.name), &self.ratios, curve.iter().map(of).collect())
            };
            figure(id, title, format!("{CHOICES_CAPTION}."), [ranged(VELOCITY_RATIO, 0.0, 1.0), y], named.map(curve).collect())
        };
        let power = |ratios: &Ratios| ratios.power.unwrap_or(f64::NAN);
        let mut figures = [
            over_time("fig-4-21", "Figure 4.21: displacement", "displacement [µm]", &|_, state| 1e6 * state.x_m),
            over_time("fig-4-22", "Figure 4.22: velocity", "velocity [m/s]", &|_, state| state.v_m_per_s),
            over_time("fig-4-23", "Figure 4.23: friction force", "friction / Fc", &|problem, state| {
                state.force_n / problem.coulomb_n
            }),
            over_time("fig-4-24", "Figure 4.24: dissipated power", "power [mW]", &|problem, state| 1e3 * power_w(problem, state)),
        ]
        .concat();
        figures.push(over_ratio("fig-4-25", "Figure 4.25: friction ratio by waveform, oscillator", axis(FRICTION_RATIO), &|r| {
            r.friction
        }));
        figures.push(over_ratio("fig-4-26", "Figure 4.26: power ratio by waveform, oscillator", log_axis(POWER_RATIO), &power));
        figures.push(over_ratio(
            "fig-4-26-printed",
            "Figure 4.26: power ratio by waveform, by 4.35 as printed (random held T/10: thousands, not drawn)",
            axis("power ratio by 4.35"),
            &|ratios| ratios.power_as_printed.unwrap_or(f64::NAN),
        ));
        figures
    }
}
