//! Speed against error: every method on one standard case, what is claimed of them, and the cases that are hard.
//!
//! ```text
//! case --> reference (Taylor 28/32, held against an independent method)
//!   |          |
//!   +--> work: errors of every method at every step count, times round by round, instructions
//!                  |
//!                  +--> claims (ratios at equal error)      hard: cases with their invariants
//! ```

pub mod claims;
pub mod folder;
pub mod hard;
pub mod instructions;
pub mod interpolate;
pub mod method;
pub mod plots;
pub mod reference;
pub mod sample;
pub mod single;
pub mod study;
pub mod table;
pub mod work;
