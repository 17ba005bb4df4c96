//! A scene's configuration as the stored settings of the image.
//!
//! The image has a configuration of its own, and a host may set those of its numbers that are parameters. What a scene asks for beyond that is
//! refused by name: the image would do something else than the scene says.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};
use firmware::board::parameters::{Overrides, PARAMETERS};
use firmware::board::settings::{Record, Settings};
use firmware::seam::config::{Config, Range};
use nucleo_g474re::pages;
use scene::Driven;
use serde_json::Value;

/// Why an image cannot be configured as a scene asks.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("the image cannot be configured as this scene asks:\n{}", .0.join("\n"))]
pub struct Misfit(pub Vec<String>);

/// What has to be stored so that the image does what a scene asks.
pub fn stored(scene: &Driven) -> Result<Overrides, Misfit> {
    overrides(&scene::settings::config(scene), &nucleo_g474re::config::config())
}

/// What has to be stored so that an image with the configuration `built_in` has the configuration `asked`.
pub fn overrides(asked: &Config, built_in: &Config) -> Result<Overrides, Misfit> {
    let (mut configured, mut overrides, mut misfits) = (built_in.clone(), Overrides::new(), Vec::new());
    for parameter in &PARAMETERS {
        let (value, default) = ((parameter.read)(asked), (parameter.read)(built_in));
        if value == default || value.is_nan() && default.is_nan() {
            continue;
        }
        // What cannot be set is reported once: here, and not among the differences below.
        (parameter.write)(&mut configured, value);
        match parameter.check(value, default) {
            Ok(()) => drop(overrides.push((parameter.key, value))),
            Err(_) => misfits.push(format!(
                "  {}: {value}, and the image can be set {}",
                parameter.name,
                range(parameter.range, default)
            )),
        }
    }
    // The host timeout is the link's, and no scene says it.
    configured.link = asked.link;
    let json = |config: &Config| serde_json::to_value(config).unwrap_or_default();
    differences("", &json(asked), &json(&configured), &mut misfits);
    if misfits.is_empty() { Ok(overrides) } else { Err(Misfit(misfits)) }
}

fn range(range: Range, built_in: f32) -> String {
    let (least, most) = range.of(built_in);
    let why = match range {
        Range::Within(..) => "",
        Range::UpToBuiltIn(..) => ", as a limit can only be lowered",
        Range::NearBuiltIn => ", within a tenth of its front end",
    };
    format!("from {least} to {most}{why}")
}

/// Names what differs in two configurations, by the paths of its fields.
fn differences(path: &str, asked: &Value, image: &Value, found: &mut Vec<String>) {
    match (asked, image) {
        (Value::Object(asked), Value::Object(image)) if asked.keys().eq(image.keys()) => {
            for (key, value) in asked {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                differences(&path, value, &image[key], found);
            }
        }
        _ if asked != image => {
            found.push(format!("  {path}: {asked}, and the image has {image}, which cannot be set over the link"))
        }
        _ => (),
    }
}

/// Stores settings in the flash of a part: `flash` is all of it, as it lies at [`pages::FLASH`].
pub fn store(overrides: Overrides, flash: &mut [u8]) -> Result<(), Misfit> {
    let unstored = || Misfit(vec!["  the settings do not fit into their pages".to_owned()]);
    let from = (pages::START - pages::FLASH) as usize;
    let pages = flash.get_mut(from..from + pages::SIZE as usize).ok_or_else(unstored)?;
    let mut settings = Settings::new(Bytes(pages)).map_err(|_| unstored())?;
    settings.store(&Record { parameters: overrides, ..Record::default() }).map_err(|_| unstored())
}

/// The settings' pages as a flash that never fails.
struct Bytes<'a>(&'a mut [u8]);

/// Beyond the end, or off the grid.
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
    fn the_images_own_configuration_needs_nothing_stored() {
        let built_in = nucleo_g474re::config::config();
        assert_eq!(overrides(&built_in, &built_in), Ok(Overrides::new()));
    }

    #[test]
    fn the_dummy_loads_scene_fits_the_image() {
        let loaded = scene::load::load("dummy-load", &[]).unwrap();
        let asked = scene::settings::config(&loaded.scene.driven().unwrap());
        let stored = overrides(&asked, &nucleo_g474re::config::config()).unwrap();
        // The scale factors of the two sense channels, a hair beside the board's, and the nominal values of its load.
        assert!(stored.len() < 6, "{stored:?}");
    }

    #[test]
    fn what_is_stored_is_what_the_board_reads() {
        let built_in = nucleo_g474re::config::config();
        let mut asked = built_in.clone();
        asked.drive.frequency_hz = 28e3;
        asked.limits.current_a = 1.5;
        let stored = overrides(&asked, &built_in).unwrap();
        assert_eq!(stored.len(), 2);
        let mut flash = vec![0xff; 0x8_0000];
        store(stored.clone(), &mut flash).unwrap();
        let from = (pages::START - pages::FLASH) as usize;
        let (record, state) = Settings::new(Bytes(&mut flash[from..])).unwrap().record();
        assert_eq!((record.parameters, state), (stored, StoredState::Stored));
        assert!(flash[..from].iter().all(|&byte| byte == 0xff), "nothing else is written");
    }

    #[test]
    fn what_the_image_cannot_do_is_named() {
        let built_in = nucleo_g474re::config::config();
        let mut asked = built_in.clone();
        asked.front_end.drive_volt_per_lsb *= 1.3;
        asked.limits.current_a = 30.0;
        asked.lanes = 2;
        asked.phasing.direction = firmware::seam::config::Direction::Reverse;
        let Misfit(misfits) = overrides(&asked, &built_in).unwrap_err();
        let named = |name: &str| misfits.iter().filter(|line| line.trim_start().starts_with(name)).count();
        assert_eq!(
            ["front_end.drive_volt_per_lsb", "limits.current_a", "lanes", "phasing.direction"].map(named),
            [1; 4],
            "{misfits:#?}"
        );
        assert_eq!(misfits.len(), 4, "{misfits:#?}");
    }
}
