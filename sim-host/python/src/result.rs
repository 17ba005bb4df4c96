//! Result of a run: strings, and columns of numbers as bytes. Slow parts are computed on request.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Duration;

use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use report::{Figure, Report};
use scene::load::Loaded;
use sim::columns::{self, Values};
use sim::provenance::Provenance;
use sim::study::{Detached, Study};
use sim::{output, tables};

use crate::errors::{RunError, run_error};
use crate::interruptible::guarded;

/// A table: identifier, title, caption, header, rows.
type TableParts = (String, String, String, Vec<String>, Vec<Vec<String>>);

/// Metrics, tables, figures and signals of a run.
#[pyclass(frozen, module = "sonoglide._native")]
pub struct Result {
    loaded: Arc<Loaded>,
    /// The study; `None` only while it is in use under the lock, and after a panic there.
    study: Mutex<Option<Detached>>,
    report: OnceLock<Report>,
    passed: bool,
    took: Duration,
}

impl Result {
    /// Creates the result of a study of a scene, with the wall time of its run.
    pub fn new(loaded: Arc<Loaded>, study: Detached, passed: bool, took: Duration) -> Self {
        Result { loaded, study: Mutex::new(Some(study)), report: OnceLock::new(), passed, took }
    }

    /// Evaluates the study, without the interpreter's lock.
    fn with_study<T: Send>(&self, py: Python<'_>, look: impl FnOnce(&Study) -> T + Send) -> PyResult<T> {
        let look = || {
            let mut kept = self.study.lock().unwrap_or_else(PoisonError::into_inner);
            let study = kept.take().and_then(|study| study.of(&self.loaded.scene))?;
            let seen = look(&study);
            *kept = Some(study.detached());
            Some(seen)
        };
        py.detach(|| guarded(look))?.ok_or_else(|| RunError::new_err("the result of this run was lost in an earlier error"))
    }

    /// Returns the report, with the data of its figures; it is computed once.
    fn report(&self, py: Python<'_>) -> PyResult<&Report> {
        if let Some(report) = self.report.get() {
            return Ok(report);
        }
        let made = self.with_study(py, |study| tables::report(study, &Provenance::default()))?;
        Ok(self.report.get_or_init(|| made))
    }

    fn figure(&self, py: Python<'_>, place: usize) -> PyResult<&Figure> {
        self.report(py)?.figures.get(place).ok_or_else(|| PyIndexError::new_err(format!("there is no figure {place}")))
    }
}

#[pymethods]
impl Result {
    /// Returns the summary as JSON, as in `summary.json`.
    #[getter]
    fn summary(&self, py: Python<'_>) -> PyResult<String> {
        self.with_study(py, |study| output::summary(study).to_string())
    }

    /// Returns the figures of the machine as JSON, as in `machine.json`.
    #[getter]
    fn machine(&self, py: Python<'_>) -> PyResult<String> {
        self.with_study(py, |study| output::machine(study).to_string())
    }

    /// Returns `true` if every expectation of the scene is met.
    #[getter]
    fn passed(&self) -> bool {
        self.passed
    }

    /// Returns the wall time of the run itself, s, without evaluation of the result.
    #[getter]
    fn run_s(&self) -> f64 {
        self.took.as_secs_f64()
    }

    /// Returns the title of the report.
    #[getter]
    fn title(&self, py: Python<'_>) -> PyResult<String> {
        self.with_study(py, tables::title)
    }

    /// Returns the headline numbers: label, and value with its unit.
    #[getter]
    fn headline(&self, py: Python<'_>) -> PyResult<Vec<(String, String)>> {
        self.with_study(py, tables::headline)
    }

    /// Returns remarks on the run and notes of the scene.
    #[getter]
    fn notes(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        Ok(self.report(py)?.paragraphs.clone())
    }

    /// Returns the tables: identifier, title, caption, header, rows.
    #[getter]
    fn tables(&self, py: Python<'_>) -> PyResult<Vec<TableParts>> {
        let table = |table: &report::TableBlock| {
            (table.id.clone(), table.title.clone(), table.caption.clone(), table.header.clone(), table.rows.clone())
        };
        Ok(self.report(py)?.tables.iter().map(table).collect())
    }

    /// Returns the signals of the run: name, unit, meaning.
    #[getter]
    fn signals(&self, py: Python<'_>) -> PyResult<Vec<(String, String, String)>> {
        let heads = self.with_study(py, columns::heads)?;
        Ok(heads.into_iter().map(|head| (head.name, head.unit, head.meaning)).collect())
    }

    /// Returns the values of a signal by its index: 64-bit floating-point numbers as bytes in the
    /// machine's order, or strings.
    fn signal<'py>(&self, py: Python<'py>, place: usize) -> PyResult<Bound<'py, PyAny>> {
        let values = self.with_study(py, |study| columns::values(study, place))?;
        match values.ok_or_else(|| PyIndexError::new_err(format!("there is no signal {place}")))? {
            Values::Numbers(numbers) => bytes_of(py, &numbers).map(Bound::into_any),
            Values::Texts(texts) => Ok(texts.into_pyobject(py)?.into_any()),
        }
    }

    /// Returns the figures: identifier, title, caption.
    #[getter]
    fn figures(&self, py: Python<'_>) -> PyResult<Vec<(String, String, String)>> {
        let texts = |figure: &Figure| (figure.id.clone(), figure.title.clone(), figure.caption.clone());
        Ok(self.report(py)?.figures.iter().map(texts).collect())
    }

    /// Returns a figure as SVG, by its index.
    fn svg(&self, py: Python<'_>, place: usize) -> PyResult<String> {
        let figure = self.figure(py, place)?;
        py.detach(|| guarded(|| report::svg(figure)))?.map_err(|error| run_error(&error))
    }

    /// Returns the data of a figure as CSV, by its index.
    fn csv(&self, py: Python<'_>, place: usize) -> PyResult<String> {
        report::csv(self.figure(py, place)?).map_err(|error| run_error(&error))
    }
}

/// Converts 64-bit floating-point numbers to bytes in the machine's order.
pub fn bytes_of<'py>(py: Python<'py>, numbers: &[f64]) -> PyResult<Bound<'py, PyBytes>> {
    PyBytes::new_with(py, size_of_val(numbers), |bytes| {
        bytes
            .chunks_exact_mut(size_of::<f64>())
            .zip(numbers)
            .for_each(|(bytes, number)| bytes.copy_from_slice(&number.to_ne_bytes()));
        Ok(())
    })
}
