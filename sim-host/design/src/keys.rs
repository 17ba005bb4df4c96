//! Keys of `[design]`: a transducer or horn as a chain of parts.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The mechanical design of a transducer or horn: a chain of one-dimensional parts from the back to
/// the tip. Both ends are free, unless a `mass` or a `ground` is there.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Design {
    /// Wanted frequency, Hz: the working mode is the nearest one that the rings excite. Default:
    /// the lowest mode with at least half of the largest coupling, or without rings the lowest.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 100.0, max = 450e3))]
    pub frequency_hz: Option<f64>,
    /// Modes up to this frequency are listed, Hz.
    #[serde(default = "default::highest_hz")]
    #[schemars(range(min = 200.0, max = 1e6))]
    pub highest_hz: f64,
    /// Operating point: voltage, V peak, at the series resonance. Default: 1 V.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-6, max = 1e5))]
    pub drive_v: Option<f64>,
    /// Operating point: velocity of the tip, m/s peak.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-9, max = 100.0))]
    pub tip_velocity_m_per_s: Option<f64>,
    /// Operating point: displacement of the tip, m peak.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-12, max = 1e-2))]
    pub tip_amplitude_m: Option<f64>,
    /// `true` to include the inertia of the lateral motion by Poisson's ratio (Love's rod). It
    /// lowers the frequency of thick parts.
    #[serde(default)]
    pub lateral_inertia: bool,
    /// Quality factor of all parts, instead of those of the materials. Joints and the mount lose
    /// more than the materials do, so that a measured Q is usually lower than the calculated one.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 5.0, max = 1e6))]
    pub q: Option<f64>,
    /// Thermal resistance from the piezoelectric rings to the surroundings, K/W. Default: their
    /// temperature is not computed.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-6, max = 1e6))]
    pub thermal_resistance_k_per_w: Option<f64>,
    /// The parts, from the back to the tip.
    #[schemars(length(min = 1, max = 64))]
    pub element: Vec<Element>,
    /// The bolt that presses parts together.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bolt: Option<Bolt>,
    /// Materials of your own. They replace built-in ones of the same name.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub material: Vec<Material>,
}

/// A part of the chain.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Element {
    /// Kind of the part.
    pub kind: Kind,
    /// Name of the part in tables, and for the bolt. Default: its kind and number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Material, by its name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Length of a cylinder or horn, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-6, max = 10.0))]
    pub length_m: Option<f64>,
    /// Outer diameter, m: of a horn, at its left end.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-5, max = 1.0))]
    pub diameter_m: Option<f64>,
    /// Diameter of a horn at its right end, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-5, max = 1.0))]
    pub end_diameter_m: Option<f64>,
    /// Diameter of the hole in a cylinder or in rings, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub bore_m: Option<f64>,
    /// Number of rings, electrically in parallel, neighbours polarised in opposite directions.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 1000))]
    pub count: Option<u32>,
    /// Thickness of each ring, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-6, max = 0.1))]
    pub thickness_m: Option<f64>,
    /// Thickness of the electrode on the right of each ring, m. Default: no electrodes.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-7, max = 0.01))]
    pub electrode_m: Option<f64>,
    /// Material of the electrodes. Default: beryllium-copper.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub electrode_material: Option<String>,
    /// Mass at this place, kg.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1e3))]
    pub mass_kg: Option<f64>,
    /// Stiffness of a joint between its neighbours, or of a support to ground, N/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1.0, max = 1e15))]
    pub stiffness_n_per_m: Option<f64>,
    /// Damping of a support to ground, N s/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1e9))]
    pub damping_n_s_per_m: Option<f64>,
}

/// Kind of a part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A cylinder, with a hole or without. Two of them are a stepped horn.
    #[default]
    Cylinder,
    /// A conical horn: the diameter is linear.
    Cone,
    /// An exponential horn.
    Exponential,
    /// A catenoidal horn: a hyperbolic cosine with its vertex at the thin end.
    Catenoidal,
    /// Piezoelectric rings or discs, polarised along the axis.
    Rings,
    /// A massless spring in series: a contact or an adhesive layer.
    Joint,
    /// A mass at one place.
    Mass,
    /// A spring and damper from one place to ground: a contact at the tip, or a mount.
    Ground,
}

/// The bolt that presses parts together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bolt {
    /// Material of the bolt, by its name.
    pub material: String,
    /// Diameter of the bolt's core, m.
    #[schemars(range(min = 1e-5, max = 1.0))]
    pub diameter_m: f64,
    /// Name of the first part that the bolt passes without touching it.
    pub from: String,
    /// Name of the last part that the bolt passes without touching it. Default: the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to: Option<String>,
    /// Preload, N.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1e7))]
    pub preload_n: f64,
}

/// A material. With `d33_m_per_v` and `permittivity` it is piezoelectric.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Name of the material.
    pub name: String,
    /// Young's modulus, Pa; of a piezoelectric material, `1 / s33E`.
    #[schemars(range(min = 1e6, max = 1e13))]
    pub modulus_pa: f64,
    /// Density, kg/m^3.
    #[schemars(range(min = 1.0, max = 1e5))]
    pub density_kg_per_m3: f64,
    /// Poisson's ratio, for `lateral_inertia`.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 0.5))]
    pub poisson: f64,
    /// Mechanical quality factor.
    #[schemars(range(min = 5.0, max = 1e7))]
    pub q: f64,
    /// Largest alternating stress, Pa peak: endurance limit of a metal, or tension that a ceramic
    /// endures. Default: of a metal, no limit is known; of a ceramic, none beyond the preload.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e3, max = 1e11))]
    pub endurance_pa: Option<f64>,
    /// Tensile strength, Pa, for a bolt under preload.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e3, max = 1e11))]
    pub tensile_pa: Option<f64>,
    /// Piezoelectric constant d33, m/V.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-14, max = 1e-7))]
    pub d33_m_per_v: Option<f64>,
    /// Relative permittivity at constant stress, `eps33T / eps0`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1.0, max = 1e6))]
    pub permittivity: Option<f64>,
    /// Dielectric loss tangent.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub loss_tangent: f64,
    /// Compression at which the ceramic loses its polarisation, Pa.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e3, max = 1e11))]
    pub compression_pa: Option<f64>,
    /// Largest alternating field, V/m peak.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1.0, max = 1e9))]
    pub field_v_per_m: Option<f64>,
    /// Curie point, degrees Celsius. Half of it is the highest operating temperature.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 20.0, max = 1500.0))]
    pub curie_c: Option<f64>,
}

/// Defaults that serde needs as functions.
mod default {
    pub(super) fn highest_hz() -> f64 {
        150e3
    }
}
