//! Hints for command lines in which a scene takes the place of a command or of a port.

use clap::error::ErrorKind;
use scene::builtin;

/// Returns the command line that was probably meant, if a scene is in the wrong place.
pub(super) fn meant(kind: ErrorKind, arguments: &[String]) -> Option<String> {
    let is_scene = |word: &str| builtin::text(word).is_some() || word.ends_with(".toml");
    match arguments {
        [scene, ..] if kind == ErrorKind::InvalidSubcommand && is_scene(scene) => {
            Some(format!("`{scene}` is a scene, not a command; did you mean `sim-host run {scene}`?"))
        }
        [link, scene, rest @ ..] if link == "link" && is_scene(scene) => {
            let rest: String = rest.iter().map(|word| format!(" {word}")).collect();
            Some(format!("`{scene}` is not a port; did you mean `sim-host link sim:{scene}{rest}`?"))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_in_the_wrong_place_is_recognised() {
        let meant = |line: &str| {
            let words: Vec<String> = line.split(' ').map(str::to_owned).collect();
            meant(ErrorKind::InvalidSubcommand, &words)
        };
        assert!(meant("lock").unwrap().contains("`sim-host run lock`"));
        assert!(meant("link lock status").unwrap().contains("`sim-host link sim:lock status`"));
        assert_eq!(meant("locks"), None);
    }
}
