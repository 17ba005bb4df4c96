//! Power-up: the built-in configuration, overridden by the stored settings.
//!
//! | stored | active |
//! |---|---|
//! | usable trims and parameters | these |
//! | an unknown parameter, or one out of its range | its default; for a limit the nearest valid value: [`StoredState::Partly`] |
//! | settings that do not build together | the limits, and all other settings that still build within them: [`StoredState::Refused`] |
//! | two copies, of which one is older or damaged | the other one: [`StoredState::OneCopy`]; the next store writes both |
//! | nothing | the built-in configuration |
//! | unreadable or erased settings, or settings of another version | the built-in configuration; the board does not drive, because a lower limit may be stored |
//!
//! **A stored limit is never exceeded by any other stored value.** Limits are applied first, and
//! the drive is held within them. The other settings are then added one by one, in the order in
//! which limits depend on them: scale factors, lane trims, the rest. A setting that does not build
//! with the others is left out alone. A limit is left out only if the board cannot check it (an
//! energy per metre of belt without an encoder). Such a limit is refused when it is set; if it is
//! stored nevertheless, the board does not drive.

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

/// Place of the lane trims, after the parameters.
const TRIMS_PLACE: usize = PARAMETERS.len();

/// Configuration and settings that a board is started with.
#[derive(Clone, Debug)]
pub struct PowerUp {
    /// Configuration of the controller.
    pub config: Config,
    /// Built-in values of the parameters.
    pub(crate) built_in: Values,
    /// Set values of the parameters.
    pub(crate) next: Values,
    pub(crate) stored: StoredState,
}

impl PowerUp {
    /// Reads the stored settings, and replaces the built-in ones with them.
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

    /// Builds the controller at its final place, and its task. If the stored settings do not build,
    /// uses as many of them as build within the set limits.
    pub fn build<'a>(&mut self, built_in: &Config, ends: BlockEnds<'a>) -> Result<BlockTask<'a>, Error> {
        if Controller::check(&self.config).is_err() {
            self.fall_back(built_in);
            self.stored = StoredState::Refused;
        }
        BlockTask::build(&self.config, ends)
    }

    /// Returns `true` if a stored limit may not act.
    pub(crate) fn limits_are_unsure(&self) -> bool {
        let acts = values_of(&self.config);
        let is_above = |place: usize| PARAMETERS[place].is_limit() && acts[place] > self.next[place];
        self.stored.hides_limits() || (0..PARAMETERS.len()).any(is_above)
    }

    /// Applies the limits first, and then each setting that still builds with those before it.
    #[inline(never)]
    fn fall_back(&mut self, built_in: &Config) {
        let trims = core::mem::take(&mut self.config.phasing.calibration);
        let mut acting = 0_u128;
        loop {
            let before = acting;
            for rank in 0..RANKS {
                for place in (0..=TRIMS_PLACE).filter(|&place| rank_of(place) == rank) {
                    self.compose(built_in, acting | 1 << place, &trims);
                    if Controller::check(&self.config).is_ok() {
                        acting |= 1 << place;
                    }
                }
            }
            // A later setting may have made room for one that did not fit before.
            if acting == before {
                break;
            }
        }
        self.compose(built_in, acting, &trims);
    }

    /// Composes the built-in configuration, the set values at the places in `acting`, and a drive
    /// within the limits.
    fn compose(&mut self, built_in: &Config, acting: u128, trims: &LaneTrims) {
        let config = &mut self.config;
        config.clone_from(built_in);
        apply(config, &self.next, &self.built_in, |place| acting & 1 << place != 0);
        if acting & 1 << TRIMS_PLACE != 0 {
            config.phasing.calibration.clone_from(trims);
        }
        // Without a scale there is neither a largest amplitude nor a controller.
        let most_volts = most_volts(config).unwrap_or(0.0);
        let Config { drive, limits, .. } = config;
        drive.scan_volts = drive.scan_volts.min(most_volts);
        drive.amplitude = match drive.amplitude {
            Amplitude::Volts(volts) => Amplitude::Volts(volts.min(most_volts)),
            Amplitude::MotionalCurrent(amperes) => Amplitude::MotionalCurrent(amperes.min(limits.current_a)),
        };
    }
}

/// Number of ranks.
const RANKS: u8 = 4;

/// Returns the rank of a parameter or of the trims: limits, scale factors, trims, all others.
fn rank_of(place: usize) -> u8 {
    match PARAMETERS.get(place).map(|parameter| parameter.range) {
        Some(Range::UpToCeiling(..)) => 0,
        Some(Range::Scale(..)) => 1,
        None => 2,
        Some(Range::Within(..) | Range::Choice(_) | Range::Whole(..)) => 3,
    }
}
