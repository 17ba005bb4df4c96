//! Power-up: the configuration that is built in, with what the settings have of it.
//!
//! | what is kept | what acts |
//! |---|---|
//! | trims and parameters that can be used | they |
//! | a parameter that nobody knows, or out of its range | what is built in, in its place: [`Kept::Partly`] |
//! | parameters that together do not build | what is built in, within the limits that are set, and the trims: [`Kept::Refused`] |
//! | nothing, or something that cannot be read | all that is built in |

use embedded_storage::nor_flash::NorFlash;

use crate::block::Amplitude;
use crate::block_task::BlockTask;
use crate::config::Config;
use crate::controller::Controller;
use crate::error::Error;
use crate::kept::Kept;
use crate::parameters::{Values, apply, apply_limits, overridden, values_of};
use crate::queues::HotEnds;
use crate::settings::Settings;

/// What a board is started with.
#[derive(Clone, Debug)]
pub struct PowerUp {
    /// What the controller is to be built with.
    pub config: Config,
    /// Parameters that are built in, and those that are set.
    pub(crate) built_in: Values,
    pub(crate) next: Values,
    pub(crate) kept: Kept,
}

impl PowerUp {
    /// Reads what is kept, and puts it in place of what is built in.
    pub fn read<F: NorFlash>(built_in: &Config, settings: &mut Settings<F>) -> Self {
        let (record, kept) = settings.record();
        let mut config = built_in.clone();
        let built_in = values_of(&config);
        let (next, all) = overridden(&record.parameters, &built_in);
        apply(&mut config, &next, &built_in);
        if kept == Kept::Stored && !record.trims.is_empty() {
            config.phasing.calibration = record.trims;
        }
        PowerUp { config, built_in, next, kept: if all { kept } else { Kept::Partly } }
    }

    /// Builds the controller where it is to stay, and the task of it; where what is kept does not make one, of what is built in, within the limits
    /// that are set.
    pub fn build<'a>(&mut self, built_in: &Config, ends: HotEnds<'a>) -> Result<BlockTask<'a>, Error> {
        if Controller::check(&self.config).is_err() {
            self.fall_back(built_in);
            self.kept = Kept::Refused;
        }
        BlockTask::build(&self.config, ends)
    }

    /// What is built in, with the trims and the limits that are set, and a drive within these: whoever has lowered a limit keeps it.
    #[inline(never)]
    fn fall_back(&mut self, built_in: &Config) {
        let trims = core::mem::take(&mut self.config.phasing.calibration);
        self.config.clone_from(built_in);
        self.config.phasing.calibration = trims;
        apply_limits(&mut self.config, &self.next);
        let Config { drive, limits, .. } = &mut self.config;
        drive.scan_volts = drive.scan_volts.min(limits.voltage_v);
        drive.amplitude = match drive.amplitude {
            Amplitude::Volts(volts) => Amplitude::Volts(volts.min(limits.voltage_v)),
            Amplitude::MotionalCurrent(amperes) => Amplitude::MotionalCurrent(amperes.min(limits.current_a)),
        };
        if Controller::check(&self.config).is_err() {
            self.config.clone_from(built_in);
        }
    }
}
