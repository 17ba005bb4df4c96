//! Conversion of a scene's configuration to stored settings of the image.
//!
//! The image has a built-in configuration, and a host can set its parameters. Other settings of a
//! scene that differ from the image are refused by name, because the image would behave
//! differently.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};
use firmware::board::parameters::{Overrides, PARAMETERS, ceiling, values_of};
use firmware::board::settings::{Record, Settings};
use firmware::seam::block::LATENCY_BLOCKS;
use firmware::seam::config::keys::RESTRAINT_ENABLED;
use firmware::seam::config::{Config, Link, Range, Schedule, ShapeKind};
use nucleo_g474re::pages;
use scene::Driven;
use scene::load::{LoadError, Loaded};
use serde_json::Value;

use crate::sensors::newton_per_lsb;

/// Settings of a scene that the image does not support, one per line.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("the image does not support these settings of the scene:\n{}", .0.join("\n"))]
pub struct Misfit(pub Vec<String>);

/// Stored settings of an image, and the resulting configuration.
#[derive(Clone, Debug, PartialEq)]
pub struct Stored {
    /// Parameters to store in its flash.
    pub overrides: Overrides,
    /// Resulting configuration: that of the scene, in the precision of the parameters.
    pub config: Config,
}

/// Returns the settings that a scene without them takes on the image, as `key=value`: the block
/// length.
pub fn defaults() -> [String; 1] {
    [format!("controller.block_samples={}", nucleo_g474re::blocks::BLOCK)]
}

/// Loads a scene for the image, as [`scene::load::load`] does.
pub fn load(source: &str, sets: &[String]) -> Result<Loaded, LoadError> {
    scene::load::load(source, sets)?.with_defaults(&defaults())
}

/// Returns the settings with which the image runs a scene.
///
/// Windows of a burst count from the run command. The scene begins with the block that plays the
/// codes of that command's block.
pub fn stored(scene: &Driven) -> Result<Stored, Misfit> {
    let mut asked = scene::settings::config(scene);
    asked.front_end.newton_per_lsb = newton_per_lsb(scene);
    if let Schedule::Windows(windows) = &mut asked.burst.schedule {
        let samples = LATENCY_BLOCKS as f64 * f64::from(asked.block_samples);
        let later_s = samples / f64::from(asked.sample_hz);
        windows.iter_mut().for_each(|(on_s, off_s)| (*on_s, *off_s) = (*on_s + later_s, *off_s + later_s));
    }
    overrides(&asked, &nucleo_g474re::config::config())
}

/// Returns the settings that change an image from the configuration `built_in` to `asked`.
pub fn overrides(asked: &Config, built_in: &Config) -> Result<Stored, Misfit> {
    let defaults = values_of(built_in);
    let mut same = Config { link: built_in.link, ..asked.clone() };
    if asked.drive.shape != ShapeKind::Noise {
        same.drive.noise_band_hz = built_in.drive.noise_band_hz;
        if !asked.drive.dither {
            // The seed has no effect then.
            same.drive.seed = built_in.drive.seed;
        }
    }
    let asked = &same;
    let (mut values, mut config) = (defaults, built_in.clone());
    if let Some(place) = PARAMETERS.iter().position(|parameter| parameter.key == RESTRAINT_ENABLED) {
        // A ceiling depends on it.
        values[place] = (PARAMETERS[place].read)(asked);
    }
    let (mut overrides, mut misfits, mut lower) = (Overrides::new(), Vec::new(), String::new());
    for (place, parameter) in PARAMETERS.iter().enumerate() {
        let (value, ceiling) = ((parameter.read)(asked), ceiling(place, &values, &defaults));
        let checked = parameter.check(value, ceiling);
        // Scenes have no host timeout. A zero that cannot be set is an amplitude of the other kind,
        // which follows from it.
        if value == defaults[place] && checked.is_ok()
            || value == 0.0 && checked.is_err()
            || parameter.name == Link::PATIENCE_S.name
        {
            continue;
        }
        values[place] = value;
        // A value that cannot be set is named here, and not among the differences below.
        (parameter.write)(&mut config, value);
        if checked.is_ok() {
            let _ = overrides.push((parameter.key, value));
            continue;
        }
        misfits.push(format!("  {}: {value}, but the image accepts {}", parameter.name, range(parameter.range, ceiling)));
        if parameter.is_limit() {
            lower += &format!(" --set controller.{}={ceiling}", parameter.name);
        }
    }
    let json = |config: &Config| serde_json::to_value(config).unwrap_or_default();
    differences("", &json(asked), &json(&config), &mut misfits);
    match (misfits.is_empty(), lower.is_empty()) {
        (true, _) => Ok(Stored { overrides, config }),
        (false, true) => Err(Misfit(misfits)),
        (false, false) => Err(Misfit(misfits.into_iter().chain([format!("lower the limits with{lower}")]).collect())),
    }
}

fn range(range: Range, ceiling: f32) -> String {
    match (range, range.of(ceiling)) {
        (Range::Choice(names), _) => format!("one of {}", names.join(", ")),
        (Range::UpToCeiling(..), (least, most)) => format!("{least} to {most}; a limit can only be lowered"),
        (_, (least, most)) => format!("{least} to {most}"),
    }
}

