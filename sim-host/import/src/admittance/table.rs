//! Tables and report of a fitted admittance.

use report::{Report, TableBlock};

use super::figures;
use super::result::{Admittance, Mode, Value};
use report::{MIN_STATED_REL, rounded, stated};

impl Admittance {
    /// Returns the tables of the result.
    pub fn tables(&self) -> Vec<TableBlock> {
        let mut tables = vec![self.circuit_table()];
        if self.modes.len() > 1 {
            tables.push(self.modes_table());
        }
        tables.push(self.data_table());
        tables
    }

    /// Returns the report with tables and figures. `source` is the file of the measurement.
    pub fn report(&self, source: &str) -> Report {
        let (hz, q) = (self.circuit.series_resonance_hz, self.circuit.q);
        let tile = |value: Value, unit: &str| {
            let (value, sd) = stated(value.value, value.sd);
            format!("{value} ± {sd}{unit}")
        };
        Report {
            title: format!("Measured transducer {}", self.name),
            subtitle: format!("equivalent circuit fitted to {source}"),
            summary: vec![
                ("series resonance".into(), tile(hz, " Hz")),
                ("Q".into(), tile(q, "")),
                ("Rm".into(), tile(self.circuit.rm_ohm, " ohm")),
            ],
            paragraphs: self.warnings.iter().map(|warning| format!("Note: {warning}.")).collect(),
            tables: self.tables(),
            figures: figures::figures(self),
            ..Report::default()
        }
    }

    fn circuit_table(&self) -> TableBlock {
        let circuit = &self.circuit;
        let rows = [
            ("series resonance [Hz]", circuit.series_resonance_hz, 1.0),
            ("parallel resonance [Hz]", circuit.parallel_resonance_hz, 1.0),
            ("Q", circuit.q, 1.0),
            ("Rm [ohm]", circuit.rm_ohm, 1.0),
            ("Lm [mH]", circuit.lm_h, 1e3),
            ("Cm [pF]", circuit.cm_f, 1e12),
            ("C0 [pF]", circuit.c0_f, 1e12),
            ("coupling", circuit.coupling, 1.0),
            ("loss tangent of C0", circuit.loss_tangent, 1.0),
        ];
        let rows = rows.map(|(name, value, factor)| {
            let (number, sd) = stated(value.value * factor, value.sd * factor);
            vec![name.to_owned(), number, sd, format!("{:.1e}", (value.sd / value.value).abs().max(MIN_STATED_REL))]
        });
        let caption = "Standard deviations follow from the noise of the residuals and its correlation. Systematic errors of a \
                       fixture or a calibration are not included.";
        TableBlock::new("circuit", "Equivalent circuit", caption, &["", "value", "standard deviation", "relative"], rows.into())
    }

    fn modes_table(&self) -> TableBlock {
        let row = |(at, mode): (usize, &Mode)| {
            let cell = |value: Value, factor: f64| {
                let (number, sd) = stated(value.value * factor, value.sd * factor);
                format!("{number} ± {sd}")
            };
            let role = if mode.working { "working mode" } else { "further mode" };
            vec![
                (at + 1).to_string(),
                cell(mode.series_resonance_hz, 1.0),
                cell(mode.q, 1.0),
                cell(mode.rm_ohm, 1.0),
                cell(mode.lm_h, 1e3),
                cell(mode.cm_f, 1e12),
                role.to_owned(),
            ]
        };
        let caption = "The working mode has the largest figure of merit Q Cm / C0, if `--mode` does not choose another one.";
        let header = ["mode", "series resonance [Hz]", "Q", "Rm [ohm]", "Lm [mH]", "Cm [pF]", ""];
        TableBlock::new("modes", "Resonances", caption, &header, self.modes.iter().enumerate().map(row).collect())
    }

    fn data_table(&self) -> TableBlock {
        let hz = &self.measured.hz;
        let [from, to] = [hz.first(), hz.last()].map(|hz| rounded(hz.copied().unwrap_or(0.0), 9));
        let range = format!("{from} to {to} Hz");
        let mut rows = vec![vec!["points".to_owned(), hz.len().to_string()], vec!["range".to_owned(), range]];
        let noise = match self.measured.coordinate {
            super::coordinate::Coordinate::Scattering(..) => format!("{:.1e} of the scattering parameter", self.noise[0]),
            super::coordinate::Coordinate::Immittance => {
                format!("{:.1e} of the magnitude, {:.1e} rad of the angle", self.noise[0], self.noise[1])
            }
        };
        rows.push(vec!["noise, rms".to_owned(), noise]);
        rows.extend(self.measured.remarks.iter().map(|remark| vec!["found".to_owned(), remark.clone()]));
        TableBlock::new("data", "Data", "", &["", ""], rows)
    }
}
