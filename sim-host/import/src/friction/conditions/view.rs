//! Tables, figure, JSON and scene of the friction at many conditions.

use std::fmt::Write as _;

use serde_json::{Value as Json, json};

use super::fit::Stiffness;
use super::interval::{Interval, interval};
use super::model::Point;
use super::{Condition, Conditions, Prediction};
use report::{Axis, Figure, Report, Series, Style, TableBlock, rounded, rounded_to, significant};

impl Conditions {
    /// Returns a condition as text. Load and strength of the vibration are named if they vary.
    pub(super) fn describe(&self, speed: Option<f64>, normal: Option<f64>, level: Option<f64>, label: &str) -> String {
        let varies = |of: &dyn Fn(&Condition) -> Option<f64>| {
            let first = self.conditions.first().and_then(of);
            self.conditions.iter().any(|c| of(c).zip(first).is_some_and(|(a, b)| (a / b - 1.0).abs() > 0.05))
        };
        let level_text = |level: f64| match self.level_unit.as_deref() {
            Some("m") => format!("{} um", significant(1e6 * level)),
            Some(unit) => format!("{} {unit}", significant(level)).trim_end().to_owned(),
            None => format!("tip {} m/s", significant(level)),
        };
        let parts = [
            speed.map(|speed| format!("{} m/s", significant(rounded(speed, 3)))),
            level.filter(|_| varies(&|c| c.level)).map(level_text),
            normal.filter(|_| varies(&|c| c.normal_n)).map(|normal| format!("{} N", significant(rounded(normal, 3)))),
            Some(label.to_owned()).filter(|label| !label.is_empty()),
        ];
        parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }

    /// Returns the values of the fit with their intervals, for tables and programs.
    fn values(&self) -> Vec<(&'static str, Interval)> {
        let mut values = vec![("mu", self.mu)];
        if let Some(tip) = self.tip {
            values.push(match self.level_unit.as_deref() {
                Some("m") => ("tip_m_per_s_per_m", tip),
                Some("V") => ("tip_m_per_s_per_v", tip),
                Some("A") => ("tip_m_per_s_per_a", tip),
                Some(_) => ("tip_m_per_s_per_unit", tip),
                None => ("tip_m_per_s", tip),
            });
        }
        if self.stiffness != Stiffness::Rigid {
            let has_normal = self.measurements.iter().all(|m| m.normal_n.is_some());
            values.push(match (self.stiffness_n_per_m(), has_normal) {
                (Some(stiffness), _) => ("stiffness_n_per_m", stiffness),
                (None, true) => ("stiffness_over_angular_frequency_n_s_per_m", self.stiffness_s),
                (None, false) => ("stiffness_over_angular_frequency_and_load_s_per_m", self.stiffness_s),
            });
        }
        values
    }

