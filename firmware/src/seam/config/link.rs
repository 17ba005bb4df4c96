//! What a user sets of the link.

use config_macro::settings;
use serde::{Deserialize, Serialize};

/// The link to the host. A host that vanishes silences the drive: that it goes on for ever has to be chosen.
#[settings(table = "link")]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Link {
    /// How long the host may be silent while the drive is on, s; zero is for ever. Until an order says otherwise.
    #[setting(default = 1.0, min = 0.0, max = 3600.0, key = 21)]
    pub patience_s: f32,
}
