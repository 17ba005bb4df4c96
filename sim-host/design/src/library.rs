//! Built-in materials, each with its source.
//!
//! Values of the same material differ between makers and batches: moduli by several per cent,
//! piezoelectric constants by 20 %, quality factors by a factor. A strength is only given if its
//! source was read.

use std::sync::LazyLock;

use crate::keys::Material;

/// A built-in material.
#[derive(Clone, Debug, PartialEq)]
pub struct Known {
    /// Constants of the material.
    pub material: Material,
    /// Source of the constants.
    pub source: &'static str,
}

/// Source of densities and velocities, from which the moduli follow:
/// `E = rho Vs^2 (3 Vl^2 - 4 Vs^2) / (Vl^2 - Vs^2)`.
const ONDA: &str = "Onda, Acoustic properties of solids: density and both velocities of sound";
/// Source of the ceramics.
const APC: &str = "APC International, Physical and piezoelectric properties of APC materials; field: 9 V/mil";

/// All built-in materials.
pub static MATERIALS: LazyLock<Vec<Known>> = LazyLock::new(|| {
    vec![
        metal("steel", (206e9, 7800.0, 0.29), 9200.0, ONDA),
        metal("stainless-steel", (197e9, 7890.0, 0.30), 9200.0, ONDA),
        metal("aluminium", (73.1e9, 2790.0, 0.34), 4500.0, ONDA),
        metal("titanium", (114e9, 4480.0, 0.32), 20e3, ONDA),
        metal("beryllium-copper", (112e9, 8250.0, 0.30), 4500.0, "density, modulus and loss of a published four-ring transducer"),
        ceramic("apc-840", 68e9, (290e-12, 1275.0), (500.0, 0.006), 325.0),
        ceramic("apc-841", 63e9, (300e-12, 1375.0), (1400.0, 0.004), 320.0),
        ceramic("apc-880", 72e9, (215e-12, 1050.0), (1000.0, 0.004), 310.0),
    ]
});

fn metal(name: &str, (modulus_pa, density_kg_per_m3, poisson): (f64, f64, f64), q: f64, source: &'static str) -> Known {
    Known { material: Material { name: name.into(), modulus_pa, density_kg_per_m3, poisson, q, ..Material::default() }, source }
}

/// Creates a hard PZT of 7600 kg/m^3.
fn ceramic(name: &str, modulus_pa: f64, (d33, permittivity): (f64, f64), (q, loss_tangent): (f64, f64), curie_c: f64) -> Known {
    let material = Material {
        name: name.into(),
        modulus_pa,
        density_kg_per_m3: 7600.0,
        poisson: 0.31,
        q,
        d33_m_per_v: Some(d33),
        permittivity: Some(permittivity),
        loss_tangent,
        field_v_per_m: Some(354e3),
        curie_c: Some(curie_c),
        ..Material::default()
    };
    Known { material, source: APC }
}

/// Returns the material with this name.
pub(crate) fn material(name: &str) -> Option<&'static Material> {
    MATERIALS.iter().map(|known| &known.material).find(|material| material.name == name)
}

/// Returns the names of all materials.
pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    MATERIALS.iter().map(|known| known.material.name.as_str())
}
