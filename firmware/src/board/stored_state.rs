//! State of the settings in flash.

use serde::{Deserialize, Serialize};

/// State of the stored settings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum StoredState {
    /// Nothing is stored.
    #[default]
    Nothing,
    /// The stored settings are the active ones, or will be after a reset.
    Stored,
    /// Neither copy of the stored settings can be read, both were erased, or their trims are
    /// invalid. The stored limits are unknown, and the board does not drive.
    Damaged,
    /// The stored settings are of this other version. They stay until an order to store or to
    /// clear, and the board does not drive before that.
    Version(u8),
    /// The active trims will be stored as soon as the drive is silent.
    Due,
    /// The flash has failed to store the settings.
    Failed,
    /// Some stored parameters are not active: they are unknown here, or out of their ranges.
    Partly,
    /// The stored settings do not build together. The limits are active, with those of the other
    /// settings that are valid with them.
    Refused,
    /// A parameter was set after the settings were stored, and is lost with a reset unless it is
    /// stored.
    Changed,
    /// One of the two copies of the stored settings was older, or could not be read, when the board
    /// started. The other one is active.
    OneCopy,
    /// The first store was cut off: nothing is stored.
    Unfinished,
}

impl StoredState {
    /// Returns `true` if unknown limits may be stored.
    pub fn hides_limits(self) -> bool {
        matches!(self, StoredState::Damaged | StoredState::Version(_))
    }
}
