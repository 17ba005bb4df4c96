//! Request of the page: a scene and its changes.

use scene::load::{LoadError, Loaded, load_text};
use scene::{builtin, load};
use serde::Deserialize;

/// A scene as requested by the page.
#[derive(Clone, Debug, Default, Deserialize)]
pub struct Request {
    /// Name of a built-in scene, or the name of the text in messages.
    pub name: String,
    /// Text of the reader's own scene; `None` for a built-in one.
    #[serde(default)]
    pub text: Option<String>,
    /// Changes as `key=value`.
    #[serde(default)]
    pub sets: Vec<String>,
    /// `true` to run the scene's grid and comparison as well.
    #[serde(default)]
    pub whole: bool,
    /// `true` for a bare Nucleo with the wires of the self-test, instead of the scene's plant at a
    /// simulated board.
    #[serde(default)]
    pub jumper: bool,
    /// Metric of a point of a curve.
    #[serde(default)]
    pub metric: String,
}

impl Request {
    /// Loads the scene. The error has all messages of the command line.
    pub(crate) fn load(&self) -> Result<Loaded, String> {
        let loaded = match &self.text {
            Some(text) => {
                load_text(&self.name, text, &self.sets).map(|loaded| Loaded { name: stem(&self.name).to_owned(), ..loaded })
            }
            // A page has no files, so only built-in scenes are looked up.
            None if builtin::text(&self.name).is_some() => load::load(&self.name, &self.sets),
            None => return Err(format!("error: there is no built-in scene `{}`", self.name)),
        };
        let mut loaded = loaded.map_err(|error| message(&error))?;
        if !self.whole {
            let scene = &mut loaded.scene;
            (scene.grid, scene.comparison) = (None, None);
            scene.expect.retain(|expect| expect.case.is_none());
        }
        Ok(loaded)
    }
}

/// Formats an error as on the command line.
pub(crate) fn message(error: &LoadError) -> String {
    match error {
        LoadError::Invalid(report) => report.render(false),
        error => format!("error: {error}"),
    }
}

/// Returns the name of a file without its extension.
pub(crate) fn stem(name: &str) -> &str {
    name.rsplit_once('.').map_or(name, |(stem, _)| stem)
}
