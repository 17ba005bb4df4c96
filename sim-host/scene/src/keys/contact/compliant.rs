//! `[contact.compliant]`: constant stiffness along and across the surface.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use contact::compliant::Press;

/// A contact with constant normal stiffness kz and tangential stiffness kx, `N = kz u`, `df/dt = kx Vt` up to mu N, under a given vibration across the
/// surface (`rig.kinematic`), until contact is lost in every period if the vibration is large. Where it sticks, friction stays below mu N.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Compliant {
    /// Coefficient of friction of the contact.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub mu: f64,
    /// Normal force without vibration, N; under vibration the mean one, if that is what is held.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-9, max = 1e6))]
    pub normal_n: Option<f64>,
    /// Normal contact stiffness kz, N/m.
    #[schemars(range(min = 1.0, max = 1e12))]
    pub normal_stiffness_n_per_m: f64,
    /// Tangential contact stiffness kx, N/m.
    #[schemars(range(min = 1.0, max = 1e12))]
    pub stiffness_n_per_m: f64,
    /// What the vibration leaves as it is: the mean normal force, or the mean indentation. They differ once contact is lost.
    #[serde(default)]
    pub held: Held,
}

/// What is held while the bodies vibrate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Held {
    /// The mean normal force is `normal_n`.
    #[default]
    Load,
    /// The mean indentation is `normal_n` over kz.
    Indentation,
}

impl Compliant {
    /// What presses on the contact.
    pub fn press(&self, normal_n: f64) -> Press {
        match self.held {
            Held::Load => Press::Load(normal_n),
            Held::Indentation => Press::Indentation(normal_n / self.normal_stiffness_n_per_m),
        }
    }
}