    /// Returns the tables: parameters, conditions, predictions.
    pub fn tables(&self, predictions: &[Prediction]) -> Vec<TableBlock> {
        let mut rows: Vec<Vec<String>> = self.values().iter().map(|(name, value)| row(name, value)).collect();
        match self.stiffness {
            Stiffness::Rigid => {
                // Only the lower end may be identified.
                let (name, low) = match (self.stiffness_n_per_m(), self.fit.slices.first()) {
                    (Some(of), Some(soft)) if soft.rise > self.fit.max_rise => ("stiffness_n_per_m", format!("{:.2e}", of.low)),
                    _ => ("stiffness", "-".to_owned()),
                };
                rows.push(vec![name.into(), "not identified: rigid limit".into(), low, "-".into()]);
            }
            Stiffness::Soft => {
                rows.push(vec!["stiffness".into(), "only the upper end is identified".into(), "-".into(), "-".into()])
            }
            Stiffness::Identified => {}
        }
        if self.fit.model.has_trend {
            rows.push(row("exponent of mu over the speed", &interval(&self.fit, |of| of.trend)));
        }
        if let Some([off, on]) = self.scatter {
            rows.push(vec![
                "scatter OFF, ON [%]".into(),
                format!("{:.1}, {:.1}", 100.0 * off, 100.0 * on),
                "-".into(),
                "-".into(),
            ]);
        }
        let (off, on) = (self.measurements.iter().filter(|m| !m.on).count(), self.conditions.iter().map(|c| c.on).sum::<usize>());
        let caption = format!(
            "One fit to {off} measurements OFF and {on} ON. Intervals contain the noise, the scatter between measurements, and \
             the uncertainty of the stiffness."
        );
        let header = ["", "value", "95 % from", "to"];
        let mut tables = vec![TableBlock::new("shared", "Fit to all conditions", caption, &header, rows)];
        let condition = |c: &Condition| {
            let counts = if c.off == 0 { format!("{} / fitted", c.on) } else { format!("{} / {}", c.on, c.off) };
            let name = self.describe(Some(c.speed_m_per_s), c.normal_n, c.level, &c.label);
            let (value, fitted) = (rounded_to(c.measured, c.sd), rounded_to(c.fitted, c.sd));
            vec![name, counts, value, report::stated(c.measured, c.sd).1, fitted, format!("{:+.1}", c.residual())]
        };
        let caption = "Ratio: mean friction ON over OFF at the same speed and load. The residual is measured minus fitted, in \
                       standard deviations of the measured ratio.";
        let header = ["condition", "ON / OFF", "measured ratio", "sd", "fitted ratio", "residual [sd]"];
        let rows = self.conditions.iter().map(condition).collect();
        tables.push(TableBlock::new("conditions", "Friction ratio by condition", caption, &header, rows));
        if !predictions.is_empty() {
            let band = |interval: &Interval| {
                let digits = |value| rounded_to(value, 0.25 * (interval.high - interval.low));
                format!("{} to {}", digits(interval.low), digits(interval.high))
            };
            let one = |p: &Prediction| {
                let measured =
                    if p.outside.is_empty() { "inside".to_owned() } else { format!("EXTRAPOLATED: {}", p.outside.join("; ")) };
                let value = rounded_to(p.fit.value, 0.25 * (p.fit.high - p.fit.low));
                let both = p.fit_and_scatter.as_ref().map_or_else(|| "unknown".into(), band);
                vec![p.condition.clone(), value, band(&p.fit), both, measured]
            };
            let caption = "95 % bands: of the ratio (fit), and of a single new measurement of it (fit and scatter).";
            let header = ["condition", "ratio", "fit", "fit and scatter", "measured range"];
            tables.push(TableBlock::new("predictions", "Prediction", caption, &header, predictions.iter().map(one).collect()));
        }
        tables
    }

    /// Returns the report.
    pub fn report(&self, predictions: &[Prediction]) -> Report {
        let notes = self.warnings.iter().map(|warning| format!("Note: {warning}."));
        let assumed = self.assumptions.iter().map(|assumed| format!("Assumed: {assumed}."));
        Report {
            title: format!("Friction at {} conditions: {}", self.conditions.len(), self.name),
            subtitle: "one fit of the friction without and with vibration".into(),
            paragraphs: notes.chain(assumed).chain(self.remarks.iter().map(|remark| format!("{remark}."))).collect(),
            tables: self.tables(predictions),
            figures: vec![self.figure()],
            ..Report::default()
        }
    }

    /// Returns the figure of the measured over the fitted friction ratio.
    fn figure(&self) -> Figure {
        let of = |value: fn(&Condition) -> f64| self.conditions.iter().map(value).collect::<Vec<f64>>();
        let most = of(|c| c.fitted.max(c.measured)).into_iter().fold(1.0, f64::max);
        let series = |name: &str, x, y, style| Series { name: name.into(), csv_column: format!("ratio_{name}"), x, y, style };
        Figure {
            id: "friction-ratio".into(),
            title: "Measured and fitted friction ratio".into(),
            caption: "Dots: conditions. Line: equal ratios.".into(),
            x: Axis { label: "fitted friction ratio".into(), ..Axis::default() },
            y: Axis { label: "measured friction ratio".into(), ..Axis::default() },
            series: vec![
                series("measured", of(|c| c.fitted), of(|c| c.measured), Style::Points),
                series("equal", vec![0.0, most], vec![0.0, most], Style::Line),
            ],
            ..Figure::default()
        }
    }

