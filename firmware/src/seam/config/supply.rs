//! The amplifier's supply, where the board measures it.

use config_macro::settings;
use serde::{Deserialize, Serialize};

use crate::seam::config::keys::SUPPLY_DIVIDER;
use crate::seam::error::Error;

/// The amplifier's supply, through a divider at an input of the board. Nothing is driven, and a drive ends with fault 14, while it is outside of its
/// window: too low it clips what the controller asks for, too high it ends the amplifier.
#[settings(table = "supply")]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Supply {
    /// Volts of the supply for a volt at the input. Absent: the supply is not measured.
    #[setting(min = 0.1, max = 1e3, key = SUPPLY_DIVIDER)]
    pub divider: Option<f32>,
    /// The lowest voltage at which it may drive, V.
    #[setting(default = 0.0, min = 0.0, max = 1e4, key = 94)]
    pub min_v: f32,
    /// The highest voltage at which it may drive, V.
    #[setting(default = 1e4, min = 0.0, max = 1e4, key = 95)]
    pub max_v: f32,
}

impl Supply {
    /// Whether the window has an inside.
    pub(super) fn check_window(&self) -> Result<(), Error> {
        Self::MIN_V.check_within(self.min_v.into(), 0.0, self.max_v.into()).map(drop)
    }
}
