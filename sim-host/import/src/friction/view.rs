//! Tables, figures and scene of a fitted contact.

use std::fmt::Write as _;

use super::log::Options;
use super::models::Model;
use super::result::Friction;
use crate::thinned::thinned;
use report::{Axis, Figure, Report, Series, Style, TableBlock, significant};
use report::{rounded, stated};

impl Friction {
    /// Returns the report. `source` is the file of the measurement.
    pub fn report(&self, source: &str) -> Report {
        Report {
            title: format!("Measured contact {}", self.name),
            subtitle: format!("contact models fitted to {source}"),
            paragraphs: (self.warnings.iter().map(|warning| format!("Note: {warning}.")))
                .chain(self.log.remarks.iter().map(|remark| format!("{remark}.")))
                .collect(),
            tables: self.tables(),
            figures: self.figures(),
            ..Report::default()
        }
    }

    /// Returns the tables: contact, models, correlations.
    pub fn tables(&self) -> Vec<TableBlock> {
        vec![self.contact_table(), self.models_table(), self.correlation_table()]
    }

    fn contact_table(&self) -> TableBlock {
        let rows: Vec<Vec<String>> = self.chosen().parameters.iter().map(row).collect();
        let caption = format!(
            "Model {}, fitted to the OFF part at a normal force of {} N. Standard deviations follow from the noise of the \
             residuals and its correlation.",
            self.chosen().model.name(),
            significant(self.log.normal_n)
        );
        TableBlock::new("contact", "Contact", caption, &["", "value", "standard deviation"], rows)
    }

    fn models_table(&self) -> TableBlock {
        let least = self.chosen().criterion;
        let row = |model: &super::Fitted| {
            let held_out = model.held_out_n.map_or_else(|| "-".into(), significant);
            vec![model.model.name().to_owned(), significant(model.rms_n), held_out, format!("{:.1}", model.criterion - least)]
        };
        let caption = "Bayes's information criterion, `n ln(sum of squares) + p ln n` with the number n of samples divided by \
                       their memory, relative to the chosen model. Held-out: error at segments that the fit has not seen; a \
                       model with fewer parameters and a smaller error is preferred. The generalised Maxwell slip (maxwell) is \
                       not available in scenes and is never chosen.";
        let header = ["model", "residuals, rms [N]", "held-out, rms [N]", "criterion"];
        TableBlock::new("models", "Models", caption, &header, self.models.iter().map(row).collect())
    }

    fn correlation_table(&self) -> TableBlock {
        let chosen = self.chosen();
        let header: Vec<&str> = std::iter::once("").chain(chosen.names.iter().copied()).collect();
        let row = |(name, row): (&&str, &Vec<f64>)| {
            std::iter::once((*name).to_owned()).chain(row.iter().map(|c| format!("{c:.2}"))).collect()
        };
        let rows = chosen.names.iter().zip(&chosen.correlations).map(row).collect();
        TableBlock::new(
            "correlation",
            "Correlation of the fitted parameters",
            "Zero for parameters that the log does not determine.",
            &header,
            rows,
        )
    }

