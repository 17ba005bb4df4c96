//! The scenes that come with the program.

macro_rules! scenes {
    ($($name:literal),+ $(,)?) => {
        &[$(($name, include_str!(concat!("../scenes/", $name, ".toml")))),+]
    };
}

const SCENES: &[(&str, &str)] = scenes![
    "experiment-1",
    "experiment-1-fast",
    "experiment-1-fitted",
    "experiment-2",
    "experiment-2-heavy",
    "friction-ratio",
    "friction-burst",
    "contact",
    "contact-kinematic",
    "lock",
    "lock-cold",
    "lock-load",
    "lock-welder",
    "lock-any",
    "lock-step",
    "lock-drift",
    "burst",
    "waveforms",
    "waveforms-fast",
    "transducer-smbltd45f40h-1",
    "transducer-smbltd45f40h-2",
    "transducer-gb-4540-4sh",
    "transducer-skymen-60w",
    "transducer-smbltd45f28h",
    "transducer-ma40s4s",
    "belt-stop",
    "belt-stop-stuck",
    "belt-stop-lost",
    "belt-stop-lies",
    "belt-stop-slow",
    "usm",
    "usm-miscalibrated",
    "dring-crash"
];

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
            if let Err(error) = crate::load::load_text(name, text, &[]) {
                panic!("{error}");
            }
        }
    }
}
