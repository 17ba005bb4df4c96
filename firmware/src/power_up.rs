//! Power-up: the configuration that is built in, with what the settings have of it.
//!
//! | what is kept | what acts |
//! |---|---|
//! | trims and parameters that can be used | they |
//! | a parameter that nobody knows, or out of its range | what is built in, in its place: [`Kept::Partly`] |
//! | parameters or trims that together do not build | all that is built in: [`Kept::Refused`] |
//! | nothing, or something that cannot be read | all that is built in |

use embedded_storage::nor_flash::NorFlash;

use crate::block_task::BlockTask;
use crate::config::Config;
use crate::controller::Controller;
use crate::error::Error;
use crate::parameters::{Values, apply, overridden, values_of};
use crate::queues::HotEnds;
use crate::settings::{Kept, Settings};

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

    /// Builds the controller where it is to stay, and the task of it; where what is kept does not make one, of what is built in alone.
    pub fn build<'a>(&mut self, built_in: &Config, ends: HotEnds<'a>) -> Result<BlockTask<'a>, Error> {
        if Controller::check(&self.config).is_err() {
            self.config = built_in.clone();
            self.kept = Kept::Refused;
        }
        BlockTask::build(&self.config, ends)
    }
}
