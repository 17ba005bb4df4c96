//! What a user sets of the friction switch.

use serde::{Deserialize, Serialize};

use crate::block::Target;

/// The friction switch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Friction {
    /// What is wanted until an order says otherwise.
    pub target: Target,
    /// The law that is inverted.
    pub law: FrictionLaw,
    /// Bursts wherever their duty allows it, not only near the velocity threshold. Only with a periodic burst schedule, whose duty the switch sets.
    pub prefer_bursts: bool,
    /// Amperes of motional current per m/s of tip velocity, as told: the force factor, N/V.
    pub force_factor_n_per_v: f32,
    /// Sliding speed where no sensor tells it, m/s.
    pub speed_m_per_s: f32,
    /// Dahl length Fc / Kt, m, where no force sensor allows a survey.
    pub dahl_length_m: f32,
    /// For how long the force is averaged at each place of the survey, s.
    pub average_s: f32,
}

/// The law of friction that is inverted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum FrictionLaw {
    /// Dahl's, with the contact's own stiffness.
    #[default]
    Dahl,
    /// Coulomb's, which knows no stiffness: the reference. By it a soft contact has up to 0.39 more than is wanted.
    Coulomb,
}
