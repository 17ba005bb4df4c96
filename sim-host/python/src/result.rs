//! What a run has come to, apart from the run itself: texts, and columns of numbers as bytes.

use pyo3::prelude::*;
use pyo3::types::PyBytes;
use report::Report;
use sim::columns::{Column, Values};
use sim::provenance::Provenance;
use sim::study::Study;
use sim::{columns, output, tables};

use crate::errors::of_run;

/// A table: identifier, title, caption, header, rows.
type TableParts = (String, String, String, Vec<String>, Vec<Vec<String>>);
/// A signal: name, unit, meaning, values.
type SignalParts<'py> = (String, String, String, Bound<'py, PyAny>);

/// Metrics, tables, figures and signals of a run.
#[pyclass(frozen, module = "sonoglide._native")]
pub struct Result {
    summary: String,
    machine: String,
    passed: bool,
    report: Report,
    columns: Vec<Column>,
}

impl Result {
    /// All that Python is shown of a study.
    pub fn of(study: &Study) -> Self {
        Result {
            summary: output::summary(study).to_string(),
            machine: output::machine(study).to_string(),
            passed: study.passes(),
            report: tables::report(study, &Provenance::default()),
            columns: columns::of(study),
        }
    }
}

#[pymethods]
impl Result {
    /// The summary as JSON, as `summary.json` has it.
    #[getter]
    fn summary(&self) -> &str {
        &self.summary
    }

    /// Figures of the machine as JSON, as `machine.json` has them.
    #[getter]
    fn machine(&self) -> &str {
        &self.machine
    }

    /// Whether every expectation of the scene holds.
    #[getter]
    fn passed(&self) -> bool {
        self.passed
    }

    /// Title of the report.
    #[getter]
    fn title(&self) -> &str {
        &self.report.title
    }

    /// The numbers that come first: label, and value with its unit.
    #[getter]
    fn headline(&self) -> Vec<(String, String)> {
        self.report.summary.clone()
    }

    /// Remarks on the run and notes of the scene.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.report.paragraphs.clone()
    }

    /// Tables: identifier, title, caption, header, rows.
    #[getter]
    fn tables(&self) -> Vec<TableParts> {
        let table = |table: &report::TableBlock| {
            (table.id.clone(), table.title.clone(), table.caption.clone(), table.header.clone(), table.rows.clone())
        };
        self.report.tables.iter().map(table).collect()
    }

    /// The signals of the run: name, unit, meaning, and the values: 64-bit floating-point numbers as bytes in the machine's order, or texts.
    fn signals<'py>(&self, py: Python<'py>) -> PyResult<Vec<SignalParts<'py>>> {
        let signal = |column: &Column| {
            let values = match &column.values {
                Values::Numbers(numbers) => {
                    let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_ne_bytes()).collect();
                    PyBytes::new(py, &bytes).into_any()
                }
                Values::Texts(texts) => texts.clone().into_pyobject(py)?.into_any(),
            };
            Ok((column.name.clone(), column.unit.clone(), column.meaning.clone(), values))
        };
        self.columns.iter().map(signal).collect()
    }

    /// The figures: identifier, title, caption.
    #[getter]
    fn figures(&self) -> Vec<(String, String, String)> {
        self.report.figures.iter().map(|figure| (figure.id.clone(), figure.title.clone(), figure.caption.clone())).collect()
    }

    /// A figure as SVG, by its place.
    fn svg(&self, place: usize) -> PyResult<String> {
        report::svg(&self.report.figures[place]).map_err(|error| of_run(&error))
    }

    /// The data of a figure as CSV, by its place.
    fn csv(&self, place: usize) -> PyResult<String> {
        report::csv(&self.report.figures[place]).map_err(|error| of_run(&error))
    }
}
