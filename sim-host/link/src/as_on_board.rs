//! A scene with block length and limits of the Nucleo board, for a simulated board on which a
//! session with the real one is rehearsed, and for runs of its image.

use firmware::board::parameters::{PARAMETERS, ceiling, values_of};
use scene::Driven;
use scene::load::{LoadError, Loaded};
use scene::settings;

/// Limit of a scene above that of the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lowered {
    /// Name of the setting, without `controller.`.
    pub name: &'static str,
    /// Value of the scene.
    pub asked: f32,
    /// Largest value that the image accepts, with the scale factors of the scene.
    pub ceiling: f32,
}

impl Lowered {
    /// Returns the change of the scene, as `key=value`.
    pub fn set(&self) -> String {
        format!("{}={}", self.key(), self.ceiling)
    }

    fn key(&self) -> String {
        format!("controller.{}", self.name)
    }
}

/// Returns the settings that a scene without them takes on the board, as `key=value`.
pub fn defaults() -> [String; 1] {
    [format!("controller.block_samples={}", nucleo_g474re::blocks::BLOCK)]
}

/// Returns the limits of a scene that the image does not accept. A limit can only be lowered.
pub fn lowered(scene: &Driven) -> Vec<Lowered> {
    let (asked, built_in) = (values_of(&settings::config(scene)), values_of(&nucleo_g474re::config::config()));
    let limits = PARAMETERS.iter().enumerate().filter(|(_, parameter)| parameter.is_limit());
    let compared =
        limits.map(|(n, parameter)| Lowered { name: parameter.name, asked: asked[n], ceiling: ceiling(n, &asked, &built_in) });
    compared.filter(|limit| limit.asked > limit.ceiling).collect()
}

/// Returns the scene with the block length of the board and with the lower of both limits, and the
/// limits that were lowered. A limit that was set on the command line is kept.
pub fn adapted(loaded: Loaded) -> Result<(Loaded, Vec<Lowered>), LoadError> {
    if loaded.scene.driven().is_none() {
        return Ok((loaded, Vec::new()));
    }
    let typed = |key: &str| loaded.sets.iter().any(|set| set.split('=').next().is_some_and(|set| set.trim() == key));
    let limits = loaded.scene.driven().map(|scene| lowered(&scene)).unwrap_or_default();
    let lowered: Vec<Lowered> = limits.into_iter().filter(|limit| !typed(&limit.key())).collect();
    let sets: Vec<String> = lowered.iter().map(Lowered::set).collect();
    Ok((loaded.with_defaults(&defaults())?.changed(&sets)?, lowered))
}

/// Describes lowered limits for the user, in one line.
pub fn in_words(lowered: &[Lowered]) -> Option<String> {
    let each = lowered.iter().map(|limit| format!("{} = {} instead of {}", limit.name, limit.ceiling, limit.asked));
    let each: Vec<String> = each.collect();
    (!each.is_empty()).then(|| format!("the limits of the board are lower than those of the scene: {}", each.join(", ")))
}

#[cfg(test)]
mod tests {
    use scene::load::load;

    use super::*;

    #[test]
    fn the_lower_limit_applies_unless_it_is_typed() {
        let (scene, lowered) = adapted(load("lock", &[]).unwrap()).unwrap();
        let names: Vec<&str> = lowered.iter().map(|limit| limit.name).collect();
        assert_eq!(names, ["limits.current_a", "limits.temperature_c"]);
        let config = settings::config(&scene.scene.driven().unwrap());
        assert_eq!((config.block_samples, config.limits.temperature_c), (100, 85.0));
        assert!(in_words(&lowered).unwrap().contains("limits.temperature_c = 85 instead of 100"));
        assert_eq!(super::lowered(&scene.scene.driven().unwrap()), [], "the image accepts what remains");
        let sets = ["controller.limits.current_a=3".to_owned(), "controller.block_samples=32".to_owned()];
        let (typed, _) = adapted(load("lock", &sets).unwrap()).unwrap();
        let config = settings::config(&typed.scene.driven().unwrap());
        assert_eq!((config.block_samples, config.limits.current_a), (32, 3.0));
    }
}
