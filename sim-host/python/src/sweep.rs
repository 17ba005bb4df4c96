//! A sweep: metrics of a scene at many points, in a folder as on the command line.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use pyo3::prelude::*;
use pyo3::types::PyBytes;
use scene::load::Loaded;
use sim::output::Presentation;
use sim::output::sweep::{PlanFile, RowsFile, Shard, SweepFolder, join};
use sim::study::sweep::design::Design;
use sim::study::sweep::{self, SweepError};

use crate::errors::{RunError, SceneError, run_error, scene_error};
use crate::interruptible;
use crate::result::bytes_of;
use crate::scene::Scene;

/// Points of a sweep and the metrics to read at each. It is immutable.
#[pyclass(frozen, module = "sonoglide._native")]
pub struct Sweep {
    loaded: Loaded,
    design: Design,
    metrics: Vec<String>,
    done: AtomicU64,
}

impl Sweep {
    fn plan(&self) -> PyResult<sweep::Sweep<'_>> {
        sweep::Sweep::new(&self.loaded, self.design.clone(), &self.metrics).map_err(|error| sweep_error(&error))
    }
}

#[pymethods]
impl Sweep {
    /// Creates a sweep over every combination of some axes, in the syntax of the command line; with
    /// `draws` over a sample of their ranges; or over the points of a CSV.
    #[new]
    fn new(scene: &Scene, axes: Vec<String>, draws: Option<u64>, points: Option<&str>, metrics: Vec<String>) -> PyResult<Self> {
        let design = match (points, draws) {
            (Some(table), _) => Design::read("points", table.as_bytes()),
            (None, Some(draws)) => {
                axes.iter().map(|axis| axis.parse()).collect::<Result<_, _>>().and_then(|ranges| Design::sample(ranges, draws))
            }
            (None, None) => axes.iter().map(|axis| axis.parse()).collect::<Result<_, _>>().and_then(Design::product),
        };
        let design = design.map_err(|error| sweep_error(&error))?;
        let sweep = Sweep { loaded: scene.loaded().clone(), design, metrics, done: AtomicU64::new(0) };
        // Errors are reported here, before anything runs.
        sweep.plan()?;
        Ok(sweep)
    }

    /// Returns the number of points.
    #[getter]
    fn count(&self) -> u64 {
        self.design.count()
    }

    /// Returns the number of points that have been run in this process.
    #[getter]
    fn done(&self) -> u64 {
        self.done.load(Ordering::Relaxed)
    }

    /// Returns the points that are missing in a folder, as ranges. The folder is created if it does
    /// not exist.
    fn missing(&self, folder: PathBuf) -> PyResult<Vec<(u64, u64)>> {
        let open = SweepFolder::open(&folder, &self.plan()?, Shard::WHOLE, &[]).map_err(|error| run_error(&error))?;
        let missing = open.missing().map_err(|error| run_error(&error))?;
        Ok(missing.into_iter().map(|range| (range.start, range.end)).collect())
    }

    /// Runs the missing points of a folder in this process, with `jobs` threads; 0 means one per
    /// processor.
    fn run(&self, py: Python<'_>, folder: PathBuf, jobs: usize) -> PyResult<()> {
        let (plan, stop) = (self.plan()?, AtomicBool::new(false));
        let done = || {
            self.done.fetch_add(1, Ordering::Relaxed);
        };
        interruptible::run(py, &stop, || {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs).build().map_err(|error| run_error(&error))?;
            let open = SweepFolder::open(&folder, &plan, Shard::WHOLE, &[]).map_err(|error| run_error(&error))?;
            pool.install(|| open.run(&plan, &stop, &done)).map(drop).map_err(|error| run_error(&error))
        })?
    }

    /// Runs some points with one thread. Returns the name of their part's file, and its bytes.
    fn part<'py>(&self, py: Python<'py>, from: u64, to: u64, scratch: PathBuf) -> PyResult<(String, Bound<'py, PyBytes>)> {
        let (sweep, stop) = (self.plan()?, AtomicBool::new(false));
        let written = interruptible::run(py, &stop, || -> PyResult<Option<(PathBuf, Vec<u8>)>> {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(|error| run_error(&error))?;
            let part = pool.install(|| PlanFile::new(&sweep).write_part(&sweep, from..to, &scratch, (&stop, &|| ())));
            let Some(part) = part.map_err(|error| run_error(&error))? else { return Ok(None) };
            let bytes = std::fs::read(&part.path).map_err(|error| run_error(&error))?;
            Ok(Some((part.path, bytes)))
        })??;
        let (path, bytes) = written.ok_or_else(|| RunError::new_err("the part was stopped"))?;
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        Ok((name, PyBytes::new(py, &bytes)))
    }

    /// Joins the parts in a folder, and writes the result next to them. Returns the number of
    /// points without a result.
    fn join(&self, py: Python<'_>, folder: PathBuf) -> PyResult<u64> {
        let work = move || join(std::slice::from_ref(&folder), &folder, &Presentation::default());
        Ok(interruptible::run_detached(py, work)?.map_err(|error| run_error(&error))?.failures)
    }

    /// Returns a column of numbers of a folder's result: 64-bit floating-point numbers as bytes in
    /// the machine's order, NaN for a missing value.
    #[staticmethod]
    fn column<'py>(py: Python<'py>, folder: PathBuf, name: &str) -> PyResult<Bound<'py, PyBytes>> {
        let values = RowsFile::open(&folder.join("sweep.parquet"))
            .and_then(|file| file.column(name))
            .map_err(|error| run_error(&error))?;
        bytes_of(py, &values.iter().map(|value| value.unwrap_or(f64::NAN)).collect::<Vec<_>>())
    }
}

/// Converts the error of an invalid sweep.
fn sweep_error(error: &SweepError) -> PyErr {
    match error {
        SweepError::Scene(error) => scene_error(error),
        error => SceneError::new_err(error.to_string()),
    }
}
