//! Effect of one parameter on both ratios, in the form shared by Figures 4.11 to 4.13.

use super::case::{Case, SHORT_S, TABLE_4_1};
use super::picture::{FRICTION_RATIO, FROM_REST, POWER_RATIO, STEADY, VELOCITY_RATIO, axis, column, figure, line, ranged};
use super::steady::Steady;
use super::{steady, sweep};
use contact::SolveError;
use contact::tally::Ratios;
use report::{Axis, Figure, Series};

/// Velocity ratio at which the claims are judged.
pub const JUDGED_RATIO: f64 = 0.5;

/// Curves over the velocity ratio, one for each value of a parameter.
pub struct Parametric {
    /// Labels of the curves.
    pub labels: Vec<String>,
    /// Steady ratios, by closed form in the velocity ratio and kappa.
    steady: Vec<Vec<Steady>>,
    /// Ratios from rest, over the first millisecond.
    from_rest: Vec<Vec<Ratios>>,
    /// Ratios from rest at a fixed sliding speed, that of Table 4.1 with 384 N at the judged ratio.
    fixed_speed: Vec<Ratios>,
    ratios: Vec<f64>,
}

/// Names for the figures of a parameter.
pub struct FigureNames {
    /// Number of the figure, such as `4-11`.
    pub number: &'static str,
    /// Varied parameter.
    pub of: &'static str,
    /// Remark at the start of the captions.
    pub remark: String,
}

impl Parametric {
    /// Computes all curves of these cases.
    pub fn new(cases: &[(String, Case)]) -> Result<Self, SolveError> {
        let ratios = sweep::velocity_ratios();
        let speed = JUDGED_RATIO * TABLE_4_1.vibration_m_per_s();
        Ok(Parametric {
            labels: cases.iter().map(|(label, _)| label.clone()).collect(),
            steady: cases.iter().map(|(_, case)| ratios.iter().map(|&xi| steady::dahl(xi, case.kappa())).collect()).collect(),
            from_rest: sweep::curves(cases, &ratios, |(_, case), xi| sweep::ratios(&case.at_ratio(xi, SHORT_S)))?,
            fixed_speed: sweep::each(cases, |(_, case)| {
                let velocity_ratio = speed / case.vibration_m_per_s();
                sweep::ratios(&case.at_ratio(velocity_ratio, SHORT_S))
            })?,
            ratios,
        })
    }

    /// Returns a steady quantity at a velocity ratio, for each curve.
    pub fn steady(&self, velocity_ratio: f64, of: impl Fn(&Steady) -> f64) -> Vec<f64> {
        self.steady.iter().map(|curve| of(&curve[self.index(velocity_ratio)])).collect()
    }

    /// Returns a quantity of the first millisecond at a velocity ratio, for each curve.
    pub fn first_ms(&self, velocity_ratio: f64, of: impl Fn(&Ratios) -> Option<f64>) -> Vec<f64> {
        self.from_rest.iter().map(|curve| of(&curve[self.index(velocity_ratio)]).unwrap_or(f64::NAN)).collect()
    }

    /// Returns a quantity at the same sliding speed for all curves, for each curve.
    pub fn fixed_speed(&self, of: impl Fn(&Ratios) -> Option<f64>) -> Vec<f64> {
        self.fixed_speed.iter().map(|ratios| of(ratios).unwrap_or(f64::NAN)).collect()
    }

    fn index(&self, velocity_ratio: f64) -> usize {
        let off = |xi: f64| (xi - velocity_ratio).abs();
        (0..self.ratios.len()).min_by(|&a, &b| off(self.ratios[a]).total_cmp(&off(self.ratios[b]))).unwrap_or(0)
    }

    /// Draws both ratios, steady and from rest.
    pub fn figures(&self, names: &FigureNames) -> Vec<Figure> {
        let FigureNames { number, of, remark } = names;
        let dotted = number.replace('-', ".");
        let draw = |part: &str, suffix: &str, title: &str, declared: &str, y: Axis, value: &dyn Fn(usize, usize) -> f64| {
            let curves = self.labels.iter().enumerate().map(|(curve, label)| {
                let values = (0..self.ratios.len()).map(|point| value(curve, point)).collect();
                line(label, column(of, label), &self.ratios, values)
            });
            let series: Vec<Series> = curves.collect();
            let id = format!("fig-{number}{part}{suffix}");
            let title = format!("Figure {dotted}({part}): effect of {of} on the {title}");
            figure(&id, &title, format!("{remark} {declared}"), [ranged(VELOCITY_RATIO, 0.0, 1.0), y], series)
        };
        let unit = || ranged(FRICTION_RATIO, 0.0, 1.0);
        let power = |ratios: &Ratios| ratios.power.unwrap_or(f64::NAN);
        vec![
            draw("a", "", "friction ratio, steady", STEADY, unit(), &|c, p| self.steady[c][p].friction),
            draw("a", "-from-rest", "friction ratio, first millisecond", FROM_REST, unit(), &|c, p| {
                self.from_rest[c][p].friction
            }),
            draw("b", "", "power ratio, steady", STEADY, axis(POWER_RATIO), &|c, p| self.steady[c][p].power),
            draw("b", "-from-rest", "power ratio, first millisecond", FROM_REST, axis(POWER_RATIO), &|c, p| {
                power(&self.from_rest[c][p])
            }),
            draw(
                "b",
                "-printed",
                "power ratio by 4.35 as printed",
                "Equation 4.35 subtracts a mean energy from a work, so its value depends on the duration of the run: here \
                 the first millisecond from rest.",
                axis("power ratio by 4.35"),
                &|c, p| self.from_rest[c][p].power_as_printed.unwrap_or(f64::NAN),
            ),
        ]
    }
}
