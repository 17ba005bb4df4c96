//! `[contact.compliant]`: constant stiffness along and across the surface.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use contact::compliant::Press;

/// A contact with constant normal stiffness kz and tangential stiffness kx: `N = kz u`, and
/// `df/dt = kx Vt` up to mu N. The vibration across the surface is prescribed (`rig.kinematic`); a
/// large one interrupts contact in every period. While the contact sticks, friction is below mu N.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Compliant {
    /// Coefficient of friction of the contact.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub mu: f64,
    /// Normal force without vibration, N; under vibration, its mean if `held` is `load`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-9, max = 1e6))]
    pub normal_n: Option<f64>,
    /// Normal contact stiffness kz, N/m.
    #[schemars(range(min = 1.0, max = 1e12))]
    pub normal_stiffness_n_per_m: f64,
    /// Tangential contact stiffness kx, N/m.
    #[schemars(range(min = 1.0, max = 1e12))]
    pub stiffness_n_per_m: f64,
    /// Quantity that vibration does not change, mean normal force or mean indentation; they differ
    /// once contact is lost.
    #[serde(default)]
    pub held: Held,
}

/// Quantity that is kept constant while the bodies vibrate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Held {
    /// The mean normal force is `normal_n`.
    #[default]
    Load,
    /// The mean indentation is `normal_n` divided by kz.
    Indentation,
}

impl Compliant {
    /// Returns the constraint across the surface: load or indentation.
    pub fn press(&self, normal_n: f64) -> Press {
        match self.held {
            Held::Load => Press::Load(normal_n),
            Held::Indentation => Press::Indentation(normal_n / self.normal_stiffness_n_per_m),
        }
    }
}
