//! The scenes that come with the program.

macro_rules! scenes {
    ($($name:literal),+ $(,)?) => {
        &[$(($name, include_str!(concat!("../../scenes/", $name, ".toml")))),+]
    };
}

const SCENES: &[(&str, &str)] = scenes!["experiment-1"];

/// Name and text of every built-in scene.
pub fn all() -> &'static [(&'static str, &'static str)] {
    SCENES
}

/// The text of one built-in scene.
pub fn text(name: &str) -> Option<&'static str> {
    SCENES.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

#[cfg(test)]
mod tests {
    #[test]
    fn every_scene_is_valid() {
        for (name, text) in super::all() {
            if let Err(error) = crate::scene::load::load_text(name, text, &[]) {
                panic!("{error}");
            }
        }
    }
}
