//! Figures of a contact study: the last periods in full, and the whole run by its extremes.

mod between;
mod in_plane;
mod whole_run;

use self::between::{coulomb_n, filled};
use crate::instruments::curves::axis;
use crate::study::across::Compliance;
use crate::study::answer::Answer;
use crate::study::contact::Solved;
use contact::{Problem, State};
use report::{Axis, Figure, Series, Style};

const TIME: &str = "time [periods of the excitation]";

/// Returns all figures that apply to this study, the most important first.
pub fn all(solved: &Solved) -> Vec<Figure> {
    let mut figures = Vec::new();
    if let Some(answer) = &solved.answer
        && let Some(in_plane) = &answer.in_plane
    {
        figures.extend(in_plane::all(&answer.problem, in_plane));
    } else if let Some(answer) = &solved.answer
        && solved.playback.last_periods().len() > 1
    {
        let last = Last::new(answer, solved.playback.last_periods());
        figures.push(last.friction());
        figures.extend(answer.across.and_then(|across| across.compliant).map(|compliant| last.normal(&compliant)));
        figures.push(last.against_displacement());
        figures.extend(last.along.then(|| last.against_slip()));
        figures.extend([last.motion(), last.velocity(), last.power()]);
    }
    figures.extend(whole_run::all(solved));
    figures
}

/// Figures over the last periods.
struct Last<'a> {
    problem: &'a Problem,
    /// `true` if the vibration is along the sliding and contributes to the slip.
    along: bool,
    states: Vec<State>,
    periods: Vec<f64>,
}

impl<'a> Last<'a> {
    fn new(answer: &'a Answer, states: &[State]) -> Self {
        let (problem, along) = (&answer.problem, answer.across.is_none());
        let hz = problem.waveform.frequency_hz();
        let states = if along { filled(problem, states) } else { states.to_vec() };
        Last { problem, along, periods: states.iter().map(|state| hz * state.time_s).collect(), states }
    }

    fn values(&self, value: impl Fn(&State) -> f64) -> Vec<f64> {
        self.states.iter().map(value).collect()
    }

    /// Returns the slip velocity V, m/s.
    fn slip(&self, state: &State) -> f64 {
        let along = if self.along { self.problem.sign.factor() * state.v_m_per_s } else { 0.0 };
        self.problem.sliding_m_per_s + along
    }

    fn over_time(&self, (id, title, caption): (&str, &str, &str), y: &str, series: Series) -> Figure {
        Figure {
            id: id.into(),
            title: title.into(),
            caption: caption.into(),
            x: axis(TIME),
            y: axis(y),
            series: vec![series],
            interactive: true,
            ..Figure::default()
        }
    }

    fn series(&self, name: &str, csv_column: &str, value: impl Fn(&State) -> f64) -> Series {
        line(name, csv_column, self.periods.clone(), self.values(value))
    }

    fn friction(&self) -> Figure {
        let texts =
            ("friction", "Friction over the last periods", "Dashed: the Coulomb force, which is the friction without vibration.");
        let mut figure = self.over_time(texts, "friction [N]", self.series("friction", "friction_n", |state| state.force_n));
        let coulomb_n = self.coulomb_n();
        figure.hlines = vec![(coulomb_n, "mu N".into()), (0.0, String::new())];
        if self.states.iter().any(|state| state.force_n < 0.0) {
            figure.hlines.push((-coulomb_n, "-mu N".into()));
        }
        figure
    }

    /// Returns the figure of normal force and friction; the contact sticks while friction is below
    /// its limit.
    fn normal(&self, contact: &Compliance) -> Figure {
        let texts = (
            "normal-force",
            "Normal force and friction over the last periods",
            "While friction is below mu times the normal force, the contact sticks and the sliding loads its spring; without a \
             normal force the spring relaxes.",
        );
        let normal = self.series("normal force N", "normal_n", |state| contact.normal_n(state.x_m));
        let mut figure = self.over_time(texts, "force [N]", normal);
        let limit = self.series("mu N", "friction_limit_n", |state| contact.mu * contact.normal_n(state.x_m));
        figure.series.push(Series { style: Style::Dashed, ..limit });
        figure.series.push(self.series("friction", "spring_n", |state| state.force_n));
        figure.hlines = vec![(0.0, String::new())];
        figure
    }

    fn velocity(&self) -> Figure {
        let texts = ("velocity", "Velocity over the last periods", "Friction reverses when the slip velocity changes its sign.");
        let vibration = self.series("vibration x'", "velocity_m_per_s", |state| state.v_m_per_s);
        let mut figure = self.over_time(texts, "velocity [m/s]", vibration);
        figure.series.push(self.series("slip V", "slip_m_per_s", |state| self.slip(state)));
        figure.hlines = vec![(0.0, String::new())];
        figure
    }

    fn motion(&self) -> Figure {
        let texts = ("displacement", "Displacement over the last periods", "Displacement of the vibration, without the sliding.");
        self.over_time(texts, "displacement [µm]", self.series("displacement x", "displacement_um", |state| 1e6 * state.x_m))
    }

    fn power(&self) -> Figure {
        let texts = (
            "power",
            "Power into friction over the last periods",
            "Friction times slip velocity. It is negative when the contact returns elastically stored energy. Dashed: power \
             dissipated by Coulomb friction without vibration.",
        );
        let power = self.series("F V", "power_mw", |state| 1e3 * state.force_n * self.slip(state));
        let mut figure = self.over_time(texts, "power [mW]", power);
        figure.hlines = vec![(1e3 * self.coulomb_n() * self.problem.sliding_m_per_s, "mu N Vt".into()), (0.0, String::new())];
        figure
    }

    /// Returns the friction loop over displacement; its area is the work of friction on the
    /// vibration.
    fn against_displacement(&self) -> Figure {
        let (x, y) = (self.values(|state| 1e6 * state.x_m), self.values(|state| state.force_n));
        loop_of(
            ("hysteresis", "Friction against displacement", "The area is the work of friction on the vibration per period."),
            axis("displacement x [µm]"),
            line("friction", "friction_n", x, y),
        )
    }

    fn against_slip(&self) -> Figure {
        let (x, y) = (self.values(|state| self.slip(state)), self.values(|state| state.force_n));
        loop_of(
            (
                "slip-loop",
                "Friction against slip velocity",
                "Coulomb friction would jump at zero; friction of a soft contact lags.",
            ),
            axis("slip velocity V [m/s]"),
            line("friction", "friction_against_slip_n", x, y),
        )
    }

    /// Returns the Coulomb force at the end, N.
    fn coulomb_n(&self) -> f64 {
        coulomb_n(self.problem, self.states.last().map_or(0.0, |state| state.time_s))
    }
}

fn line(name: &str, csv_column: &str, x: Vec<f64>, y: Vec<f64>) -> Series {
    Series { name: name.into(), csv_column: csv_column.into(), x, y, style: Style::Line }
}

fn loop_of((id, title, caption): (&str, &str, &str), x: Axis, series: Series) -> Figure {
    Figure {
        id: id.into(),
        title: title.into(),
        caption: caption.into(),
        x,
        y: axis("friction [N]"),
        series: vec![series],
        hlines: vec![(0.0, String::new())],
        ..Figure::default()
    }
}
