//! The built-in scenes: every file in the folder `scenes`.

/// Names and texts, listed by the build script.
const SCENES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/scenes.rs"));

/// Returns name and text of every built-in scene, in alphabetical order.
pub fn all() -> &'static [(&'static str, &'static str)] {
    SCENES
}

/// Returns the text of a built-in scene.
pub fn text(name: &str) -> Option<&'static str> {
    SCENES.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

#[cfg(test)]
mod tests {
    #[test]
    fn every_scene_is_valid() {
        for (name, text) in super::all() {
            if let Err(error) = crate::load::load_text(name, text, &[]) {
                panic!("{error}");
            }
        }
    }
}
