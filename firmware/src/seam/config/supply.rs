//! Supply of the amplifier, if the board measures it.

use config_macro::settings;
use serde::{Deserialize, Serialize};

use crate::seam::config::keys::SUPPLY_DIVIDER;
use crate::seam::error::Error;

/// Supply of the amplifier, measured through a divider at an input of the board. Outside of its
/// window nothing is driven, and a drive ends with fault 14: too low a supply clips the drive, too
/// high a supply destroys the amplifier.
#[settings(table = "supply")]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Supply {
    /// Ratio of the supply voltage to the voltage at the input. Absent: the supply is not measured.
    #[setting(min = 0.1, max = 1e3, key = SUPPLY_DIVIDER)]
    pub divider: Option<f32>,
    /// Lowest supply voltage for a drive, V.
    #[setting(default = 0.0, min = 0.0, max = 1e4, key = 94)]
    pub min_v: f32,
    /// Highest supply voltage for a drive, V.
    #[setting(default = 1e4, min = 0.0, max = 1e4, key = 95)]
    pub max_v: f32,
}

impl Supply {
    /// Checks that the window is not empty.
    pub(super) fn check_window(&self) -> Result<(), Error> {
        Self::MIN_V.check_within(self.min_v.into(), 0.0, self.max_v.into()).map(drop)
    }
}