    /// Returns the result for programs.
    pub fn json(&self, predictions: &[Prediction]) -> Json {
        let values: serde_json::Map<String, Json> =
            self.values().into_iter().map(|(name, value)| (name.to_owned(), json!(value))).collect();
        json!({
            "fit": values, "stiffness": match self.stiffness {
                Stiffness::Identified => "identified",
                Stiffness::Soft => "upper end only",
                Stiffness::Rigid => "not identified",
            },
            "scatter": self.scatter.map(|[off, on]| json!({ "off": off, "on": on })), "frequency_hz": self.frequency_hz,
            "conditions": self.conditions, "predictions": predictions, "assumed": self.assumptions, "remarks": self.remarks,
            "warnings": self.warnings,
        })
    }

    /// Returns a contact study at the first prediction, or at the middle condition, as TOML.
    ///
    /// # Errors
    /// Returns the options that a scene needs, if they were neither measured nor given.
    pub fn scene(&self, source: &str, predictions: &[Prediction]) -> Result<String, String> {
        let middle = &self.conditions[self.conditions.len() / 2];
        let measured = self.measurements.iter().find(|m| m.on && m.level.or(m.tip_m_per_s) == middle.level).map(Point::new);
        let slice = &self.fit.slices[self.fit.chosen];
        let of = self.fit.model.parameters(&slice.fitted, slice.ln_compliance);
        let tip = measured.and_then(|point| point.drive).unwrap_or(1.0) * libm::exp(of.ln_tip);
        let (speed, normal, tip, note) = match predictions.first() {
            Some(p) => (p.speed_m_per_s, p.normal_n, p.tip_m_per_s, "predicted, not measured".to_owned()),
            None => {
                let (value, sd) = report::stated(middle.measured, middle.sd);
                (middle.speed_m_per_s, middle.normal_n, tip, format!("measured friction ratio {value} ± {sd}"))
            }
        };
        let missing: Vec<&str> = [("`--frequency-hz`", self.frequency_hz.is_none()), ("`--normal-n`", normal.is_none())]
            .into_iter()
            .filter_map(|(option, is_missing)| is_missing.then_some(option))
            .collect();
        let (Some(hz), Some(normal)) = (self.frequency_hz, normal) else { return Err(missing.join(" and ")) };
        if self.stiffness == Stiffness::Soft {
            return Err("a stiffness, of which the data give only an upper limit".to_owned());
        }
        let condition = self.describe(Some(speed), None, None, "");
        let off = Point { speed_m_per_s: speed, normal_n: normal, drive: None };
        let stiffness = std::f64::consts::TAU * hz * libm::exp(of.ln_compliance);
        let (law, key) = match self.stiffness {
            Stiffness::Rigid => ("coulomb", "# The stiffness is not identified: rigid limit.\n".to_owned()),
            _ => ("dahl", format!("stiffness_n_per_m = {:?}\n", rounded(stiffness, 4))),
        };
        let mut text = format!(
            "title = \"Measured contact at {condition}\"\nsource = \"{} conditions of {} fitted by `sim-host import friction`\"\n\
             duration_s = {:?}\n\n# {note}\n[excitation]\nwaveform = \"sine\"\nfrequency_hz = {hz:?}\nsliding_m_per_s = {:?}\n",
            self.conditions.len(),
            source.replace(['"', '\\'], "'"),
            200.0 / hz,
            rounded(speed, 6),
        );
        let _ = write!(
            text,
            "\n[contact.{law}]\nnormal_n = {:?}\nmu = {:?}\n{key}\n[rig.kinematic]\nvibration_m_per_s = {:?}\n\n\
             [integrator]\nwindow_periods = [100, 200]\n",
            rounded(normal, 6),
            rounded(self.fit.model.mu(&of, &off), 4),
            rounded(tip, 4),
        );
        Ok(text)
    }
}

fn row(name: &str, value: &Interval) -> Vec<String> {
    let digits = |number: f64| match number {
        1e5.. => format!("{number:.2e}"),
        _ => rounded_to(number, 0.25 * (value.high - value.low)),
    };
    vec![name.to_owned(), digits(value.value), digits(value.low), digits(value.high)]
}
