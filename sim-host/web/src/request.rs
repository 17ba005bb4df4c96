//! What the page asks for: a scene and its changes.

use scene::load::{LoadError, Loaded, load_text};
use scene::{builtin, load};
use serde::Deserialize;

/// A scene as the page names it.
#[derive(Clone, Debug, Default, Deserialize)]
pub struct Request {
    /// Name of a built-in scene, or what messages call the text.
    pub name: String,
    /// The text of a scene of the reader's own; none of a built-in one.
    #[serde(default)]
    pub text: Option<String>,
    /// Changes as `key=value`.
    #[serde(default)]
    pub sets: Vec<String>,
    /// Whether the scene's grid and comparison are run as well.
    #[serde(default)]
    pub whole: bool,
}

impl Request {
    /// The scene, or everything that is wrong with it in the words of the command line.
    pub(crate) fn load(&self) -> Result<Loaded, String> {
        let loaded = match &self.text {
            Some(text) => load_text(&self.name, text, &self.sets).map(|loaded| Loaded { name: stem(&self.name), ..loaded }),
            // A page has no files: what is not built in is said so, and nothing is looked for.
            None if builtin::text(&self.name).is_some() => load::load(&self.name, &self.sets),
            None => return Err(format!("error: there is no built-in scene `{}`", self.name)),
        };
        let mut loaded = loaded.map_err(|error| said(&error))?;
        if !self.whole {
            let scene = &mut loaded.scene;
            (scene.grid, scene.comparison) = (None, None);
            scene.expect.retain(|expect| expect.case.is_none());
        }
        Ok(loaded)
    }
}

/// An error as the command line prints it.
fn said(error: &LoadError) -> String {
    match error {
        LoadError::Invalid(report) => report.render(false),
        error => format!("error: {error}"),
    }
}

/// The name of a file without its ending.
fn stem(name: &str) -> String {
    name.strip_suffix(".toml").unwrap_or(name).to_owned()
}
