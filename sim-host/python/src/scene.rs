//! A scene to run.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, LazyLock};
use std::time::{Duration, Instant};

use contact::custom::FrictionLaw;
use pyo3::prelude::*;
use scene::load::{Loaded, load, load_text};
use scene::resolved::{resolved_json, resolved_toml};
use sim::output::{self, Folder, Owner, Presentation};
use sim::study::{self, Options};

use crate::errors::{SceneError, run_error, scene_error};
use crate::interruptible;
use crate::law::Law;
use crate::result::Result;

/// Shortest time between two reports of the progress.
const PROGRESS_INTERVAL: Duration = Duration::from_millis(50);

/// A valid scene. It is immutable: `changed` returns another one.
#[pyclass(frozen, module = "sonoglide._native")]
pub struct Scene {
    /// Shared with the results of its runs.
    loaded: Arc<Loaded>,
}

impl Scene {
    /// Returns the loaded scene.
    pub fn loaded(&self) -> &Loaded {
        &self.loaded
    }
}

impl From<Loaded> for Scene {
    fn from(loaded: Loaded) -> Self {
        Scene { loaded: Arc::new(loaded) }
    }
}

#[pymethods]
impl Scene {
    /// Loads a built-in scene by name, or a TOML file by path, with changes as `key=value`.
    #[staticmethod]
    fn load(source: &str, changes: Vec<String>) -> PyResult<Self> {
        load(source, &changes).map(Scene::from).map_err(|error| scene_error(&error))
    }

    /// Creates a scene from TOML text; `name` is its name in messages and results.
    #[staticmethod]
    fn from_toml(text: &str, name: &str, changes: Vec<String>) -> PyResult<Self> {
        load_text(name, text, &changes).map(Scene::from).map_err(|error| scene_error(&error))
    }

    /// Creates a scene from a dictionary as JSON.
    #[staticmethod]
    fn from_json(text: &str, name: &str, changes: Vec<String>) -> PyResult<Self> {
        let table: toml::Table = serde_json::from_str(text).map_err(|error| SceneError::new_err(error.to_string()))?;
        Self::from_toml(&table.to_string(), name, changes)
    }

    /// Creates a scene from the value of `state`.
    #[staticmethod]
    fn from_state(state: (String, String, String, Vec<String>)) -> PyResult<Self> {
        let (name, origin, input, changes) = state;
        let loaded = load_text(&origin, &input, &changes).map_err(|error| scene_error(&error))?;
        Ok(Loaded { name, ..loaded }.into())
    }

    /// Returns the data that define this scene: name, origin, text, changes.
    fn state(&self) -> (String, String, String, Vec<String>) {
        let Loaded { name, origin, input, sets, .. } = &*self.loaded;
        (name.clone(), origin.clone(), input.clone(), sets.clone())
    }

    /// Returns the scene with further changes.
    fn changed(&self, changes: Vec<String>) -> PyResult<Self> {
        let Loaded { name, origin, input, sets, .. } = &*self.loaded;
        let loaded = load_text(origin, input, &[sets.clone(), changes].concat()).map_err(|error| scene_error(&error))?;
        Ok(Loaded { name: name.clone(), ..loaded }.into())
    }

    /// Returns the name of the scene.
    #[getter]
    fn name(&self) -> &str {
        &self.loaded.name
    }

    /// Returns the title of the scene.
    #[getter]
    fn title(&self) -> &str {
        &self.loaded.scene.title
    }

    /// Returns the scene with all its defaults as TOML, every key with its unit and meaning.
    fn to_toml(&self) -> String {
        resolved_toml(&self.loaded.scene)
    }

    /// Returns the scene with all its defaults, as JSON.
    fn to_json(&self) -> String {
        resolved_json(&self.loaded.scene).to_string()
    }

    /// Runs the scene, its grid and its comparison. With `output` it writes the folder as the
    /// command line does. `law` replaces the friction law of the contact: a function, and the
    /// values of its states at the start.
    /// `progress` is called with the simulated time, s, or the number of completed runs.
    fn run(
        &self,
        py: Python<'_>,
        output: Option<PathBuf>,
        law: Option<(Py<PyAny>, Vec<f64>)>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Result> {
        let stop = AtomicBool::new(false);
        let law = law.map(|(function, start)| Law::new(&self.loaded.scene, function, start, &stop)).transpose()?;
        let ran = interruptible::run(py, &stop, || {
            let folder = output
                .map(|dir| Folder::open(&dir, Owner::new("run", self.loaded.files())))
                .transpose()
                .map_err(|error| run_error(&error))?;
            let law = law.as_ref().map(|law| law as &(dyn FrictionLaw + Sync));
            let mut shown = clock();
            let mut report = progress.map(|progress| {
                move |reached: f64| {
                    let now = clock();
                    if now - shown < PROGRESS_INTERVAL {
                        return;
                    }
                    shown = now;
                    Python::attach(|py| {
                        if let Err(error) = progress.call1(py, (reached,)) {
                            error.write_unraisable(py, None);
                        }
                    });
                }
            });
            let report = report.as_mut().map(|report| report as &mut (dyn FnMut(f64) + Send));
            let options = Options { stop: Some(&stop), clock: Some(clock), law, progress: report, ..Options::default() };
            let began = clock();
            // One attachment for all calls of a law: each new one would allocate a thread state.
            let study = match law {
                Some(_) => Python::attach(|_| study::run(&self.loaded, options)),
                None => study::run(&self.loaded, options),
            };
            let study = study.map_err(|error| run_error(&error))?;
            let took = clock() - began;
            // A run cut short by a signal is not written, as its result is discarded.
            if let Some(folder) = folder.filter(|_| !study.interrupted) {
                output::write_into(&self.loaded, &study, &folder, &Presentation::default()).map_err(|error| run_error(&error))?;
            }
            let passed = study.passes();
            Ok(Result::new(Arc::clone(&self.loaded), study.detached(), passed, took))
        })?;
        // An exception in the law is the reason that there is no result.
        law.and_then(Law::into_raised).map_or(ran, Err)
    }
}

/// Returns the time since the first call.
fn clock() -> Duration {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed()
}
