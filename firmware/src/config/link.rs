//! What a user sets of the link.

use serde::{Deserialize, Serialize};

/// The longest patience that can be told, s.
pub const LONGEST_PATIENCE_S: f32 = 3600.0;

/// The host timeout of a configuration that gives none, s.
pub const DEFAULT_PATIENCE_S: f32 = 1.0;

/// The link to the host.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Link {
    /// How long the host may be silent while the drive is on, s, up to [`LONGEST_PATIENCE_S`]; zero is for ever. Until an order says otherwise.
    pub patience_s: f32,
}

impl Default for Link {
    /// A host that vanishes silences the drive after [`DEFAULT_PATIENCE_S`]: that it goes on for ever has to be chosen.
    fn default() -> Self {
        Link { patience_s: DEFAULT_PATIENCE_S }
    }
}
