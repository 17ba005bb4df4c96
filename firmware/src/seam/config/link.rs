//! Settings of the link to the host.

use config_macro::settings;
use serde::{Deserialize, Serialize};

/// Link to the host. If the host disappears, the drive is silenced; a drive without a timeout must
/// be chosen.
#[settings(table = "link")]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Link {
    /// Longest time for which the host may be silent while the drive is on, s; zero is unlimited.
    /// An order may change it.
    #[setting(default = 1.0, min = 0.0, max = 3600.0, key = 21)]
    pub patience_s: f32,
}
