//! What the flash has of the settings, and what has become of it.

use serde::{Deserialize, Serialize};

/// What is kept, and what has become of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kept {
    /// Nothing.
    #[default]
    Nothing,
    /// What acted when it was stored, or came from there at power-up.
    Stored,
    /// Something that cannot be read, or cannot be trims.
    Damaged,
    /// Something of this other version. It stays until an order to store or to clear.
    Version(u8),
    /// What acts is to be kept, as soon as the drive is silent.
    Due,
    /// The flash does not take it.
    Failed,
    /// Parameters, of which some do not act: nobody knows them here, or they are out of their ranges.
    Partly,
    /// Settings that together do not make a configuration: the limits act, and of the rest what builds with them.
    Refused,
    /// Not what is set: a parameter was set since, and is lost with a reset unless it is stored.
    Changed,
}