/// Names the differences of two configurations, by the paths of their fields. Numbers are compared
/// in single precision, the precision of parameters.
fn differences(path: &str, asked: &Value, image: &Value, found: &mut Vec<String>) {
    match (asked, image) {
        (Value::Object(asked), Value::Object(image)) if asked.keys().eq(image.keys()) => {
            for (key, value) in asked {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                differences(&path, value, &image[key], found);
            }
        }
        (Value::Array(asked), Value::Array(image)) if asked.len() == image.len() => {
            asked.iter().zip(image).for_each(|(asked, image)| differences(path, asked, image, found));
        }
        (Value::Number(asked), Value::Number(image)) if single(asked) == single(image) => (),
        _ if asked != image => {
            found.push(format!("  {path}: {asked}, but the image has {image}, which cannot be set over the link"))
        }
        _ => (),
    }
}

fn single(number: &serde_json::Number) -> Option<f32> {
    number.as_f64().map(|number| number as f32)
}

/// Stores settings in a flash; `flash` is the whole memory at [`pages::FLASH`].
pub fn store(overrides: Overrides, flash: &mut [u8]) -> Result<(), Misfit> {
    let unstored = || Misfit(vec!["  the settings do not fit into their pages".to_owned()]);
    let from = (pages::SETTINGS.start - pages::FLASH) as usize;
    let pages = flash.get_mut(from..from + pages::SETTINGS.size as usize).ok_or_else(unstored)?;
    let mut settings = Settings::new(Bytes(pages)).map_err(|_| unstored())?;
    settings.store(&Record { parameters: overrides, ..Record::default() }).map_err(|_| unstored())
}

/// Pages of the settings as a flash that never fails.
struct Bytes<'a>(&'a mut [u8]);

/// Access outside the pages, or misaligned.
#[derive(Debug)]
struct Outside(NorFlashErrorKind);

impl NorFlashError for Outside {
    fn kind(&self) -> NorFlashErrorKind {
        self.0
    }
}

impl ErrorType for Bytes<'_> {
    type Error = Outside;
}

impl ReadNorFlash for Bytes<'_> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Outside> {
        check_read(self, offset, bytes.len()).map_err(Outside)?;
        bytes.copy_from_slice(&self.0[offset as usize..][..bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.0.len()
    }
}

impl NorFlash for Bytes<'_> {
    const WRITE_SIZE: usize = pages::WORD as usize;
    const ERASE_SIZE: usize = pages::PAGE as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Outside> {
        check_erase(self, from, to).map_err(Outside)?;
        self.0[from as usize..to as usize].fill(0xff);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Outside> {
        check_write(self, offset, bytes.len()).map_err(Outside)?;
        self.0[offset as usize..][..bytes.len()].copy_from_slice(bytes);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use firmware::board::stored_state::StoredState;

    use super::*;

    #[test]
    fn the_built_in_configuration_needs_no_settings() {
        let built_in = nucleo_g474re::config::config();
        assert_eq!(overrides(&built_in, &built_in).unwrap().overrides, Overrides::new());
    }

    #[test]
    fn the_dummy_loads_scene_fits_the_image() {
        let loaded = load("dummy-load", &[]).unwrap();
        let asked = scene::settings::config(&loaded.scene.driven().unwrap());
        let stored = overrides(&asked, &nucleo_g474re::config::config()).unwrap().overrides;
        // The scale factors of the two sense channels, which differ slightly, and the nominal
        // values of its load.
        assert!(stored.len() < 6, "{stored:?}");
    }

    #[test]
    fn the_board_reads_the_stored_settings() {
        let built_in = nucleo_g474re::config::config();
        let mut asked = built_in.clone();
        asked.drive.frequency_hz = 28e3;
        asked.limits.current_a = 1.5;
        let stored = overrides(&asked, &built_in).unwrap().overrides;
        assert_eq!(stored.len(), 2);
        let mut flash = vec![0xff; 0x8_0000];
        store(stored.clone(), &mut flash).unwrap();
        let from = (pages::SETTINGS.start - pages::FLASH) as usize;
        let (record, state) = Settings::new(Bytes(&mut flash[from..])).unwrap().record();
        assert_eq!((record.parameters, state), (stored, StoredState::Stored));
        let marker = (pages::START - pages::WORD - pages::FLASH) as usize;
        assert!(flash[..marker].iter().all(|&byte| byte == 0xff), "only the marker and the settings are written");
    }

    #[test]
    fn unsupported_settings_are_named() {
        let built_in = nucleo_g474re::config::config();
        let mut asked = built_in.clone();
        asked.front_end.drive_max_code = 1023;
        asked.limits.current_a = 30.0;
        asked.block_samples = 50;
        asked.phasing.gain_trim.push(0.9).unwrap();
        let Misfit(misfits) = overrides(&asked, &built_in).unwrap_err();
        let named = |name: &str| misfits.iter().filter(|line| line.trim_start().starts_with(name)).count();
        assert_eq!(
            ["front_end.drive_max_code", "limits.current_a", "block_samples", "phasing.gain_trim"].map(named),
            [1; 4],
            "{misfits:#?}"
        );
        assert_eq!(misfits.last().unwrap(), "lower the limits with --set controller.limits.current_a=3");
        assert_eq!(misfits.len(), 5, "{misfits:#?}");
    }
}
