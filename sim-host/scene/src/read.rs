//! Reading of a scene: text to typed keys, or to a report of all mistakes.

pub mod builtin;
pub mod diagnostic;
pub mod distribution;
pub mod exclusive;
pub mod load;
pub mod nearest;
pub mod overlay;
pub mod profile;
pub mod rules;
pub mod schema;
pub mod suite;
pub mod tree;
pub mod unknown;
pub mod walk;
pub mod wording;
