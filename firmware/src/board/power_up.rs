//! Power-up: the built-in configuration, overridden by the stored settings.
//!
//! | stored | active |
//! |---|---|
//! | trims and parameters that can be used | they |
//! | an unknown parameter, or one out of its range | its default; of a limit the nearest value that it can have: [`StoredState::Partly`] |
//! | settings that together do not build | the limits, and within them whatever else of it still builds: [`StoredState::Refused`] |
//! | one copy of two, the other one being older or damaged | it: [`StoredState::OneCopy`]; the next store writes both |
//! | nothing | all that is built in |
//! | something that cannot be read, or of another version | all that is built in, and nothing is driven: a lower limit may be in it |
//!
//! **A limit that is stored is never exceeded, whatever else is stored.** Limits come first, the drive is held within them, and everything else is
//! added to that one by one, in the order in which limits depend on it: scale factors, lane trims, the rest. What does not build with the others
//! is left out alone. A limit is left out only where nothing is there to judge it by (an energy for each metre of belt without an encoder): that is
//! refused when it is set, and where it is stored all the same, nothing is driven.

use embedded_storage::nor_flash::NorFlash;

use crate::board::block_task::BlockTask;
use crate::board::parameters::{PARAMETERS, Values, apply, overridden, values_of};
use crate::board::queues::BlockEnds;
use crate::board::settings::Settings;
use crate::board::stored_state::StoredState;
use crate::controller::Controller;
use crate::generate::amplitude::most_volts;
use crate::seam::block::Amplitude;
use crate::seam::config::Range;
use crate::seam::config::{Config, LaneTrims};
use crate::seam::error::Error;

/// The place of the lane trims, behind the parameters.
const TRIMS: usize = PARAMETERS.len();

/// What a board is started with.
#[derive(Clone, Debug)]
pub struct PowerUp {
    /// What the controller is to be built with.
    pub config: Config,
    /// Parameters that are built in, and those that are set.
    pub(crate) built_in: Values,
    pub(crate) next: Values,
    pub(crate) stored: StoredState,
}

impl PowerUp {
    /// Reads the stored settings, and puts them in place of the built-in ones.
    pub fn read<F: NorFlash>(built_in: &Config, settings: &mut Settings<F>) -> Self {
        let (record, stored) = settings.record();
        let mut config = built_in.clone();
        let built_in = values_of(&config);
        let (next, all) = overridden(&record.parameters, &built_in);
        apply(&mut config, &next, &built_in, |_| true);
        if !record.trims.is_empty() {
            config.phasing.calibration = record.trims;
        }
        PowerUp { config, built_in, next, stored: if all { stored } else { StoredState::Partly } }
    }

    /// Builds the controller at its final place, and its task; where the stored settings do not make one, of as much of them as does, within the
    /// limits that are set.
    pub fn build<'a>(&mut self, built_in: &Config, ends: BlockEnds<'a>) -> Result<BlockTask<'a>, Error> {
        if Controller::check(&self.config).is_err() {
            self.fall_back(built_in);
            self.stored = StoredState::Refused;
        }
        BlockTask::build(&self.config, ends)
    }

    /// Whether a limit may be stored that does not act.
    pub(crate) fn limits_are_unsure(&self) -> bool {
        let acts = values_of(&self.config);
        let is_above = |place: usize| PARAMETERS[place].is_limit() && acts[place] > self.next[place];
        self.stored.hides_limits() || (0..PARAMETERS.len()).any(is_above)
    }

    /// Limits first, and then whatever still builds with them and with what came before it.
    #[inline(never)]
    fn fall_back(&mut self, built_in: &Config) {
        let trims = core::mem::take(&mut self.config.phasing.calibration);
        let mut acting = 0_u128;
        loop {
            let before = acting;
            for rank in 0..RANKS {
                for place in (0..=TRIMS).filter(|&place| rank_of(place) == rank) {
                    self.compose(built_in, acting | 1 << place, &trims);
                    if Controller::check(&self.config).is_ok() {
                        acting |= 1 << place;
                    }
                }
            }
            // What came later may have made room for what did not fit.
            if acting == before {
                break;
            }
        }
        self.compose(built_in, acting, &trims);
    }

    /// What is built in, with what is set of the places in `acting`, and a drive within the limits.
    fn compose(&mut self, built_in: &Config, acting: u128, trims: &LaneTrims) {
        let config = &mut self.config;
        config.clone_from(built_in);
        apply(config, &self.next, &self.built_in, |place| acting & 1 << place != 0);
        if acting & 1 << TRIMS != 0 {
            config.phasing.calibration.clone_from(trims);
        }
        // Without a scale there is no largest amplitude, and no controller either.
        let most_volts = most_volts(config).unwrap_or(0.0);
        let Config { drive, limits, .. } = config;
        drive.scan_volts = drive.scan_volts.min(most_volts);
        drive.amplitude = match drive.amplitude {
            Amplitude::Volts(volts) => Amplitude::Volts(volts.min(most_volts)),
            Amplitude::MotionalCurrent(amperes) => Amplitude::MotionalCurrent(amperes.min(limits.current_a)),
        };
    }
}

/// How many ranks there are.
const RANKS: u8 = 4;

/// When it is the turn of a parameter, or of the trims: limits, what limits are measured by, trims, and all others.
fn rank_of(place: usize) -> u8 {
    match PARAMETERS.get(place).map(|parameter| parameter.range) {
        Some(Range::UpToCeiling(..)) => 0,
        Some(Range::Scale(..)) => 1,
        None => 2,
        Some(Range::Within(..) | Range::Choice(_) | Range::Whole(..)) => 3,
    }
}
