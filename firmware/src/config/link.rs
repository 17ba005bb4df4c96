//! What a user sets of the link.

use serde::{Deserialize, Serialize};

/// The longest patience that can be told, s.
pub const LONGEST_PATIENCE_S: f32 = 3600.0;

/// The link to the host.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Link {
    /// How long the host may be silent while the drive is on, s, up to [`LONGEST_PATIENCE_S`]; zero is for ever. Until an order says otherwise.
    pub patience_s: f32,
}