    fn figures(&self) -> Vec<Figure> {
        let log = &self.log;
        let mut at = 0.0;
        let x: Vec<f64> = log
            .slip_m
            .iter()
            .map(|slip| {
                at += slip;
                at * 1e6
            })
            .collect();
        let v: Vec<f64> = log.velocity_m_per_s.iter().map(|v| v * 1e3).collect();
        let force = |name: &str, x: &[f64], y: &[f64], style| Series {
            name: name.into(),
            csv_column: format!("friction_{name}_n"),
            x: x.to_vec(),
            y: y.to_vec(),
            style,
        };
        let axis = |label: &str| Axis { label: label.into(), ..Axis::default() };
        let figure = |id: &str, title: &str, label: &str, x: &[f64]| Figure {
            id: id.into(),
            title: title.into(),
            caption: "Dots: measured, ON and OFF. Line: chosen model, fitted to the OFF part, along the same slip.".into(),
            x: axis(label),
            y: axis("friction [N]"),
            series: vec![
                force("measured", x, &log.force_n, Style::Points),
                force("fitted", x, &self.chosen().force_n, Style::Line),
            ],
            ..Figure::default()
        };
        let numbers: Vec<f64> = if log.time_s.is_empty() { (0..x.len()).map(|n| n as f64).collect() } else { log.time_s.clone() };
        let residuals: Vec<f64> = self
            .chosen()
            .force_n
            .iter()
            .zip(&log.force_n)
            .zip(&log.on)
            .map(|((fitted, measured), on)| if *on { f64::NAN } else { fitted - measured })
            .collect();
        let label = if log.time_s.is_empty() { "sample" } else { "time [s]" };
        let all = vec![
            figure("friction-displacement", "Friction against displacement", "displacement [µm]", &x),
            figure("friction-velocity", "Friction against velocity", "velocity [mm/s]", &v),
            Figure {
                id: "residuals".into(),
                title: "Residuals of the fit".into(),
                caption: "Fitted minus measured, for the OFF part.".into(),
                x: axis(label),
                y: axis("residual [N]"),
                series: vec![Series {
                    name: "residual".into(),
                    csv_column: "residual_n".into(),
                    x: numbers,
                    y: residuals,
                    style: Style::Points,
                }],
                ..Figure::default()
            },
        ];
        all.into_iter().map(thinned).collect()
    }

    /// Returns a contact study with the contact as TOML, at the mean sliding speed of the log.
    ///
    /// # Errors
    /// Returns the options that it needs, or that a scene cannot have the model.
    pub fn scene(&self, source: &str, options: &Options) -> Result<String, String> {
        let (Some(hz), Some(tip)) = (options.frequency_hz, options.tip_m_per_s) else {
            let given = [("`--frequency-hz`", options.frequency_hz), ("`--tip-m-per-s`", options.tip_m_per_s)];
            return Err(given
                .into_iter()
                .filter(|(_, value)| value.is_none())
                .map(|(name, _)| name)
                .collect::<Vec<_>>()
                .join(" and "));
        };
        let log = &self.log;
        let speeds: Vec<f64> = log.velocity_m_per_s.iter().map(|v| v.abs()).filter(|v| *v > 0.0).collect();
        let speed = rounded(speeds.iter().sum::<f64>() / speeds.len().max(1) as f64, 4);
        let value =
            |name: &str| self.chosen().parameters.iter().find(|(own, ..)| own == name).map(|(_, value, _)| rounded(*value, 6));
        let quoted = |text: &str| text.replace(['"', '\\'], "'");
        let mut text = format!(
            "title = \"Measured contact {}: friction under a {} kHz vibration\"\nsource = \"contact fitted to {} by `sim-host import friction`\"\n\
             duration_s = {:?}\n\n[excitation]\nwaveform = \"sine\"\nfrequency_hz = {hz:?}\nsliding_m_per_s = {speed:?}\n",
            quoted(&self.name),
            hz / 1e3,
            quoted(source),
            200.0 / hz
        );
        let (name, keys): (&str, &[&str]) = match self.chosen().model {
            Model::Coulomb => ("coulomb", &["mu"]),
            Model::Dahl => ("dahl", &["mu", "stiffness_n_per_m"]),
            Model::Lugre => ("lugre", &["mu", "static_mu", "stiffness_n_per_m", "stribeck_m_per_s", "sigma2"]),
            Model::Stribeck | Model::Maxwell => return Err("a contact that a scene can have: log the presliding".into()),
        };
        let _ = write!(text, "\n[contact.{name}]\nnormal_n = {:?}\n", rounded(log.normal_n, 6));
        for key in keys {
            let _ = writeln!(text, "{key} = {:?}", value(key).unwrap_or_default());
        }
        let _ = write!(
            text,
            "\n[rig.kinematic]\nvibration_m_per_s = {:?}\n\n[integrator]\nwindow_periods = [100, 200]\n",
            rounded(tip, 4)
        );
        Ok(text)
    }
}

fn row((name, value, sd): &(String, f64, Option<f64>)) -> Vec<String> {
    match sd {
        Some(sd) => {
            let (value, sd) = stated(*value, *sd);
            vec![name.clone(), value, sd]
        }
        None => vec![name.clone(), significant(*value), "not determined".into()],
    }
}
