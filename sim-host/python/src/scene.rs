//! A scene: what is to be run.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, LazyLock};
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use scene::load::{Loaded, load, load_text};
use scene::resolved::{resolved_json, resolved_toml};
use sim::output::{self, Folder, Owner, Presentation};
use sim::study::{self, Options};

use crate::errors::{SceneError, of_run, of_scene};
use crate::interruptible;
use crate::result::Result;

/// A scene that is valid as a whole. It does not change: `changed` makes another.
#[pyclass(frozen, module = "sonoglide._native")]
pub struct Scene {
    /// Shared with the results of its runs.
    loaded: Arc<Loaded>,
}

impl Scene {
    /// The scene as it was loaded.
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
    /// A built-in scene by name, or a TOML file by path, with changes as `key=value`.
    #[staticmethod]
    fn load(source: &str, changes: Vec<String>) -> PyResult<Self> {
        load(source, &changes).map(Scene::from).map_err(|error| of_scene(&error))
    }

    /// A scene from its text as TOML; `name` is what messages and results call it.
    #[staticmethod]
    fn from_toml(text: &str, name: &str, changes: Vec<String>) -> PyResult<Self> {
        load_text(name, text, &changes).map(Scene::from).map_err(|error| of_scene(&error))
    }

    /// A scene from a dictionary, as JSON.
    #[staticmethod]
    fn from_json(text: &str, name: &str, changes: Vec<String>) -> PyResult<Self> {
        let table: toml::Table = serde_json::from_str(text).map_err(|error| SceneError::new_err(error.to_string()))?;
        Self::from_toml(&table.to_string(), name, changes)
    }

    /// A scene from what `state` gives.
    #[staticmethod]
    fn from_state(state: (String, String, String, Vec<String>)) -> PyResult<Self> {
        let (name, origin, input, changes) = state;
        let loaded = load_text(&origin, &input, &changes).map_err(|error| of_scene(&error))?;
        Ok(Loaded { name, ..loaded }.into())
    }

    /// What makes this scene, and no other: name, origin, text, changes.
    fn state(&self) -> (String, String, String, Vec<String>) {
        let Loaded { name, origin, input, sets, .. } = &*self.loaded;
        (name.clone(), origin.clone(), input.clone(), sets.clone())
    }

    /// The scene with further changes.
    fn changed(&self, changes: Vec<String>) -> PyResult<Self> {
        let Loaded { name, origin, input, sets, .. } = &*self.loaded;
        let loaded = load_text(origin, input, &[sets.clone(), changes].concat()).map_err(|error| of_scene(&error))?;
        Ok(Loaded { name: name.clone(), ..loaded }.into())
    }

    /// Name of the scene.
    #[getter]
    fn name(&self) -> &str {
        &self.loaded.name
    }

    /// Title of the scene.
    #[getter]
    fn title(&self) -> &str {
        &self.loaded.scene.title
    }

    /// The scene with all its defaults as TOML, every key with its unit and meaning.
    fn to_toml(&self) -> String {
        resolved_toml(&self.loaded.scene)
    }

    /// The scene with all its defaults, as JSON.
    fn to_json(&self) -> String {
        resolved_json(&self.loaded.scene).to_string()
    }

    /// Runs the scene, its grid and its comparison. With `output` the folder is written as the command line writes it.
    fn run(&self, py: Python<'_>, output: Option<PathBuf>) -> PyResult<Result> {
        let stop = AtomicBool::new(false);
        interruptible::run(py, &stop, || {
            let folder = output
                .map(|dir| Folder::open(&dir, Owner::new("run", self.loaded.files())))
                .transpose()
                .map_err(|error| of_run(&error))?;
            let options = Options { stop: Some(&stop), clock: Some(clock), ..Options::default() };
            let began = clock();
            let study = study::run(&self.loaded, options).map_err(|error| of_run(&error))?;
            let took = clock() - began;
            // What a signal has cut short is not written: nobody sees its result.
            if let Some(folder) = folder.filter(|_| !study.interrupted) {
                output::write_into(&self.loaded, &study, &folder, &Presentation::default()).map_err(|error| of_run(&error))?;
            }
            let passed = study.passes();
            Ok(Result::new(Arc::clone(&self.loaded), study.detached(), passed, took))
        })?
    }
}

/// Time since the first call.
fn clock() -> Duration {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed()
}
