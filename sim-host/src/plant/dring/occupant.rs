//! How heavy a torso is.

use crate::scene::Occupant;

/// Torso mass of an occupant, kg, as assumed for the three sizes of adult dummies (5th percentile woman, 50th and 95th percentile man).
pub fn torso_kg(occupant: Occupant) -> f64 {
    match occupant {
        Occupant::Light => 14.0,
        Occupant::Medium => 22.0,
        Occupant::Heavy => 29.0,
    }
}
